//! Refused calls, with nothing written, and queries too far out for single precision.

use super::{evaluate, jacobian, variance, with};
use crate::common::{apart, call_error, length_error, short_error};
use models::KernelContent;
use sinew_runtime::kernel::{Kernel, Normalise, QueryRule};
use sinew_runtime::{Argument, CallError, CallErrorKind};

/// Numbers too large or too small for the kernels.
const FAR: [f32; 8] = [1e4, 1e10, 1e19, -1e25, 3e38, f32::MAX, f32::MIN, 1e-40];

#[test]
fn lengths_are_checked() {
    let content = KernelContent::every(Kernel::Gaussian);
    with(&content, |map| {
        let (r, o, m) = (map.query_len(), map.result_len(), 9);
        assert_eq!((r, o), (24, 10));
        let counts = map.counts();
        let query = vec![0.5; r];
        for wrong in [0, r - 1, r + 1] {
            let query = vec![0.5; wrong];
            let expected = length_error(Argument::Query, r, wrong);
            assert_eq!(evaluate(&map, &query).unwrap_err(), expected);
            assert_eq!(jacobian(&map, &query).unwrap_err(), expected);
            assert_eq!(variance(&map, &query).unwrap_err(), expected);
        }
        let mut scratch = vec![0.0; 4096];
        for wrong in [0, o - 1, o + 1] {
            let mut out = vec![7.0; wrong];
            let found = map.evaluate(&query, &mut scratch, &mut out).unwrap_err();
            assert_eq!(found, length_error(Argument::Outputs, o, wrong));
            assert!(out.iter().all(|x| *x == 7.0));
        }
        let mut out = vec![7.0; r * m + 1];
        let found = map.jacobian(&query, &mut scratch, &mut out).unwrap_err();
        assert_eq!(found, length_error(Argument::Jacobian, r * m, r * m + 1));
        let found = map.variance(&query, &mut scratch, &mut out[..m - 1]).unwrap_err();
        assert_eq!(found, length_error(Argument::Variances, m, m - 1));
        let (evaluation, slopes, spread) =
            (counts.scratch_len(), counts.jacobian_scratch_len(), counts.variance_scratch_len());
        let found =
            map.evaluate(&query, &mut scratch[..evaluation - 1], &mut out[..o]).unwrap_err();
        assert_eq!(found, short_error(Argument::Scratch, evaluation, evaluation - 1));
        let found =
            map.jacobian(&query, &mut scratch[..slopes - 1], &mut out[..r * m]).unwrap_err();
        assert_eq!(found, short_error(Argument::Scratch, slopes, slopes - 1));
        let found = map.variance(&query, &mut scratch[..spread - 1], &mut out[..m]).unwrap_err();
        assert_eq!(found, short_error(Argument::Scratch, spread, spread - 1));
        assert!(out.iter().all(|x| *x == 7.0));
    });
}

#[test]
fn queries_are_checked() {
    let content = KernelContent::every(Kernel::Gaussian);
    with(&content, |map| {
        let refused = |query: &[f32]| {
            let found = evaluate(&map, query).unwrap_err();
            assert_eq!(jacobian(&map, query).unwrap_err(), found);
            assert_eq!(variance(&map, query).unwrap_err(), found);
            found
        };
        for number in 0..24 {
            for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
                let mut query = vec![0.5; 24];
                query[number] = x;
                let error = call_error(CallErrorKind::NonFinite, Argument::Query);
                assert_eq!(refused(&query), CallError { index: number, ..error });
            }
        }
        // Inputs 2 to 6 are rotations, with four numbers each, starting at the fifth.
        for input in 2..7 {
            for q in [[0.0; 4], [-0.0; 4], [1e-30; 4], [1e30; 4]] {
                let mut query = vec![0.5; 24];
                query[4 * (input - 1)..][..4].copy_from_slice(&q);
                let error = call_error(CallErrorKind::ZeroRotation, Argument::Query);
                assert_eq!(refused(&query), CallError { index: input, ..error });
            }
        }
        let mut query = vec![0.0; 24];
        query[4..].fill(0.5);
        assert!(evaluate(&map, &query).is_ok());
        query[20..].fill(0.0);
        let phrase = refused(&query).to_string();
        assert_eq!(phrase, "query: the rotation of input 6 has no direction");
        query[3] = f32::NAN;
        assert_eq!(refused(&query).to_string(), "query: number 3 is not finite");
    });
}

