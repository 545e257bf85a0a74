//! Normals of exact linear skins with few rings (METHOD §1.8): longer influence lists, vertices
//! without coefficients, and weights on a hinge.

use faer::Mat;
use nalgebra::{Matrix3x4, Matrix4, Rotation3, Unit, Vector3};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::Space;
use sinew_runtime::{Model, Skin};
use sinew_trainer::envelope::model::{Shapes, SkinModel};
use sinew_trainer::envelope::normals::{Fan, PosedSurface};
use sinew_trainer::envelope::{Options, Predict, train};
use sinew_trainer::examples::{Examples, Skeleton, Split};
use sinew_trainer::progress::Silent;

/// A mesh on three joints along y, at heights 0, 1 and 2, in 13 poses.
struct Chain {
    rest: Vec<[f64; 3]>,
    triangles: Vec<[usize; 3]>,
    influences: Vec<Vec<(usize, f64)>>,
    palettes: Vec<Vec<Matrix4<f64>>>,
}

impl Chain {
    /// Makes a tube of rings at heights 0 to 3; `of_height` gives the influences at a height.
    fn tube(rings: usize, sides: usize, of_height: impl Fn(f64) -> Vec<(usize, f64)>) -> Self {
        let height = |ring: usize| 3.0 * ring as f64 / (rings - 1) as f64;
        let vertices = || (0..rings).flat_map(|ring| (0..sides).map(move |side| (ring, side)));
        let place = |(ring, side): (usize, usize)| {
            let around = std::f64::consts::TAU * side as f64 / sides as f64;
            [0.3 * around.cos(), height(ring), 0.3 * around.sin()]
        };
        let mut triangles = Vec::new();
        for (ring, side) in vertices().filter(|(ring, _)| ring + 1 < rings) {
            let [a, b] = [side, (side + 1) % sides].map(|side| ring * sides + side);
            triangles.extend([[a, a + sides, b], [b, a + sides, b + sides]]);
        }
        Self {
            rest: vertices().map(place).collect(),
            triangles,
            influences: vertices().map(|(ring, _)| of_height(height(ring))).collect(),
            palettes: (0..13).map(palette).collect(),
        }
    }

    /// Makes a strip along y whose corners at height 1 lie on the hinge between the first two
    /// joints.
    fn strip() -> Self {
        let corner = |vertex: usize| [[-0.25, 0.25][vertex % 2], (vertex / 2) as f64, 0.0];
        let half = vec![(0, 0.5), (1, 0.5)];
        Self {
            rest: (0..6).map(corner).collect(),
            triangles: vec![[0, 1, 2], [1, 3, 2], [2, 3, 4], [3, 5, 4]],
            influences: [vec![(0, 1.0)], half, vec![(1, 1.0)]]
                .into_iter()
                .flat_map(|list| [list.clone(), list])
                .collect(),
            palettes: (0..13).map(palette).collect(),
        }
    }

    fn posed(&self) -> Mat<f64> {
        Mat::from_fn(3 * self.palettes.len(), self.rest.len(), |row, vertex| {
            let x = Vector3::from(self.rest[vertex]).push(1.0);
            let moved = |&(l, weight): &(usize, f64)| self.palettes[row / 3][l] * x * weight;
            self.influences[vertex].iter().map(moved).sum::<nalgebra::Vector4<f64>>()[row % 3]
        })
    }

    fn skin(&self) -> SkinModel {
        let fans = Fan::all(&self.triangles, self.rest.len());
        let normal = |fan: &Fan| fan.normal(|v| self.rest[v].into()).normalize().into();
        SkinModel {
            name: "skin".to_owned(),
            envelope: Some(0),
            rest_positions: self.rest.clone(),
            rest_normals: fans.iter().map(normal).collect(),
            rest_tangents: None,
            influences: self.influences.clone(),
            tangent_coefficients: None,
            normal_errors: None,
            ranges: Vec::new(),
            shapes: Shapes::default(),
        }
    }

