//! Cases of the folder `signal`.
