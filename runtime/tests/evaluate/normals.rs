//! Normals and tangents from tangent coefficients, against their definition in f64 and against
//! known results.

use crate::common::{
    IDENTITY, apart, bits, max_difference, palette, random_pose, rest, run, skinned, with_skin,
};
use models::{Pieces, Rest, Rng, SMALL, Shape, cells, direction, floats};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::SectionKind;
use sinew_runtime::skin::Output;
use sinew_runtime::{Envelope, Matrix3x4, Model, Skin, SkinJob};
use std::ops::Range;

type V = [f64; 3];
type M = [V; 3];

/// With and without tangents, with few and with many influences.
fn shapes() -> impl Iterator<Item = Shape> {
    let all = [2, 3, 4, 7].into_iter().flat_map(|k| [(k, true), (k, false)]);
    all.map(|(influences, tangents)| Shape { vertices: 21, influences, tangents, ..SMALL })
}

fn add(a: V, b: V) -> V {
    [0, 1, 2].map(|c| a[c] + b[c])
}

fn scaled(a: V, by: f64) -> V {
    a.map(|x| by * x)
}

fn dot(a: V, b: V) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn cross(a: V, b: V) -> V {
    [0, 1, 2].map(|c| a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3])
}

fn length(a: V) -> f64 {
    dot(a, a).sqrt()
}

fn unit(a: V) -> V {
    scaled(a, 1.0 / length(a))
}

fn wide<const N: usize>(x: [f32; N]) -> [f64; N] {
    x.map(f64::from)
}

fn linear(m: &Matrix3x4) -> M {
    m.map(|[x, y, z, _]| wide([x, y, z]))
}

fn apply(m: M, v: V) -> V {
    m.map(|row| dot(row, v))
}

fn moved(m: &Matrix3x4, x: V) -> V {
    add(apply(linear(m), x), m.map(|row| f64::from(row[3])))
}

/// M T: a transform followed by a motion of everything.
fn after(m: M, shift: V, transform: &Matrix3x4) -> Matrix3x4 {
    [0, 1, 2].map(|r| {
        let column = |c: usize| (0..3).map(|k| m[r][k] * f64::from(transform[k][c])).sum::<f64>();
        [column(0), column(1), column(2), column(3) + shift[r]].map(|x| x as f32)
    })
}

fn determinant([x, y, z]: M) -> f64 {
    dot(x, cross(y, z))
}

/// Result of the definition for a vertex, and the allowed error of f32.
struct Expected {
    normal: V,
    normal_error: f64,
    tangent: Option<V>,
    tangent_error: f64,
}

/// The two directions of a vertex's frame: from a tangent, or by the formula of Duff et al.
fn frame(n: V, tangent: Option<V>) -> [V; 2] {
    if let Some(tangent) = tangent {
        let v = cross(n, tangent);
        return [cross(v, n), v];
    }
    let [x, y, z] = n;
    let side = 1.0f64.copysign(z);
    let a = -1.0 / (side + z);
    let b = x * y * a;
    [[1.0 + side * x * x * a, side * b, -side * x], [b, side + y * y * a, -y]]
}

