//! S1's dynamical system: centres, metric and coefficients go down the energy's gradient, ω times as
//! far as it is steep (METHOD §3).

use super::energy::{Energy, Parameters, Point};
use super::quasi_newton::add;
use super::trace::{Step, Stop, Trace};

/// Flows from a point on, within the trace's evaluations; ω is halved where the energy would rise.
pub(super) fn learn(
    energy: &Energy,
    mut here: Point,
    mut omega: f64,
    budget: usize,
    trace: &mut Trace,
) -> Point {
    let mut gradient = energy.gradient(&here);
    trace.stop = Stop::Budget;
    while trace.evaluations < budget {
        let parameters = moved(&here.parameters, -omega, &gradient);
        if parameters == here.parameters {
            trace.stop = Stop::NoDescent;
            break;
        }
        trace.evaluations += 1;
        let there = energy.at(parameters);
        let accepted = there.energy <= here.energy;
        if accepted {
            gradient = energy.gradient(&there);
            here = there;
        } else {
            omega *= 0.5;
        }
        trace.steps.push(Step { energy: here.energy, accepted });
    }
    here
}

fn moved(from: &Parameters, omega: f64, gradient: &Parameters) -> Parameters {
    let mut to = from.clone();
    add(&mut to.centres, omega, &gradient.centres);
    add(&mut to.metric, omega, &gradient.metric);
    add(&mut to.coefficients, omega, &gradient.coefficients);
    to
}
