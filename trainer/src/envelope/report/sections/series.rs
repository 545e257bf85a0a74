//! What sections say of all series alike: names, legends, cells of a table.

use crate::envelope::evaluate::Errors;
use crate::envelope::report::comparison::{Comparison, Series};
use crate::page::html::{percent, text};

/// RMS, 99th percentile, largest and normals, as cells.
pub(super) fn errors(errors: &Errors) -> [String; 4] {
    let Errors { rms_percent, p99_percent, max_percent, normal_rms_degrees, .. } = *errors;
    let [rms, p99, max] =
        [rms_percent, p99_percent, max_percent].map(|e| format!("{} %", percent(e)));
    [rms, p99, max, format!("{normal_rms_degrees:.2}°")]
}

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
