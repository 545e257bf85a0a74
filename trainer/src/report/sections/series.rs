//! What sections say of all series alike: names, legends, cells of a table.

use crate::evaluate::Errors;
use crate::page::html::{below, percent, text};
use crate::report::comparison::{Comparison, Series};

/// RMS, 99th percentile and largest error, then RMS, median and 99th percentile of the normals' angles, as
/// cells.
pub(super) fn errors(errors: &Errors) -> [String; 6] {
    let Errors { rms_percent, p99_percent, max_percent, millimetres, .. } = *errors;
    let lengths = millimetres.map(|of| [of.rms_mm, of.p99_mm, of.max_mm]);
    let Errors { normal_rms_degrees, normal_median_degrees, normal_p99_degrees, .. } = *errors;
    let [rms, p99, max] = [(rms_percent, 0), (p99_percent, 1), (max_percent, 2)]
        .map(|(own, place)| format!("{} %{}", percent(own), below(lengths.map(|all| all[place]))));
    let angles = [normal_rms_degrees, normal_median_degrees, normal_p99_degrees];
    let [normals, median, normals_p99] = angles.map(|angle| format!("{angle:.2}°"));
    [rms, p99, max, normals, median, normals_p99]
}

/// What heads the cells of [`errors`].
pub(super) const ERRORS: [&str; 6] = ["RMS", "99 %", "largest", "normals, RMS", "median", "99 %"];

/// Names of the columns of all series.
pub(super) fn names(comparison: &Comparison<'_>) -> Vec<String> {
    comparison.series().iter().map(|series| text(series.name)).collect()
}

/// A length in % of the diagonal as a cell of a column that says so, with millimetres below it.
pub(super) fn length(comparison: &Comparison<'_>, own: f64) -> String {
    percent(own) + &below(comparison.mm(own))
}

/// The legend of all series.
pub(super) fn legend(comparison: &Comparison<'_>) -> String {
    entries(&comparison.series())
}

/// The legend of some series.
pub(super) fn entries(series: &[Series<'_>]) -> String {
    let entries: Vec<_> = series.iter().map(|series| (series.class, series.name)).collect();
    crate::page::chart::legend(&entries)
}
