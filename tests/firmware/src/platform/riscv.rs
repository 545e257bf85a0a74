//! RISC-V without a floating-point unit.

use core::arch::{asm, global_asm};

// The reset handler: sets traps as failures, sets the stack, clears `.bss`.
global_asm!(
    ".section .start, \"ax\"",
    ".global _start",
    "_start:",
    "la t0, fault",
    "csrw mtvec, t0",
    "la sp, _stack_start",
    "la t0, _bss_start",
    "la t1, _bss_end",
    "0: bgeu t0, t1, 1f",
    "sw zero, 0(t0)",
    "addi t0, t0, 4",
    "j 0b",
    "1: call run_image",
);

/// Makes a semihosting call.
///
/// # Safety
/// `argument` must be valid for the operation.
pub(super) unsafe fn call(operation: usize, argument: usize) {
    // SAFETY: the debugger changes only a0, and memory as the caller has promised. The debugger
    // recognises a call by these three instructions: uncompressed, in one page.
    unsafe {
        asm!(
            ".option push",
            ".option norvc",
            ".balign 16",
            "slli x0, x0, 0x1f",
            "ebreak",
            "srai x0, x0, 7",
            ".option pop",
            inout("a0") operation => _,
            in("a1") argument,
        );
    }
}
