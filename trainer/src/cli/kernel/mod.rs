//! The commands of scattered data: `sinew kernel ...`.

mod eval;
mod plot;
mod train;

use crate::cli::printable;
use sinew_runtime::kernel::KernelMap;

commands! {
    Train(train::Train),
    Eval(eval::Eval),
    Check(eval::Check),
    Plot(plot::PlotArgs),
}

/// Returns the names of all output numbers.
fn columns(map: &KernelMap<'_>) -> Vec<String> {
    let mut out = Vec::new();
    for (output, row) in map.outputs().enumerate() {
        let name = printable(map.output_name(output).unwrap_or_default());
        let parts: &[&str] = match row.kind.number_len() {
            1 => &[""],
            3 => &[".x", ".y", ".z"],
            _ => &[".x", ".y", ".z", ".w"],
        };
        out.extend(parts.iter().map(|part| format!("{name}{part}")));
    }
    out
}
