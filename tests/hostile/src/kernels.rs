//! Kernels of an accepted file, evaluated and held to what the runtime promises.

use models::Rng;
use sinew_runtime::{Argument, CallError, CallErrorKind, KernelMap};

/// Sizes of a query's numbers, from what the data holds to what overflows.
const SIZES: [f32; 8] = [0.5, 1.0, 0.0, 1e-20, 10.0, 1e6, 1e18, 3e38];

/// Derivatives that are worth their time.
const DERIVATIVES: usize = 1 << 14;

/// Reads all that a kernel's accessors give.
///
/// # Panics
/// Where one lacks what a loaded kernel must have, or where it asks for more than a file of its length may.
pub(crate) fn read_kernel(map: &KernelMap<'_>, file: &[u8]) {
    let counts = map.counts();
    for cost in [counts.scratch_len(), map.query_len(), map.result_len()] {
        assert!(cost <= file.len(), "a file of {} bytes costs {cost}", file.len());
    }
    // Rows of a variance of neither centres nor terms take no bytes: the format holds them.
    assert!(counts.variance_scratch_len() <= file.len() + 65_536);
    assert_eq!(map.inputs().count(), counts.input_len as usize);
    assert_eq!(map.outputs().count(), counts.output_len as usize);
    assert!((0..counts.input_len as usize).all(|input| map.input_name(input).is_some()));
    assert!((0..counts.output_len as usize).all(|output| map.output_name(output).is_some()));
    let (features, values) = (counts.feature_len as usize, counts.value_len as usize);
    assert_eq!(map.inputs().map(|input| input.kind.feature_len()).sum::<usize>(), features);
    assert_eq!(map.outputs().map(|output| output.kind.value_len()).sum::<usize>(), values);
    let opened = map.layout().open(file);
    assert!(opened.is_some_and(|opened| opened.counts() == counts));
}

/// Makes a query by its number.
pub(crate) fn query(map: &KernelMap<'_>, number: usize) -> Vec<f32> {
    let mut random = Rng(number as u64);
    let size = SIZES[number % SIZES.len()];
    // The odd numbers are as they are in the data: one number far out among near ones is the likelier call.
    (0..map.query_len()).map(|at| random.unit() * if at % 3 == 1 { 0.7 } else { size }).collect()
}

/// Evaluates a query by its number, its derivatives and its variance.
///
/// # Panics
/// Where a call is refused but for a rotation without a direction or a result beyond single precision, where a
/// refused call has written, or where a result is not finite.
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
