//! Bound on the motion of a vertex by rounding of the correction to f32 (METHOD §2.7).

use super::features::Features;
use crate::envelope::lbs::training::Training;
use crate::envelope::model::{EnvelopeModel, Group, SkinModel};
use crate::numeric::columns;
use crate::regression::arithmetic::{Arithmetic, U};
use crate::regression::map::Value;
use faer::Mat;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;

/// Bounds the distance that rounding may move any vertex of a skin, in units of the input. The bound holds for the
/// training poses, and for an equal number of random poses in their bounding box.
pub(in crate::envelope) fn bound(
    groups: &[Group],
    training: &Training,
    restated: &EnvelopeModel,
    skin: &SkinModel,
) -> f64 {
    let errors: Vec<Vec<Latents>> =
        groups.par_iter().map(|group| latents(group, training)).collect();
    let inputs = errors.first().map_or(0, Vec::len);
    let of_vertex = |v: usize| {
        let x = skin.rest_positions[v];
        let followed = follow(restated, &skin.influences[v], [x[0], x[1], x[2], 1.0]);
        let at = |input: usize| {
            let motion = |r: usize| -> f64 {
                let of = |(group, moves): &(usize, Vec<Moves>)| -> f64 {
                    let latents = errors[*group][input].iter().zip(moves);
                    latents.map(|(own, m)| m.sum[r].abs() * own.error + m.size[r] * own.term).sum()
                };
                followed.iter().map(of).sum()
            };
            (0..3).map(|r| motion(r).powi(2)).sum::<f64>().sqrt()
        };
        (0..inputs).map(at).fold(0.0, f64::max)
    };
    let all: Vec<f64> = (0..skin.rest_positions.len()).into_par_iter().map(of_vertex).collect();
    all.into_iter().fold(0.0, f64::max)
}

/// Rounding errors of a latent output at one input.
struct Latent {
    /// Error of the output, times its share.
    error: f64,
    /// Error of each term that is multiplied by the output.
    term: f64,
}

type Latents = Vec<Latent>;

/// Motion of a vertex per latent output: sum of the terms, and sum of their sizes.
#[derive(Clone, Default)]
struct Moves {
    sum: [f64; 3],
    size: [f64; 3],
}

/// Computes the rounding errors of a group's latent outputs at every input.
fn latents(group: &Group, training: &Training) -> Vec<Latents> {
    columns::narrow_registers();
    let samples = Features::of(training).evaluate(&training.poses, &group.inputs);
    let at = |input: Vec<f64>| {
        let Value { outputs, expected_error } = group.map.evaluate(&input);
        let error = group.map.error(&input);
        let share = expected_error.map_weight();
        let (least, most) = error.expected_error.map_weights(Arithmetic::IEEE);
        let of_share = (share - least).max(most - share);
        // The roundings are a sum of r products, the share, and the product with the joint's rotation.
        let term = (outputs.len() as f64 + 6.0) * U * most;
        let latent = |(z, error): (&f64, &f64)| Latent {
            error: most * error + of_share * z.abs(),
            term: term * z.abs(),
        };
        outputs.iter().zip(&error.outputs).map(latent).collect()
    };
    with_box(&samples).map(at).collect()
}

/// Lists the groups that a vertex follows, with the motion of the vertex per latent output.
fn follow(
    restated: &EnvelopeModel,
    influences: &[(usize, f64)],
    x: [f64; 4],
) -> Vec<(usize, Vec<Moves>)> {
    let mut out = Vec::<(usize, Vec<Moves>)>::new();
    for &(index, alpha) in influences {
        let Some(proxy) = index.checked_sub(restated.first_proxy()) else { continue };
        let owner = restated.groups.iter().position(|group| group.proxies.contains(&proxy));
        let Some(owner) = owner else { continue };
        let Group { proxies, outputs, .. } = &restated.groups[owner];
        let (rank, own) = (outputs.ncols(), 12 * (proxy - proxies.start));
        let at = out.iter().position(|known| known.0 == owner).unwrap_or_else(|| {
            out.push((owner, vec![Moves::default(); rank]));
            out.len() - 1
        });
        for (z, moves) in out[at].1.iter_mut().enumerate() {
            for r in 0..3 {
                for (c, x) in x.iter().enumerate() {
                    let term = alpha * outputs[(own + 4 * r + c, z)] * x;
                    moves.sum[r] += term;
                    moves.size[r] += term.abs();
                }
            }
        }
    }
    out
}

/// Lists samples (columns), then an equal number of random points of their bounding box, which contains the origin.
fn with_box(samples: &Mat<f64>) -> impl Iterator<Item = Vec<f64>> + '_ {
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(3);
    let ranges: Vec<(f64, f64)> = samples
        .row_iter()
        .map(|row| row.iter().fold((0.0f64, 0.0f64), |(a, b), &x| (a.min(x), b.max(x))))
        .collect();
    let within = move |_| {
        ranges.iter().map(|&(a, b)| a + (b - a) * random.random_range(0.0..=1.0)).collect()
    };
    let columns = samples.col_iter().map(|x| x.iter().copied().collect());
    columns.chain((0..samples.ncols()).map(within))
}
