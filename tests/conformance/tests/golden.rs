//! Today's bake writes the golden file's bytes.
//!
//! `SINEW_BLESS=1 cargo test -p conformance --test golden` writes the file anew; a released
//! version's golden file is never written again.

use sinew_runtime::Model;
use sinew_runtime::format::Certificate;
use sinew_trainer::bake::{Alignment, BakeError, EnvelopeParts, Key, bake, bake_aligned};
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

/// A model of 24 vertices, 5 joints, 5 proxies, 4 influences; the root is joint 3.
fn parts() -> EnvelopeParts {
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
    let influences = (0..v).map(|vertex| match vertex % 3 {
        0 => vec![(vertex % p, 1.0)],
        1 => vec![(vertex % p, 0.75), ((vertex + 1) % p, 0.25)],
        _ => (0..4).map(|slot| ((vertex + slot) % p, 0.25)).collect(),
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
    EnvelopeParts {
        name: "golden".to_owned(),
        joint_names: ["hand", "elbow", "shoulder", "hip", "tail"].map(str::to_owned).to_vec(),
        parents: vec![Some(1), Some(2), Some(3), None, Some(3)],
        root,
        rest_frames: rest_frames.collect(),
        rest_positions: (0..v).map(|_| [(); 3].map(|()| dyadic.next(2.0))).collect(),
        rest_normals: (0..v).map(axis).collect(),
        rest_tangents: Some((0..v).map(tangent).collect()),
        influences: influences.collect(),
        keys,
        c1,
        c2,
        pose_ranges: vec![1.0, 0.5, 0.25, 0.0, 0.125],
        certificate: Certificate {
            diagonal: 4.0,
            training_rms: 0.125,
            cross_validated_rms: 0.25,
            lbs_training_rms: 0.5,
        },
    }
}

fn golden_path() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../golden/envelope-1.snw")
}

#[test]
fn bake_writes_the_golden_file() {
    let baked = bake(&parts()).unwrap();
    if std::env::var_os("SINEW_BLESS").is_some() {
        std::fs::write(golden_path(), &baked).unwrap();
    }
    let golden = std::fs::read(golden_path()).unwrap();
    assert!(baked == golden, "the baked bytes differ from the golden file");
    // The comparison can fail.
    let mut other = parts();
    other.c1[0] += 1.0 / 64.0;
    assert!(bake(&other).unwrap() != golden);
}

#[test]
fn baked_parts_are_read_back() {
    let parts = parts();
    for alignment in [Alignment::Bytes16, Alignment::Bytes256] {
        let bytes = bake_aligned(&parts, alignment).unwrap();
        let model = Model::from_bytes(&bytes).unwrap();
        let step = if alignment == Alignment::Bytes16 { 16 } else { 256 };
        let blob = bytes.as_ptr_range();
        for section in model.sections() {
            let offset = section.bytes.as_ptr() as usize - blob.start as usize;
            assert_eq!(offset % step, 0, "sections are aligned in the file");
        }
        let envelope = model.envelope_named("golden").unwrap();
        assert_eq!(envelope.parent(0), Some(1));
        assert_eq!(envelope.joint_name(3), Some("hip"));
        assert_eq!(envelope.evaluation_order().collect::<Vec<_>>(), [3, 2, 4, 1, 0]);
        // The inverse of a quarter turn about z at (x, 0.5, 0).
        let inverse = [[0.0, 1.0, 0.0, -0.5], [-1.0, 0.0, 0.0, 2.0], [0.0, 0.0, 1.0, 0.0]];
        assert_eq!(envelope.inverse_bind(2), Some(inverse));
        for (l, key) in parts.keys.iter().enumerate() {
            let found = envelope.key(l).unwrap();
            assert_eq!(found.joint, key.joint);
            assert_eq!(found.twist.map(|row| row.map(f64::from)), key.twist);
            assert_eq!(found.shear.map(|row| row.map(f64::from)), key.shear);
            let residual = found.residual.map(|(j, m)| (j, m.map(|row| row.map(f64::from))));
            assert_eq!(residual, key.residual);
        }
        let (c1, c2) = (15, 20);
        for row in 0..20 {
            for column in 0..c1 {
                let found = envelope.c1(row, column).map(f64::from);
                assert_eq!(found, Some(parts.c1[row * c1 + column]));
            }
            for column in 0..c2 {
                let found = envelope.c2(row, column).map(f64::from);
                assert_eq!(found, Some(parts.c2[row * c2 + column]));
            }
        }
        for (vertex, influences) in parts.influences.iter().enumerate() {
            let found = envelope.influences(vertex).filter(|(_, weight)| *weight > 0.0);
            let found = found.map(|(index, weight)| (index, f64::from(weight)));
            assert_eq!(&found.collect::<Vec<_>>(), influences);
        }
    }
}

#[test]
fn parts_that_do_not_fit_are_refused() {
    let refused = |edit: &dyn Fn(&mut EnvelopeParts)| {
        let mut parts = parts();
        edit(&mut parts);
        bake(&parts).unwrap_err()
    };
    let length = |what, expected, found| BakeError::Length { what, expected, found };
    assert_eq!(refused(&|p| p.c1.truncate(299)), length("c1", 300, 299));
    assert_eq!(refused(&|p| p.rest_normals.truncate(1)), length("rest normals", 24, 1));
    assert_eq!(refused(&|p| p.parents[2] = Some(0)), BakeError::Hierarchy { joint: 0 });
    assert_eq!(refused(&|p| p.rest_frames[1] = [[0.0; 4]; 3]), BakeError::RestFrame { joint: 1 });
    assert_eq!(refused(&|p| p.influences[7].clear()), BakeError::Weights { vertex: 7, sum: 0.0 });
    assert_eq!(
        refused(&|p| p.influences[7] = vec![(70_000, 1.0)]),
        BakeError::Size { what: "palette index", found: 70_000 }
    );
    for edit in [
        (|p| p.c2[9] = f64::NAN) as fn(&mut EnvelopeParts),
        |p| p.influences[7] = vec![(5, 1.0)],
        |p| p.keys[0].joint = 9,
        |p| p.rest_positions[3][1] = 1e300,
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
