//! Shapes compared with their f64 oracle, and controls that catch wrong shapes.

use crate::stages::altered::{Step, altered, idle};
use conformance::backend::{Backend, part};
use conformance::compare::Mismatch;
use conformance::cpu::Cpu;
use conformance::finding::{Finding, sound};
use conformance::shapes::{FACES, ShapeSubject, shapes};
use conformance::stages::shapes::body;
use conformance::tolerance::{self, Arithmetic};
use models::{Pieces, SMALL, Shape, ShapeContent};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::Element;
use std::cell::Cell;

const IEEE: Arithmetic = Arithmetic::IEEE;
const VERTICES: usize = 130;

#[test]
fn shapes_of_every_skin() {
    let mut most = [0.0f64; 3];
    for subject in shapes(FACES) {
        let findings = body(&Cpu, &subject).unwrap();
        assert_eq!(sound(&findings), Ok(()), "{}", subject.described());
        let ratios: Vec<_> = findings.iter().map(|Finding { worst, .. }| *worst).collect();
        println!("{}: {ratios:.3?}", subject.described());
        most.iter_mut().zip(ratios).for_each(|(most, ratio)| *most = most.max(ratio));
    }
    assert!(most.iter().all(|most| *most > 0.05), "a bound without use: {most:?}");
}

/// Returns a file of a skin with tangents and with shapes in whole numbers, edited.
fn file(edit: impl Fn(&mut ShapeContent)) -> Vec<u8> {
    let shape = Shape { vertices: VERTICES, tangents: true, ..SMALL };
    let mut content = ShapeContent::sample(Element::I8, 7, VERTICES);
    edit(&mut content);
    let mut pieces = Pieces::sample(Predictor::Rotational, shape);
    pieces.set_shapes(&content);
    pieces.bytes()
}

/// Compares a backend with one error of `factor` tolerances, in a float of an attribute.
fn off_by(subject: &ShapeSubject<'_>, attribute: usize, factor: f64) -> Result<(), Mismatch> {
    let seen = Cell::new(0);
    let spoil = |step: Step<'_>| {
        let Step::Shapes { batch, out } = step else { return };
        // Only in the whole mesh, not in the range.
        if batch.vertices.len() != VERTICES {
            return;
        }
        let own =
            [batch.positions, batch.normals, batch.tangents][attribute].expect("the skin has it");
        for face in 0..batch.instance_len {
            let weights = part(&subject.weights, subject.face_len, face);
            let right = tolerance::shapes(subject, 9, weights, IEEE);
            let (value, error) = &right[attribute];
            if error[1] > 0.0 {
                seen.set(seen.get() + 1);
                if seen.get() == 10 {
                    let place = own.offset + face * own.instance_stride + 9 * own.stride + 1;
                    out[place] = (value[1] + factor * error[1]) as f32;
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
    let subject = ShapeSubject::new(&bytes, FACES);
    for attribute in 0..3 {
        let caught = off_by(&subject, attribute, 2.0);
        assert!(matches!(caught, Err(Mismatch::Beyond { .. })), "{attribute}: {caught:?}");
        assert_eq!(off_by(&subject, attribute, 0.5), Ok(()));
    }
    assert!(sound(&body(&idle(), &subject).unwrap()).is_err(), "an output left alone");
}

/// Whether a backend that uses another file passes the comparison.
fn passes_with(other: &[u8]) -> bool {
    let bytes = file(|_| {});
    let subject = ShapeSubject::new(&bytes, 12);
    let other = ShapeSubject { weights: subject.weights.clone(), ..ShapeSubject::new(other, 12) };
    let wrong = altered(
        |step: Step<'_>| {
            let Step::Shapes { batch, out } = step else { return };
            Cpu.shapes(&other, batch, out).expect("it is no larger");
        },
        IEEE,
    );
    sound(&body(&wrong, &subject).expect("the backend gives something")).is_ok()
}

#[test]
fn another_step_mask_number_or_slope_is_caught() {
    assert!(passes_with(&file(|_| {})));
    assert!(!passes_with(&file(|own| own.steps[2][0] *= 1.001)), "a step");
    assert!(!passes_with(&file(|own| own.steps[2][1] *= 1.001)), "a slope's");
    assert!(!passes_with(&file(|own| own.moved[3][90] = None)), "a bit of a mask");
    assert!(!passes_with(&file(|own| own.moved[0][64].as_mut().unwrap()[2] += 1.0)), "a number");
    assert!(!passes_with(&file(|own| own.moved[0][129].as_mut().unwrap()[4] += 1.0)), "a slope");
    assert!(!passes_with(&file(|own| own.moved[0].swap(63, 64))), "another block's");
}
