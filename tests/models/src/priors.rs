//! Priors as plain lists, whose fields may be invalid.

use crate::bytes::{floats, halves, names, words};
use crate::pieces::{Content, Pieces};
use crate::rng::Rng;
use sinew_runtime::format::{PartKind, PartRow, SectionKind};
use sinew_runtime::prior::PRIOR_SECTIONS;

/// A prior as plain lists.
#[derive(Clone)]
pub struct PriorContent {
    /// Name of the part.
    pub name: String,
    /// Part of its skin.
    pub skin: u32,
    /// S means.
    pub mean: Vec<f32>,
    /// Rows of the factor's upper triangle, each starting at the diagonal.
    pub factor: Vec<Vec<f32>>,
    /// S bounds: minimum and maximum.
    pub bounds: Vec<[f32; 2]>,
    /// Mirrored pairs, and their stiffness.
    pub symmetry: Vec<([u16; 2], f32)>,
    /// Cancelling pairs.
    pub cancel: Vec<[u16; 2]>,
    /// β, number of frames, error, slider error.
    pub fit: [f32; 4],
}

impl PriorContent {
    /// Makes a prior of S shapes of a skin. Every shape correlates with all others. With at least
    /// four shapes, one pair is mirrored and one pair cancels.
    pub fn sample(skin: u32, shape_len: usize) -> Self {
        let mut rng = Rng(40);
        let row = |row: usize, rng: &mut Rng| {
            let others = (row + 1..shape_len).map(|_| 0.5 * rng.unit());
            [1.5 + 0.25 * row as f32].into_iter().chain(others).collect::<Vec<_>>()
        };
        let factor = (0..shape_len).map(|at| row(at, &mut rng)).collect();
        let has_pairs = shape_len >= 4;
        Self {
            name: "prior".to_owned(),
            skin,
            mean: (0..shape_len).map(|shape| 0.125 + 0.0625 * (shape % 4) as f32).collect(),
            factor,
            bounds: (0..shape_len).map(|shape| [0.0, 1.0 - 0.0625 * (shape % 3) as f32]).collect(),
            symmetry: if has_pairs { vec![([0, 1], 2.5)] } else { Vec::new() },
            cancel: if has_pairs { vec![[3, 2]] } else { Vec::new() },
            fit: [0.0004, 1400.0, 0.0625, 0.125],
        }
    }

    /// Writes the sections.
    ///
    /// # Panics
    /// If the order of sections differs from FORMAT.md.
    fn sections(&self) -> [(SectionKind, Vec<u8>); 8] {
        let lens = [self.mean.len(), self.symmetry.len(), self.cancel.len()].map(|len| len as u32);
        let [s, y, c] = lens;
        let mirrored = self.symmetry.iter();
        let mirrored = mirrored.flat_map(|(pair, x)| [halves(pair), floats(&[*x])].concat());
        let written = [
            (SectionKind::PriorCounts, words(&[self.skin, s, y, c])),
            (SectionKind::Names, names(&self.name, &[])),
            (SectionKind::PriorMean, floats(&self.mean)),
            (SectionKind::PriorFactor, floats(&self.factor.concat())),
            (SectionKind::WeightBounds, floats(self.bounds.as_flattened())),
            (SectionKind::Symmetry, mirrored.collect()),
            (SectionKind::CancelPairs, halves(self.cancel.as_flattened())),
            (SectionKind::PriorFit, floats(&self.fit)),
        ];
        assert!(written.iter().map(|(kind, _)| *kind).eq(PRIOR_SECTIONS));
        written
    }
}

/// Name of the golden file of a face, which [`Pieces::face`] makes.
pub const FACE_NAME: &str = "prior-11.snw";

impl Pieces {
    /// Appends a prior.
    ///
    /// # Panics
    /// If the order of sections differs from FORMAT.md.
    pub fn add_prior(&mut self, content: &PriorContent) {
        let part = self.parts.len() as u16;
        self.parts.push(PartRow { kind: PartKind::Prior.number(), flags: 1 });
        let own = content.sections().into_iter();
        self.sections.extend(own.map(|(kind, bytes)| Content::new(kind, part, bytes)));
    }

    /// Makes a face: a skin of 9 vertices and 8 shapes that follows no envelope, and a prior over
    /// the shapes.
    ///
    /// # Panics
    /// If the order of sections differs from FORMAT.md.
    pub fn face() -> Self {
        let [.., mut pieces] = Self::shaped();
        pieces.add_prior(&PriorContent::sample(0, 8));
        pieces
    }
}
