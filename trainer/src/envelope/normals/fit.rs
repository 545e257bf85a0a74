//! The fit of tangent coefficients (METHOD §1.8).

use super::fan::Fan;
use super::lean::{Lean, LeaningNormal};
use super::vertex::{PosedVertex, SEEN, VertexPose};
use crate::envelope::model::SkinModel;
use faer::Mat;
use nalgebra::Vector3;
use rayon::prelude::*;

/// Longer lists are worth their bytes where they leave at most this share of the normals' error, and
/// shorter ones leave one that is seen.
const WIDER: f64 = 0.8;

/// A mesh in n poses, and the palettes that are to carry it; lengths in units of the rest diagonal.
pub struct PosedSurface<'a> {
    /// Rest positions.
    pub rest: &'a [[f64; 3]],
    /// Their trajectories, 3n a position.
    pub trajectories: &'a Mat<f64>,
    /// The palettes as they are predicted, 3n x 4 a transform.
    pub palettes: &'a Mat<f64>,
    /// The faces of each of the skin's vertices, by these positions.
    pub fans: &'a [Fan],
    /// Whether the skin's normals are authored, and not those of the faces.
    pub authored: bool,
}

/// What a fit gives the vertices of a skin.
struct FittedNormals {
    influences: Vec<Vec<(usize, f64)>>,
    coefficients: Vec<Vec<[f64; 2]>>,
    /// RMS angle of the normals over the poses and the rest surface's area, in radians.
    rms: f64,
}

