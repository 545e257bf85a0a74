//! Cases of the folder `frames`.
