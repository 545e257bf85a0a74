//! Priors of an accepted file, solved for pins and held to what the runtime promises.

use models::Rng;
use sinew_runtime::prior::{Anchor, Temporal};
use sinew_runtime::{Argument, CallErrorKind, Matrix3x4, Pin, PinJob, Pins, Prior, Skin};

/// Sizes of pins' targets, from what the data holds to what overflows.
const SIZES: [f32; 6] = [0.5, 1.0, 0.0, 1e-20, 1e6, 3e38];

/// Shapes that are worth a solve's time.
const SHAPES: usize = 64;

/// Reads all that a prior's accessors give.
///
/// # Panics
/// Where one lacks what a loaded prior must have, or where it asks for more than a file of its length may.
pub(crate) fn read_prior(prior: &Prior<'_>, file: &[u8]) {
    let (n, counts) = (prior.shape_len(), prior.counts());
    let cost = counts.pin_scratch_len(0);
    assert!(cost <= 7 + file.len(), "a file of {} bytes costs {cost}", file.len());
    assert!((0..n).all(|s| prior.mean(s).is_some() && prior.weight_bounds(s).is_some()));
    assert!((0..n).all(|s| prior.factor_entry(s, s).is_some_and(|x| x > 0.0)));
    assert!(prior.symmetry().all(|([a, b], _)| a < n && b < n && a != b));
    assert!(prior.cancel_pairs().all(|[a, b]| a < n && b < n && a != b));
    let opened = prior.layout().open(file);
    assert!(opened.is_some_and(|opened| opened.counts() == counts));
}

/// Solves for pins by a number.
///
/// # Panics
/// Where a call is refused but for what is beyond measure, where a refused call has written, or where a result is not
/// finite or outside the bounds.
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
    let size = SIZES[number % SIZES.len()];
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
        is_bounded: number % 3 != 0,
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
