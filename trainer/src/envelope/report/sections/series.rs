//! What sections say of all series alike: names, legends, cells of a table.

use crate::envelope::evaluate::Errors;
use crate::envelope::report::comparison::{Comparison, Series};
use crate::page::html::{percent, text};

/// RMS, 99th percentile and largest error, then RMS, median and 99th percentile of the normals' angles, as
/// cells.
pub(super) fn errors(errors: &Errors) -> [String; 6] {
    let Errors { rms_percent, p99_percent, max_percent, .. } = *errors;
    let Errors { normal_rms_degrees, normal_median_degrees, normal_p99_degrees, .. } = *errors;
    let [rms, p99, max] =
        [rms_percent, p99_percent, max_percent].map(|e| format!("{} %", percent(e)));
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

/// The legend of all series.
pub(super) fn legend(comparison: &Comparison<'_>) -> String {
    entries(&comparison.series())
}

/// The legend of some series.
pub(super) fn entries(series: &[Series<'_>]) -> String {
    let entries: Vec<_> = series.iter().map(|series| (series.class, series.name)).collect();
    crate::page::chart::legend(&entries)
}
