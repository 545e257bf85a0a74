//! What `sinew inspect` says of filters.

use crate::cli::described::Described;
use crate::cli::{counted, printable};
use serde_json::json;
use sinew_runtime::Model;
use sinew_runtime::filter::{Filter, FilterFit};
use sinew_runtime::format::PartKind;

/// Describes the filters of a file.
pub(in crate::cli) fn describe(model: &Model<Vec<u8>>) -> Vec<Described> {
    model.filters().map(|filter| described(&filter)).collect()
}

fn described(filter: &Filter<'_>) -> Described {
    let (name, factor, taps) = (filter.name(), filter.factor(), filter.tap_len());
    let FilterFit { step, left_out_rms, linear_rms } = filter.fit();
    let has_variance = filter.variance(0, 0).is_some();
    let mut text = format!(
        "filter \"{}\": {} of {taps} taps{}\n",
        printable(name),
        counted(factor, "phase", "phases"),
        if has_variance { ", with variances" } else { "" },
    );
    for (name, figure) in
        [("samples left out, RMS", left_out_rms), ("by lines between samples", linear_rms)]
    {
        text += &format!("  {name:<26}{figure:.3e}\n");
    }
    let json = json!({
        "part": filter.part(),
        "name": name,
        "factor": factor,
        "taps": taps,
        "variances": has_variance,
        "fit": { "step": step, "left_out_rms": left_out_rms, "linear_rms": linear_rms },
    });
    Described { part: filter.part(), kind: PartKind::Filter, name: name.to_owned(), text, json }
}
