//! `sinew kernel check`: cases of another implementation.

use crate::cli::column::{longest, padded};
use crate::cli::{Output, printable};
use anyhow::{Context, bail};
use sinew_trainer::scattered::compat::{Cases, DEVIATION, RCOND};
use std::path::PathBuf;

/// Columns of the longest name of a case.
const NAME: usize = 48;

/// Compares this solver with cases of another one
///
/// FILE has `cases`, each with `sites`, `values`, `queries`, `expected` and `options` by the names of SciPy's
/// RBFInterpolator.
///
/// Fails where an output deviates by more than 1e-9 of its range although the system's reciprocal
/// condition is above 1e-10.
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    /// Cases, as JSON
    file: PathBuf,
}

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let about = || arguments.file.display().to_string();
    let text = std::fs::read(&arguments.file).with_context(about)?;
    let report = Cases::read(&text).with_context(about)?.check();
    let columns = longest(report.cases.iter().map(|case| &*case.name), 4, NAME) + 2;
    let mut text = format!("{:<columns$}{:>10}{:>10}\n", "case", "deviation", "rcond");
    for case in &report.cases {
        let name = padded(&case.name, columns - 2) + "  ";
        text += &match (case.deviation, case.rcond, &case.skipped) {
            (Some(deviation), Some(rcond), _) => {
                let mark = match (rcond > RCOND, deviation <= DEVIATION) {
                    (true, true) => "",
                    (true, false) => "  <- too far",
                    (false, _) => "  (ill-conditioned: not held)",
                };
                format!("{name}{deviation:>10.1e}{rcond:>10.1e}{mark}\n")
            }
            (_, _, why) => {
                format!("{name}skipped: {}\n", printable(why.as_deref().unwrap_or("")))
            }
        };
    }
    text += &format!(
        "{} held to {DEVIATION:.0e} of the range, {} too far; {} ill-conditioned, {} skipped\n",
        report.held, report.failed, report.ill_conditioned, report.skipped
    );
    output.print(&report, &text)?;
    if report.failed > 0 {
        bail!("{}: {} of {} cases are too far", about(), report.failed, report.held);
    }
    if !report.passes() {
        bail!("{}: no case could be held", about());
    }
    Ok(())
}
