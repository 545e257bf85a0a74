//! Weights of a further mesh: transferred from the nearest surface, then fitted to the motion of that surface.

use super::nearest::{Foot, Tree, Triangle};
use crate::Error;
use crate::formats::Mesh;
use crate::numeric::columns;
use crate::numeric::simplex::{self, Gram, MAX_COLUMNS};
use faer::Mat;
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use sinew_runtime::Matrix3x4;

/// Maximum distance of a vertex from the model's surface, as a share of the diagonal.
pub(super) const FAR: f64 = 0.1;
/// Strength that pulls fitted weights to the transferred weights, as a share of the mean squared error of one
/// transform. Weights that the frames do not determine stay as transferred.
const PULL: f64 = 1e-3;

/// A further mesh in the model's rest pose and space, with any topology.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Name of its skin in the file.
    pub name: String,
    /// The mesh.
    pub mesh: Mesh,
    /// True if its axes and unit were given: other axes and units are not searched.
    pub is_placed: bool,
}

/// Report on a further mesh that follows the model's own skin.
#[derive(Clone, Debug, serde::Serialize)]
pub struct LevelReport {
    /// Name of the mesh.
    pub name: String,
    /// Number of vertices.
    pub vertices: usize,
    /// Number of triangles.
    pub triangles: usize,
    /// Conversion of a mesh in other axes or another unit.
    pub moved: Option<String>,
    /// Median distance of its vertices from the model's surface at rest, in % of the diagonal.
    pub distance_percent: f64,
    /// Number of vertices further than 10 % of the diagonal from the surface.
    pub far: usize,
    /// RMS distance of the vertices from their positions on the posed surface, in % of the diagonal, with transferred
    /// weights.
    pub transferred_percent: f64,
    /// RMS distance of the vertices from their positions on the posed surface, in % of the diagonal, with fitted
    /// weights.
    pub fitted_percent: f64,
}

/// Weights of a mesh: for each vertex a list of palette indices and weights.
pub type Influences = Vec<Vec<(usize, f64)>>;

/// A model's own skin, at rest and in some frames.
pub struct SkinSurface<'a> {
    /// Rest positions, V.
    pub rest: &'a [[f64; 3]],
    /// Triangles, each with a positive area.
    pub triangles: &'a [Triangle],
    /// Weights on the palette, V.
    pub influences: &'a Influences,
    /// Maximum number of influences of a vertex.
    pub most: usize,
    /// The rest diagonal.
    pub diagonal: f64,
    /// Palette of each frame.
    pub palettes: &'a [Vec<Matrix3x4>],
    /// Posed positions of each frame, V.
    pub posed: Vec<Vec<[f32; 3]>>,
}

impl SkinSurface<'_> {
    /// Checks that a mesh lies on the surface.
    ///
    /// # Errors
    /// The median distance is too large.
    pub fn check_near(&self, Level { name, mesh, .. }: &Level) -> Result<(), Error> {
        let tree = Tree::new(self.rest, self.triangles);
        let feet = mesh.positions.par_iter().filter_map(|x| tree.nearest(&Vector3::from(*x)));
        let median = median(feet.map(|foot| foot.distance / self.diagonal).collect());
        if median > FAR { Err(far_away(name, median)) } else { Ok(()) }
    }

    /// Finds weights for the vertices of a further mesh. Transfers the weights of the nearest point of the surface,
    /// then fits them to the vertex's position on the posed surface in all frames.
    pub fn follow(&self, level: &Level) -> (Influences, LevelReport) {
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
        let distances: Vec<f64> = followed.iter().map(|f| f.distance / self.diagonal).collect();
        let far = distances.iter().filter(|&&distance| distance > FAR).count();
        let median = median(distances);
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
            far,
            transferred_percent: percent(|f| f.transferred),
            fitted_percent: percent(|f| f.fitted),
        };
        (followed.into_iter().map(|f| f.influences).collect(), report)
    }

    /// Finds the weights of one vertex.
    ///
    /// - `around`: triangles around each surface vertex, V.
    /// - `foot`: nearest point of the surface.
    /// - `x`: rest position of the vertex.
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
                *difference = transformed(&palette[index], x) - target;
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

    /// Computes the positions of a further mesh on the posed surface: 3n x V, three rows per frame. [`Self::follow`]
    /// fits weights to these positions.
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

    /// Returns the position on the posed surface of a vertex with a given offset from its nearest point.
    fn carried_point(
        &self,
        posed: &[[f32; 3]],
        foot: &Foot,
        offset: &Vector3<f64>,
    ) -> Vector3<f64> {
        let corners = self.triangles[foot.triangle].map(|v| Vector3::from(posed[v].map(f64::from)));
        point(&corners, foot) + frame(&corners) * offset
    }

    /// Lists the transforms that the surface near a point follows, and the weights of the point on these transforms.
    /// Only the strongest weights are kept, at most `most`.
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

/// Returns the error of a mesh that does not lie on the model's surface.
///
/// - `distance`: median distance, as a share of the diagonal.
pub(super) fn far_away(name: &str, distance: f64) -> Error {
    Error::mismatch(format!(
        "mesh {name} is {:.0} % of the diagonal away from the model's surface, expected at \
         most 10 % at the median, in any axes and unit: export it in the rest pose of the examples",
        100.0 * distance
    ))
}

/// Returns the median of distances; infinite if there are none.
pub(super) fn median(mut distances: Vec<f64>) -> f64 {
    distances.sort_by(f64::total_cmp);
    distances.get(distances.len() / 2).copied().unwrap_or(f64::INFINITY)
}

/// Weights and errors of a vertex of a further mesh.
struct Followed {
    influences: Vec<(usize, f64)>,
    distance: f64,
    /// Squared error of the transferred weights, summed over the frames.
    transferred: f64,
    /// Squared error of the fitted weights, summed over the frames.
    fitted: f64,
}

/// Fits weights, pulled to the transferred weights. Returns the transferred weights if the fit is not better.
///
/// - `most`: maximum number of weights that are not 0.
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

/// Computes the offset of a point from its nearest point, along the triangle's axes.
fn offset(tree: &Tree<'_>, foot: &Foot, x: &Vector3<f64>) -> Vector3<f64> {
    let corners = tree.corners(foot.triangle);
    frame(&corners).transpose() * (x - point(&corners, foot))
}

/// Returns the point of a triangle with the barycentric coordinates of `foot`.
fn point(corners: &[Vector3<f64>; 3], foot: &Foot) -> Vector3<f64> {
    corners.iter().zip(foot.shares).map(|(corner, share)| corner * share).sum()
}

/// Returns the axes of a triangle: along its first side, across that side, and its normal. The axes of a collapsed
/// triangle are 0, so its offsets are 0.
fn frame([a, b, c]: &[Vector3<f64>; 3]) -> Matrix3<f64> {
    let unit = |v: Vector3<f64>| v.try_normalize(0.0).unwrap_or_default();
    let along = unit(b - a);
    let normal = unit(along.cross(&(c - a)));
    Matrix3::from_columns(&[along, normal.cross(&along), normal])
}

/// Transforms a position by a matrix of a palette.
fn transformed(transform: &Matrix3x4, x: &Vector3<f64>) -> Vector3<f64> {
    Vector3::from(transform.map(|[a, b, c, d]| {
        f64::from(a) * x[0] + f64::from(b) * x[1] + f64::from(c) * x[2] + f64::from(d)
    }))
}
