//! WebAssembly: the page or Node prints.

#[link(wasm_import_module = "host")]
unsafe extern "C" {
    /// Prints a text in the module's memory.
    #[link_name = "print"]
    fn host_print(start: *const u8, len: usize);
}

/// Prints a text.
pub fn print(text: &str) {
    // SAFETY: the host only reads the text.
    unsafe { host_print(text.as_ptr(), text.len()) }
}

/// Ends a failed image by a trap.
pub fn end(_success: bool) -> ! {
    core::arch::wasm32::unreachable()
}
