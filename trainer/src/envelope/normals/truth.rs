//! The true normals of posed meshes.

use super::fan::Fan;
use super::lean::Lean;
use crate::mesh::{Surface, normals};
use crate::numeric::frame;
use nalgebra::{Vector2, Vector3};

/// The true normals of the engine's vertices of a surface wherever its vertices go: those of the posed mesh, weighted by area;
/// and where they are authored, what the surface around a vertex makes of its own (METHOD §1.8).
pub struct TrueNormals<'a> {
    surface: Surface<'a>,
    /// Of each of the engine's vertices, where normals are authored.
    sides: Option<Vec<Side>>,
}

/// The faces of a vertex that are on one side of its hard edges.
struct Side {
    fan: Fan,
    leaning: Option<Leaning>,
}

/// An authored normal, and what the images of the plane's axes are made of.
struct Leaning {
    lean: Lean,
    images: Vec<(usize, Vector2<f64>)>,
}

impl<'a> TrueNormals<'a> {
    /// Measures how the authored normals of a surface lean at rest.
    pub fn new(surface: Surface<'a>) -> Self {
        let rest = |vertex: usize| Vector3::from(surface.positions[vertex]);
        let side = |(fan, normal): (Fan, &[f64; 3])| {
            let normal = Vector3::from(*normal);
            let along = frame::tangent(&normal);
            let lean = Lean::new(&fan, rest, &[along, normal.cross(&along)]);
            let leaning = lean.and_then(|lean| {
                let images = fan.images(rest, &lean.plane)?;
                Some(Leaning { lean, images })
            });
            Side { fan, leaning }
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
        sides.iter().map(|side| side.posed(at).unwrap_or_default().into()).collect()
    }
}

impl Side {
    fn posed(&self, at: impl Fn(usize) -> Vector3<f64> + Copy) -> Option<Vector3<f64>> {
        let normal = self.fan.normal(at).try_normalize(0.0)?;
        let Some(Leaning { lean, images }) = &self.leaning else { return Some(normal) };
        let [u, v] = self.fan.carried(images, at, &normal);
        let [along, across] = lean.images([u, v], normal);
        along.cross(&across).try_normalize(0.0)
    }
}
