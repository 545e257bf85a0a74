//! Prints instructions, stack and scratch of a step of the servo.
#![no_std]
#![no_main]

firmware::image!(firmware::cost::servo);
firmware::may_panic!();
