//! An independent evaluation of features and kernel maps in f64.

use crate::common::{IDENTITY, Stretched};
use models::GroupContent;
use sinew_runtime::Matrix3x4;
use sinew_runtime::envelope::{GroupConfidence, GroupKernel};

pub(super) type Wide = [[f64; 4]; 3];

/// Features from the motion of points: half of a joint's rotation relative to its parent, and the gap
/// between the joint's origin and where the parent carries it, in the parent's frame. Then strains,
/// if joints stretch, and curves.
pub(super) fn reference_features(at: &Stretched, stretches: bool) -> Vec<f64> {
    let Stretched { pose, rigid, curves } = at;
    let (parents, origins) = skeleton(pose.len());
    let mut out = Vec::new();
    for (joint, parent) in parents.iter().enumerate() {
        let Some(parent) = *parent else {
            out.extend([0.0; 12]);
            continue;
        };
        let [own, above] = [joint, parent].map(|joint| wide(&rigid[joint]));
        let back = |x: [f64; 3]| [0, 1, 2].map(|r| (0..3).map(|k| above[k][r] * x[k]).sum::<f64>());
        let columns = [0, 1, 2].map(|c| back(own.map(|row| row[c])));
        let turn = reference_half([0, 1, 2].map(|r| columns.map(|column| column[r])));
        let origin = origins[joint];
        let place = |joint: usize| {
            wide(&pose[joint])
                .map(|m| m[0] * origin[0] + m[1] * origin[1] + m[2] * origin[2] + m[3])
        };
        let (own, carried) = (place(joint), place(parent));
        let gap = back([0, 1, 2].map(|r| own[r] - carried[r]));
        out.extend((0..3).flat_map(|r| {
            let [x, y, z] = turn[r];
            [x, y, z, gap[r]]
        }));
    }
    if stretches {
        out.extend(pose.iter().flat_map(reference_strain));
    }
    out.extend(curves.iter().map(|value| f64::from(*value)));
    out
}

/// The palette after the correction of a base palette, and the confidence of the groups.
///
/// - `phi`: features of the pose.
pub(super) fn reference(
    groups: &[GroupContent],
    pose: &[Matrix3x4],
    phi: &[f64],
    base: &[Matrix3x4],
) -> (Vec<Wide>, f64) {
    let mut out = base.iter().map(wide).collect::<Vec<_>>();
    let proxies = groups.iter().map(|group| group.proxies).sum::<usize>();
    let mut at = out.len() - proxies;
    let mut known = [0.0; 2];
    for group in groups.iter().filter(|group| !group.centres.is_empty()) {
        let (maps, error) = reference_map(group, phi);
        known = [0, 1].map(|k| known[k] + error[k]);
        let q = wide(pose.get(group.joint).unwrap_or(&IDENTITY));
        for (l, map) in maps.iter().enumerate() {
            for (r, c) in (0..3).flat_map(|r| (0..4).map(move |c| (r, c))) {
                out[at + l][r][c] += (0..3).map(|k| q[r][k] * map[k][c]).sum::<f64>();
            }
        }
        at += group.proxies;
    }
    (out, confidence_of(known))
}

/// A rigid pose without curves.
pub(super) fn rigid(pose: &[Matrix3x4]) -> Stretched {
    Stretched { pose: pose.to_vec(), rigid: pose.to_vec(), curves: Vec::new() }
}

pub(super) fn narrow(transforms: &[Wide]) -> Vec<f32> {
    transforms.as_flattened().as_flattened().iter().map(|&x| x as f32).collect()
}

fn wide(m: &Matrix3x4) -> Wide {
    m.map(|row| row.map(f64::from))
}

/// Parents and origins of the sample's joints, repeated here.
fn skeleton(joints: usize) -> (Vec<Option<usize>>, Vec<[f64; 3]>) {
    let order = [1, 2, 0].into_iter().chain(3..joints).take(joints).collect::<Vec<_>>();
    let mut parents = vec![None; joints];
    let mut origins = vec![[0.0; 3]; joints];
    for (rank, pair) in order.windows(2).enumerate() {
        parents[pair[1]] = Some(pair[0]);
        origins[pair[1]][0] = (rank + 1) as f64;
    }
    (parents, origins)
}

