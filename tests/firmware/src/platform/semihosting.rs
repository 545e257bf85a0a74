//! Semihosting: the debugger, or QEMU, prints and ends for the image.

use super::target::call;

const WRITE0: usize = 0x04;
const EXIT: usize = 0x18;
/// ADP_Stopped_ApplicationExit and ADP_Stopped_RunTimeErrorUnknown.
const STOPPED: [usize; 2] = [0x20026, 0x20023];

unsafe extern "C" {
    /// Defined by [`crate::image`].
    fn image() -> bool;
}

/// Runs the image; called by the reset handlers.
#[unsafe(no_mangle)]
extern "C" fn run_image() -> ! {
    // SAFETY: every image defines the function by the macro `image`, with this type.
    end(unsafe { image() })
}

/// Ends with a failure; called by exceptions.
#[unsafe(no_mangle)]
extern "C" fn fault() -> ! {
    print("fault\n");
    end(false)
}

/// Prints a text.
pub fn print(text: &str) {
    // The call takes a zero-terminated text.
    let mut buffer = [0u8; 65];
    for chunk in text.as_bytes().chunks(64) {
        for (to, from) in buffer.iter_mut().zip(chunk.iter().chain(&[0])) {
            *to = *from;
        }
        // SAFETY: the buffer is zero-terminated, and the call only reads it.
        unsafe { call(WRITE0, buffer.as_ptr().addr()) };
    }
}

/// Ends the image.
pub fn end(success: bool) -> ! {
    let [success_code, failure] = STOPPED;
    loop {
        // SAFETY: the argument of the call is a number.
        unsafe { call(EXIT, if success { success_code } else { failure }) };
    }
}
