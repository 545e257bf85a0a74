//! Queries so far out that single precision gives up: a finite result, or an error and nothing written.

use super::{evaluate, jacobian, variance, with};
use crate::common::apart;
use models::KernelContent;
use sinew_runtime::kernel::{Kernel, Normalise, QueryRule};
use sinew_runtime::{Argument, CallErrorKind};

const FAR: [f32; 8] = [1e4, 1e10, 1e19, -1e25, 3e38, f32::MAX, f32::MIN, 1e-40];

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
                    // A rotation as long as that has no square.
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
fn a_sum_that_overflows_is_seen_behind_a_range() {
    // Infinity would be kept at the most of the range.
    let mut content = KernelContent::plain(Kernel::Cubic, [1, 1, 1]);
    content.outputs[0].1.range = (-1.0, 1.0);
    let error = with(&content, |map| evaluate(&map, &[1e30])).unwrap_err();
    assert_eq!((error.kind, error.argument), (CallErrorKind::NonFinite, Argument::Outputs));
    assert_eq!(error.to_string(), "outputs: number 0 is not finite");
}

#[test]
fn outputs_whose_sum_overflows_are_not_brought_to_nothing() {
    let mut content = KernelContent::plain(Kernel::Gaussian, [1, 0, 3]);
    content.terms = vec![[u16::MAX; 2]];
    content.coefficients = [1.0, 3e38, 3e38].map(|value| vec![value]).to_vec();
    content.outputs[1..].iter_mut().for_each(|(_, output)| output.is_marked = true);
    assert!(with(&content, |map| evaluate(&map, &[0.0])).is_ok());
    content.rule.normalise = Normalise::Always;
    let error = with(&content, |map| evaluate(&map, &[0.0])).unwrap_err();
    assert_eq!((error.argument, error.index), (Argument::Outputs, 1));
}
