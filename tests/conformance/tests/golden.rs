//! Today's bake writes the golden files' bytes.
//!
//! `SINEW_BLESS=1 cargo test -p conformance --test golden` writes the files anew; a released
//! version's golden files are never written again.
#![allow(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

use sinew_runtime::envelope::{Certificate, Predictor};
use sinew_runtime::format::{ALIGNMENT, Axis, Handedness, Space};
use sinew_runtime::kernel::Kernel;
use sinew_runtime::{Envelope, Model, Skin};
use sinew_trainer::bake::{
    BakeError, EnvelopeParts, Group, Key, ModelParts, Reconstruction, SkinParts, bake,
};
use sinew_trainer::files;
use std::path::PathBuf;

/// Multiples of 1/64 in [-1, 1), so that rounding to f32 is no part of what is compared.
struct Dyadic(u32);

impl Dyadic {
    fn next(&mut self, scale: f64) -> f64 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let unit = f64::from(self.0 >> 25) / 64.0 - 1.0;
        unit * scale
    }

    fn list(&mut self, len: usize, scale: f64) -> Vec<f64> {
        (0..len).map(|_| self.next(scale)).collect()
    }

    fn matrix<const N: usize>(&mut self, scale: f64) -> [[f64; N]; N] {
        [(); N].map(|()| [(); N].map(|()| self.next(scale)))
    }
}

/// A model of an envelope and its skin: 24 vertices, 5 joints, 5 proxies, 4 influences; the root is
/// joint 3.
fn parts(predictor: Predictor) -> ModelParts {
    let mut dyadic = Dyadic(7);
    let (v, j, p, root) = (24, 5, 5, 3);
    let rest_frames = (0..j).map(|joint| {
        let x = joint as f64;
        [[0.0, -1.0, 0.0, x], [1.0, 0.0, 0.0, 0.5], [0.0, 0.0, 1.0, 0.0]]
    });
    let axis = |i: usize| [0, 1, 2].map(|c| if i % 3 == c { 1.0 } else { 0.0 });
    let tangent = |i: usize| {
        let [x, y, z] = axis(i + 1);
        [x, y, z, if i.is_multiple_of(2) { 1.0 } else { -1.0 }]
    };
    let palette_len = if predictor == Predictor::Kernel { j + p } else { p };
    let influences = (0..v).map(|vertex| match vertex % 3 {
        0 => vec![(vertex % palette_len, 1.0)],
        1 => vec![(vertex % palette_len, 0.75), ((vertex + 1) % palette_len, 0.25)],
        _ => (0..4).map(|slot| ((vertex + slot) % palette_len, 0.25)).collect(),
    });
    let keys = (0..p).map(|l| Key {
        joint: l % j,
        twist: dyadic.matrix(0.5),
        residual: (l % 2 == 1).then(|| ((l + 2) % j, dyadic.matrix(0.25))),
        shear: dyadic.matrix(0.125),
    });
    let keys = keys.collect();
    let c1 = dyadic.list(12 * p * p, 0.25);
    let mut c2 = dyadic.list(16 * p * j, 0.25);
    // Rows sum so that the rest pose is exact: c1 I + c2 rest = [I | 0].
    for row in 0..4 * p {
        for c in 0..3 {
            let of_c1 = c1[row * 3 * p..][..3 * p].iter().skip(c).step_by(3).sum::<f64>();
            let of_c2 = c2[row * 4 * j..][..4 * j].iter().skip(c).step_by(4).sum::<f64>();
            c2[row * 4 * j + 4 * root + c] -= of_c1 + of_c2 - if row % 4 == c { 1.0 } else { 0.0 };
        }
    }
    // Two, one and two proxies; odd sizes, and all four kernels between the two predictors.
    let first = usize::from(predictor.number());
    let groups = [(2, 5, 13, 3), (1, 9, 7, 11), (2, 3, 17, 1)].into_iter().enumerate();
    let groups = groups.map(|(g, (proxies, d, n, rank))| Group {
        joint: 2 * g,
        kernel: Kernel::ALL[(first + g) % 4],
        proxies,
        inputs: (0..d).map(|i| ((7 * i + 12 * g) % (12 * j), 0.75 - dyadic.next(0.25))).collect(),
        centres: (0..n).map(|_| dyadic.list(d, 1.0)).collect(),
        coefficients: dyadic.list(rank * (n + d), 0.25),
        rank,
        outputs: dyadic.list(12 * proxies * rank, 0.25),
        fade: (1.0, 16.0),
    });
    let groups = if predictor.corrects() { groups.collect() } else { Vec::new() };
    let reconstruction = Reconstruction { keys, c1, c2 };
    let skin = SkinParts {
        name: "golden skin".to_owned(),
        envelope: Some(0),
        rest_positions: (0..v).map(|_| [(); 3].map(|()| dyadic.next(2.0))).collect(),
        rest_normals: (0..v).map(axis).collect(),
        rest_tangents: Some((0..v).map(tangent).collect()),
        influences: influences.collect(),
        ranges: vec![("body".to_owned(), 0..20), ("eyes".to_owned(), 20..24)],
    };
    let envelope = EnvelopeParts {
        name: "golden".to_owned(),
        joint_names: ["hand", "elbow", "shoulder", "hip", "tail"].map(str::to_owned).to_vec(),
        parents: vec![Some(1), Some(2), Some(3), None, Some(3)],
        root,
        rest_frames: rest_frames.collect(),
        reconstruction: predictor.reconstructs().then_some(reconstruction),
        groups,
        pose_ranges: vec![2.0, 1.0, 0.75, 0.0, 1.25],
        certificate: Certificate {
            diagonal: 4.0,
            training_rms: 0.125,
            cross_validated_rms: 0.25,
            lbs_training_rms: 0.5,
            correction_error: if predictor.corrects() { 0.0625 } else { 0.0 },
        },
    };
    let space = Space {
        up: Some(Axis::Y),
        forward: Some(Axis::Z),
        handedness: Handedness::Right,
        unit: Some(1.0),
    };
    ModelParts { space, envelopes: vec![envelope], skins: vec![skin] }
}

