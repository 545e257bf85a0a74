//! Weights of a further mesh: those of the nearest surface, fitted to where it is carried.

use super::nearest::{Foot, Tree, Triangle};
use crate::formats::Mesh;
use crate::numeric::columns;
use crate::numeric::simplex::{self, Gram, MAX_COLUMNS};
use faer::Mat;
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use sinew_runtime::Matrix3x4;

/// Further than this share of the diagonal a vertex does not belong to the model's surface.
pub(super) const FAR: f64 = 0.1;
/// Pull of fitted weights to those of the nearest point, as a share of what one transform alone errs:
/// what the frames do not show stays as it was.
const PULL: f64 = 1e-3;

/// A further mesh in the model's rest pose and space, of any topology.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Its name in the file.
    pub name: String,
    /// The mesh.
    pub mesh: Mesh,
    /// Whether its axes and unit are given as the model's, so that no others are looked for.
    pub is_placed: bool,
}

/// A further mesh that cannot follow a model's palette.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LevelError {
    /// It does not lie on the model's surface.
    #[error(
        "mesh {name} is {percent:.0} % of the diagonal away from the model's surface, expected at \
         most 10 % at the median, in whatever axes and unit: export it in the rest pose of the examples"
    )]
    Far {
        /// Its name.
        name: String,
        /// Median distance in % of the diagonal.
        percent: f64,
    },
    /// It does not lie on the model's surface in the axes that were given.
    #[error(
        "mesh {name} is {percent:.0} % of the diagonal away from the model's surface in the axes and unit given as \
         --also-axes, expected at most 10 % at the median: give others, or leave --also-axes out, so that they are \
         recognised"
    )]
    GivenAxes {
        /// Its name.
        name: String,
        /// Median distance in % of the diagonal.
        percent: f64,
    },
    /// It lies on the model's surface in several other axes, and which are meant cannot be told.
    #[error(
        "mesh {name} is not in the model's axes and unit: turned to {axes} it is {percent:.1} % of the diagonal away from \
         the model's surface, and hardly further to {}: give one of these, as --also-axes \"{axes}\", or export it in the \
         axes and unit of the examples",
        as_near.join(", ")
    )]
    Axes {
        /// Its name.
        name: String,
        /// Least median distance in % of the diagonal.
        percent: f64,
        /// Where it is so.
        axes: String,
        /// Where it is hardly more.
        as_near: Vec<String>,
    },
    /// Two skins would have one name.
    #[error(
        "two skins are called {name}: a further mesh is called as its file, without the ending, and \
         the examples' own is called skin; rename the file"
    )]
    Duplicate {
        /// The name.
        name: String,
    },
}

/// How a further mesh follows the model's own skin.
#[derive(Clone, Debug, serde::Serialize)]
pub struct LevelReport {
    /// Its name.
    pub name: String,
    /// Its vertices.
    pub vertices: usize,
    /// Its triangles.
    pub triangles: usize,
    /// How it was moved, of a mesh in other axes or another unit.
    pub moved: Option<String>,
    /// Median distance of its vertices from the model's surface at rest, in % of the diagonal.
    pub distance_percent: f64,
    /// Vertices that are further than 10 % of the diagonal from it.
    pub far: usize,
    /// RMS distance from where the surface carries the vertices, with the weights of its nearest
    /// points, in % of the diagonal.
    pub transferred_percent: f64,
    /// The same with the weights that were fitted.
    pub fitted_percent: f64,
}

/// The weights of a mesh: transforms of the palette and shares of them, a list a vertex.
pub type Influences = Vec<Vec<(usize, f64)>>;

/// A model's own skin, at rest and in some frames.
pub struct SkinSurface<'a> {
    /// V rest positions.
    pub rest: &'a [[f64; 3]],
    /// Triangles that have an area.
    pub triangles: &'a [Triangle],
    /// Weights on the palette, V.
    pub influences: &'a Influences,
    /// Most influences a vertex may have.
    pub most: usize,
    /// The rest diagonal.
    pub diagonal: f64,
    /// A palette a frame.
    pub palettes: &'a [Vec<Matrix3x4>],
    /// V posed positions a frame.
    pub posed: Vec<Vec<[f32; 3]>>,
}