/// S - I for the rows of a rotation R, from its trace and its odd part. S rotates by half the angle
/// about the same axis; its odd part fades like the quaternion's w.
fn reference_half(r: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let odd = [(2, 1), (0, 2), (1, 0)].map(|(a, b)| r[a][b] - r[b][a]);
    let length = odd.iter().map(|x| x * x).sum::<f64>().sqrt();
    let (sine, w) = (length.atan2(r[0][0] + r[1][1] + r[2][2] - 1.0) / 2.0).sin_cos();
    let [x, y, z] = odd.map(|value| value / length.max(1e-300));
    let cross = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]];
    let faded = sine * (1.0 - (1.0 - w).powi(8));
    [0, 1, 2].map(|a| {
        [0, 1, 2].map(|b| {
            let twice = (0..3).map(|k| cross[a][k] * cross[k][b]).sum::<f64>();
            faded * cross[a][b] + (1.0 - w) * twice
        })
    })
}

/// Entries xx, xy, xz, yy, yz, zz of half of LᵀL - I.
fn reference_strain(map: &Matrix3x4) -> [f64; 6] {
    let map = wide(map);
    [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|(a, b)| {
        let product = map.iter().map(|row| row[a] * row[b]).sum::<f64>();
        (product - f64::from(u8::from(a == b))) / 2.0
    })
}

fn reference_kernel(kernel: GroupKernel, s: f64) -> f64 {
    let r = s.sqrt();
    match kernel {
        GroupKernel::Gaussian => (-s).exp(),
        GroupKernel::Matern12 => (-r).exp(),
        GroupKernel::Matern32 => (1.0 + 3f64.sqrt() * r) * (-(3f64.sqrt()) * r).exp(),
        GroupKernel::Matern52 => {
            (1.0 + 5f64.sqrt() * r + 5.0 / 3.0 * s) * (-(5f64.sqrt()) * r).exp()
        }
    }
}

/// Returns K of a group's helpers, multiplied by w, and the explained and unexplained error.
fn reference_map(group: &GroupContent, phi: &[f64]) -> (Vec<Wide>, [f64; 2]) {
    let x = group.inputs.iter().map(|&(f, w)| f64::from(w) * phi[f as usize]);
    let x = x.collect::<Vec<_>>();
    let squared = |x: &[f64], t: &[f32]| {
        x.iter().zip(t).map(|(x, t)| (x - f64::from(*t)).powi(2)).sum::<f64>()
    };
    let change = |t: &Vec<f32>| {
        let [here, rest] = [squared(&x, t), squared(&vec![0.0; x.len()], t)];
        reference_kernel(group.kernel, here) - reference_kernel(group.kernel, rest)
    };
    let basis = group.centres.iter().map(change).collect::<Vec<_>>();
    let times = |rows: &[Vec<f32>], x: &[f64]| {
        let row = |row: &Vec<f32>| row.iter().zip(x).map(|(a, x)| f64::from(*a) * x).sum::<f64>();
        rows.iter().map(row).collect::<Vec<_>>()
    };
    let mut latent = times(&group.coefficients, &[basis.clone(), x.clone()].concat());
    let certainty = latent.split_off(latent.len() - group.certainty);
    let GroupConfidence { reach, linear, signal, noise } = group.confidence;
    let [reach, linear, signal, noise] = [reach, linear, signal, noise].map(f64::from);
    let apart = x.iter().map(|x| x * x).sum::<f64>();
    let prior = (1.0 - (1.0 + basis[0]).powi(2) + linear * apart).max(0.0);
    let smooth = |u: f64| 10.0 * u.powi(3) - 15.0 * u.powi(4) + 6.0 * u.powi(5);
    let near = smooth(((4.0 * reach - apart) / (3.0 * reach)).clamp(0.0, 1.0));
    let explained = near * certainty.iter().map(|h| h * h).sum::<f64>().min(prior);
    let error = if near > 0.0 {
        let growth = 4.0 * apart / (4.0 * apart + reach);
        [signal * growth * explained, noise * growth * (prior - explained)]
    } else {
        [0.0, f64::INFINITY]
    };
    let w = smooth((8.0 * confidence_of(error)).min(1.0));
    let out = times(&group.outputs, &latent);
    let maps = out.chunks(12).map(|k| [0, 1, 2].map(|r| [0, 1, 2, 3].map(|c| w * k[4 * r + c])));
    (maps.collect(), error)
}

/// Returns the confidence of the explained and unexplained error.
fn confidence_of([explained, unexplained]: [f64; 2]) -> f64 {
    1.0 / (1.0 + unexplained / (1.0 + explained))
}
