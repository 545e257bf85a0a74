//! The golden files.

use crate::pieces::Pieces;
use crate::shape::{SMALL, Shape};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::SectionKind;
use std::path::{Path, PathBuf};

/// Names of the golden files, by predictor: rotational, kernel.
pub const GOLDEN_NAMES: [&str; 2] = ["envelope-11-rotational.snw", "envelope-11-kernel.snw"];

/// The golden files named by [`GOLDEN_NAMES`].
pub const GOLDEN: [&[u8]; 2] = [
    include_bytes!("../../golden/envelope-11-rotational.snw"),
    include_bytes!("../../golden/envelope-11-kernel.snw"),
];

/// Names of the golden files whose joints stretch, by predictor. The kernel file has curves.
pub const GOLDEN_STRETCH_NAMES: [&str; 2] =
    ["envelope-11-stretch-rotational.snw", "envelope-11-stretch.snw"];

/// The golden files named by [`GOLDEN_STRETCH_NAMES`].
pub const GOLDEN_STRETCH: [&[u8]; 2] = [
    include_bytes!("../../golden/envelope-11-stretch-rotational.snw"),
    include_bytes!("../../golden/envelope-11-stretch.snw"),
];

/// Names of the golden files whose helpers are of kind trs, with joints that stretch and curves, and of kind rigid.
pub const GOLDEN_KIND_NAMES: [&str; 2] = ["envelope-11-trs.snw", "envelope-11-rigid.snw"];

/// The golden files named by [`GOLDEN_KIND_NAMES`].
pub const GOLDEN_KIND: [&[u8]; 2] = [
    include_bytes!("../../golden/envelope-11-trs.snw"),
    include_bytes!("../../golden/envelope-11-rigid.snw"),
];

/// Names of the golden skins with tangent coefficients, which [`Pieces::turned`] makes.
pub const TURNED_NAMES: [&str; 2] = ["skin-11-tangents.snw", "skin-11-normals.snw"];

/// The golden files named by [`TURNED_NAMES`]: with tangents, and with normals only.
pub const TURNED: [&[u8]; 2] = [
    include_bytes!("../../golden/skin-11-tangents.snw"),
    include_bytes!("../../golden/skin-11-normals.snw"),
];

impl Pieces {
    /// Makes the golden files of skins with tangent coefficients: one with four influences and
    /// tangents, one with three influences and no tangents. Normals point in all directions; one
    /// normal is zero.
    ///
    /// # Panics
    /// As [`Pieces::sample`] does.
    pub fn turned() -> [Self; 2] {
        let shape = Shape { vertices: 41, joints: 6, proxies: 5, influences: 4, ..SMALL };
        let other = Shape { vertices: 38, influences: 3, tangents: false, ..shape };
        [(Predictor::Kernel, shape), (Predictor::Kernel, other)].map(|(predictor, shape)| {
            let mut pieces = Self::sample(predictor, shape);
            for (kind, floats) in [(SectionKind::RestNormals, 3), (SectionKind::RestTangents, 4)] {
                if pieces.find(kind).is_none() {
                    continue;
                }
                // Flips z of every third vertex.
                pieces.edit_vertices(kind, |numbers| {
                    for vertex in numbers.chunks_mut(4 * floats).step_by(3) {
                        vertex[11] ^= 0x80;
                    }
                });
            }
            pieces.edit_vertices(SectionKind::RestNormals, |numbers| numbers[12..24].fill(0));
            let coefficients = 4 * (shape.influences - 1);
            pieces.edit_vertices(SectionKind::TangentCoefficients, |numbers| {
                numbers[coefficients..2 * coefficients].fill(0);
            });
            pieces
        })
    }
}

/// Returns the path of a golden file, or of their folder if `name` is empty.
pub fn golden_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../golden").join(name)
}