    /// Fits a skin whose influence lists may have up to `most` entries.
    fn fit(&self, mut skin: SkinModel, most: usize) -> SkinModel {
        let stacked = Mat::from_fn(3 * self.palettes.len(), 12, |row, column| {
            self.palettes[row / 3][column / 4][(row % 3, column % 4)]
        });
        let surface = PosedSurface {
            rest: &self.rest,
            trajectories: &self.posed(),
            palettes: &stacked,
            fans: &Fan::all(&self.triangles, self.rest.len()),
            authored: false,
        };
        surface.fit(&mut skin, 1.0, most);
        skin
    }

    /// Measures the angles of a skin's normals in degrees, each with its share of the area; returns
    /// a list per vertex.
    fn angles(&self, skin: &SkinModel) -> Vec<Vec<(f64, f64)>> {
        let (posed, fans) = (self.posed(), Fan::all(&self.triangles, self.rest.len()));
        let of_vertex = |(number, fan): (usize, &Fan)| {
            let area: f64 =
                fan.edges(|v| self.rest[v].into()).map(|[a, b]| a.cross(&b).norm()).sum();
            let in_pose = |(pose, palette): (usize, &Vec<Matrix4<f64>>)| {
                let at = |v: usize| {
                    Vector3::from_column_slice(&posed.col_as_slice(v)[3 * pose..3 * pose + 3])
                };
                let truth = fan.normal(at);
                let maps: Vec<Matrix3x4<f64>> =
                    palette.iter().map(|map| map.fixed_rows::<3>(0).into()).collect();
                let found = skin.vertex(number).skinned(&maps).normal;
                let angle = found.cross(&truth).norm().atan2(found.dot(&truth));
                (angle.to_degrees(), area)
            };
            self.palettes.iter().enumerate().map(in_pose).collect()
        };
        fans.iter().enumerate().map(of_vertex).collect()
    }

    /// Returns the RMS angle over area, and the 99th percentile over area.
    fn errors(&self, skin: &SkinModel) -> [f64; 2] {
        let mut all = self.angles(skin).concat();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let area: f64 = all.iter().map(|own| own.1).sum();
        let squares: f64 = all.iter().map(|(angle, own)| angle * angle * own).sum();
        let mut below = 0.0;
        let at_99 = all.iter().find(|own| {
            below += own.1;
            below >= 0.99 * area
        });
        [(squares / area).sqrt(), at_99.unwrap().0]
    }
}

/// Rotates the joints by up to 50°, about different axes at different rates; pose 0 is at rest.
fn palette(pose: usize) -> Vec<Matrix4<f64>> {
    let axes = [Vector3::z(), Vector3::x(), Vector3::new(0.3, 0.5, 0.7)];
    let mut world: Matrix4<f64> = Matrix4::identity();
    let of_joint = |(joint, axis): (usize, Vector3<f64>)| {
        let j = joint as f64;
        let phase = std::f64::consts::TAU * pose as f64 / 12.0 * (1.0 + 0.37 * j) + j;
        let angle = if pose > 0 { 50.0_f64.to_radians() * phase.sin() } else { 0.0 };
        let turn = Rotation3::from_axis_angle(&Unit::new_normalize(axis), angle);
        let step = Matrix4::new_translation(&(Vector3::y() * j.min(1.0)));
        world = world * step * turn.to_homogeneous();
        world * Matrix4::new_translation(&(Vector3::y() * -j))
    };
    axes.into_iter().enumerate().map(of_joint).collect()
}

/// Returns the index of the last joint at or below a height.
fn joint_below(height: f64) -> usize {
    (height + 1e-9).min(2.0) as usize
}

#[test]
fn rings_of_one_joint_each_follow_their_neighbours_for_their_normals() {
    let tube = Chain::tube(3, 48, |height| vec![(joint_below(height), 1.0)]);
    let plain = tube.skin();
    let found = tube.fit(plain.clone(), 4);
    let ([by_cofactors, _], [rms, at_99]) = (tube.errors(&plain), tube.errors(&found));
    assert!(by_cofactors > 9.0, "{by_cofactors}");
    assert!(rms < 2.0 && at_99 < 10.0, "{rms} {at_99}");
    // The three joints suffice, and positions do not change.
    assert_eq!(found.influence_len(), 3);
    for (before, after) in plain.influences.iter().zip(&found.influences) {
        assert_eq!(before[0], after[0]);
        assert!(after[1..].iter().all(|other| other.1 == 0.0));
    }
    // The caller's limit is respected.
    let narrow = tube.fit(plain.clone(), 1);
    assert!(narrow.tangent_coefficients.is_none() && narrow.influences == plain.influences);
}