/// The definition: a surface whose weights change by g and h along the frame's directions. The
/// surface is quadratic, so differences over any step are exact.
fn expected(skin: &Skin<'_>, palette: &[Matrix3x4], vertex: usize) -> Expected {
    let position = wide(skin.rest_position(vertex).unwrap());
    let normal = wide(skin.rest_normal(vertex).unwrap());
    let tangent = skin.rest_tangent(vertex).map(|[x, y, z, _]| wide([x, y, z]));
    let mut changes = skin.tangent_coefficients(vertex).map(wide).collect::<Vec<_>>();
    let sums = changes.iter().fold([0.0; 2], |sums, [g, h]| [sums[0] + g, sums[1] + h]);
    changes.insert(0, sums.map(|sum| -sum));
    let influences = skin.influences(vertex).collect::<Vec<_>>();
    assert_eq!(changes.len(), influences.len());
    let directions = frame(normal, tangent);
    let place = |a: f64, b: f64, along: V| {
        let mut sum = [0.0; 3];
        for ((index, weight), [g, h]) in influences.iter().zip(&changes) {
            let weight = f64::from(*weight) + a * g + b * h;
            sum = add(sum, scaled(moved(&palette[*index], add(position, along)), weight));
        }
        sum
    };
    let slope = |[a, b]: V2, along: V| {
        let (to, from) = (place(a, b, along), place(-a, -b, scaled(along, -1.0)));
        scaled(add(to, scaled(from, -1.0)), 0.5)
    };
    let [u, v] = [slope([1.0, 0.0], directions[0]), slope([0.0, 1.0], directions[1])];
    let side = determinant(linear(&palette[0])).signum();
    let turned = cross(u, v);
    // The largest terms of the two sums. Each has about thirty roundings, which a cross product
    // enlarges.
    let most = |of: usize| {
        let parts = influences.iter().zip(&changes).map(|((index, weight), change)| {
            let m = palette[*index].map(|row| wide(row).map(f64::abs));
            let far = m.iter().flatten().sum::<f64>() * (1.0 + length(position));
            far * (f64::from(*weight) + change[of].abs())
        });
        parts.sum::<f64>()
    };
    let [a, b] = [most(0), most(1)];
    let rounding = 30.0 * f64::from(f32::EPSILON);
    let out_tangent = tangent.map(|t| {
        let weights = [dot(t, directions[0]), dot(t, directions[1])];
        slope(weights, t)
    });
    Expected {
        normal: unit(scaled(turned, side)),
        normal_error: rounding * (1.0 + (a * length(v) + b * length(u)) / length(turned)),
        tangent_error: out_tangent.map_or(0.0, |t| rounding * (1.0 + (a + b) / length(t))),
        tangent: out_tangent.map(unit),
    }
}

type V2 = [f64; 2];

#[test]
fn normals_and_tangents_are_those_of_a_surface_whose_weights_change() {
    for shape in shapes() {
        with_skin(shape, |envelope, skin| {
            assert!(skin.has_coefficients());
            let (v, mut certain) = (skin.vertex_len(), 0);
            for seed in (0..20).step_by(apart(10)) {
                let pose = random_pose(&envelope, &mut Rng(seed), 0.3);
                let palette = palette(&envelope, &pose);
                let found = skinned(skin, &palette);
                for vertex in 0..v {
                    let expected = expected(&skin, &palette, vertex);
                    let close = |at: usize, expected: V, most: f64| {
                        let found = wide(*found[at..].first_chunk::<3>().unwrap());
                        let off = length(add(found, scaled(expected, -1.0)));
                        assert!(off <= most, "{vertex}: {off} of {most}");
                    };
                    close(3 * (v + vertex), expected.normal, expected.normal_error);
                    if let Some(tangent) = expected.tangent {
                        close(6 * v + 4 * vertex, tangent, expected.tangent_error);
                    }
                    certain += usize::from(expected.normal_error < 1e-3);
                }
            }
            assert!(cfg!(miri) || certain > 13 * v, "{certain}: bounds that bind");
        });
    }
}

#[test]
fn at_rest_the_normal_is_that_at_rest_whatever_the_coefficients() {
    for shape in shapes() {
        for scale in [0, 12 << 10] {
            let mut pieces = Pieces::sample(Predictor::Rotational, shape);
            let coefficients = pieces.section(SectionKind::TangentCoefficients);
            for half in coefficients.as_chunks_mut::<2>().0 {
                // Up to 16,384.
                let bits = u16::from_le_bytes(*half);
                let is_zero = bits & 0x7fff == 0;
                *half = if is_zero { bits } else { bits + scale }.to_le_bytes();
            }
            let model = Model::from_bytes(pieces.bytes()).unwrap();
            let skin = model.first::<Skin>().unwrap();
            let identity = vec![IDENTITY; skin.palette_len()];
            let (found, rest) = (skinned(skin, &identity), rest(skin));
            assert_eq!(found[..3 * 21], rest[..3 * 21]);
            assert!(max_difference(&found, &rest) < 4e-7);
        }
    }
}

