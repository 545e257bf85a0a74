//! Writes vectors for authors of backends.

use clap::Parser;
use std::path::PathBuf;
use std::process::ExitCode;

/// Writes models, poses, the outputs of every stage, and the tolerances of a backend: plain files,
/// which the README.md beside them describes.
#[derive(Parser)]
#[command(
    bin_name = "cargo xtask vectors",
    after_help = "The same bytes every time. The folder appears whole or not at all. \
        tests/conformance/examples/vectors.py checks an implementation of skinning against them."
)]
struct Arguments {
    /// A folder that is not there, or is empty
    out: PathBuf,
}

fn main() -> ExitCode {
    let Arguments { out } = Arguments::parse();
    match conformance::vectors::write(&out) {
        Ok(()) => {
            println!("{}: read README.md first", out.display());
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("vectors: {error}");
            ExitCode::FAILURE
        }
    }
}
