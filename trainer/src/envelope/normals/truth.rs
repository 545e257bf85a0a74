//! The true normals of posed meshes.

use super::fan::Fan;
use super::lean::LeaningNormal;
use crate::mesh::{Surface, normals};
use nalgebra::Vector3;

/// The true normals of a posed surface, at the engine's vertices: those of the posed mesh, weighted by area; authored normals
/// are carried by the faces around each vertex (METHOD §1.8).
pub struct TrueNormals<'a> {
    surface: Surface<'a>,
    /// Faces on one side of the hard edges at each of the engine's vertices, where normals are authored.
    sides: Option<Vec<(Fan, LeaningNormal)>>,
}

impl<'a> TrueNormals<'a> {
    /// Measures how the authored normals of a surface lean at rest.
    pub fn new(surface: Surface<'a>) -> Self {
        let rest = |vertex: usize| Vector3::from(surface.positions[vertex]);
        let side = |(fan, normal): (Fan, &[f64; 3])| {
            let leaning = LeaningNormal::new(&fan, rest, &Vector3::from(*normal));
            (fan, leaning)
        };
        let sides = surface
            .authored_normals()
            .map(|normals| Fan::of(&surface).into_iter().zip(normals).map(side).collect());
        Self { surface, sides }
    }

    /// Computes the E normals, of length 1, or 0 where there is none.
    ///
    /// - `posed`: positions of the surface's vertices, V.
    pub fn posed(&self, posed: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let Some(sides) = &self.sides else {
            return self.surface.copied(&normals(posed, self.surface.triangles));
        };
        let at = |vertex: usize| Vector3::from(posed[vertex]);
        sides
            .iter()
            .map(|(fan, leaning)| leaning.posed(fan, at).unwrap_or_default().into())
            .collect()
    }
}
