//! Cortex-M, with and without a floating-point unit.

use core::arch::{asm, global_asm};

// The vector table: stack, reset, and a failure for every exception. The reset handler enables the
// FPU (CPACR, full access to CP10 and CP11) before any code can use it, and clears `.bss`.
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
/// `argument` must be valid for the operation.
pub(super) unsafe fn call(operation: usize, argument: usize) {
    // SAFETY: the debugger changes only r0, and memory as the caller has promised.
    unsafe { asm!("bkpt 0xAB", inout("r0") operation => _, in("r1") argument) }
}

/// Instructions per tick of the system timer, under `-icount shift=0` on QEMU's mps2 boards: an
/// instruction takes 1 ns there, and the timer runs at 25 MHz.
pub const TICK: u32 = 40;

/// Starts the system timer, which counts down from 2^24 - 1.
pub fn start_timer() {
    const CONTROL: *mut u32 = core::ptr::without_provenance_mut(0xE000_E010);
    const RELOAD: *mut u32 = core::ptr::without_provenance_mut(0xE000_E014);
    // SAFETY: these are the system timer's registers on every Cortex-M; no interrupt is enabled.
    unsafe {
        RELOAD.write_volatile(0x00FF_FFFF);
        VALUE.write_volatile(0);
        CONTROL.write_volatile(0b101);
    }
}

const VALUE: *mut u32 = core::ptr::without_provenance_mut(0xE000_E018);

/// Counts the instructions of `work`, to within a tick; up to 2^24 ticks.
pub fn instructions_of(work: impl FnOnce()) -> u32 {
    // SAFETY: the register can be read at any time.
    let before = unsafe { VALUE.read_volatile() };
    work();
    // SAFETY: as above.
    let after = unsafe { VALUE.read_volatile() };
    (before.wrapping_sub(after) & 0x00FF_FFFF) * TICK
}

/// Runs two instructions `times` times.
pub fn count_down(times: u32) {
    // SAFETY: the code changes only its own register and the flags.
    unsafe { asm!("0: subs {0}, {0}, #1", "bne 0b", inout(reg) times => _) }
}

/// Measures the stack used by `work`, in bytes: paints the memory below before, and searches it
/// after.
#[inline(never)]
pub fn stack_of(work: &mut dyn FnMut()) -> usize {
    const PAINT: u32 = 0x5AFE_5AFE;
    unsafe extern "C" {
        static mut _stack_end: u32;
    }
    let end = &raw mut _stack_end;
    let top: *mut u32;
    // SAFETY: the memory from the end of the stack to the stack pointer is unused. The loop touches
    // only this memory, and has no frame in it.
    unsafe {
        asm!(
            "mov {top}, sp",
            "0: cmp {at}, {top}",
            "bhs 1f",
            "str {paint}, [{at}]",
            "adds {at}, #4",
            "b 0b",
            "1:",
            top = out(reg) top,
            at = inout(reg) end => _,
            paint = in(reg) PAINT,
        );
    }
    work();
    let mut at = end;
    // SAFETY: as above; the words that the work left there are plain data.
    while at < top && unsafe { at.read_volatile() } == PAINT {
        at = at.wrapping_add(1);
    }
    top.addr() - at.addr()
}
