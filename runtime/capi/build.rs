//! Sets the name of the shared library. Programs then search for this name, not for the path at link time.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let of = |name| std::env::var(name).unwrap_or_default();
    match (of("CARGO_CFG_TARGET_OS").as_str(), of("CARGO_CFG_TARGET_VENDOR").as_str()) {
        ("linux" | "android" | "freebsd" | "netbsd" | "openbsd" | "dragonfly", _) => {
            println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,libsinew_capi.so");
        }
        (_, "apple") => {
            println!("cargo::rustc-cdylib-link-arg=-Wl,-install_name,@rpath/libsinew_capi.dylib");
        }
        _ => {}
    }
}
