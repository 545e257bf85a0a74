//! Checks that need nightly or much time: Miri, a million mutated files, and every fuzz target for
//! a while.

use crate::call::{cargo, run};
use std::path::Path;
use std::process::{Command, Stdio};

/// Seconds per fuzz target.
const SECONDS: u32 = 300;

/// Seconds after which one input counts as a hang.
const HANG_SECONDS: u32 = 10;

/// Folder of the fuzzers' builds, corpora and findings.
const FOLDER: &str = "target/nested/fuzz";

/// Runs every deep check; `seconds` is the time per fuzz target.
pub(crate) fn deep(seconds: Option<&str>) -> Result<(), String> {
    let seconds = seconds.map_or(Ok(SECONDS), str::parse);
    let seconds = seconds.map_err(|_| "expected the seconds of a fuzz target".to_owned())?;
    prepare()?;
    run(&mut nightly("miri test -p sinew-runtime --locked"))?;
    run(&mut nightly("miri test -p calls --locked"))?;
    cargo("run --release --locked -p hostile --bin mutants", &[])?;
    for target in targets()? {
        fuzz(&target, seconds)?;
    }
    Ok(())
}

/// Fuzzes from the goldens and, if the target has one, from the committed corpus. New inputs stay in
/// the build folder.
fn fuzz(target: &str, seconds: u32) -> Result<(), String> {
    let corpus = format!("{FOLDER}/corpus/{target}");
    let findings = format!("{FOLDER}/findings/{target}/");
    for folder in [&corpus, &findings] {
        std::fs::create_dir_all(folder).map_err(|error| format!("{folder}: {error}"))?;
    }
    let committed = format!("tests/fuzz/corpus/{target}");
    let committed = if Path::new(&committed).is_dir() { committed.as_str() } else { "" };
    let arguments = format!(
        "fuzz run --fuzz-dir tests/fuzz --target-dir {FOLDER} {target} {corpus} tests/golden \
         {committed} -- -max_total_time={seconds} \
         -timeout={HANG_SECONDS} -max_len=16384 -print_final_stats=1 -artifact_prefix={findings}"
    );
    run(&mut nightly(&arguments)).map_err(|error| {
        format!("{error}; move the files of {findings} to tests/fuzz/regressions/{target}")
    })
}

/// Lists the fuzz targets by their file names.
fn targets() -> Result<Vec<String>, String> {
    let folder = Path::new("tests/fuzz/fuzz_targets");
    let said = |error| format!("{}: {error}", folder.display());
    let mut targets = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(said)? {
        let path = entry.map_err(said)?.path();
        targets.extend(path.file_stem().map(|stem| stem.to_string_lossy().into_owned()));
    }
    targets.sort();
    Ok(targets)
}

/// Returns the command to run if nightly, Miri or cargo-fuzz is missing.
fn prepare() -> Result<(), String> {
    for (arguments, advice) in [
        ("--version", "rustup toolchain install nightly --component miri,rust-src"),
        ("miri --version", "rustup component add --toolchain nightly miri rust-src"),
        ("fuzz --version", "cargo install --locked cargo-fuzz"),
    ] {
        let silent = nightly(arguments).stdout(Stdio::null()).stderr(Stdio::null()).status();
        if !silent.is_ok_and(|status| status.success()) {
            return Err(format!("`cargo +nightly {arguments}` does not run: run `{advice}`"));
        }
    }
    Ok(())
}

/// Makes a command for nightly's cargo; the cargo that runs this program is stable's.
fn nightly(arguments: &str) -> Command {
    let mut command = Command::new("rustup");
    command.args(["run", "nightly", "cargo"]).args(arguments.split_whitespace());
    command.env_remove("CARGO").env_remove("RUSTC");
    command
}
