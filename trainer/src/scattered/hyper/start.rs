//! The samples on which centres start.

use super::energy::{Energy, Parameters, squared};
use super::options::Start;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Chooses `count` different samples; distances are those of the metric, W by rows.
pub(super) fn choose(
    start: Start,
    energy: &Energy,
    metric: &[f64],
    count: usize,
    random: &mut ChaCha8Rng,
) -> Vec<usize> {
    match start {
        Start::Random => any(energy.sample_len(), count, random),
        Start::KMeansPlusPlus => apart(energy, metric, count, random),
        Start::Greedy => greedy(energy, metric, count),
    }
}

/// Draws samples, each as likely.
fn any(sample_len: usize, count: usize, random: &mut ChaCha8Rng) -> Vec<usize> {
    let mut samples: Vec<usize> = (0..sample_len).collect();
    for place in 0..count {
        samples.swap(place, random.random_range(place..sample_len));
    }
    samples.truncate(count);
    samples
}

/// Draws each next sample with a probability as its squared distance from those before; where none
/// is apart from them, any other.
fn apart(energy: &Energy, metric: &[f64], count: usize, random: &mut ChaCha8Rng) -> Vec<usize> {
    let measured = energy.measured_samples(metric);
    let row_len = measured.len() / energy.sample_len();
    let at = |sample: usize| &measured[sample * row_len..][..row_len];
    let mut chosen = vec![random.random_range(0..energy.sample_len())];
    let mut distances = vec![f64::INFINITY; energy.sample_len()];
    while chosen.len() < count {
        let last = chosen[chosen.len() - 1];
        for (i, distance) in distances.iter_mut().enumerate() {
            *distance = distance.min(squared(at(i), at(last)));
        }
        let mut left = random.random::<f64>() * distances.iter().sum::<f64>();
        let drawn = distances.iter().position(|distance| {
            left -= distance;
            left < 0.0
        });
        let next = drawn.or_else(|| (0..energy.sample_len()).find(|i| !chosen.contains(i)));
        chosen.extend(next);
    }
    chosen
}

/// Takes each next sample where those before, their coefficients solved, leave the largest residual.
fn greedy(energy: &Energy, metric: &[f64], count: usize) -> Vec<usize> {
    let mut chosen = Vec::new();
    while chosen.len() < count {
        let misfits = energy.misfits(&energy.solved(placed(energy, metric, &chosen)));
        let others = (0..energy.sample_len()).filter(|i| !chosen.contains(i));
        let worst = others.max_by(|&a, &b| misfits[a].total_cmp(&misfits[b]).then(b.cmp(&a)));
        chosen.extend(worst);
    }
    chosen
}

/// Puts centres on samples, their coefficients yet unsolved.
pub(super) fn placed(energy: &Energy, metric: &[f64], samples: &[usize]) -> Parameters {
    let centres = samples.iter().flat_map(|&i| energy.input(i).iter().copied()).collect();
    Parameters { centres, metric: metric.to_vec(), coefficients: Vec::new() }
}
