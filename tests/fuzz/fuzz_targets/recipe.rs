//! Changes a golden file piece by piece, then loads and evaluates.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let _ = hostile::targets::recipe(data);
});
