//! Calls of other programs, told with the time that they take.

use std::ffi::{OsStr, OsString};
use std::path::PathBuf;
use std::process::Command;
use std::time::Instant;

/// Bare targets that the runtime must build for.
pub(crate) const TARGETS: [&str; 2] = ["thumbv7em-none-eabihf", "wasm32-unknown-unknown"];

/// Returns the folder that builds go to.
pub(crate) fn target_folder() -> Result<PathBuf, String> {
    let folder = std::env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into());
    std::path::absolute(folder).map_err(|error| error.to_string())
}

pub(crate) fn cargo(arguments: &str, environment: &[(&str, OsString)]) -> Result<(), String> {
    run(&mut cargo_with(arguments, environment))
}

pub(crate) fn cargo_with(arguments: &str, environment: &[(&str, OsString)]) -> Command {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| OsStr::new("cargo").to_owned());
    let mut command = Command::new(cargo);
    let environment = environment.iter().map(|(name, value)| (name, value));
    command.args(arguments.split_whitespace()).envs(environment);
    command
}

pub(crate) fn run(command: &mut Command) -> Result<(), String> {
    let shown: Vec<_> = command.get_args().map(|a| a.to_string_lossy().into_owned()).collect();
    let shown = format!("{} {}", command.get_program().to_string_lossy(), shown.join(" "));
    eprintln!("xtask: {shown}");
    let start = Instant::now();
    let status = command.status().map_err(|error| format!("`{shown}`: {error}"))?;
    eprintln!("xtask: {:.0} s", start.elapsed().as_secs_f64());
    if status.success() { Ok(()) } else { Err(format!("`{shown}` failed")) }
}
