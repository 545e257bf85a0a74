//! Inputs, outputs and tolerances of every stage in plain files, for authors of backends.

mod alone;
mod case;
mod folder;
mod written;

pub use folder::{Folder, VectorError};

use crate::filters::{self, FilterSubject};
use crate::models::{self, SHAPES};
use crate::subject::Subject;
use ::models::{GOLDEN, GOLDEN_STRETCH, KernelContent, Pieces};
use case::{Case, subject};
use sinew_runtime::envelope::Predictor;
use std::path::Path;

/// The page at the top of the folder.
const README: &str = include_str!("README.md");
/// Number of poses drawn for a random model, before those with an undecided half turn are removed.
const POSES: usize = 41;
/// Number of poses drawn for a trained character.
const CHARACTER_POSES: usize = 77;

/// Number of queries of a kernel.
const QUERIES: usize = 41;
/// Number of faces of a skin with shapes.
const FACES: usize = 7;
/// Number of signals of a filter.
const SIGNALS: usize = 3;

/// Writes the vectors into a folder that does not exist or is empty. The folder appears whole or
/// not at all.
///
/// # Errors
/// [`VectorError`]
pub fn write(out: &Path) -> Result<(), VectorError> {
    let folder = Folder::create(out)?;
    folder.write("README.md", README.as_bytes())?;
    // The trained characters come from the golden files, which have equal bytes on every machine.
    for (kind, files) in [("character", GOLDEN), ("character-stretch", GOLDEN_STRETCH)] {
        for (predictor, bytes) in Predictor::ALL.into_iter().zip(files) {
            let case = format!("{kind}-{}", predictor.name());
            Case::new(&case, &subject(bytes, CHARACTER_POSES)).write(bytes, &folder)?;
        }
    }
    for (shape, bytes) in SHAPES.iter().zip(models::shapes()) {
        let own: Subject<'_> = subject(bytes, POSES);
        let [v, j, p, k] = [shape.vertices, shape.joints, shape.proxies, shape.influences];
        let case = format!("random-{}-{v}-{j}-{p}-{k}", shape.predictor.name());
        Case::new(&case, &own).write(bytes, &folder)?;
    }
    for content in KernelContent::goldens().into_iter().chain([KernelContent::servo()]) {
        let name = content.name.replace([' ', '/'], "-").replace('é', "e");
        let bytes = Pieces::kernels(&[content]).bytes();
        alone::kernel(&format!("kernel-{name}"), &bytes, QUERIES, &folder)?;
    }
    for (element, pieces) in ["f32", "f16", "i8", "few"].into_iter().zip(Pieces::shaped()) {
        alone::shapes(&format!("shapes-{element}"), &pieces.bytes(), FACES, &folder)?;
    }
    for (bytes, lanes) in filters::files().iter().zip([1, 3, 8, 5]) {
        let subject = FilterSubject::new(bytes, SIGNALS, lanes);
        let case = format!("filter-{}-{}", subject.filter.factor(), subject.filter.tap_len());
        alone::filter(&case, bytes, &subject, &folder)?;
    }
    folder.finish()
}
