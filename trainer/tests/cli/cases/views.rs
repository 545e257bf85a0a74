//! Cases of the folder `views`.