#[test]
fn lists_stay_as_long_as_they_are_where_normals_gain_little() {
    // A hard bend between two rings: coefficients of a corner alone cannot give its normal.
    let tube = Chain::tube(4, 24, |height| vec![(joint_below(height), 1.0)]);
    let plain = tube.skin();
    let found = tube.fit(plain.clone(), 4);
    assert!(tube.errors(&plain)[0] > 8.0);
    assert!(found.tangent_coefficients.is_none() && found.influences == plain.influences);
    // The lists also stay short if cofactors are right: all rings move alike.
    let tube = Chain::tube(3, 48, |_| vec![(1, 1.0)]);
    let found = tube.fit(tube.skin(), 4);
    assert_eq!(found.influence_len(), 1);
}

#[test]
fn no_vertex_has_normals_worse_than_by_cofactors() {
    for sides in [3, 4] {
        let tube = Chain::tube(13, sides, |height| {
            let joint = joint_below(height);
            vec![(joint, 1.0), ((joint + 1) % 3, 0.0)]
        });
        let plain = tube.skin();
        let found = tube.fit(plain.clone(), 2);
        let squares = |of: &[(f64, f64)]| of.iter().map(|own| own.0 * own.0).sum::<f64>();
        let mut better = 0;
        for (number, (found, plain)) in
            tube.angles(&found).iter().zip(&tube.angles(&plain)).enumerate()
        {
            let [found, plain] = [found, plain].map(|angles| squares(angles));
            // An RMS error of 1° is below the threshold.
            assert!(found <= plain.max(1.01 * 13.0), "{sides} {number}: {found} {plain}");
            better += usize::from(found < 0.8 * plain);
        }
        assert!(better > 0);
    }
}

#[test]
fn painted_weights_stay_on_a_hinge_that_positions_do_not_determine() {
    let strip = Chain::strip();
    let identity = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    let rows = |map: &Matrix4<f64>| [0, 1, 2].map(|r| [0, 1, 2, 3].map(|c| map[(r, c)]));
    let at = |height: f64| {
        let mut frame = identity;
        frame[1][3] = height;
        frame
    };
    let (posed, frames) = (strip.posed(), strip.palettes.len());
    let vertices = (0..frames).flat_map(|pose| {
        let posed = &posed;
        (0..6).map(move |v| [0, 1, 2].map(|axis| posed[(3 * pose + axis, v)]))
    });
    let examples = Examples {
        vertices: vertices.collect(),
        rest: strip.rest.clone(),
        triangles: strip.triangles.clone(),
        engine: None,
        skeleton: Skeleton {
            names: ["root", "mid", "tip"].map(str::to_owned).to_vec(),
            parents: vec![None, Some(0), Some(1)],
            rest: [0.0, 1.0, 2.0].map(at).to_vec(),
            ..Skeleton::default()
        },
        transforms: strip.palettes.iter().flatten().map(rows).collect(),
        curve_names: Vec::new(),
        curves: Vec::new(),
        split: vec![Split::Train; frames],
        ranges: Vec::new(),
        clip_starts: vec![0],
        space: Space::default(),
        joint_weights: Some(
            strip
                .influences
                .iter()
                .flat_map(|list| {
                    let weight =
                        |joint| list.iter().find(|own| own.0 == joint).map_or(0.0, |o| o.1);
                    [0, 1, 2].map(weight)
                })
                .collect(),
        ),
        importance: None,
        frame_weights: None,
        own_skin: false,
    };
    let options = Options { predictor: Predict::Only(Predictor::Kernel), ..Options::default() };
    let model = train(&examples, &options, &Silent).unwrap().model;
    let skin = Model::from_bytes(&model).unwrap();
    let skin = SkinModel::from_file(&skin.first::<Skin>().unwrap());
    for vertex in [2, 3] {
        let mut weights = [0.0; 3];
        skin.influences[vertex].iter().for_each(|&(joint, weight)| weights[joint] += weight);
        assert!((weights[0] - 0.5).abs() < 1e-4 && (weights[1] - 0.5).abs() < 1e-4, "{weights:?}");
    }
}