#[test]
fn a_motion_of_everything_turns_normals_by_its_cofactors() {
    let motions: [M; 4] = [
        [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
        [[1.5, 0.25, 0.0], [-0.5, 0.75, 0.25], [0.0, 0.5, 2.0]],
        [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        [[0.5, 0.0, 0.25], [0.0, 1.25, 0.0], [0.5, 0.25, -1.0]],
    ];
    for (shape, coefficients) in shapes().flat_map(|shape| [(shape, true), (shape, false)]) {
        with_skin(Shape { coefficients, ..shape }, |envelope, skin| {
            let still = palette(&envelope, &random_pose(&envelope, &mut Rng(5), 0.1));
            let v = skin.vertex_len();
            let before = skinned(skin, &still);
            for m in motions {
                let motion = |transform| after(m, [4.0, -2.0, 1.0], transform);
                let after = skinned(skin, &still.iter().map(motion).collect::<Vec<_>>());
                // Normals stay outward: cofactors times the sign of the motion's determinant.
                let [x, y, z] = m;
                let cofactors = [cross(y, z), cross(z, x), cross(x, y)];
                for vertex in 0..v {
                    let normal = |of: &[f32]| wide(*of[3 * (v + vertex)..].first_chunk().unwrap());
                    let turned = apply(cofactors, normal(&before));
                    let expected = unit(scaled(turned, determinant(m).signum()));
                    let off = length(add(normal(&after), scaled(expected, -1.0)));
                    assert!(off < 2e-4, "{vertex}: {off}");
                }
            }
        });
    }
}

#[test]
fn a_mirror_keeps_normals_outward() {
    let mirror: Matrix3x4 = [[-1.0, 0.0, 0.0, 0.5], IDENTITY[1], IDENTITY[2]];
    let turn: Matrix3x4 = [[-1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0], IDENTITY[2]];
    for coefficients in [true, false] {
        with_skin(Shape { coefficients, ..SMALL }, |_, skin| {
            for (transform, signs) in [(mirror, [-1.0, 1.0, 1.0]), (turn, [-1.0, -1.0, 1.0])] {
                let found = skinned(skin, &vec![transform; skin.palette_len()]);
                for vertex in 0..skin.vertex_len() {
                    let normal = skin.rest_normal(vertex).unwrap();
                    let expected = [0, 1, 2].map(|c| signs[c] * normal[c]);
                    let found = &found[3 * (skin.vertex_len() + vertex)..][..3];
                    assert!(max_difference(found, &expected) < 4e-7);
                }
            }
        });
    }
}

/// Skins one vertex with two transforms and weights 3/4 and 1/4; the coefficients have no effect.
fn normal_of_two(transforms: [Matrix3x4; 2]) -> ([f32; 3], [f32; 3]) {
    let shape = Shape { vertices: 1, ..SMALL };
    let mut pieces = Pieces::sample(Predictor::Rotational, shape);
    pieces.section(SectionKind::TangentCoefficients).fill(0);
    let model = Model::from_bytes(pieces.bytes()).unwrap();
    let skin = model.first::<Skin>().unwrap();
    assert_eq!(skin.influences(0).collect::<Vec<_>>(), [(0, 0.75), (1, 0.25)]);
    let mut palette = vec![IDENTITY; skin.palette_len()];
    palette[..2].copy_from_slice(&transforms);
    let found = skinned(skin, &palette);
    (*found[3..].first_chunk().unwrap(), skin.rest_normal(0).unwrap())
}

#[test]
fn a_normal_without_direction_takes_the_strongest_influence() {
    let scaled = |by: f32| IDENTITY.map(|row| row.map(|x| by * x));
    let turned = |by: f32| {
        let turn: Matrix3x4 = [[0.0, -1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], IDENTITY[2]];
        turn.map(|row| row.map(|x| by * x))
    };
    // 3/4 of one transform and 1/4 of minus three times the other cancel.
    let (found, [x, y, z]) = normal_of_two([turned(1.0), turned(-3.0)]);
    assert!(max_difference(&found, &[-y, x, z]) < 2e-7);
    let (found, rest) = normal_of_two([scaled(2.0), scaled(-6.0)]);
    assert!(max_difference(&found, &rest) < 2e-7);
    // The strongest transform vanishes too, or overflows.
    for by in [0.0, 1e25] {
        let (found, rest) = normal_of_two([scaled(by), scaled(-3.0 * by)]);
        assert_eq!(found, rest, "{by}");
    }
}

#[test]
fn a_vertex_without_a_normal_stays_without() {
    for tangents in [true, false] {
        let mut pieces = Pieces::sample(Predictor::Rotational, Shape { tangents, ..SMALL });
        pieces.edit_vertices(SectionKind::RestNormals, |numbers| numbers[..12].fill(0));
        pieces.edit_vertices(SectionKind::TangentCoefficients, |numbers| numbers[..4].fill(0));
        let model = Model::from_bytes(pieces.bytes()).unwrap();
        let (envelope, skin) = (model.first::<Envelope>().unwrap(), model.first::<Skin>().unwrap());
        let palette = palette(&envelope, &random_pose(&envelope, &mut Rng(5), 0.3));
        assert_eq!(skinned(skin, &palette)[3 * SMALL.vertices..][..3], [0.0; 3]);
    }
}

#[test]
fn the_frame_of_a_caller_normal_flips_only_with_the_files_frame() {
    let shape = Shape { tangents: false, influences: 4, ..SMALL };
    let mut pieces = Pieces::sample(Predictor::Rotational, shape);
    let mut rng = Rng(3);
    let near = (0..SMALL.vertices).map(|_| {
        let [x, y, _] = direction(&mut rng);
        unit(wide([x, y, 1e-4])).map(|x| x as f32)
    });
    let mut normals = near.collect::<Vec<_>>();
    pieces.set_vertices(SectionKind::RestNormals, &floats(normals.as_flattened()));
    let model = Model::from_bytes(pieces.bytes()).unwrap();
    let (envelope, skin) = (model.first::<Envelope>().unwrap(), model.first::<Skin>().unwrap());
    let palette = palette(&envelope, &random_pose(&envelope, &mut Rng(5), 0.3));
    let own = skinned(skin, &palette);
    normals.iter_mut().for_each(|normal| normal[2] = -normal[2]);
    let rest = Rest { normals: Some(&normals), ..Rest::default() };
    let given = run(&rest.of(SkinJob::new(skin, &palette)));
    let at = 3 * SMALL.vertices;
    let difference = max_difference(&given[at..], &own[at..]);
    assert!(difference > 1e-5 && difference < 2e-2, "{difference}");
}

#[test]
fn caller_tangents_keep_the_frame_of_a_skin_without_tangents() {
    let shape = Shape { tangents: false, ..SMALL };
    with_skin(shape, |envelope, skin| {
        let palette = palette(&envelope, &random_pose(&envelope, &mut Rng(5), 0.3));
        let v = skin.vertex_len();
        let own = skinned(skin, &palette);
        // Tangents of the frame stay orthogonal to the normals.
        let given = (0..v).map(|vertex| {
            let [[x, y, z], _] = frame(wide(skin.rest_normal(vertex).unwrap()), None);
            [x as f32, y as f32, z as f32, 1.0]
        });
        let given = given.collect::<Vec<_>>();
        let rest = Rest { tangents: Some(&given), ..Rest::default() };
        let found = run(&rest.of(SkinJob::new(skin, &palette)));
        assert_eq!(bits(&found[..6 * v]), bits(&own));
        for vertex in 0..v {
            let normal = wide(*found[3 * (v + vertex)..].first_chunk().unwrap());
            let tangent = wide(*found[6 * v + 4 * vertex..].first_chunk().unwrap());
            assert!(dot(normal, tangent).abs() < 1e-5);
        }
    });
}

#[test]
fn an_attribute_alone_keeps_its_bits() {
    for shape in shapes() {
        with_skin(shape, |envelope, skin| {
            let palette = palette(&envelope, &random_pose(&envelope, &mut Rng(5), 0.3));
            let (v, whole) = (skin.vertex_len(), skinned(skin, &palette));
            let mut normals = vec![f32::NAN; 3 * v];
            let alone = SkinJob::new(skin, &palette).normals(Output::new(&mut normals, 3));
            alone.run().unwrap();
            assert_eq!(bits(&normals), bits(&whole[3 * v..6 * v]));
            if shape.tangents {
                let mut tangents = vec![f32::NAN; 4 * v];
                let alone = SkinJob::new(skin, &palette).tangents(Output::new(&mut tangents, 4));
                alone.run().unwrap();
                assert_eq!(bits(&tangents), bits(&whole[6 * v..]));
            }
        });
    }
}

#[test]
fn vertices_side_by_side_have_the_bits_that_each_has_alone() {
    for shape in shapes().filter(|shape| shape.influences == 4) {
        with_skin(shape, |envelope, skin| {
            let posed = palette(&envelope, &random_pose(&envelope, &mut Rng(5), 0.3));
            let mirrored = |m: &Matrix3x4| [m[0].map(|x| -x), m[1], m[2]];
            // Transforms that leave a normal without direction: for some vertices all of their
            // transforms.
            let nothing = |l: usize, m: &Matrix3x4| if l < 5 { Matrix3x4::default() } else { *m };
            let palettes = [
                posed.clone(),
                posed.iter().map(mirrored).collect(),
                posed.iter().enumerate().map(|(l, m)| nothing(l, m)).collect(),
            ];
            for palette in &palettes {
                let v = skin.vertex_len();
                let [mut together, mut alone] = [vec![f32::NAN; 6 * v], vec![f32::NAN; 6 * v]];
                let all = |vertices: Range<usize>, out: &mut [f32]| {
                    let (positions, normals) = cells(out).split_at(3 * v);
                    let start = 3 * vertices.start;
                    SkinJob::new(skin, palette)
                        .vertices(vertices)
                        .positions(Output::shared(&positions[start..], 3))
                        .normals(Output::shared(&normals[start..], 3))
                        .run()
                        .unwrap();
                };
                all(0..v, &mut together);
                (0..v).for_each(|vertex| all(vertex..vertex + 1, &mut alone));
                assert_eq!(bits(&together), bits(&alone));
                assert!(together.iter().all(|x| x.is_finite()));
            }
        });
    }
}

#[test]
fn caller_tangents_give_equal_normals_in_blocks_and_one_at_a_time() {
    for shape in shapes().filter(|shape| shape.influences == 4 && shape.tangents) {
        with_skin(shape, |envelope, skin| {
            let palette = palette(&envelope, &random_pose(&envelope, &mut Rng(5), 0.3));
            let v = skin.vertex_len();
            let mut rng = Rng(8);
            let given: Vec<[f32; 4]> = (0..v)
                .map(|_| {
                    let [x, y, z] = direction(&mut rng);
                    [x, y, z, 1.0]
                })
                .collect();
            let rest = Rest { tangents: Some(&given), ..Rest::default() };
            let whole = run(&rest.of(SkinJob::new(skin, &palette)));
            let mut normals = vec![f32::NAN; 3 * v];
            let normals_alone = Output::new(&mut normals, 3);
            rest.of(SkinJob::new(skin, &palette)).normals(normals_alone).run().unwrap();
            assert_eq!(bits(&normals), bits(&whole[3 * v..6 * v]));
            assert_ne!(bits(&normals), bits(&skinned(skin, &palette)[3 * v..6 * v]));
        });
    }
}
