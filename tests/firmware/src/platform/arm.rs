//! Cortex-M, with and without a floating-point unit.

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

/// Instructions of a tick of the system timer, under `-icount shift=0` on QEMU's mps2 boards: an
/// instruction takes 1 ns there, and the timer runs at 25 MHz.
pub const TICK: u32 = 40;

/// Starts the system timer, which counts 24 bits down.
pub fn start_timer() {
    const CONTROL: *mut u32 = core::ptr::without_provenance_mut(0xE000_E010);
    const RELOAD: *mut u32 = core::ptr::without_provenance_mut(0xE000_E014);
    // SAFETY: these are the registers of every Cortex-M's system timer; no interrupt is asked for.
    unsafe {
        RELOAD.write_volatile(0x00FF_FFFF);
        VALUE.write_volatile(0);
        CONTROL.write_volatile(0b101);
    }
}

const VALUE: *mut u32 = core::ptr::without_provenance_mut(0xE000_E018);

/// Counts the instructions of some work, to within a tick; up to 2^24 ticks.
pub fn instructions_of(work: impl FnOnce()) -> u32 {
    // SAFETY: the register can be read at any time.
    let before = unsafe { VALUE.read_volatile() };
    work();
    // SAFETY: as above.
    let after = unsafe { VALUE.read_volatile() };
    (before.wrapping_sub(after) & 0x00FF_FFFF) * TICK
}

/// Runs two instructions, `times` times over.
pub fn count_down(times: u32) {
    // SAFETY: it changes a register that nothing else is in, and the flags.
    unsafe { asm!("0: subs {0}, {0}, #1", "bne 0b", inout(reg) times => _) }
}

/// Measures the stack that some work takes, in bytes: what lies below is painted before and looked
/// through after.
#[inline(never)]
pub fn stack_of(work: &mut dyn FnMut()) -> usize {
    const PAINT: u32 = 0x5AFE_5AFE;
    unsafe extern "C" {
        static mut _stack_end: u32;
    }
    let end = &raw mut _stack_end;
    let top: *mut u32;
    // SAFETY: from the stack's end up to its pointer nothing lives; the loop touches no more, and
    // has no frame of its own there.
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
    // SAFETY: as above; what the work left there is plain words.
    while at < top && unsafe { at.read_volatile() } == PAINT {
        at = at.wrapping_add(1);
    }
    top.addr() - at.addr()
}
