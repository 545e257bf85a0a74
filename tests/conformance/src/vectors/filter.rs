//! One filter with signals, and what it makes of them.

use super::tolerances::Tolerance;
use super::written::Written;
use super::{Folder, VectorError};
use crate::backend::Cpu;
use crate::filters::FilterSubject;
use crate::stages::filter::finer_by;
use crate::tolerance;
use serde::Serialize;
use sinew_gpu::layout::Stage;
use sinew_runtime::filter::Samples;

#[derive(Serialize)]
struct Counts {
    signals: usize,
    samples: usize,
    lanes: usize,
    factor: usize,
}

/// Makes signals finer, and writes them into a folder of the case's name.
///
/// # Errors
/// [`VectorError`]
pub(super) fn write(
    case: &str,
    bytes: &[u8],
    subject: &FilterSubject<'_>,
    folder: &Folder,
) -> Result<(), VectorError> {
    let Samples { signal_len: signals, sample_len: samples, lane_len: lanes } = subject.shape;
    let factor = subject.filter.factor();
    let mut written = Written::new(case, None, Counts { signals, samples, lanes, factor });
    let fine = finer_by(&Cpu, subject)?;
    written.array("sample", vec![signals, samples, lanes], &subject.samples);
    written.array("fine", vec![signals, samples * factor, lanes], &fine);
    let mut tolerance = Tolerance::new();
    for (place, found) in fine.iter().enumerate() {
        let (value, error) = tolerance::filter(subject, place);
        tolerance.add(*found, value, error);
    }
    written.stage(Stage::Filter.name(), &["sample"], vec![("fine", tolerance.0)]);
    written.write(bytes, folder)
}
