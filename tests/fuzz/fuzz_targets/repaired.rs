//! Repairs the checksum of any bytes, then loads and evaluates.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let _ = hostile::targets::repaired(data);
});
