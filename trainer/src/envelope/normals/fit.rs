//! Fits the tangent coefficients of a skin (METHOD §1.8).

use super::fan::Fan;
use super::truth::{Lean, LeaningNormal};
use super::vertex::{PosedVertex, VISIBLE, VertexPose};
use crate::envelope::model::SkinModel;
use faer::Mat;
use nalgebra::Vector3;
use rayon::prelude::*;

/// Longer influence lists are used if they reduce the error of the normals to less than this share. They are tried only
/// while that error is visible.
const LONGER: f64 = 0.8;

/// A mesh in n poses, and the palettes that move it. Lengths are in units of the rest diagonal.
pub struct PosedSurface<'a> {
    /// Rest positions, V.
    pub rest: &'a [[f64; 3]],
    /// Trajectories of the positions, 3n x V.
    pub trajectories: &'a Mat<f64>,
    /// Predicted palettes, 3n x 4 per transform.
    pub palettes: &'a Mat<f64>,
    /// Fan of each vertex of the skin; its corners are indices of `rest`.
    pub fans: &'a [Fan],
    /// True if the skin's normals are authored, false if they come from the faces.
    pub authored: bool,
}

/// Influences and coefficients of a skin, one list per vertex.
struct FittedNormals {
    influences: Vec<Vec<(usize, f64)>>,
    coefficients: Vec<Vec<[f64; 2]>>,
    /// RMS angle between the normals and the true normals, in radians; weighted by area at rest.
    rms: f64,
}

impl PosedSurface<'_> {
    /// Fits the tangent coefficients of a skin, per length unit of the skin. Free places of a vertex's influence list
    /// get transforms that its neighbours follow, with weight 0. All lists become longer if that lowers the error
    /// enough.
    ///
    /// A vertex gets zeros, and so a cofactor normal, in three cases: it has no true images, coefficients do not lower
    /// a visible error, or its coefficients are beyond half precision.
    ///
    /// - `unit`: the rest diagonal in length units of the skin.
    /// - `len_max`: maximum length of an influence list that becomes longer.
    pub fn fit(&self, skin: &mut SkinModel, unit: f64, len_max: usize) {
        let len = skin.influence_len();
        if len == 0 {
            return;
        }
        let mut best = self.fitted(skin, unit, len);
        for len in len + 1..=len_max {
            if best.rms <= VISIBLE {
                break;
            }
            let longer = self.fitted(skin, unit, len);
            if longer.rms < LONGER * best.rms {
                best = longer;
            }
        }
        if best.influences.iter().any(|list| list.len() > 1) {
            skin.influences = best.influences;
            skin.tangent_coefficients = Some(best.coefficients);
        }
    }

    /// Fits the vertices of a skin with lists of `len` influences.
    fn fitted(&self, skin: &SkinModel, unit: f64, len: usize) -> FittedNormals {
        let mut followed: Vec<&[(usize, f64)]> = vec![&[]; self.rest.len()];
        for (fan, own) in self.fans.iter().zip(&skin.influences) {
            followed[fan.centre] = own;
        }
        let vertex = |(number, fan): (usize, &Fan)| {
            let influences = filled(fan, &followed, len);
            let posed = self.posed(fan, &skin.vertex(number).frame(), &influences);
            let coefficients = posed.fit(unit).unwrap_or_else(|| vec![[0.0; 2]; len]);
            let area = fan.area(|corner| self.rest[corner].into());
            let sums = [area * posed.error(&coefficients), area * posed.poses.len() as f64];
            let coefficients: Vec<_> = coefficients.iter().map(|c| c.map(|c| c / unit)).collect();
            ((influences, coefficients), sums)
        };
        let fitted: Vec<_> = self.fans.par_iter().enumerate().map(vertex).collect();
        let (lists, sums): (Vec<_>, Vec<_>) = fitted.into_iter().unzip();
        let (influences, coefficients) = lists.into_iter().unzip();
        let sum = |k: usize| sums.iter().map(|sums: &[f64; 2]| sums[k]).sum::<f64>();
        let rms = (sum(0) / sum(1).max(f64::MIN_POSITIVE)).sqrt();
        FittedNormals { influences, coefficients, rms }
    }

    /// Gathers the poses of a vertex for its fit.
    fn posed(
        &self,
        fan: &Fan,
        frame: &[Vector3<f64>; 2],
        influences: &[(usize, f64)],
    ) -> PosedVertex {
        let at_rest = |corner: usize| self.rest[corner].into();
        let leaning =
            self.authored.then(|| LeaningNormal::new(fan, at_rest, &frame[0].cross(&frame[1])));
        let lean = self.authored.then(|| Lean::new(fan, at_rest, frame)).flatten();
        let plane = if self.authored { lean.as_ref().map(|lean| &lean.plane) } else { Some(frame) };
        let images = plane.and_then(|plane| fan.images(at_rest, plane));
        let (first, others) = influences.split_first().map_or((0, &[][..]), |(f, o)| (f.0, o));
        let x = self.rest[fan.centre];
        let differences: Vec<Vec<f64>> = others
            .iter()
            .map(|&(l, _)| {
                self.combined(&[(l, [x[0], x[1], x[2], 1.0]), (first, [-x[0], -x[1], -x[2], -1.0])])
            })
            .collect();
        let blended = frame.map(|axis| {
            let term = |&(l, weight): &(usize, f64)| {
                let along = axis * weight;
                (l, [along.x, along.y, along.z, 0.0])
            };
            self.combined(&influences.iter().map(term).collect::<Vec<_>>())
        });

        let pose_len = self.trajectories.nrows() / 3;
        let mut out = PosedVertex {
            poses: Vec::new(),
            differences: Vec::new(),
            free: others.len(),
            pose_len,
        };
        for pose in 0..pose_len {
            let at = |position: usize| in_pose(self.trajectories.col_as_slice(position), pose);
            let Some(mut normal) = fan.normal(at).try_normalize(0.0) else { continue };
            let mut carried = images.as_ref().map(|images| fan.carried(images, at, &normal));
            if let Some(leaning) = &leaning {
                let Some(truth) = leaning.posed(fan, at) else { continue };
                let images = carried.zip(lean.as_ref()).map(|(of, lean)| lean.images(of, normal));
                normal = truth;
                carried =
                    images.map(|images| images.map(|image| image - truth * truth.dot(&image)));
            }
            // Faces folded onto each other may invert the map, and its normal would point inward.
            let images = carried.filter(|[u, v]| normal.dot(&u.cross(v)) > 0.0);
            let blended = [0, 1].map(|k| in_pose(&blended[k], pose));
            out.poses.push(VertexPose { normal, blended, images });
            out.differences.extend(differences.iter().map(|y| in_pose(y, pose)));
        }
        out
    }

    /// Sums transforms times vectors, in each pose: 3n.
    ///
    /// - `terms`: palette index and vector.
    fn combined(&self, terms: &[(usize, [f64; 4])]) -> Vec<f64> {
        let mut out = vec![0.0; self.palettes.nrows()];
        for (l, vector) in terms {
            for (c, factor) in vector.iter().enumerate().filter(|(_, factor)| **factor != 0.0) {
                let column = self.palettes.col_as_slice(4 * l + c);
                out.iter_mut().zip(column).for_each(|(sum, m)| *sum += factor * m);
            }
        }
        out
    }
}

