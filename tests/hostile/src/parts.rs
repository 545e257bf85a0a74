//! Reads and evaluates kernels, priors and filters of an accepted file, and checks the promises of
//! the runtime.

use models::Rng;
use sinew_runtime::filter::Samples;
use sinew_runtime::format::MAGNITUDE_MAX;
use sinew_runtime::prior::{Anchor, Temporal};
use sinew_runtime::{
    Argument, CallError, CallErrorKind, Filter, KernelMap, Matrix3x4, Pin, PinJob, Pins, Prior,
    Skin,
};

/// Magnitudes of a query's numbers, from values like the data's to values that overflow.
const QUERY_SIZES: [f32; 8] = [0.5, 1.0, 0.0, 1e-20, 10.0, 1e6, 1e18, 3e38];

/// Magnitudes of samples and of pins' targets, from values like the data's to values that overflow.
const NUMBER_SIZES: [f32; 6] = [0.5, 1.0, 0.0, 1e-20, 1e6, 3e38];

/// Number of derivatives above which a call would take too long.
const DERIVATIVES: usize = 1 << 14;

/// Reads every accessor of a kernel.
///
/// # Panics
/// If an accessor lacks a value that a loaded kernel must have, or if the kernel asks for more than
/// its file's length allows.
pub(crate) fn read_kernel(map: &KernelMap<'_>, file: &[u8]) {
    let counts = map.counts();
    for cost in [counts.scratch_len(), map.query_len(), map.result_len()] {
        assert!(cost <= file.len(), "a file of {} bytes costs {cost}", file.len());
    }
    // A variance without centres and terms takes no bytes for its rows: the format bounds their
    // number.
    assert!(counts.variance_scratch_len() <= file.len() + 65_536);
    assert_eq!(map.inputs().count(), counts.input_len as usize);
    assert_eq!(map.outputs().count(), counts.output_len as usize);
    assert!((0..counts.input_len as usize).all(|input| map.input_name(input).is_some()));
    assert!((0..counts.output_len as usize).all(|output| map.output_name(output).is_some()));
    let (features, values) = (counts.feature_len as usize, counts.value_len as usize);
    assert_eq!(map.inputs().map(|input| input.kind.feature_len()).sum::<usize>(), features);
    assert_eq!(map.outputs().map(|output| output.kind.value_len()).sum::<usize>(), values);
    let opened = map.layout().open::<KernelMap>(file);
    assert!(opened.is_some_and(|opened| opened.counts() == counts));
}

/// Makes query `number`.
pub(crate) fn query(map: &KernelMap<'_>, number: usize) -> Vec<f32> {
    let mut random = Rng(number as u64);
    let size = QUERY_SIZES[number % QUERY_SIZES.len()];
    // Some numbers keep the data's magnitude: one outlier among normal numbers is the likelier
    // call.
    (0..map.query_len()).map(|at| random.unit() * if at % 3 == 1 { 0.7 } else { size }).collect()
}

/// Evaluates query `number`, its derivatives and its variance.
///
/// # Panics
/// If a call is refused for another reason than a rotation without a direction or overflow, if a
/// refused call has written, or if a result is not finite.
pub(crate) fn evaluate_kernel(map: &KernelMap<'_>, number: usize) {
    let counts = map.counts();
    let (query, m) = (query(map, number), counts.value_len as usize);
    let mut out = vec![f32::NAN; map.result_len()];
    let done = map.evaluate(&query, &mut vec![f32::NAN; counts.scratch_len()], &mut out);
    check(
        done.map(|confidence| assert!((0.0..=1.0).contains(&confidence))),
        Argument::Outputs,
        &out,
    );
    if m * query.len() <= DERIVATIVES {
        let mut out = vec![f32::NAN; m * query.len()];
        let mut scratch = vec![f32::NAN; counts.jacobian_scratch_len()];
        check(map.jacobian(&query, &mut scratch, &mut out), Argument::Jacobian, &out);
    }
    let mut out = vec![f32::NAN; m];
    let mut scratch = vec![f32::NAN; counts.variance_scratch_len()];
    let done = map.variance(&query, &mut scratch, &mut out);
    assert_eq!(
        done.is_err_and(|error| error.kind == CallErrorKind::NoAttribute),
        !map.has_variance()
    );
    if map.has_variance() {
        check(done, Argument::Variances, &out);
    }
}

fn check(done: Result<(), CallError>, argument: Argument, out: &[f32]) {
    match done {
        Ok(()) => assert!(out.iter().all(|x| x.is_finite()), "{argument:?} {out:?}"),
        Err(error) => {
            assert!(out.iter().all(|x| x.is_nan()), "{error}: written");
            let of_query =
                (error.kind, error.argument) == (CallErrorKind::ZeroRotation, Argument::Query);
            let of_result = (error.kind, error.argument) == (CallErrorKind::NonFinite, argument);
            assert!(of_query || of_result, "{error}");
        }
    }
}

/// Number of shapes above which a solve would take too long.
const SHAPES: usize = 64;

/// Reads every accessor of a prior.
///
/// # Panics
/// If an accessor lacks a value that a loaded prior must have, or if the prior asks for more than
/// its file's length allows.
pub(crate) fn read_prior(prior: &Prior<'_>, file: &[u8]) {
    let (n, counts) = (prior.shape_len(), prior.counts());
    let cost = counts.pin_scratch_len(0);
    assert!(cost <= 7 + file.len(), "a file of {} bytes costs {cost}", file.len());
    assert!((0..n).all(|s| prior.mean(s).is_some() && prior.weight_bounds(s).is_some()));
    assert!((0..n).all(|s| prior.factor_entry(s, s).is_some_and(|x| x > 0.0)));
    assert!(prior.symmetry().all(|([a, b], _)| a < n && b < n && a != b));
    assert!(prior.cancel_pairs().all(|[a, b]| a < n && b < n && a != b));
    let opened = prior.layout().open::<Prior>(file);
    assert!(opened.is_some_and(|opened| opened.counts() == counts));
}

