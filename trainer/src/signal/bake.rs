//! A filter as a part of a file, as FORMAT.md has it.

use super::grid::Grid;
use super::model::FilterModel;
use crate::bake::sections::{floats, names, narrow, words};
use crate::bake::{BakeError, Part, Sections};
use sinew_runtime::filter::{FilterCounts, FilterFit};
use sinew_runtime::format::{Element, PartKind, SectionKind};

/// Writes a filter.
///
/// - `variance`: whether the variance of each fine sample is written, in the square of the signal's unit.
///
/// # Errors
/// [`BakeError::Size`] of a count that does not fit the file.
pub fn part(model: &FilterModel, variance: bool) -> Result<Part, BakeError> {
    let FilterModel { name, filter, variance: scale, fit } = model;
    let Grid { factor, taps, .. } = filter.grid;
    let counts =
        FilterCounts { factor: narrow("the factor", factor)?, tap_len: narrow("taps", taps)? };
    let mut sections: Sections = vec![
        (SectionKind::FilterCounts, true, words(&counts.words())),
        (SectionKind::Names, true, names(std::iter::once(name))?),
        (SectionKind::FilterTaps, true, floats(&filter.weights)),
    ];
    if variance {
        let own: Vec<f64> = filter.variances.iter().map(|x| x * scale).collect();
        sections.push((SectionKind::FilterVariances, true, floats(&own)));
    }
    let [left_out_rms, linear_rms] =
        fit.map_or([0.0; 2], |fit| [fit.rms, fit.linear_rms]).map(|x| x as f32);
    let fit = FilterFit { step: 1.0, left_out_rms, linear_rms };
    sections.push((SectionKind::FilterFit, true, floats(&fit.figures().map(f64::from))));
    Ok(Part { kind: PartKind::Filter, sections, element: Element::F32 })
}
