//! S1's random changes: a centre or the metric is moved at random, the coefficients are solved, and a
//! change that raises the energy by ΔE is taken with probability e^(-ΔE/T) (METHOD §3).

use super::energy::{Energy, Parameters, Point};
use super::trace::{Step, Stop, Trace};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// A change goes as far as the reach, or a half of it, a quarter, ..., each as likely. It does not depend
/// on the point, so that a change and its reverse are as likely as each other.
const HALVES: u32 = 8;

/// Random changes of a point.
pub(super) struct Walk<'a> {
    /// What is to be lowered.
    pub(super) energy: &'a Energy,
    /// The farthest that a number changes.
    pub(super) reach: f64,
    /// T at first and at last, linear between by evaluations.
    pub(super) temperatures: [f64; 2],
    /// Most evaluations of the trace.
    pub(super) budget: usize,
}

impl Walk<'_> {
    /// Changes a point; returns the best that was seen.
    pub(super) fn run(&self, mut here: Point, random: &mut ChaCha8Rng, trace: &mut Trace) -> Point {
        let entries = 0..here.parameters.metric.len();
        let entries: Vec<usize> = entries.filter(|&entry| self.energy.learns(entry)).collect();
        let [first, last] = self.temperatures;
        let begin = trace.evaluations;
        let mut best = here.clone();
        trace.stop = Stop::Budget;
        while trace.evaluations < self.budget {
            let done = (trace.evaluations - begin) as f64 / (self.budget - begin) as f64;
            let temperature = first + (last - first) * done;
            let there = self.energy.solved(self.changed(&here.parameters, &entries, random));
            trace.evaluations += 1;
            let rise = there.energy - here.energy;
            let accepted = rise <= 0.0
                || (temperature > 0.0 && random.random::<f64>() < libm::exp(-rise / temperature));
            if accepted {
                here = there;
            }
            if here.energy < best.energy {
                best = here.clone();
            }
            trace.steps.push(Step { energy: here.energy, accepted });
        }
        best
    }

    /// Moves a centre, or the entries of the metric that are learned.
    fn changed(&self, from: &Parameters, entries: &[usize], random: &mut ChaCha8Rng) -> Parameters {
        let mut to = from.clone();
        let input_len = self.energy.input_len();
        let group_len = to.centres.len() / input_len + usize::from(!entries.is_empty());
        let group = random.random_range(0..group_len);
        let size = self.reach / f64::from(1u32 << random.random_range(0..HALVES));
        let mut change = || size * (2.0 * random.random::<f64>() - 1.0);
        match to.centres.chunks_exact_mut(input_len).nth(group) {
            Some(centre) => centre.iter_mut().for_each(|t| *t += change()),
            None => entries.iter().for_each(|&entry| to.metric[entry] += change()),
        }
        to
    }
}