fn golden_path(predictor: Predictor) -> PathBuf {
    let name = format!("../golden/envelope-3-{}.snw", predictor.name());
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(name)
}

#[test]
fn bake_writes_the_golden_files() {
    for predictor in Predictor::ALL {
        let baked = bake(&parts(predictor)).unwrap();
        if std::env::var_os("SINEW_BLESS").is_some() {
            std::fs::write(golden_path(predictor), &baked).unwrap();
        }
        let golden = std::fs::read(golden_path(predictor)).unwrap();
        assert!(baked == golden, "the baked bytes differ from the golden file of {predictor:?}");
        // The comparison can fail.
        let mut other = parts(predictor);
        let envelope = &mut other.envelopes[0];
        if let Some(reconstruction) = &mut envelope.reconstruction {
            reconstruction.c1[0] += 1.0 / 64.0;
        } else {
            envelope.groups[0].outputs[0] += 1.0 / 64.0;
        }
        assert!(bake(&other).unwrap() != golden);
    }
}

#[test]
fn baked_parts_are_read_back() {
    Predictor::ALL.into_iter().for_each(read_back);
}

fn read_back(predictor: Predictor) {
    let parts = parts(predictor);
    let bytes = bake(&parts).unwrap();
    let model = Model::from_bytes(bytes.as_slice()).unwrap();
    assert_eq!(model.space(), parts.space);
    for section in model.sections() {
        let offset = section.bytes.as_ptr().addr() - bytes.as_ptr().addr();
        assert!(offset.is_multiple_of(ALIGNMENT), "sections are aligned in the file");
    }
    read_back_envelope(&parts.envelopes[0], model.envelope_named("golden").unwrap());
    let skin = model.skin_named("golden skin").unwrap();
    read_back_skin(&parts.skins[0], skin);
    assert_eq!(model.envelope_of(&skin).map(|found| found.part()), Some(0));
}

