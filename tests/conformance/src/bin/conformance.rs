//! Runs every stage on every device of this machine and prints how each compares.

use clap::Parser;
use conformance::devices::{list, open};
use conformance::matrix::{Matrix, Scope, markdown, page};
use conformance::poses::POSES;
use conformance::subject::{self, FEWER_POSES};
use conformance::{filters, kernels, shapes};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Runs every stage on every Vulkan device of this machine, through wgpu and through raw Vulkan, and
/// prints how each compares with the CPU, bit by bit, and with the f64 oracle, in units of the
/// tolerance.
#[derive(Parser)]
#[command(
    bin_name = "cargo xtask conformance",
    after_help = "Markdown goes to standard output, a line for each device and stage: how many \
        values were compared, how many have other bits than the CPU's on the same inputs, and the \
        largest deviation from the oracle in units of the tolerance that follows from what Vulkan \
        and WGSL promise of their arithmetic. A stage beyond 1 fails.\n\n\
        Any Vulkan driver serves; without a GPU install lavapipe (Debian: mesa-vulkan-drivers). \
        SwiftShader is found in Chromium's folder. Exit status: 0 if every stage holds on every \
        device, 1 if not or if there is no device."
)]
struct Arguments {
    /// Also write the figures as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Also write a page for people, in one file
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(message) => {
            eprintln!("conformance: {message}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<bool, String> {
    let devices = list().map_err(|error| error.to_string())?;
    if devices.is_empty() {
        return Err(
            "there is no Vulkan device: install a driver, or lavapipe, which needs no GPU \
                    (Debian: mesa-vulkan-drivers)"
                .to_owned(),
        );
    }
    eprintln!("conformance: training the models");
    let subjects: Vec<_> =
        subject::trained(POSES).into_iter().chain(subject::shapes(FEWER_POSES)).collect();
    eprintln!("conformance: cpu");
    let scope = Scope {
        subjects,
        kernels: kernels::kernels(kernels::QUERIES),
        shaped: shapes::shapes(shapes::FACES),
        filters: filters::filters(filters::SIGNALS),
    };
    let mut matrix = Matrix::new(&scope);
    for info in devices {
        eprintln!("conformance: {}, {}, {}", info.api, info.name, info.driver);
        match open(&info, false) {
            Ok(device) => matrix.add(&*device, &scope),
            Err(error) => matrix.add_unopened(&info, &error),
        }
    }
    print!("{}", markdown(&matrix));
    if let Some(path) = &arguments.json {
        let json = serde_json::to_string_pretty(&matrix).map_err(|error| error.to_string())?;
        write(path, &(json + "\n"))?;
    }
    if let Some(path) = &arguments.html {
        write(path, &page(&matrix))?;
    }
    Ok(matrix.holds())
}

fn write(path: &Path, text: &str) -> Result<(), String> {
    sinew_trainer::files::write(path, text.as_bytes())
        .map_err(|error| format!("{}: {error}", path.display()))
}