/// Lists the influences of a vertex, then the other influences of the corners of its faces, the strongest first, with
/// weight 0. Repeats the last entry if there are fewer than `len`.
///
/// - `influences`: of each position, V.
fn filled(fan: &Fan, influences: &[&[(usize, f64)]], len: usize) -> Vec<(usize, f64)> {
    let mut out = influences[fan.centre].to_vec();
    let mut others: Vec<(usize, f64)> = Vec::new();
    for &(index, weight) in fan.faces.iter().flatten().flat_map(|&corner| influences[corner]) {
        if out.iter().any(|own| own.0 == index) {
            continue;
        }
        match others.iter_mut().find(|other| other.0 == index) {
            Some(other) => other.1 += weight,
            None => others.push((index, weight)),
        }
    }
    others.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    out.extend(others.into_iter().map(|(index, _)| (index, 0.0)));
    out.truncate(len);
    let last = out.last().map_or(0, |last| last.0);
    out.resize(len, (last, 0.0));
    out
}

/// Returns the vector of a pose from a trajectory, 3n.
fn in_pose(trajectory: &[f64], pose: usize) -> Vector3<f64> {
    Vector3::from_column_slice(&trajectory[3 * pose..3 * pose + 3])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::envelope::fitted::Fitted;
    use crate::envelope::helpers::fit::HelperFit;
    use crate::envelope::lbs::training::Training;
    use crate::examples::Examples;
    use crate::examples::demo::{DemoOptions, demo};
    use crate::progress::Silent;
    use nalgebra::{DMatrix, DVector, Matrix3};
    use sinew_runtime::envelope::Certificate;
    use std::sync::LazyLock;

    /// Returns a small arm in training units, the true palettes of its helpers, its fans and its skin.
    fn arm() -> (Training<'static>, Mat<f64>, Vec<Fan>, SkinModel) {
        static ARM: LazyLock<Examples> =
            LazyLock::new(|| demo(&DemoOptions { vertices: 200, poses: 12, held_out: 0, seed: 1 }));
        let training = Training::new(&ARM, &Silent).unwrap();
        let helpers = HelperFit::new(&training, sinew_runtime::envelope::HelperKind::Affine)
            .unwrap()
            .run(6, 4);
        let palettes = helpers.true_palette(&training.poses);
        let fitted = Fitted::new(&training, helpers.weights, None);
        let mut model = fitted.file_model(&training, Certificate::default());
        let fans = Fan::all(&ARM.triangles, ARM.vertex_len());
        (training, palettes, fans, model.skins.remove(0))
    }

    fn surface<'a>(
        training: &'a Training<'a>,
        palettes: &'a Mat<f64>,
        fans: &'a [Fan],
    ) -> PosedSurface<'a> {
        let Training { rest, trajectories, .. } = training;
        PosedSurface { rest, trajectories, palettes, fans, authored: false }
    }

    /// Solves all equations of one vertex by a singular value decomposition.
    fn brute_force(
        surface: &PosedSurface<'_>,
        fan: &Fan,
        [t, b]: [Vector3<f64>; 2],
        influences: &[(usize, f64)],
    ) -> DMatrix<f64> {
        let rest = |v: usize| Vector3::from(surface.rest[v]);
        // The area-weighted mean of the maps of the faces; a map comes from two edges and the unit normal.
        let map_of = |at: &dyn Fn(usize) -> Vector3<f64>| {
            let mean = |&[p, q]: &[usize; 2]| {
                let edges = |at: &dyn Fn(usize) -> Vector3<f64>| {
                    let [a, b] = [p, q].map(|v| at(v) - at(fan.centre));
                    Matrix3::from_columns(&[a, b, a.cross(&b).normalize()])
                };
                let from = edges(&rest);
                let flat = Matrix3::identity() - from.column(2) * from.column(2).transpose();
                edges(at) * from.try_inverse().unwrap() * flat * from.determinant()
            };
            fan.faces.iter().map(mean).sum::<Matrix3<f64>>()
        };
        let axes = nalgebra::Matrix3x2::from_columns(&[t, b]);
        let at_rest = (axes.transpose() * map_of(&rest) * axes).try_inverse().unwrap();
        let (poses, free) = (surface.trajectories.nrows() / 3, influences.len() - 1);
        let map = |l: usize, pose: usize| {
            nalgebra::Matrix3x4::from_fn(|r, c| surface.palettes[(3 * pose + r, 4 * l + c)])
        };
        let mut left = DMatrix::zeros(3 * poses, free);
        let mut right = DMatrix::zeros(3 * poses, 2);
        for pose in 0..poses {
            let at = |v: usize| in_pose(surface.trajectories.col_as_slice(v), pose);
            let faces = fan.faces.iter();
            let normal: Vector3<f64> = faces
                .map(|&[p, q]| (at(p) - at(fan.centre)).cross(&(at(q) - at(fan.centre))))
                .sum();
            let along = normal.normalize() * normal.normalize().transpose();
            let root = Matrix3::identity() * 0.3 + along * 0.7;
            let x = rest(fan.centre).push(1.0);
            let moved = |l: usize| map(influences[l].0, pose) * x;
            for l in 0..free {
                let apart = root * (moved(l + 1) - moved(0));
                left.fixed_view_mut::<3, 1>(3 * pose, l).copy_from(&apart);
            }
            for (k, axis) in [t, b].into_iter().enumerate() {
                let image = map_of(&at) * axes * at_rest.column(k);
                let blended: Vector3<f64> = influences
                    .iter()
                    .map(|&(l, weight)| map(l, pose).fixed_columns::<3>(0) * axis * weight)
                    .sum();
                let wanted = image - along * image - blended;
                right.fixed_view_mut::<3, 1>(3 * pose, k).copy_from(&(root * wanted));
            }
        }
        let ridge = 1e-5 * left.norm_squared() / free as f64 + 1e-14 * poses as f64;
        let mut left = left.resize_vertically(3 * poses + free, 0.0);
        (0..free).for_each(|l| left[(3 * poses + l, l)] = ridge.sqrt());
        let right = right.resize_vertically(3 * poses + free, 0.0);
        left.svd(true, true).solve(&right, 0.0).unwrap()
    }

    #[test]
    fn the_fit_of_a_vertex_solves_all_its_equations() {
        let (training, palettes, fans, mut skin) = arm();
        let surface = surface(&training, &palettes, &fans);
        surface.fit(&mut skin, training.unit, 4);
        let mut largest: f64 = 0.0;
        for vertex in (0..fans.len()).step_by(7) {
            let own = &skin.influences[vertex];
            let frame = skin.vertex(vertex).frame();
            let expected = brute_force(&surface, &fans[vertex], frame, own);
            let found = surface.posed(&fans[vertex], &frame, own).linear().unwrap();
            let size = expected.amax().max(1e-3);
            for (a, found) in found[1..].iter().enumerate() {
                for k in 0..2 {
                    let difference = found[k] - expected[(a, k)];
                    assert!(difference.abs() < 1e-6 * size, "{vertex}: {difference} of {size}");
                }
            }
            for k in 0..2 {
                let sum = DVector::from_iterator(own.len(), found.iter().map(|c| c[k])).sum();
                assert!(sum.abs() < 1e-12 * size, "the coefficients of a vertex must sum to 0");
            }
            largest = largest.max(expected.amax());
        }
        assert!(largest > 1.0, "{largest}");
    }

    #[test]
    fn lists_are_filled_with_influences_of_neighbours_and_weights_do_not_change() {
        let (training, palettes, fans, mut skin) = arm();
        let before = skin.influences.clone();
        let most = skin.influence_len();
        surface(&training, &palettes, &fans).fit(&mut skin, training.unit, 4);
        let mut taken = 0;
        for (vertex, (own, filled)) in before.iter().zip(&skin.influences).enumerate() {
            assert_eq!((&filled[..own.len()], filled.len()), (&own[..], most));
            for &(index, weight) in &filled[own.len()..] {
                let follows = |&corner: &usize| before[corner].iter().any(|i| i.0 == index);
                let near = fans[vertex].faces.iter().flatten().any(follows);
                assert!(weight == 0.0 && (near || index == own[own.len() - 1].0));
                taken += usize::from(near);
            }
        }
        assert!(taken > 0, "a rigid vertex next to blended vertices must take influences");
    }

    #[test]
    fn vertices_without_true_images_get_no_coefficients() {
        let (training, palettes, mut fans, mut skin) = arm();
        let rest = skin.clone();
        // Vertex 0 has no face, vertex 1 has one face, vertex 2 has a face without area.
        fans[0].faces.clear();
        fans[1].faces.truncate(1);
        let next = fans[2].faces[0][0];
        fans[2].faces = vec![[next, next]];
        surface(&training, &palettes, &fans).fit(&mut skin, training.unit, 4);
        let zero = |skin: &SkinModel, vertex: usize| {
            skin.tangent_coefficients.as_ref().unwrap()[vertex].iter().flatten().all(|c| *c == 0.0)
        };
        assert!(zero(&skin, 0) && !zero(&skin, 1) && zero(&skin, 2) && !zero(&skin, 3));
        // Equal transforms determine no coefficients: their differences are rounding errors.
        let mut equal = Mat::zeros(palettes.nrows(), palettes.ncols());
        for column in 0..equal.ncols() {
            equal.col_mut(column).copy_from(palettes.col(column % 4));
        }
        let mut same = rest.clone();
        surface(&training, &equal, &fans).fit(&mut same, training.unit, 4);
        let all = same.tangent_coefficients.unwrap();
        assert!(all.iter().flatten().flatten().all(|c| c.abs() < 0.1));
        // Coefficients beyond half precision, here in a huge length unit, are 0 and not infinite.
        let mut far = rest;
        surface(&training, &palettes, &fans).fit(&mut far, 1e-16, 4);
        assert!(zero(&far, 3));
    }

    #[test]
    fn a_skin_with_one_influence_per_vertex_gets_no_coefficients() {
        let (training, palettes, fans, mut skin) = arm();
        skin.influences.iter_mut().for_each(|list| list.truncate(1));
        surface(&training, &palettes, &fans).fit(&mut skin, training.unit, 1);
        assert!(skin.tangent_coefficients.is_none());
        assert!(skin.influences.iter().all(|list| list.len() == 1));
    }
}
