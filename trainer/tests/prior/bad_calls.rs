//! Refused calls, which write nothing.

use super::common::*;
use sinew_runtime::prior::{Pin, PinJob, Pins, Temporal};
use sinew_runtime::{Argument, CallErrorKind as Kind, Model, Prior, Skin};

type Set = fn(&mut PinJob<'_>);

#[test]
fn arguments_are_refused_by_name() {
    let face = Face::new(5, 1);
    let pins = [Pin::new(2, [0.1; 3])];
    let cases: [(Set, Kind, Argument); 8] = [
        (|job| job.palette = &[[[0.0; 4]; 3]], Kind::Length, Argument::Palette),
        (|job| job.beta = 0.0, Kind::OutOfRange, Argument::Prior),
        (|job| job.beta = f32::NAN, Kind::OutOfRange, Argument::Prior),
        (|job| job.symmetry = -1.0, Kind::OutOfRange, Argument::Prior),
        (|job| job.symmetry = f32::INFINITY, Kind::OutOfRange, Argument::Prior),
        (
            |job| job.temporal = Some(Temporal { weights: &[0.0; 4], stiffness: 1.0 }),
            Kind::Length,
            Argument::Weights,
        ),
        (
            |job| job.temporal = Some(Temporal { weights: &[f32::NAN; 5], stiffness: 1.0 }),
            Kind::NonFinite,
            Argument::Weights,
        ),
        (
            |job| job.temporal = Some(Temporal { weights: &[0.0; 5], stiffness: -1.0 }),
            Kind::OutOfRange,
            Argument::Prior,
        ),
    ];
    for (set, kind, argument) in cases {
        let error = face.solve(&pins, &[0.5; 5], set).unwrap_err();
        assert_eq!((error.kind, error.argument), (kind, argument), "{error}");
    }
    let error = face.solve(&pins, &[0.5; 4], |_| ()).unwrap_err();
    assert_eq!((error.kind, error.argument), (Kind::Length, Argument::Weights));
    let error = face.solve(&pins, &[0.5, 0.5, f64::NAN, 0.5, 0.5], |_| ()).unwrap_err();
    assert_eq!((error.kind, error.argument, error.index), (Kind::NonFinite, Argument::Weights, 2));
    let beyond = [Pin::new(2, [0.0; 3]), Pin::new(VERTICES as u32, [0.0; 3])];
    let error = face.solve(&beyond, &[0.5; 5], |_| ()).unwrap_err();
    assert_eq!((error.kind, error.argument, error.index), (Kind::OutOfRange, Argument::Pins, 1));
    let short = &mut face.scratch(1)[1..];
    let error = face.solve_in(short, &pins, &[0.5; 5], |_| ()).unwrap_err();
    assert_eq!((error.kind, error.argument), (Kind::TooShort, Argument::Scratch));
    assert_eq!(error.expected, error.found + 1);
}

#[test]
fn a_target_that_is_no_number_and_too_many_pins_are_refused_by_the_list() {
    let face = Face::new(5, 1);
    let error = face.solve(&[Pin::new(1, [0.0, f32::NAN, 0.0])], &[0.5; 5], |_| ()).unwrap_err();
    assert_eq!((error.kind, error.argument, error.index), (Kind::NonFinite, Argument::Pins, 1));
    let error = face.solve(&[Pin::new(1, [0.0; 3]); 33], &[0.5; 5], |_| ()).unwrap_err();
    assert_eq!((error.kind, error.argument), (Kind::OutOfRange, Argument::Pins));
    assert_eq!((error.expected, error.found), (32, 33));
}

#[test]
fn pins_beyond_all_measure_are_refused_and_nothing_is_written() {
    let face = Face::new(5, 1);
    let model = Model::from_bytes(&face.file).unwrap();
    let (prior, skin) = (model.first::<Prior>().unwrap(), model.first::<Skin>().unwrap());
    for (target, beta) in [(f32::MAX, 1e-3), (0.1, f32::from_bits(1))] {
        let mut pins = Pins::<2>::new();
        pins.add(Pin::new(2, [target; 3]).with_stiffness(f32::MAX)).unwrap();
        let mut job = PinJob::new(prior, skin, pins.list());
        (job.beta, job.is_bounded) = (beta, false);
        let mut weights = [0.25; 5];
        let mut scratch = face.scratch(2);
        let error = job.run(&mut scratch, &mut weights).unwrap_err();
        assert_eq!(error.kind, Kind::NonFinite, "{error}");
        assert_eq!(weights, [0.25; 5]);
    }
}

#[test]
fn a_skin_of_other_shapes_is_refused() {
    let (face, other) = (Face::new(5, 1), Face::new(6, 1));
    let (a, b) = (Model::from_bytes(&face.file).unwrap(), Model::from_bytes(&other.file).unwrap());
    let pins = Pins::<1>::new();
    let job = PinJob::new(a.first::<Prior>().unwrap(), b.first::<Skin>().unwrap(), pins.list());
    let error = job.run(&mut [], &mut [0.0; 6]).unwrap_err();
    assert_eq!((error.kind, error.argument), (Kind::Length, Argument::Prior));
    assert_eq!((error.expected, error.found), (6, 5));
}
