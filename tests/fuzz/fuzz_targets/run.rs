//! Loads any bytes and evaluates an accepted file.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let _ = hostile::targets::run(data);
});
