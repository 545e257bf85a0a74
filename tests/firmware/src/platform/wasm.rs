//! WebAssembly: the page, or Node, prints.

#[link(wasm_import_module = "host")]
unsafe extern "C" {
    /// Prints a text of the module's memory.
    #[link_name = "print"]
    fn host_print(start: *const u8, len: usize);
}

/// Prints a text.
pub fn print(text: &str) {
    // SAFETY: the host reads the text and no more.
    unsafe { host_print(text.as_ptr(), text.len()) }
}

/// Ends the image by a trap, which only a failure needs.
pub fn end(_success: bool) -> ! {
    core::arch::wasm32::unreachable()
}
