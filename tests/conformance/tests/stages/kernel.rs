//! Kernels compared with their f64 oracle, and controls that catch a wrong kernel.

use crate::stages::altered::{Step, altered, idle};
use conformance::backend::{Backend, part};
use conformance::compare::Mismatch;
use conformance::cpu::Cpu;
use conformance::finding::{Finding, sound};
use conformance::kernels::{KernelSubject, QUERIES, kernels};
use conformance::stages::kernel::body;
use conformance::tolerance::{self, Arithmetic};
use models::{KernelContent, Pieces};
use sinew_runtime::kernel::Kernel;
use sinew_runtime::{KernelMap, Model};
use std::cell::Cell;

const IEEE: Arithmetic = Arithmetic::IEEE;

#[test]
fn kernel() {
    let mut most = [0.0f64; 2];
    for subject in kernels(QUERIES) {
        let findings = body(&Cpu, &subject).unwrap();
        assert_eq!(sound(&findings), Ok(()), "{}", subject.described());
        let ratios: Vec<_> = findings.iter().map(|Finding { worst, .. }| *worst).collect();
        println!("{}: {ratios:.3?}", subject.described());
        most.iter_mut().zip(ratios).for_each(|(most, ratio)| *most = most.max(ratio));
    }
    assert!(most.iter().all(|most| *most > 0.1), "a bound without use: {most:?}");
}

/// Returns a file of a kernel with every kind of input and output, edited.
fn file(edit: impl Fn(&mut KernelContent)) -> Vec<u8> {
    let mut content = KernelContent::every(Kernel::Matern52);
    edit(&mut content);
    Pieces::kernels(&[content]).bytes()
}

/// Compares a backend with one error of `factor` tolerances, in an output or in a confidence.
fn off_by(subject: &KernelSubject<'_>, of_confidence: bool, factor: f64) -> Result<(), Mismatch> {
    let seen = Cell::new(0);
    let spoil = |step: Step<'_>| {
        let Step::Kernel { queries, out, confidences } = step else { return };
        let n = confidences.len();
        for i in 0..n {
            let query = part(queries, n, i);
            let (right, confidence) = tolerance::kernel(&subject.oracle, query, IEEE);
            let len = right.value.len();
            let (found, right) = if of_confidence {
                (&mut confidences[i], confidence)
            } else {
                (&mut out[i * len], right)
            };
            if right.error[0] > 0.0 {
                seen.set(seen.get() + 1);
                if seen.get() == 10 {
                    *found = (right.value[0] + factor * right.error[0]) as f32;
                }
            }
        }
    };
    let findings = body(&altered(spoil, IEEE), subject).expect("the backend gives something");
    assert!(seen.get() >= 10, "it was reached");
    sound(&findings)
}

#[test]
fn one_value_off_by_two_tolerances_is_caught() {
    let bytes = file(|_| {});
    let subject = KernelSubject::new(&bytes, QUERIES);
    for of_confidence in [false, true] {
        let caught = off_by(&subject, of_confidence, 2.0);
        assert!(matches!(caught, Err(Mismatch::Beyond { .. })), "{caught:?}");
        assert_eq!(off_by(&subject, of_confidence, 0.5), Ok(()));
    }
    assert!(sound(&body(&idle(), &subject).unwrap()).is_err(), "an output left alone");
}

/// Whether a backend that uses another file passes the comparison, and how many values differ.
fn passes_with(other: &[u8]) -> (bool, usize) {
    let bytes = file(|_| {});
    let subject = KernelSubject::new(&bytes, QUERIES);
    let model = Model::from_bytes(other).expect("a kernel loads");
    let kernel = model.first::<KernelMap>().expect("it holds a kernel");
    let wrong = altered(
        |step: Step<'_>| {
            let Step::Kernel { queries, out, confidences } = step else { return };
            let other = KernelSubject { kernel, ..KernelSubject::new(&bytes, 1) };
            Cpu.kernel(&other, queries, out, confidences).expect("it is no larger");
        },
        IEEE,
    );
    let findings = body(&wrong, &subject).expect("the backend gives something");
    (sound(&findings).is_ok(), findings.iter().map(|finding| finding.differing).sum())
}

#[test]
fn another_kernel_or_coefficient_is_caught_and_another_order_counted() {
    assert_eq!(passes_with(&file(|_| {})), (true, 0));
    let (number, _) = passes_with(&file(|own| own.rule.kernel = Kernel::Matern32));
    let (coefficient, _) = passes_with(&file(|own| own.coefficients[4][3] *= 1.001));
    let (centre, _) = passes_with(&file(|own| own.centres[2][1] += 1e-3));
    let (term, _) = passes_with(&file(|own| own.terms[26] = [3, 3]));
    let (rule, _) = passes_with(&file(|own| own.rule.fade.1 *= 1.001));
    assert_eq!([number, coefficient, centre, term, rule], [false; 5]);
    // Reversed centres: equal sums in another order.
    let (is_sound, differing) = passes_with(&file(|own| {
        own.centres.reverse();
        let n = own.centres.len();
        own.coefficients.iter_mut().for_each(|row| row[..n].reverse());
    }));
    assert!(is_sound && differing > 100, "{differing}");
}