impl SkinSurface<'_> {
    /// Finds weights for the vertices of a further mesh: those of the nearest point of the surface,
    /// fitted in each frame to where the surface carries the vertex.
    ///
    /// # Errors
    /// [`LevelError::Far`].
    pub fn follow(&self, level: &Level) -> Result<(Influences, LevelReport), LevelError> {
        let Level { name, mesh, .. } = level;
        let tree = Tree::new(self.rest, self.triangles);
        let around = self.around();
        let followed: Vec<Followed> = mesh
            .positions
            .par_iter()
            .filter_map(|x| {
                let foot = tree.nearest(&Vector3::from(*x))?;
                Some(self.vertex(&tree, &around, &foot, &Vector3::from(*x)))
            })
            .collect();
        let mut distances: Vec<f64> = followed.iter().map(|f| f.distance / self.diagonal).collect();
        distances.sort_by(f64::total_cmp);
        let median = distances.get(distances.len() / 2).copied().unwrap_or(f64::INFINITY);
        if median > FAR {
            return Err(LevelError::Far { name: name.clone(), percent: 100.0 * median });
        }
        let count = (followed.len() * self.palettes.len()) as f64;
        let percent = |error: fn(&Followed) -> f64| {
            let sum: f64 = followed.iter().map(error).sum();
            100.0 * (sum / count).sqrt() / self.diagonal
        };
        let report = LevelReport {
            name: name.clone(),
            vertices: mesh.positions.len(),
            triangles: mesh.triangles.len(),
            moved: None,
            distance_percent: 100.0 * median,
            far: distances.iter().filter(|&&distance| distance > FAR).count(),
            transferred_percent: percent(|f| f.transferred),
            fitted_percent: percent(|f| f.fitted),
        };
        Ok((followed.into_iter().map(|f| f.influences).collect(), report))
    }

    fn vertex(
        &self,
        tree: &Tree<'_>,
        around: &[Vec<usize>],
        foot: &Foot,
        x: &Vector3<f64>,
    ) -> Followed {
        let (columns, transferred) = self.candidates(around, foot);
        let offset = offset(tree, foot, x);
        let mut gram =
            Gram { len: columns.len(), noise: 0.0, value: [[0.0; MAX_COLUMNS]; MAX_COLUMNS] };
        for (palette, posed) in self.palettes.iter().zip(&self.posed) {
            let target = self.carried_point(posed, foot, &offset);
            let mut differences = [Vector3::zeros(); MAX_COLUMNS];
            for (difference, &index) in differences.iter_mut().zip(&columns) {
                *difference = moved(&palette[index], x) - target;
            }
            for i in 0..columns.len() {
                for j in 0..columns.len() {
                    gram.value[i][j] += differences[i].dot(&differences[j]);
                }
            }
        }
        let fitted = fit(&gram, &transferred, self.most);
        let mut influences: Vec<(usize, f64)> =
            columns.iter().copied().zip(fitted).filter(|&(_, weight)| weight > 0.0).collect();
        influences.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        Followed {
            influences,
            distance: foot.distance,
            transferred: gram.error(&transferred),
            fitted: gram.error(&fitted),
        }
    }

    /// Carries the vertices of a further mesh with the surface, as [`Self::follow`] has it: 3n x V, three
    /// rows a frame.
    pub fn carried(&self, mesh: &Mesh) -> Mat<f64> {
        let tree = Tree::new(self.rest, self.triangles);
        let mut all = Mat::zeros(3 * self.posed.len(), mesh.positions.len());
        columns::fill(&mut all, |vertex, column| {
            let x = Vector3::from(mesh.positions[vertex]);
            let Some(foot) = tree.nearest(&x) else { return };
            let offset = offset(&tree, &foot, &x);
            for (posed, y) in self.posed.iter().zip(column.as_chunks_mut::<3>().0) {
                *y = self.carried_point(posed, &foot, &offset).into();
            }
        });
        all
    }

    fn carried_point(
        &self,
        posed: &[[f32; 3]],
        foot: &Foot,
        offset: &Vector3<f64>,
    ) -> Vector3<f64> {
        let corners = self.triangles[foot.triangle].map(|v| Vector3::from(posed[v].map(f64::from)));
        point(&corners, foot) + frame(&corners) * offset
    }

    /// Lists the transforms that appear near a point of the surface, and the weights of the point itself
    /// on them: the strongest, as many as a vertex may have.
    fn candidates(&self, around: &[Vec<usize>], foot: &Foot) -> (Vec<usize>, [f64; MAX_COLUMNS]) {
        let mut found: Vec<(usize, f64, f64)> = Vec::new();
        let mut add = |vertex: usize, share: f64| {
            for &(index, weight) in &self.influences[vertex] {
                match found.iter_mut().find(|entry| entry.0 == index) {
                    Some(entry) => {
                        (entry.1, entry.2) = (entry.1 + share * weight, entry.2 + weight)
                    }
                    None => found.push((index, share * weight, weight)),
                }
            }
        };
        let corners = self.triangles[foot.triangle];
        for (&corner, share) in corners.iter().zip(foot.shares) {
            add(corner, share);
            for &triangle in &around[corner] {
                self.triangles[triangle].iter().for_each(|&vertex| add(vertex, 0.0));
            }
        }
        found.sort_by(|a, b| b.1.total_cmp(&a.1).then(b.2.total_cmp(&a.2)).then(a.0.cmp(&b.0)));
        found.truncate(MAX_COLUMNS);
        let sum: f64 = found.iter().take(self.most).map(|entry| entry.1).sum();
        let mut transferred = [0.0; MAX_COLUMNS];
        for (weight, entry) in transferred.iter_mut().zip(&found).take(self.most) {
            *weight = entry.1 / sum;
        }
        (found.into_iter().map(|entry| entry.0).collect(), transferred)
    }

    /// Lists the triangles around each vertex.
    fn around(&self) -> Vec<Vec<usize>> {
        let mut around = vec![Vec::new(); self.rest.len()];
        for (number, triangle) in self.triangles.iter().enumerate() {
            triangle.iter().for_each(|&vertex| around[vertex].push(number));
        }
        around
    }
}

