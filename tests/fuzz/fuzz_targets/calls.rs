//! Calls the C ABI as no careful caller does, on untrusted files.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let _ = hostile::targets::calls(data);
});