fn read_back_envelope(parts: &EnvelopeParts, envelope: Envelope<'_>) {
    assert_eq!(envelope.parent(0), Some(1));
    assert_eq!(envelope.joint_name(3), Some("hip"));
    assert_eq!(envelope.evaluation_order().collect::<Vec<_>>(), [3, 2, 4, 1, 0]);
    // The inverse of a quarter turn about z at (x, 0.5, 0).
    let inverse = [[0.0, 1.0, 0.0, -0.5], [-1.0, 0.0, 0.0, 2.0], [0.0, 0.0, 1.0, 0.0]];
    assert_eq!(envelope.inverse_bind(2), Some(inverse));
    assert_eq!(envelope.predictor(), parts.predictor());
    assert_eq!(envelope.certificate(), parts.certificate);
    read_back_groups(parts, envelope);
    let keys = parts.reconstruction.as_ref().map_or(&[][..], |r| &r.keys);
    for (l, key) in keys.iter().enumerate() {
        let found = envelope.key(l).unwrap();
        assert_eq!(found.joint, key.joint);
        assert_eq!(found.twist.map(|row| row.map(f64::from)), key.twist);
        assert_eq!(found.shear.map(|row| row.map(f64::from)), key.shear);
        let residual = found.residual.map(|(j, m)| (j, m.map(|row| row.map(f64::from))));
        assert_eq!(residual, key.residual);
    }
    let base = parts.reconstruction.as_ref();
    for (row, column) in (0..20).flat_map(|row| (0..20).map(move |column| (row, column))) {
        let c1 = base.filter(|_| column < 15).map(|base| base.c1[row * 15 + column]);
        let c2 = base.map(|base| base.c2[row * 20 + column]);
        assert_eq!(envelope.c1(row, column).map(f64::from), c1);
        assert_eq!(envelope.c2(row, column).map(f64::from), c2);
    }
}

fn read_back_skin(parts: &SkinParts, skin: Skin<'_>) {
    let ranges = skin.ranges().map(|(name, range)| (name.to_owned(), range));
    assert_eq!(ranges.collect::<Vec<_>>(), parts.ranges);
    assert_eq!(skin.vertex_len(), parts.rest_positions.len());
    for (vertex, influences) in parts.influences.iter().enumerate() {
        let found = skin.influences(vertex).filter(|(_, weight)| *weight > 0.0);
        let found = found.map(|(index, weight)| (index, f64::from(weight)));
        assert_eq!(&found.collect::<Vec<_>>(), influences);
        let wide = |x: [f32; 3]| x.map(f64::from);
        assert_eq!(skin.rest_position(vertex).map(wide), Some(parts.rest_positions[vertex]));
        assert_eq!(skin.rest_normal(vertex).map(wide), Some(parts.rest_normals[vertex]));
        let tangent = skin.rest_tangent(vertex).map(|t| t.map(f64::from));
        assert_eq!(tangent, parts.rest_tangents.as_ref().map(|tangents| tangents[vertex]));
    }
}

fn read_back_groups(parts: &EnvelopeParts, envelope: Envelope<'_>) {
    assert_eq!(envelope.group_len(), parts.groups.len());
    for (joint, [x, y, z]) in parts.rest_frames.iter().enumerate() {
        let origin = envelope.origin(joint).map(|o| o.map(f64::from));
        assert_eq!(origin, (!parts.groups.is_empty()).then_some([x[3], y[3], z[3]]));
    }
    for (found, group) in envelope.groups().zip(&parts.groups) {
        let (d, n, r) = (group.inputs.len(), group.centres.len(), group.rank);
        assert_eq!((found.joint, found.kernel), (group.joint, group.kernel));
        assert_eq!(found.proxies.len(), group.proxies);
        assert_eq!((f64::from(found.fade.0), f64::from(found.fade.1)), group.fade);
        for (i, &(feature, weight)) in group.inputs.iter().enumerate() {
            assert_eq!(found.input(i), Some((feature, weight as f32)));
        }
        for (k, centre) in group.centres.iter().enumerate() {
            let coordinates = (0..d).map(|i| f64::from(found.centre(k, i).unwrap()));
            assert_eq!(&coordinates.collect::<Vec<_>>(), centre);
            // 1 at the centre, and every kernel falls from there.
            assert!(found.rest(k).is_some_and(|rest| (0.0..1.0).contains(&rest)));
        }
        for row in 0..r {
            let entries = (0..n + d).map(|c| f64::from(found.coefficient(row, c).unwrap()));
            assert!(entries.eq(group.coefficients[row * (n + d)..][..n + d].iter().copied()));
        }
        for row in 0..12 * group.proxies {
            let entries = (0..r).map(|c| f64::from(found.output(row, c).unwrap()));
            assert!(entries.eq(group.outputs[row * r..][..r].iter().copied()));
        }
    }
}