/// A vertex of a further mesh.
struct Followed {
    influences: Vec<(usize, f64)>,
    distance: f64,
    /// Squared error, summed over the frames, of transferred weights.
    transferred: f64,
    /// The same of fitted ones.
    fitted: f64,
}

/// Fits weights of which at most `most` are not zero, pulled to transferred ones; gives these back
/// where that is no better.
fn fit(gram: &Gram, transferred: &[f64; MAX_COLUMNS], most: usize) -> [f64; MAX_COLUMNS] {
    let mut pulled = *gram;
    let mean = (0..gram.len).map(|i| gram.value[i][i]).sum::<f64>() / gram.len as f64;
    let square: f64 = transferred.iter().map(|w| w * w).sum();
    for i in 0..gram.len {
        for j in 0..gram.len {
            let both = if i == j { 1.0 } else { 0.0 };
            pulled.value[i][j] += PULL * mean * (both - transferred[i] - transferred[j] + square);
        }
    }
    let fitted = simplex::solve_sparse(&pulled, most, 0.0);
    let better = pulled.error(&fitted) < pulled.error(transferred);
    if better { fitted } else { *transferred }
}

/// Gives where a point stands from its foot, along the triangle's axes.
fn offset(tree: &Tree<'_>, foot: &Foot, x: &Vector3<f64>) -> Vector3<f64> {
    let corners = tree.corners(foot.triangle);
    frame(&corners).transpose() * (x - point(&corners, foot))
}

fn point(corners: &[Vector3<f64>; 3], foot: &Foot) -> Vector3<f64> {
    corners.iter().zip(foot.shares).map(|(corner, share)| corner * share).sum()
}

/// Gives the axes of a triangle: along its first side, across it, and its normal. A triangle that
/// has collapsed has none, and carries no offset.
fn frame([a, b, c]: &[Vector3<f64>; 3]) -> Matrix3<f64> {
    let unit = |v: Vector3<f64>| v.try_normalize(0.0).unwrap_or_default();
    let along = unit(b - a);
    let normal = unit(along.cross(&(c - a)));
    Matrix3::from_columns(&[along, normal.cross(&along), normal])
}

fn moved(transform: &Matrix3x4, x: &Vector3<f64>) -> Vector3<f64> {
    Vector3::from(transform.map(|[a, b, c, d]| {
        f64::from(a) * x[0] + f64::from(b) * x[1] + f64::from(c) * x[2] + f64::from(d)
    }))
}
