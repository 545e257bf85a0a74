//! Traces of learning, which depend only on samples and options.

use crate::hyper::problem::{Problem, options};
use sinew_runtime::kernel::Kernel;
use sinew_trainer::scattered::hyper::{Learned, Method, Options, Start, Trace};

const FLOW: Method = Method::GradientFlow { step: 1.0 };
const COLD: Method = Method::Metropolis { reach: 0.5, temperatures: [0.0; 2] };
const ANNEALED: Method = Method::Metropolis { reach: 0.5, temperatures: [0.01, 0.0] };

fn learned(method: Method, options: Options) -> Learned {
    let options = Options { method, evaluations: 200, ..options };
    Problem::franke(9, 60).learn(&options).unwrap()
}

/// Hashes a trace (FNV-1a): the bits of its energies, and the accepted steps.
fn hash(trace: &Trace) -> u64 {
    let steps = trace.steps.iter().map(|step| (step.energy, step.accepted));
    std::iter::once((trace.start, true))
        .chain(steps)
        .flat_map(|(energy, accepted)| [energy.to_bits(), u64::from(accepted)])
        .flat_map(u64::to_le_bytes)
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        })
}

#[test]
fn a_trace_has_the_same_bits_on_any_cpu() {
    // The promise of METHOD §3: change these only with a reason that the commit states.
    const BITS: [u64; 4] = [
        0xdf65_153a_53bc_639c,
        0x7e0a_c71f_a55b_945d,
        0x54ab_a32d_0ea2_6fbc,
        0x9b15_61de_c24c_7fbe,
    ];
    let cases = [
        (Method::VariableProjection, Kernel::Gaussian, Start::KMeansPlusPlus),
        (Method::VariableProjection, Kernel::ThinPlate, Start::Random),
        (FLOW, Kernel::Matern52, Start::KMeansPlusPlus),
        (ANNEALED, Kernel::Gaussian, Start::KMeansPlusPlus),
    ];
    let found = cases.map(|(method, kernel, start)| {
        let options = Options { kernel, start, degree: Some(1), ..options(2, 6) };
        hash(&learned(method, options).traces[0])
    });
    assert_eq!(found, BITS, "{found:#018x?}");
}

#[test]
fn threads_change_nothing_and_the_best_seed_is_kept() {
    let many = Options { seeds: (1..=6).collect(), ..options(2, 6) };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| learned(Method::VariableProjection, many.clone()))
    };
    let (one, two) = (on(1), on(2));
    assert_eq!(one.traces, two.traces);
    assert_eq!(one.sum.coefficients, two.sum.coefficients);
    let last = |trace: &Trace| trace.steps.last().unwrap().energy;
    let least = one.traces.iter().map(last).fold(f64::INFINITY, f64::min);
    assert_eq!((one.energy, last(&one.traces[one.best])), (least, least));
    assert!(one.traces.iter().any(|trace| last(trace) > least), "all seeds are alike");
    let seed = one.traces[one.best].seed;
    let alone = Options { seeds: vec![seed], ..many.clone() };
    assert_eq!(
        learned(Method::VariableProjection, alone).sum.centres,
        one.sum.centres,
        "a seed depends on the others"
    );
}

#[test]
fn energies_fall_but_where_it_is_warm() {
    let warm = Method::Metropolis { reach: 0.5, temperatures: [0.01; 2] };
    for (method, falls) in
        [(Method::VariableProjection, true), (FLOW, true), (COLD, true), (warm, false)]
    {
        let learned = learned(method, options(2, 6));
        let trace = &learned.traces[0];
        let before = [trace.start].into_iter().chain(trace.steps.iter().map(|step| step.energy));
        let energies: Vec<f64> = before.collect();
        assert_eq!(energies.is_sorted_by(|a, b| a >= b), falls, "{method:?}");
        assert!(learned.energy < 0.5 * trace.start, "{method:?}");
        let least = energies.iter().copied().fold(f64::INFINITY, f64::min);
        assert_eq!(learned.energy, least, "{method:?}");
        for (step, pair) in trace.steps.iter().zip(energies.windows(2)) {
            assert!(step.accepted || pair[0] == pair[1], "{method:?}");
        }
        assert!(trace.steps.iter().any(|step| step.accepted));
    }
}

#[test]
fn evaluations_are_counted_and_end_it() {
    for method in [Method::VariableProjection, FLOW, COLD] {
        for evaluations in [0, 1, 2, 50] {
            let options = Options { method, evaluations, ..options(2, 6) };
            let learned = Problem::franke(9, 60).learn(&options).unwrap();
            let trace = &learned.traces[0];
            assert_eq!(trace.evaluations, evaluations.max(1));
            let most = trace.evaluations - 1;
            let each = method == Method::VariableProjection && trace.steps.len() <= most;
            assert!(each || trace.steps.len() == most, "{method:?}");
        }
    }
}

#[test]
fn the_energy_is_that_of_the_function_and_a_ridge_is_part_of_it() {
    let problem = Problem::franke(9, 60);
    for ridge in [0.0, 1e-4] {
        let options = Options { ridge, degree: Some(1), ..options(2, 6) };
        let Learned { sum, energy, .. } = learned(Method::VariableProjection, options);
        let squares = 60.0 * problem.rms(&sum).powi(2);
        let size = 60.0 * ridge * sum.coefficients.squared_norm_l2();
        assert!((squares + size - energy).abs() < 1e-9 * energy, "{squares} {size} {energy}");
        assert_eq!(ridge > 0.0, size > 1e-3 * energy);
    }
}

#[test]
fn an_optimal_start_stops_early() {
    // A plane: the polynomial fits exactly.
    let plane = Problem::new(3, 60, 2, |x| 1.0 + 2.0 * x[0] - x[1]);
    let options = Options { degree: Some(1), ridge: 0.0, ..options(2, 6) };
    let found = plane.learn(&options).unwrap();
    assert!(found.energy < 1e-24 && found.traces[0].evaluations < 1000);
    // A function of zeros: the gradient is zero.
    for method in [Method::VariableProjection, FLOW] {
        let nothing = Problem::new(3, 60, 2, |_| 0.0);
        let found = nothing.learn(&Options { method, ..options.clone() }).unwrap();
        assert_eq!((found.energy, found.traces[0].evaluations), (0.0, 1));
    }
}
