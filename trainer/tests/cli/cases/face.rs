//! Cases of the folder `face`.
