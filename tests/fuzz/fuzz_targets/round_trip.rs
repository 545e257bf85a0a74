//! Bakes a random description, loads it and compares.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let _ = hostile::targets::round_trip(data);
});
