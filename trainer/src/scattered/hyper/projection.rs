//! Variable projection: centres and metric by L-BFGS, where coefficients are always those that fit best
//! (METHOD §3; Golub and Pereyra 1973).

use super::energy::{Energy, Parameters, Point};
use super::quasi_newton::{Memory, add, search};
use super::trace::{Step, Stop, Trace};
use crate::numeric::columns::dot;

/// How far the first step goes at most, in units of u and of W.
const REACH: f64 = 0.1;
/// So many steps that together lower the energy by no more than this share are the last.
const SETTLED: (usize, f64) = (20, 1e-4);

/// Learns from a point on, within the trace's evaluations.
pub(super) fn learn(energy: &Energy, mut here: Point, budget: usize, trace: &mut Trace) -> Point {
    let mut memory = Memory::default();
    let mut gradient = downhill(energy, &here);
    trace.stop = loop {
        let direction = memory.direction(&gradient, REACH);
        let slope = dot(&gradient, &direction);
        let at = |length: f64| {
            if trace.evaluations >= budget {
                return None;
            }
            trace.evaluations += 1;
            let there = energy.solved(moved(&here.parameters, length, &direction));
            let gradient = downhill(energy, &there);
            Some((there.energy, dot(&gradient, &direction), (there, gradient)))
        };
        let found = if slope < 0.0 { search(here.energy, slope, at) } else { None };
        let Some((there, after)) = found else {
            if trace.evaluations >= budget {
                break Stop::Budget;
            }
            if memory.forget() {
                continue;
            }
            break Stop::NoDescent;
        };
        let mut step = flat(&there.parameters);
        add(&mut step, -1.0, &flat(&here.parameters));
        let mut change = after.clone();
        add(&mut change, -1.0, &gradient);
        // Wolfe's conditions promise it, but for rounding.
        if dot(&step, &change) > 0.0 {
            memory.remember(step, change);
        }
        (here, gradient) = (there, after);
        trace.steps.push(Step { energy: here.energy, accepted: true });
        if settled(trace) {
            break Stop::Settled;
        }
    };
    here
}

fn settled(trace: &Trace) -> bool {
    let (count, share) = SETTLED;
    let before = trace.steps.len().checked_sub(count + 1).map(|place| trace.steps[place].energy);
    let now = trace.steps.last().map(|step| step.energy);
    before.zip(now).is_some_and(|(before, now)| before - now <= share * before)
}

/// The gradient by centres and metric. Where coefficients are the best there is none by them.
fn downhill(energy: &Energy, point: &Point) -> Vec<f64> {
    flat(&energy.gradient(point))
}

/// Centres, then the metric.
fn flat(parameters: &Parameters) -> Vec<f64> {
    [parameters.centres.as_slice(), &parameters.metric].concat()
}

fn moved(from: &Parameters, length: f64, direction: &[f64]) -> Parameters {
    let mut to = from.clone();
    let (of_centres, of_metric) = direction.split_at(to.centres.len());
    add(&mut to.centres, length, of_centres);
    add(&mut to.metric, length, of_metric);
    to
}
