//! Prints instructions, stack and scratch of a frame.
#![no_std]
#![no_main]

firmware::image!(firmware::cost::cost);
firmware::may_panic!();
