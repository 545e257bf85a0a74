//! Prints times on scattered data on one thread: fits of 2,000 samples, 10 inputs and 100 values, and
//! queries of baked functions. Each time is the minimum of five runs.
//!
//! `cargo bench -p sinew-trainer --bench scattered`. This command prints SciPy's times:
//!
//! ```text
//! OPENBLAS_NUM_THREADS=1 python -c "
//! import numpy as np, time; from scipy.interpolate import RBFInterpolator as R
//! g = np.random.default_rng(0)
//! def least(f):
//!     def t(): a = time.perf_counter(); f(); return time.perf_counter() - a
//!     return min(t() for _ in range(5))
//! def samples(n, d, m): x = g.uniform(-1, 1, (n, d)); return x, np.sin(x @ g.normal(size=(d, m)))
//! for k in ['gaussian', 'thin_plate_spline']:
//!     x, y = samples(2000, 10, 100)
//!     print(k, 'fit, s', least(lambda: R(x, y, kernel=k, epsilon=0.4)))
//!     for n, d, m in [(200, 3, 3), (64, 27, 480)]:
//!         x, y = samples(n, d, m); f = R(x, y, kernel=k, epsilon=1, degree=1); q = g.uniform(-1, 1, (100000, d))
//!         print(k, n, d, m, 'a query, us', 1e6 * least(lambda: f(q)) / 100000)"
//! ```

use anyhow::Context;
use faer::Mat;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew_runtime::format::Space;
use sinew_runtime::kernel::Kernel;
use sinew_runtime::{KernelMap, Model};
use sinew_trainer::Error;
use sinew_trainer::bake::bake;
use sinew_trainer::scattered::bake::part;
use sinew_trainer::scattered::model::{Input, InputKind, Output, OutputKind};
use sinew_trainer::scattered::problem::{Problem, ProblemOptions};
use sinew_trainer::scattered::solver::fit::Fit;
use sinew_trainer::scattered::solver::options::Options;
use sinew_trainer::scattered::solver::report::FitReport;
use sinew_trainer::scattered::solver::samples::{Conflicts, Samples};
use sinew_trainer::scattered::solver::scaling::Block;
use sinew_trainer::scattered::train::train;
use std::time::{Duration, Instant};

const SAMPLES: usize = 2000;
const INPUTS: usize = 10;
const VALUES: usize = 100;
const RUNS: usize = 5;

/// Samples, inputs and values of the evaluated functions.
const ASKED: [[usize; 3]; 2] = [[200, 3, 3], [64, 27, 480]];
const QUERIES: usize = 100_000;

fn main() -> anyhow::Result<()> {
    fits()?;
    for sizes in ASKED {
        for kernel in [Kernel::Gaussian, Kernel::ThinPlate] {
            queries(kernel, sizes)?;
        }
    }
    Ok(())
}

/// Prints the time of a baked function per query.
fn queries(kernel: Kernel, [n, d, m]: [usize; 3]) -> anyhow::Result<()> {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut row = || (0..d).map(|_| 2.0 * random.random::<f64>() - 1.0).collect::<Vec<f64>>();
    let sites: Vec<Vec<f64>> = (0..n).map(|_| row()).collect();
    let value = |site: &Vec<f64>, o: usize| {
        let wave = |(i, x): (usize, &f64)| x * (1.0 + i as f64 + 0.37 * o as f64).sin();
        site.iter().enumerate().map(wave).sum::<f64>().sin()
    };
    let free = OutputKind::Scalar {
        low: f64::from(f32::MIN),
        high: f64::from(f32::MAX),
        normalised: false,
        neutral: 0.0,
    };
    let problem = Problem {
        name: "asked".to_owned(),
        inputs: (0..d)
            .map(|i| Input { name: format!("x{i}"), kind: InputKind::Scalar, weight: 1.0 })
            .collect(),
        outputs: (0..m).map(|o| Output { name: format!("y{o}"), kind: free }).collect(),
        values: sites.iter().map(|site| (0..m).map(|o| value(site, o)).collect()).collect(),
        sites,
        lines: Vec::new(),
        options: ProblemOptions {
            kernel: Some(kernel.name().to_owned()),
            epsilon: Some(4.0),
            degree: Some(1),
            ..ProblemOptions::default()
        },
    };
    let model = train(&problem, false)?.model;
    let file = Model::from_bytes(bake(Space::default(), &[part(&model)?])?)?;
    let map = file.first::<KernelMap>().context("the file has no function")?;
    let points: Vec<f32> = (0..QUERIES).flat_map(|_| row()).map(|x| x as f32).collect();
    let mut scratch = vec![0.0; map.counts().scratch_len()];
    let mut out = vec![0.0; map.result_len()];
    let mut shortest = f64::INFINITY;
    for _ in 0..RUNS {
        let start = Instant::now();
        for point in points.chunks(d) {
            map.evaluate(point, &mut scratch, &mut out)?;
        }
        shortest = shortest.min(start.elapsed().as_secs_f64());
    }
    let each = 1e6 * shortest / QUERIES as f64;
    println!("{}, {n} samples, {d} inputs, {m} values: a query {each:.2} us", kernel.name());
    Ok(())
}

/// Prints the times of fits and of their reports.
fn fits() -> Result<(), Error> {
    let mut random = ChaCha8Rng::seed_from_u64(0);
    let mut uniform = |rows: usize, columns: usize| {
        Mat::from_fn(rows, columns, |_, _| 2.0 * random.random::<f64>() - 1.0)
    };
    let sites = uniform(SAMPLES, INPUTS);
    let waves = &sites * uniform(INPUTS, VALUES);
    let values = Mat::from_fn(SAMPLES, VALUES, |i, o| (1.7 * waves[(i, o)]).sin());
    let blocks = [Block { len: 1, weight: 1.0 }; INPUTS];
    println!("{SAMPLES} samples, {INPUTS} inputs, {VALUES} values: seconds");
    let samples = || Samples::new(&sites, &values, &blocks, Conflicts::Refuse);
    println!("  samples checked       {:.3}", least(samples)?.1);
    let samples = samples()?;
    for kernel in [Kernel::Gaussian, Kernel::ThinPlate] {
        let options = Options::new(kernel);
        let (fit, seconds) = least(|| Fit::new(&samples, &options))?;
        println!("  {}: fitted   {seconds:.3}", kernel.name());
        let (report, seconds) = least(|| Ok(FitReport::new(&samples, &options, &fit)))?;
        println!("  {}: reported {seconds:.3}, rcond {:.1e}", kernel.name(), report.rcond);
    }
    Ok(())
}

/// Runs a function several times; returns its result and the minimum time in seconds.
fn least<T>(run: impl Fn() -> Result<T, Error>) -> Result<(T, f64), Error> {
    let timed = || {
        let start = Instant::now();
        run().map(|result| (result, start.elapsed()))
    };
    let (mut result, mut shortest) = timed()?;
    for _ in 1..RUNS {
        let (again, elapsed): (T, Duration) = timed()?;
        result = again;
        shortest = shortest.min(elapsed);
    }
    Ok((result, shortest.as_secs_f64()))
}
