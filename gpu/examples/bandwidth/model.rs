//! A model of a given size; its motion does not matter here.

use faer::Mat;
use sinew_runtime::envelope::{Certificate, GroupKernel, HelperKind};
use sinew_runtime::format::Space;
use sinew_trainer::envelope::model::{
    EnvelopeModel, Feature, FileModel, Group, Input, Shapes, SkinModel,
};
use sinew_trainer::examples::Skeleton;
use sinew_trainer::numeric::trs::Place;
use sinew_trainer::regression::confidence::MapConfidence;
use sinew_trainer::regression::map::KernelMap;

const JOINTS: usize = 20;
/// Helpers in total, and helpers of each group.
const HELPERS: usize = 40;
const GROUP: usize = 4;
/// Inputs, centres and latent values of a group's kernel map.
const INPUTS: usize = 18;
const CENTRES: usize = 24;
const RANK: usize = 12;
const CERTAINTY: usize = 8;
const INFLUENCES: usize = 4;

/// Makes a kernel model of `vertices` vertices: 20 joints, 40 helpers, four influences, no
/// tangents.
pub(crate) fn file_model(vertices: usize) -> FileModel {
    FileModel {
        space: Space::default(),
        envelopes: vec![envelope()],
        skins: vec![skin(vertices)],
        ..FileModel::default()
    }
}

fn envelope() -> EnvelopeModel {
    let frame = |joint: usize| {
        [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.5 * joint as f64]]
    };
    EnvelopeModel {
        name: "synthetic".to_owned(),
        skeleton: Skeleton {
            names: (0..JOINTS).map(|joint| format!("joint {joint}")).collect(),
            parents: (0..JOINTS).map(|joint| joint.checked_sub(1)).collect(),
            rest: (0..JOINTS).map(frame).collect(),
            ..Skeleton::default()
        },
        reconstruction: None,
        groups: (0..HELPERS / GROUP).map(group).collect(),
        helper_kind: HelperKind::Affine,
        places: vec![Place::at([0.0; 3]); HELPERS],
        pose_ranges: vec![1.0; JOINTS],
        pose_gaps: vec![0.0; JOINTS],
        stretch_ranges: None,
        curves: Vec::new(),
        certificate: Certificate {
            diagonal: 10.0,
            training_rms: 0.0,
            same_clips_rms: 0.0,
            lbs_training_rms: 0.0,
            correction_error: 0.0,
            base_training_rms: 0.0,
            other_clip_rms: None,
            trs_error: 0.0,
        },
    }
}

fn skin(vertices: usize) -> SkinModel {
    // A spiral; neighbouring vertices follow the same transforms, as in a mesh.
    let at = |vertex: usize| vertex as f64 / vertices as f64;
    let position = |vertex: usize| {
        let angle = 0.1 * vertex as f64;
        [angle.cos(), angle.sin(), 10.0 * at(vertex)]
    };
    let normal = |vertex: usize| {
        let angle = 0.1 * vertex as f64;
        [angle.cos(), angle.sin(), 0.0]
    };
    let influences = |vertex: usize| {
        let first = (at(vertex) * (JOINTS + HELPERS) as f64) as usize;
        let own = |k: usize| ((first + k) % (JOINTS + HELPERS), 1.0 / INFLUENCES as f64);
        (0..INFLUENCES).map(own).collect()
    };
    SkinModel {
        name: "spiral".to_owned(),
        envelope: Some(0),
        rest_positions: (0..vertices).map(position).collect(),
        rest_normals: (0..vertices).map(normal).collect(),
        rest_tangents: None,
        influences: (0..vertices).map(influences).collect(),
        tangent_coefficients: None,
        normal_errors: None,
        ranges: Vec::new(),
        shapes: Shapes::default(),
    }
}

fn group(group: usize) -> Group {
    let wave = |i: usize| (0.7 * i as f64).sin();
    let small = |rows, columns| Mat::from_fn(rows, columns, |r, c| 0.01 * wave(r * columns + c));
    let joint = 1 + group % (JOINTS - 1);
    Group {
        joint,
        proxies: group * GROUP..(group + 1) * GROUP,
        inputs: (0..INPUTS)
            .map(|i| Input {
                feature: Feature::Joint { joint, entry: i % 12 },
                weight: 1.0 + i as f64,
            })
            .collect(),
        map: KernelMap {
            kernel: GroupKernel::Gaussian,
            centres: Mat::from_fn(INPUTS, CENTRES, |i, k| wave(k * INPUTS + i)),
            coefficients: small(RANK + CERTAINTY, CENTRES + INPUTS),
            confidence: MapConfidence {
                len: CERTAINTY,
                reach: 1e4,
                linear: 0.1,
                signal: 1.0,
                noise: 0.0,
            },
        },
        outputs: small(12 * GROUP, RANK),
    }
}
