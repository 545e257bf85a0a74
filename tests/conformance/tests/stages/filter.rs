//! Filters compared with their f64 oracle, and controls that catch a wrong filter.

use crate::stages::altered::{Step, altered, idle};
use conformance::backend::Backend;
use conformance::compare::Mismatch;
use conformance::cpu::Cpu;
use conformance::filters::{FilterSubject, SIGNALS, filters};
use conformance::finding::sound;
use conformance::stages::filter::body;
use conformance::tolerance::{self, Arithmetic};
use models::{FilterContent, Pieces};

const IEEE: Arithmetic = Arithmetic::IEEE;

#[test]
fn filters_of_every_shape() {
    let mut most = 0.0f64;
    for subject in filters(SIGNALS) {
        let findings = body(&Cpu, &subject).unwrap();
        assert_eq!(sound(&findings), Ok(()), "{}", subject.described());
        println!("{}: {:.3}", subject.described(), findings[0].worst);
        most = most.max(findings[0].worst);
    }
    assert!(most > 0.05, "a bound without use: {most}");
}

/// Compares a backend with one error of `factor` tolerances.
fn off_by(subject: &FilterSubject<'_>, factor: f64) -> Result<(), Mismatch> {
    let spoil = |step: Step<'_>| {
        let Step::Filter { out } = step else { return };
        let (value, error) = tolerance::filter(subject, 7);
        out[7] = (value + factor * error) as f32;
    };
    sound(&body(&altered(spoil, IEEE), subject).expect("the backend gives something"))
}

#[test]
fn one_number_off_by_two_tolerances_is_caught() {
    let bytes = Pieces::filter(&FilterContent::sample(2, 9)).bytes();
    let subject = FilterSubject::new(&bytes, 2, 3);
    assert!(matches!(off_by(&subject, 2.0), Err(Mismatch::Beyond { .. })));
    assert_eq!(off_by(&subject, 0.5), Ok(()));
    assert!(sound(&body(&idle(), &subject).unwrap()).is_err(), "an output left alone");
}

/// Whether a backend that uses another filter passes the comparison.
fn passes_with(edit: impl FnOnce(&mut FilterContent)) -> bool {
    let content = FilterContent::sample(2, 9);
    let mut other = content.clone();
    edit(&mut other);
    let [bytes, other] = [content, other].map(|content| Pieces::filter(&content).bytes());
    let subject = FilterSubject::new(&bytes, 2, 3);
    let mut other = FilterSubject::new(&other, 2, 3);
    other.samples.clone_from(&subject.samples);
    let wrong = altered(
        |step: Step<'_>| {
            let Step::Filter { out } = step else { return };
            Cpu.filter(&other, out).expect("it is as large");
        },
        IEEE,
    );
    sound(&body(&wrong, &subject).expect("the backend gives something")).is_ok()
}

#[test]
fn another_tap_phase_or_border_is_caught() {
    assert!(passes_with(|_| {}));
    assert!(!passes_with(|own| own.taps[40] += 1e-3), "a tap");
    assert!(!passes_with(|own| own.taps.rotate_left(9)), "a phase");
    assert!(!passes_with(|own| own.taps.swap(0, 1)), "at the start");
    assert!(!passes_with(|own| own.taps.swap(160, 161)), "at the end");
}
