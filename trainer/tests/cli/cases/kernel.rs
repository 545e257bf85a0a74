//! Cases of the folder `kernel`.
