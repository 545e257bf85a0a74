//! Passes the linker script of a bare target to the linker.

use std::env::var;

fn main() {
    let (Ok(folder), Ok(arch), Ok(os)) =
        (var("CARGO_MANIFEST_DIR"), var("CARGO_CFG_TARGET_ARCH"), var("CARGO_CFG_TARGET_OS"))
    else {
        return;
    };
    println!("cargo::rerun-if-changed=link");
    if os == "none" {
        println!("cargo::rustc-link-arg-bins=-T{folder}/link/{arch}.ld");
    }
}
