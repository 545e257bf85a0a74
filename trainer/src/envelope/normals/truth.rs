//! The true normals of posed meshes.

use super::fan::Fan;
use super::lean::Lean;
use crate::examples::Examples;
use crate::numeric::frame;
use nalgebra::{Vector2, Vector3};

/// The true normals of the engine's vertices in the frames of examples: those of the posed mesh, weighted by area;
/// and where they are authored, what the surface around a vertex makes of its own (METHOD §1.8).
pub struct TrueNormals<'a> {
    examples: &'a Examples,
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
    /// Measures how the authored normals of examples lean.
    pub fn new(examples: &'a Examples) -> Self {
        let surface = examples.surface();
        let rest = |vertex: usize| Vector3::from(examples.rest[vertex]);
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
        Self { examples, sides }
    }

    /// Computes the E normals of frame `index`, of length 1, or 0 where there is none.
    ///
    /// # Panics
    /// If `index` is not a frame.
    pub fn posed(&self, index: usize) -> Vec<[f64; 3]> {
        let Some(sides) = &self.sides else {
            return self.examples.surface().copied(&self.examples.posed_normals(index));
        };
        let frame = self.examples.frame(index);
        let at = |vertex: usize| Vector3::from(frame[vertex]);
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
