//! Project commands. `cargo xtask test` is the one that says whether all is well.

mod deep;

use std::process::{Command, ExitCode};
use std::time::Instant;

/// Bare targets that the runtime must build for.
const TARGETS: [&str; 2] = ["thumbv7em-none-eabihf", "wasm32-unknown-unknown"];

/// Blender as a Python module.
const BPY: &str = "bpy==5.0.1";

const HELP: &str = "\
usage: cargo xtask COMMAND

  test    prepare the machine, then format, lint, document, build for every target and run every
          test; tests on real data read ../shared/data and must find it when CI is set
  shaders make the SPIR-V in shaders/spirv of the GLSL
  deep [SECONDS]
          run the runtime's tests under miri, a million mutated files, and every fuzz target for
          SECONDS (300); needs nightly
";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let done = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["test"] => test(),
        ["shaders"] => cargo("run --release --locked -p shaders", &[]),
        ["deep"] => deep::deep(None),
        ["deep", seconds] => deep::deep(Some(seconds)),
        _ => {
            eprint!("{HELP}");
            return ExitCode::from(2);
        }
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}

fn test() -> Result<(), String> {
    prepare()?;
    cargo("fmt --all --check", &[])?;
    cargo("clippy --workspace --all-targets --locked -- -D warnings", &[])?;
    cargo("doc --workspace --no-deps --locked", &[("RUSTDOCFLAGS", "-D warnings")])?;
    for target in TARGETS {
        // One package at a time: features would unify with crates that need std.
        cargo(&format!("build -p sinew-runtime --locked --target {target}"), &[])?;
    }
    cargo("test --workspace --locked", &[("SINEW_BPY", &blender()?)])
}

/// Gives the Python that the test of the Blender script runs in, with Blender as a module; the empty
/// text, said aloud, where there is no such package for this machine.
fn blender() -> Result<String, String> {
    let target = std::env::var("CARGO_TARGET_DIR").unwrap_or_else(|_| "target".to_owned());
    let folder = std::path::absolute(format!("{target}/bpy")).map_err(|error| error.to_string())?;
    let python = folder.join("bin/python").display().to_string();
    let has_bpy = || {
        let found = Command::new(&python).args(["-c", "import bpy"]).output();
        found.is_ok_and(|found| found.status.success())
    };
    if !has_bpy() {
        let advice = "install Python 3 with its venv module (Debian: python3-venv)";
        run(Command::new("python3").args(["-m", "venv", "--clear"]).arg(&folder))
            .map_err(|error| format!("{error}; {advice}"))?;
        let installed = run(Command::new(&python).args(["-m", "pip", "install", "-q", BPY]));
        if installed.is_err() || !has_bpy() {
            eprintln!("xtask: {BPY} does not install here: the Blender script is not tested");
            return Ok(String::new());
        }
    }
    Ok(python)
}

/// Installs what the tests need, or says what to run.
fn prepare() -> Result<(), String> {
    for program in ["node", "npm"] {
        // The tests of exported files fetch the glTF validator with the one and run it with the other.
        Command::new(program).arg("--version").output().map_err(|_| {
            format!("{program} was not found: install Node.js 18 or newer with npm, see nodejs.org")
        })?;
    }
    let missing = "rustup, with which the bare targets are installed, was not found: see rustup.rs";
    let listed = Command::new("rustup")
        .args(["target", "list", "--installed"])
        .output()
        .map_err(|_| missing.to_owned())?;
    let installed = String::from_utf8_lossy(&listed.stdout).into_owned();
    for target in TARGETS {
        if !installed.lines().any(|line| line.trim() == target) {
            let advice = format!("run `rustup target add {target}`");
            run(Command::new("rustup").args(["target", "add", target]))
                .map_err(|error| format!("{error}; {advice}"))?;
        }
    }
    Ok(())
}

fn cargo(arguments: &str, environment: &[(&str, &str)]) -> Result<(), String> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    run(Command::new(cargo).args(arguments.split_whitespace()).envs(environment.iter().copied()))
}

fn run(command: &mut Command) -> Result<(), String> {
    let shown: Vec<_> = command.get_args().map(|a| a.to_string_lossy().into_owned()).collect();
    let shown = format!("{} {}", command.get_program().to_string_lossy(), shown.join(" "));
    eprintln!("xtask: {shown}");
    let start = Instant::now();
    let status = command.status().map_err(|error| format!("`{shown}`: {error}"))?;
    eprintln!("xtask: {:.0} s", start.elapsed().as_secs_f64());
    if status.success() { Ok(()) } else { Err(format!("`{shown}` failed")) }
}
