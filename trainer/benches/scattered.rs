//! Prints how long fits of scattered data take: 2,000 samples, 10 inputs, 100 values, on one thread; the
//! least of five runs.
//!
//! `cargo bench -p sinew-trainer --bench scattered`. SciPy's time beside it:
//!
//! ```text
//! OPENBLAS_NUM_THREADS=1 python -c "
//! import numpy as np, time; from scipy.interpolate import RBFInterpolator as R
//! g = np.random.default_rng(0); x = g.uniform(-1, 1, (2000, 10)); y = np.sin(x @ g.normal(size=(10, 100)))
//! def t(k):
//!     a = time.perf_counter(); R(x, y, kernel=k, epsilon=0.4); return time.perf_counter() - a
//! for k in ['gaussian', 'thin_plate_spline']: print(k, min(t(k) for _ in range(5)))"
//! ```

use faer::Mat;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew_runtime::kernel::Kernel;
use sinew_trainer::kernel::scattered::error::KernelError;
use sinew_trainer::kernel::scattered::fit::Fit;
use sinew_trainer::kernel::scattered::options::Options;
use sinew_trainer::kernel::scattered::report::FitReport;
use sinew_trainer::kernel::scattered::samples::{Conflicts, Samples};
use sinew_trainer::kernel::scattered::scaling::Block;
use std::time::{Duration, Instant};

const SAMPLES: usize = 2000;
const INPUTS: usize = 10;
const VALUES: usize = 100;
const RUNS: usize = 5;

fn main() -> Result<(), KernelError> {
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

/// Runs something some times, and returns its result and the least of its seconds.
fn least<T>(run: impl Fn() -> Result<T, KernelError>) -> Result<(T, f64), KernelError> {
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