#[test]
fn parts_that_do_not_fit_are_refused() {
    let refused = |edit: &dyn Fn(&mut EnvelopeParts, &mut SkinParts)| {
        let mut parts = parts(Predictor::Hybrid);
        edit(&mut parts.envelopes[0], &mut parts.skins[0]);
        bake(&parts).unwrap_err()
    };
    let length = |what, expected, found| BakeError::Length { what, expected, found };
    let c1 = refused(&|p, _| p.reconstruction.as_mut().unwrap().c1.truncate(299));
    assert_eq!(c1, length("c1", 300, 299));
    let centre = refused(&|p, _| p.groups[1].centres[3].truncate(8));
    assert_eq!(centre, length("centre of a group", 9, 8));
    let coefficients = refused(&|p, _| p.groups[1].coefficients.truncate(2));
    assert_eq!(coefficients, length("coefficients of a group", 176, 2));
    let outputs = refused(&|p, _| p.groups[1].outputs.truncate(2));
    assert_eq!(outputs, length("outputs of a group", 132, 2));
    assert_eq!(refused(&|p, _| p.groups.truncate(2)), length("proxies of all groups", 5, 3));
    let joint = refused(&|p, _| p.groups[0].joint = 70_000);
    assert_eq!(joint, BakeError::Size { what: "joint of a group", found: 70_000 });
    assert_eq!(refused(&|_, s| s.rest_normals.truncate(1)), length("rest normals", 24, 1));
    assert_eq!(refused(&|p, _| p.parents[2] = Some(0)), BakeError::Hierarchy { joint: 0 });
    let frame = refused(&|p, _| p.rest_frames[1] = [[0.0; 4]; 3]);
    assert_eq!(frame, BakeError::RestFrame { joint: 1 });
    let weights = refused(&|_, s| s.influences[7].clear());
    assert_eq!(weights, BakeError::Weights { vertex: 7, sum: 0.0 });
    assert_eq!(
        refused(&|_, s| s.influences[7] = vec![(70_000, 1.0)]),
        BakeError::Size { what: "palette index", found: 70_000 }
    );
    assert_eq!(
        refused(&|_, s| s.envelope = Some(1)),
        BakeError::NoEnvelope { skin: 0, envelope: 1, found: 1 }
    );
    assert_eq!(refused(&|_, s| s.envelope = None), length("influences", 0, 24));
    for edit in [
        (|p, _| p.reconstruction.as_mut().unwrap().c2[9] = f64::NAN)
            as fn(&mut EnvelopeParts, &mut SkinParts),
        |_, s| s.influences[7] = vec![(5, 1.0)],
        |p, _| p.reconstruction.as_mut().unwrap().keys[0].joint = 9,
        |p, _| p.groups[0].joint = 5,
        |p, _| p.groups[0].inputs[0].0 = 60,
        |p, _| p.groups[0].outputs[0] = 1e7,
        |p, _| p.groups[0].fade = (2.0, 2.0),
        |_, s| s.rest_positions[3][1] = 1e300,
        |_, s| s.rest_normals[3] = [0.0, 1.1, 0.0],
        |_, s| s.ranges[1].1 = 19..24,
    ] {
        assert!(matches!(refused(&edit), BakeError::Refused(_)));
    }
}

#[test]
fn files_are_replaced_whole_or_not_at_all() {
    let folder = std::env::temp_dir().join(format!("sinew-golden-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("model.snw");
    for content in [b"old".as_slice(), b"new and longer"] {
        files::write(&path, content).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), content);
    }
    // A folder stands where the file should go: the rename fails and leaves nothing beside it.
    let taken = folder.join("taken");
    std::fs::create_dir_all(taken.join("full")).unwrap();
    assert!(files::write(&taken, b"x").is_err());
    assert!(files::write(&folder.join("missing/model.snw"), b"x").is_err());
    let mut left = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name());
    assert!(left.all(|name| name == "model.snw" || name == "taken"));
    std::fs::remove_dir_all(&folder).unwrap();
}
