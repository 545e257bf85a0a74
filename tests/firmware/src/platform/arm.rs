//! Cortex-M, with and without a floating-point unit.

pub use super::semihosting::{end, print};

use core::arch::{asm, global_asm};

// The vector table: stack, reset, and every exception a failure. The reset handler lets the FPU
// run (CPACR, full access to CP10 and CP11) before any code could use it, and clears `.bss`.
global_asm!(
    ".section .start, \"a\"",
    ".word _stack_start",
    ".word _start",
    ".rept 14",
    ".word fault",
    ".endr",
    ".section .text._start, \"ax\"",
    ".global _start",
    ".type _start, %function",
    ".thumb_func",
    "_start:",
    "ldr r0, =0xE000ED88",
    "ldr r1, =0x00F00000",
    "str r1, [r0]",
    "dsb",
    "isb",
    "ldr r0, =_bss_start",
    "ldr r1, =_bss_end",
    "movs r2, #0",
    "0: cmp r0, r1",
    "bhs 1f",
    "str r2, [r0]",
    "adds r0, #4",
    "b 0b",
    "1: bl run_image",
    ".pool",
);

/// Makes a semihosting call.
///
/// # Safety
/// `argument` must be what the operation takes.
pub(super) unsafe fn call(operation: usize, argument: usize) {
    // SAFETY: the debugger changes r0 alone, and memory as the caller has promised.
    unsafe { asm!("bkpt 0xAB", inout("r0") operation => _, in("r1") argument) }
}
