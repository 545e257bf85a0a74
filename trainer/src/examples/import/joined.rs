//! Joins examples of one character from several files.

use crate::Error;
use crate::examples::validate::Origin;
use crate::examples::{Clip, Examples, Skeleton, Warning};
use crate::numeric::affine::{apart, apart_unordered};
use std::path::{Path, PathBuf};

/// Result of an importer.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// Valid examples.
    pub examples: Examples,
    /// Consecutive clips that cover all frames.
    pub clips: Vec<Clip>,
    /// Repaired or ignored content, and content that a fit will ignore.
    pub warnings: Vec<Warning>,
}

impl Loaded {
    /// Checks the examples.
    ///
    /// # Errors
    /// Those of [`Examples::validate`]; they name the parts of the origin.
    pub(super) fn checked(mut self, origin: &Origin<'_>) -> Result<Self, Error> {
        self.warnings.extend(self.examples.validate_of(origin)?);
        Ok(self)
    }
}

/// Largest distance of equal rest meshes and joint origins, relative to the diagonal: covers rounding to f32 and to
/// text.
const SAME: f64 = 1e-4;

/// Concatenates the frames of several files, in the axes and unit of the first file. Clips are named FILE:CLIP. The
/// importance of vertices is the mean over files, weighted by their frames. Joint weights come from the first file that
/// has any.
///
/// # Errors
/// A file has another character than the first; the error names the file.
///
/// # Panics
/// If there is no file.
pub fn join(all: Vec<(PathBuf, Examples, Vec<Clip>)>) -> Result<(Examples, Vec<Clip>), Error> {
    assert!(!all.is_empty(), "no file");
    let several = all.len() > 1;
    let mut rest = all.into_iter();
    let Some((first, mut joined, mut clips)) = rest.next() else { unreachable!() };
    if several {
        clips = named(&first, 0, &clips);
    }
    for (file, mut next, own) in rest {
        next.convert_to(&joined.space);
        next.keep_curves(&joined.curve_names).map_err(|error| error.in_file(&file))?;
        check(&joined, &next, &first).map_err(|error| error.in_file(&file))?;
        clips.extend(named(&file, joined.frame_len(), &own));
        append(&mut joined, next);
    }
    Ok((joined, clips))
}

/// Renames a file's clips and shifts their first frames by `before`.
fn named(file: &Path, before: usize, clips: &[Clip]) -> Vec<Clip> {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let name = |clip: &Clip| match (clips.len(), clip.name == stem) {
        (1, true) => clip.name.clone(),
        _ => format!("{stem}:{}", clip.name),
    };
    let moved = |clip: &Clip| Clip { name: name(clip), first: before + clip.first, ..clip.clone() };
    clips.iter().map(moved).collect()
}

fn append(joined: &mut Examples, next: Examples) {
    let frames = [&*joined, &next].map(|own| own.frame_len() as f64);
    joined.importance = match (&joined.importance, &next.importance) {
        (None, None) => None,
        (a, b) => {
            let of = |own: &Option<Vec<f64>>, v: usize| own.as_ref().map_or(1.0, |own| own[v]);
            let mean = |v| (frames[0] * of(a, v) + frames[1] * of(b, v)) / (frames[0] + frames[1]);
            Some((0..joined.vertex_len()).map(mean).collect())
        }
    };
    if joined.frame_weights.is_some() || next.frame_weights.is_some() {
        let of =
            |own: &Examples| own.frame_weights.clone().unwrap_or_else(|| vec![1; own.frame_len()]);
        joined.frame_weights = Some([of(joined), of(&next)].concat());
    }
    joined.joint_weights = joined.joint_weights.take().or(next.joint_weights);
    let before = joined.frame_len();
    joined.clip_starts.extend(next.clip_starts.iter().map(|first| before + first));
    joined.vertices.extend(next.vertices);
    joined.own_skin &= next.own_skin;
    joined.transforms.extend(next.transforms);
    joined.curves.extend(next.curves);
    joined.split.extend(next.split);
    joined.place_joints();
}

/// Checks that both examples have the same character: counts, joints, rest mesh, rest pose and faces.
fn check(expected: &Examples, found: &Examples, first: &Path) -> Result<(), Error> {
    let first = first.file_name().unwrap_or_default().to_string_lossy();
    for (what, expected, found) in [
        ("vertices", expected.vertex_len(), found.vertex_len()),
        ("joints", expected.joint_len(), found.joint_len()),
    ] {
        if expected != found {
            return Err(Error::mismatch(format!(
                "has {found} {what}, {first} has {expected}: examples in several files are of one character"
            )));
        }
    }
    let (own, other) = (&expected.skeleton, &found.skeleton);
    if let Some(joint) = (0..own.names.len())
        .find(|&j| own.names[j] != other.names[j] || own.parents[j] != other.parents[j])
    {
        let hangs = |skeleton: &Skeleton| {
            let parent = skeleton.parents[joint].map(|parent| &skeleton.names[parent]);
            format!("{} under {}", skeleton.names[joint], parent.map_or("none", String::as_str))
        };
        let (expected, found) = (hangs(own), hangs(other));
        return Err(Error::mismatch(format!(
            "joint {joint} is {found}, in {first} it is {expected}"
        )));
    }
    let diagonal = expected.diagonal();
    let percent = 100.0 * apart(&expected.rest, &found.rest) / diagonal;
    if percent > 100.0 * SAME {
        // Detects equal positions in another order.
        let advice = match apart_unordered(&expected.rest, &found.rest) <= SAME * diagonal {
            true => "the same vertices in another order; export both with the same settings",
            false => "expected 0.01 % at most; export both in one rest pose, axes and unit",
        };
        return Err(Error::mismatch(format!(
            "its rest mesh is not that of {first}: off by {percent:.2} % of the diagonal, {advice}"
        )));
    }
    // Rest origins that were estimated from motion differ between files.
    let is_estimated =
        |joint: &usize| own.unplaced.contains(joint) || other.unplaced.contains(joint);
    let given: Vec<usize> = (0..own.names.len()).filter(|joint| !is_estimated(joint)).collect();
    let origins = |own: &Examples| -> Vec<[f64; 3]> {
        given.iter().map(|&joint| own.skeleton.rest[joint].map(|row| row[3])).collect()
    };
    let percent = 100.0 * apart(&origins(expected), &origins(found)) / diagonal;
    if percent > 100.0 * SAME {
        return Err(Error::mismatch(format!(
            "its joints at rest are not where {first} has them: off by {percent:.2} % of the diagonal; export both in \
             one rest pose"
        )));
    }
    if expected.triangles != found.triangles {
        return Err(Error::mismatch(format!(
            "its faces are not those of {first}; export both from one mesh"
        )));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::examples::testing::triangle;

    #[test]
    fn joint_weights_are_those_of_the_first_file_that_has_any() {
        let file = |weights: Option<Vec<f64>>| {
            let examples = Examples { joint_weights: weights, ..triangle(1) };
            (PathBuf::from("a.npz"), examples, Vec::new())
        };
        let [first, second] = [vec![1.0; 6], vec![0.5; 6]];
        let (joined, _) =
            join(vec![file(None), file(Some(first.clone())), file(Some(second))]).unwrap();
        assert_eq!((joined.frame_len(), joined.joint_weights), (3, Some(first)));
    }
}
