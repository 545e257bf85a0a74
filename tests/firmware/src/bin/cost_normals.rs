//! Prints instructions and stack of a skin with tangent coefficients.
#![no_std]
#![no_main]

firmware::image!(firmware::cost::normals);
firmware::may_panic!();