impl PosedSurface<'_> {
    /// Fits the tangent coefficients of a skin of these vertices, per unit of its lengths. What a vertex's list has room
    /// for is filled with transforms that its neighbours follow, of weight 0; all lists are made longer where normals
    /// gain much by it. A vertex whose surface says nothing, whose normals coefficients do not bring nearer to the
    /// truth, or whose coefficients half precision cannot hold, gets zeros: its normal goes by cofactors.
    ///
    /// - `unit`: the rest diagonal in the skin's lengths.
    /// - `most`: the greatest length of a list that has grown.
    pub fn fit(&self, skin: &mut SkinModel, unit: f64, most: usize) {
        let len = skin.influence_len();
        if len == 0 {
            return;
        }
        let mut best = self.fitted(skin, unit, len);
        for len in len + 1..=most {
            if best.rms <= SEEN {
                break;
            }
            let wider = self.fitted(skin, unit, len);
            if wider.rms < WIDER * best.rms {
                best = wider;
            }
        }
        if best.influences.iter().any(|list| list.len() > 1) {
            skin.influences = best.influences;
            skin.tangent_coefficients = Some(best.coefficients);
        }
    }

    /// Fits the vertices of a skin with lists of `len` influences.
    fn fitted(&self, skin: &SkinModel, unit: f64, len: usize) -> FittedNormals {
        let mut of_positions: Vec<&[(usize, f64)]> = vec![&[]; self.rest.len()];
        for (fan, own) in self.fans.iter().zip(&skin.influences) {
            of_positions[fan.centre] = own;
        }
        let vertex = |(number, fan): (usize, &Fan)| {
            let influences = filled(fan, &of_positions, len);
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
        let (last, others) = influences.split_last().map_or((0, &[][..]), |(last, o)| (last.0, o));
        let x = self.rest[fan.centre];
        let apart: Vec<Vec<f64>> = others
            .iter()
            .map(|&(l, _)| {
                self.combined(&[(l, [x[0], x[1], x[2], 1.0]), (last, [-x[0], -x[1], -x[2], -1.0])])
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
        let mut out =
            PosedVertex { poses: Vec::new(), apart: Vec::new(), free: others.len(), pose_len };
        for pose in 0..pose_len {
            let at = |position: usize| of(self.trajectories.col_as_slice(position), pose);
            let Some(mut normal) = fan.normal(at).try_normalize(0.0) else { continue };
            let mut carried = images.as_ref().map(|images| fan.carried(images, at, &normal));
            if let Some(leaning) = &leaning {
                let Some(truth) = leaning.posed(fan, at) else { continue };
                let images = carried.zip(lean.as_ref()).map(|(of, lean)| lean.images(of, normal));
                normal = truth;
                carried =
                    images.map(|images| images.map(|image| image - truth * truth.dot(&image)));
            }
            // Faces that are folded onto each other may turn the map over: its normal would point inward.
            let images = carried.filter(|[u, v]| normal.dot(&u.cross(v)) > 0.0);
            let blended = [0, 1].map(|k| of(&blended[k], pose));
            out.poses.push(VertexPose { normal, blended, images });
            out.apart.extend(apart.iter().map(|apart| of(apart, pose)));
        }
        out
    }

    /// Adds up transforms, each times a vector, over the poses.
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

/// Lists the influences of a vertex, then as many as there is room for of those that the corners of its faces follow
/// and it does not, the strongest first. Where there is room left, the last comes again.
fn filled(fan: &Fan, influences: &[&[(usize, f64)]], most: usize) -> Vec<(usize, f64)> {
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
    out.truncate(most);
    let last = out.last().map_or(0, |last| last.0);
    out.resize(most, (last, 0.0));
    out
}

/// The vector of a pose among those of a trajectory.
fn of(trajectory: &[f64], pose: usize) -> Vector3<f64> {
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

    /// A small arm in the training's lengths, its helpers' true palettes, and the skin that follows them.
    fn arm() -> (Training<'static>, Mat<f64>, Vec<Fan>, SkinModel) {
        static ARM: LazyLock<Examples> =
            LazyLock::new(|| demo(&DemoOptions { vertices: 200, poses: 12, held_out: 0, seed: 1 }));
        let training = Training::new(&ARM, &Silent).unwrap();
        let helpers = HelperFit::new(&training).unwrap().run(6, 4);
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

    /// Solves one vertex by the singular values of all its equations, of the edges' and of the frames'.
    fn brute_force(
        surface: &PosedSurface<'_>,
        fan: &Fan,
        [t, b]: [Vector3<f64>; 2],
        influences: &[(usize, f64)],
    ) -> DMatrix<f64> {
        let rest = |v: usize| Vector3::from(surface.rest[v]);
        // The mean map of the faces by area, each by its own edges and unit normal.
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
            let at = |v: usize| of(surface.trajectories.col_as_slice(v), pose);
            let faces = fan.faces.iter();
            let normal: Vector3<f64> = faces
                .map(|&[p, q]| (at(p) - at(fan.centre)).cross(&(at(q) - at(fan.centre))))
                .sum();
            let along = normal.normalize() * normal.normalize().transpose();
            let root = Matrix3::identity() * 0.3 + along * 0.7;
            let x = rest(fan.centre).push(1.0);
            let moved = |l: usize| map(influences[l].0, pose) * x;
            for l in 0..free {
                let apart = root * (moved(l) - moved(free));
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
    fn a_vertex_is_fitted_as_all_its_equations_ask() {
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
            for (a, found) in found[..own.len() - 1].iter().enumerate() {
                for k in 0..2 {
                    let difference = found[k] - expected[(a, k)];
                    assert!(difference.abs() < 1e-6 * size, "{vertex}: {difference} of {size}");
                }
            }
            for k in 0..2 {
                let sum = DVector::from_iterator(own.len(), found.iter().map(|c| c[k])).sum();
                assert!(sum.abs() < 1e-12 * size, "the coefficients of a vertex sum to 0");
            }
            largest = largest.max(expected.amax());
        }
        assert!(largest > 1.0, "{largest}");
    }

    #[test]
    fn lists_are_filled_with_what_neighbours_follow_and_weigh_as_before() {
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
        assert!(taken > 0, "a rigid vertex beside blended ones");
    }

    #[test]
    fn vertices_whose_surface_says_nothing_go_by_cofactors() {
        let (training, palettes, mut fans, mut skin) = arm();
        let rest = skin.clone();
        // Without a face; with one; with one of no area.
        fans[0].faces.clear();
        fans[1].faces.truncate(1);
        let next = fans[2].faces[0][0];
        fans[2].faces = vec![[next, next]];
        surface(&training, &palettes, &fans).fit(&mut skin, training.unit, 4);
        let zero = |skin: &SkinModel, vertex: usize| {
            skin.tangent_coefficients.as_ref().unwrap()[vertex].iter().flatten().all(|c| *c == 0.0)
        };
        assert!(zero(&skin, 0) && !zero(&skin, 1) && zero(&skin, 2) && !zero(&skin, 3));
        // Transforms that never part say nothing either: what is left is the rounding of equal numbers.
        let mut alike = Mat::zeros(palettes.nrows(), palettes.ncols());
        for column in 0..alike.ncols() {
            alike.col_mut(column).copy_from(palettes.col(column % 4));
        }
        let mut same = rest.clone();
        surface(&training, &alike, &fans).fit(&mut same, training.unit, 4);
        let all = same.tangent_coefficients.unwrap();
        assert!(all.iter().flatten().flatten().all(|c| c.abs() < 0.1));
        // What half precision cannot hold, in a unit of light-years, is 0, not infinite.
        let mut far = rest;
        surface(&training, &palettes, &fans).fit(&mut far, 1e-16, 4);
        assert!(zero(&far, 3));
    }

    #[test]
    fn a_skin_that_may_follow_one_transform_a_vertex_gets_no_coefficients() {
        let (training, palettes, fans, mut skin) = arm();
        skin.influences.iter_mut().for_each(|list| list.truncate(1));
        surface(&training, &palettes, &fans).fit(&mut skin, training.unit, 1);
        assert!(skin.tangent_coefficients.is_none());
        assert!(skin.influences.iter().all(|list| list.len() == 1));
    }
}
