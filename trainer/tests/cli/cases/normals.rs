//! Cases of the folder `normals`.
