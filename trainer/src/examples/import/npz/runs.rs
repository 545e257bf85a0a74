//! Runs of frames or vertices that follow one another, by name.

use std::ops::Range;

use super::fields::missing;
use crate::examples::ExamplesError;
use crate::examples::validate::same;
use crate::formats::npz::Archive;

/// Runs by name, in order.
pub(super) type Runs = Vec<(String, Range<usize>)>;

/// Which runs, as the file names them.
pub(super) struct RunKind {
    /// What the runs are.
    pub(super) what: &'static str,
    /// The array of their names.
    pub(super) names: &'static str,
    /// The array of what each begins with.
    pub(super) starts: &'static str,
}

/// Reads runs that cover `len` frames or vertices: what the JSON states of them, else the arrays. `None` where there
/// are none.
///
/// # Errors
/// Those of the arrays, [`ExamplesError::Mismatch`] for names and starts of different counts, and
/// [`ExamplesError::Start`] for a run that does not begin behind the one before it.
pub(super) fn read_runs(
    archive: &mut Archive,
    kind: &RunKind,
    names: Option<&Vec<String>>,
    starts: Option<&Vec<i64>>,
    len: usize,
) -> Result<Option<Runs>, ExamplesError> {
    let names =
        names.cloned().map_or_else(|| archive.texts(kind.names), |names| Ok(Some(names)))?;
    let starts = match starts {
        Some(starts) => Some(starts.clone()),
        None => archive
            .rows::<i64, 1>(kind.starts, &[])?
            .map(|starts| starts.data.as_flattened().to_vec()),
    };
    let (names, starts) = match (names, starts) {
        (None, None) => return Ok(None),
        (None, Some(_)) => return Err(missing(kind.names)),
        (Some(_), None) => return Err(missing(kind.starts)),
        (Some(names), Some(starts)) => (names, starts),
    };
    same(kind.what, kind.names, names.len(), kind.starts, starts.len())?;
    if names.is_empty() {
        return Err(ExamplesError::Empty { array: kind.names });
    }
    let mut begins: Vec<usize> = Vec::with_capacity(starts.len());
    for (&found, name) in starts.iter().zip(&names) {
        let fits = |start: &usize| match begins.last() {
            None => *start == 0,
            Some(before) => start > before && *start < len,
        };
        let Some(start) = usize::try_from(found).ok().filter(fits) else {
            let (array, name) = (kind.starts, name.clone());
            return Err(ExamplesError::Start { array, name, found, len });
        };
        begins.push(start);
    }
    let ends = begins.iter().skip(1).copied().chain([len]);
    let ranges = begins.iter().zip(ends).map(|(&begin, end)| begin..end);
    Ok(Some(names.into_iter().zip(ranges).collect()))
}
