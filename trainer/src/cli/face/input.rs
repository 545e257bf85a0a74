//! Faces, takes and ranges: arguments, and reading of their files.

use crate::cli::{ModelArgs, OfFile, Output, counted, printable};
use crate::envelope::model::{FileModel, PriorModel, SkinModel};
use crate::face::baked::BakedFace;
use crate::face::names::listed;
use crate::face::outline::Outline;
use crate::face::take::{self, Largest, Take};
use crate::face::train::sliders;
use sinew_runtime::Model;
use sinew_runtime::prior::Anchor;
use std::ops::Range;
use std::path::Path;

/// Weight above which a warning is given: artists exceed the full shape, which is 1, only a little.
const WEIGHT_MOST: f64 = 2.0;

/// Weights that a solve stays near to: the current weights, or the mean of the take.
pub(super) const ANCHORS: [(&str, Anchor); 2] =
    [("current", Anchor::Current), ("mean", Anchor::Mean)];

impl ModelArgs {
    /// Finds the face of a model.
    pub(super) fn face<'a>(&self, model: &'a Model<Vec<u8>>) -> anyhow::Result<BakedFace<'a>> {
        BakedFace::open(model).of(&self.file)
    }

    /// Reads the mesh beside the file.
    pub(super) fn outline(&self, face: &BakedFace<'_>) -> anyhow::Result<Outline> {
        Ok(Outline::read(&self.file, face.skin.vertex_len())?)
    }
}

/// Bakes the skin of a face with the slider norm: around 0, and around the learned mean.
pub(super) fn slider_models(
    model: &Model<Vec<u8>>,
    face: &BakedFace<'_>,
) -> anyhow::Result<[Model<Vec<u8>>; 2]> {
    let own = FileModel {
        space: model.space(),
        envelopes: Vec::new(),
        skins: vec![SkinModel {
            envelope: None,
            influences: Vec::new(),
            ..SkinModel::from_file(&face.skin)
        }],
        priors: vec![PriorModel::from_file(&face.prior, 0)],
        records: Vec::new(),
    };
    Ok(sliders(&own)?)
}

/// Reads a take of a face. Warns of lost rows, of columns without a shape, and of weights that look like percent.
///
/// - `is_percent`: whether 100 is the full shape, and not 1.
pub(super) fn take(
    path: &Path,
    is_percent: bool,
    shapes: &[String],
    output: Output,
) -> anyhow::Result<Take> {
    let mut read = take::read(path, shapes).of(path)?;
    if !read.skipped.is_empty() {
        let skipped = listed(read.skipped.iter().map(|name| printable(name)));
        let what = format!("columns that the face has no shape for are left out: {skipped}");
        output.warn(path.display(), what);
    }
    if !read.lost.is_empty() {
        let what = format!(
            "the tracking is lost in {} of {}, which are left out: line {}",
            read.lost.len(),
            counted(read.file_len(), "row", "rows"),
            listed(read.lost.iter())
        );
        output.warn(path.display(), what);
    }
    if let Some(warning) = read.largest.as_ref().and_then(|found| unusual(found, is_percent)) {
        output.warn(path.display(), warning);
    }
    if is_percent {
        read.frames.iter_mut().flatten().for_each(|weight| *weight /= 100.0);
    }
    Ok(read)
}

/// Returns a warning if weights look like percent, or percent like weights.
fn unusual(found: &Largest, is_percent: bool) -> Option<String> {
    let Largest { weight, column, place } = found;
    let (full, remedy) = match is_percent {
        true if weight.abs() <= 1.0 => (100, "leave --percent out if 1 is the full shape"),
        true if weight.abs() > 100.0 * WEIGHT_MOST => {
            (100, "divide the weights by their full value")
        }
        false if weight.abs() > WEIGHT_MOST => (
            1,
            "give --percent if 100 is the full shape, or divide the weights by their full value",
        ),
        _ => return None,
    };
    Some(format!(
        "the largest weight is {weight}, of column {column:?} in {place}, and {full} is the full shape: {remedy}"
    ))
}

/// Parses `A..B`, `A..` or `..B`.
pub(super) fn range(text: &str) -> Result<[Option<usize>; 2], String> {
    let expected =
        || "expected A..B, the first and the end, either of which may be left out".to_owned();
    let (first, end) = text.split_once("..").ok_or_else(expected)?;
    let number = |text: &str| match text {
        "" => Ok(None),
        text => text.parse().map(Some).map_err(|_| expected()),
    };
    Ok([number(first)?, number(end)?])
}

/// Completes a range with the start and the end of the data.
pub(super) fn within(range: Option<[Option<usize>; 2]>, len: usize) -> Range<usize> {
    let [first, end] = range.unwrap_or_default();
    first.unwrap_or(0)..end.unwrap_or(len)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_may_leave_an_end_out() {
        assert_eq!(range("3..7"), Ok([Some(3), Some(7)]));
        assert_eq!(range("3.."), Ok([Some(3), None]));
        assert_eq!(range(".."), Ok([None, None]));
        assert!(range("3").is_err() && range("a..3").is_err() && range("-1..3").is_err());
        assert_eq!(within(range("..7").ok(), 10), 0..7);
        assert_eq!(within(None, 10), 0..10);
    }
}