/// Solves for pins that depend on `number`.
///
/// # Panics
/// If a call is refused for another reason than overflow, if a refused call has written, or if a
/// result is not finite or outside the bounds.
pub(crate) fn evaluate_prior(
    prior: &Prior<'_>,
    skin: &Skin<'_>,
    palette: &[Matrix3x4],
    number: usize,
) {
    let n = prior.shape_len();
    if n > SHAPES || skin.vertex_len() == 0 {
        return;
    }
    let mut random = Rng(number as u64);
    let size = NUMBER_SIZES[number % NUMBER_SIZES.len()];
    let mut pins = Pins::<4>::new();
    for pin in 0..number % 5 {
        let target = [(); 3].map(|()| random.unit() * size);
        let vertex = (number * 7 + pin * 31) % skin.vertex_len();
        let pin = Pin::new(vertex as u32, target).with_stiffness(1.0 + random.unit());
        assert!(pins.add(pin).is_ok());
    }
    let weights: Vec<f32> = (0..n).map(|_| random.unit()).collect();
    let mut out = weights.clone();
    let job = PinJob {
        palette,
        anchor: if number.is_multiple_of(2) { Anchor::Mean } else { Anchor::Current },
        is_bounded: !number.is_multiple_of(3),
        temporal: Some(Temporal { weights: &weights, stiffness: 0.5 }),
        symmetry: (number % 4) as f32,
        cancels: number.is_multiple_of(5),
        ..PinJob::new(*prior, *skin, pins.list())
    };
    let len = prior.counts().pin_scratch_len(pins.list().scalar_len());
    match job.run(&mut vec![f64::NAN; len], &mut out) {
        Ok(edit) => {
            assert!(out.iter().all(|weight| weight.is_finite()), "{out:?}");
            let within = |(s, w): (usize, &f32)| {
                prior.weight_bounds(s).is_some_and(|[low, high]| (low..=high).contains(w))
            };
            let is_solved = edit.round_len > 0;
            assert!(!is_solved || !job.is_bounded || out.iter().enumerate().all(within));
        }
        Err(error) => {
            assert_eq!(out, weights, "{error}: written");
            let of = [Argument::Pins, Argument::Weights].contains(&error.argument);
            assert!(error.kind == CallErrorKind::NonFinite && of, "{error}");
        }
    }
}

/// Number of taps above which a call would take too long.
const TAPS: usize = 1 << 14;

/// Reads every accessor of a filter.
///
/// # Panics
/// If an accessor lacks a value that a loaded filter must have, or if the filter asks for more than
/// its file's length allows.
pub(crate) fn read_filter(filter: &Filter<'_>, file: &[u8]) {
    let (n, f) = (filter.tap_len(), filter.factor());
    assert!(4 * n * f * n <= file.len(), "a file of {} bytes has {n} taps", file.len());
    let is_finite = |x: Option<f32>| x.is_some_and(f32::is_finite);
    let rows = || (0..n).flat_map(|place| (0..f).map(move |phase| (place, phase)));
    assert!(
        rows().all(|(place, phase)| (0..n).all(|tap| is_finite(filter.tap(place, phase, tap))))
    );
    let has_variances = filter.variance(0, 0).is_some();
    assert!(rows().all(|(place, phase)| is_finite(filter.variance(place, phase)) == has_variances));
    for (sample, sample_len) in [(0, n), (n, 2 * n), (usize::MAX, n), (usize::MAX, usize::MAX)] {
        let (start, _) = filter.window(sample, sample_len);
        assert!(start <= sample_len - n);
    }
    let opened = filter.layout().open::<Filter>(file);
    assert!(opened.is_some_and(|opened| opened.counts() == filter.counts()));
}

/// Applies the filter to signals whose shape depends on `number`.
///
/// # Panics
/// If a call is refused for another reason than overflow, if a refused call has written, or if a
/// result is not finite.
pub(crate) fn evaluate_filter(filter: &Filter<'_>, number: usize) {
    let (n, f) = (filter.tap_len(), filter.factor());
    if n * f * n > TAPS {
        return;
    }
    let mut random = Rng(number as u64);
    let size = NUMBER_SIZES[number % NUMBER_SIZES.len()];
    let shape = Samples {
        signal_len: number % 3,
        sample_len: n + number % 5,
        lane_len: [0, 1, 3, 9][number % 4],
    };
    let len = shape.signal_len * shape.sample_len * shape.lane_len;
    let samples: Vec<f32> = (0..len).map(|_| size * random.unit()).collect();
    let mut out = vec![f32::NAN; len * f];
    match filter.apply(shape, &samples, &mut out) {
        Ok(()) => assert!(out.iter().all(|x| x.is_finite())),
        Err(error) => {
            assert!(out.iter().all(|x| x.is_nan()), "{error}: written");
            let of = (error.kind, error.argument);
            assert_eq!(of, (CallErrorKind::NonFinite, Argument::Samples), "{error}");
            assert!(samples[error.index].abs() > MAGNITUDE_MAX);
        }
    }
}