#[test]
fn a_kernel_may_have_no_variance() {
    let content = KernelContent { variance: None, ..KernelContent::every(Kernel::Gaussian) };
    let found = with(&content, |map| {
        assert!(!map.has_variance());
        variance(&map, &[0.5; 24]).unwrap_err()
    });
    assert_eq!(found, call_error(CallErrorKind::NoAttribute, Argument::Variances));
    assert_eq!(found.to_string(), "variances: the part has none");
}

#[test]
fn far_queries_give_finite_numbers_or_an_error() {
    let (mut refused, mut given) = (0, 0);
    for kernel in Kernel::ALL.into_iter().step_by(apart(7)) {
        for query_rule in QueryRule::ALL.into_iter().step_by(apart(2)) {
            let mut content = KernelContent::every(kernel);
            content.rule.query = query_rule;
            with(&content, |map| {
                let each = (0..24).flat_map(|i| FAR.map(|x| (i, x)));
                for (i, x) in each.step_by(apart(29)) {
                    let mut query = vec![0.5; 24];
                    query[i] = x;
                    // The square of so long a rotation overflows.
                    let evaluated = evaluate(&map, &query).map(|(out, w)| [out, vec![w]].concat());
                    let slopes = jacobian(&map, &query);
                    for (argument, found) in [
                        (Argument::Outputs, evaluated),
                        (Argument::Jacobian, slopes),
                        (Argument::Variances, variance(&map, &query)),
                    ] {
                        match found {
                            Ok(out) => {
                                assert!(out.iter().all(|x| x.is_finite()), "{kernel:?} {i} {x}");
                                given += 1;
                            }
                            Err(error) if error.kind == CallErrorKind::ZeroRotation => {
                                assert_eq!((error.argument, i >= 4), (Argument::Query, true));
                            }
                            Err(error) => {
                                let kind = CallErrorKind::NonFinite;
                                assert_eq!((error.kind, error.argument), (kind, argument));
                                refused += 1;
                            }
                        }
                    }
                }
            });
        }
    }
    assert!(cfg!(miri) || refused > 100 && given > 1000, "{refused} {given}");
}

#[test]
fn an_overflowing_sum_is_found_despite_a_range() {
    // The range would clamp an infinite value.
    let mut content = KernelContent::plain(Kernel::Cubic, [1, 1, 1]);
    content.outputs[0].1.range = (-1.0, 1.0);
    let error = with(&content, |map| evaluate(&map, &[1e30])).unwrap_err();
    assert_eq!((error.kind, error.argument), (CallErrorKind::NonFinite, Argument::Outputs));
    assert_eq!(error.to_string(), "outputs: number 0 is not finite");
}

#[test]
fn outputs_with_an_overflowing_sum_are_not_zeroed() {
    let mut content = KernelContent::plain(Kernel::Gaussian, [1, 0, 3]);
    content.terms = vec![[u16::MAX; 2]];
    content.coefficients = [1.0, 3e38, 3e38].map(|value| vec![value]).to_vec();
    content.outputs[1..].iter_mut().for_each(|(_, output)| output.is_marked = true);
    assert!(with(&content, |map| evaluate(&map, &[0.0])).is_ok());
    content.rule.normalise = Normalise::Always;
    let error = with(&content, |map| evaluate(&map, &[0.0])).unwrap_err();
    assert_eq!((error.argument, error.index), (Argument::Outputs, 1));
}
