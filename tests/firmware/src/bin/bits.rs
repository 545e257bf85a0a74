//! Prints the bits of every stage over seeded poses.
#![cfg_attr(any(target_os = "none", target_family = "wasm"), no_std, no_main)]

firmware::image!(firmware::report::bits);
firmware::may_panic!();
