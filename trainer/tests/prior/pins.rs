//! Pins of the runtime against dense f64, with and without bounds.

use super::common::*;
use faer::Mat;
use sinew_runtime::prior::{Anchor, Pin};
use sinew_runtime::{Model, Skin};

/// Tolerance for weights in single precision.
const CLOSE: f64 = 1e-4;

#[test]
fn weights_are_those_of_the_dual_form() {
    let face = Face::new(20, 1);
    let pins = sorted(three());
    let (b, rest) = face.rows(&pins);
    let now = weights(20, 9);
    for (anchor, beta) in ANCHORS.into_iter().flat_map(|a| [1e-4, 1e-2, 1.0].map(|b| (a, b))) {
        let beta32 = beta as f32;
        let (found, edit) =
            face.solve(&pins, &now, |job| (job.anchor, job.beta) = (anchor, beta32)).unwrap();
        let missing: Vec<f64> = targets(&pins).iter().zip(&rest).map(|(t, r)| t - r).collect();
        let from = if anchor == Anchor::Current { &now } else { &face.prior.mean };
        let noise = noise(&pins, f64::from(beta32));
        let expected = dual(&face.prior.covariance, &b, &noise, &missing, from);
        assert!(
            apart(&found, &expected) < CLOSE,
            "{anchor:?} {beta}: {}",
            apart(&found, &expected)
        );
        // The norm of the edit, by Eq. 5.
        let step: Vec<f64> = expected.iter().zip(from).map(|(w, a)| w - a).collect();
        let whitened = solved(&face.prior.covariance, &step);
        let norm = step.iter().zip(&whitened).map(|(a, b)| a * b).sum::<f64>().sqrt();
        assert!((f64::from(edit.norm) / norm - 1.0).abs() < CLOSE);
        assert_eq!((edit.unreachable_len, edit.round_len, edit.is_least), (0, 1, true));
        // Control: another stiffness gives other weights.
        let others = dual(&face.prior.covariance, &b, &[0.5; 7], &missing, from);
        assert!(apart(&found, &others) > 1e-2);
    }
}

#[test]
fn bounded_weights_are_the_least_of_every_way_to_hold_them() {
    let mut held = 0;
    for seed in 0..12 {
        let face = Face::new(6, seed);
        let pins: Vec<Pin> =
            (0..3).map(|i| Pin::new(5 + 35 * i, [1.5 - i as f32, 0.5 * i as f32, -1.0])).collect();
        let now = weights(6, seed + 50);
        for anchor in ANCHORS {
            let (found, edit) = face
                .solve(&pins, &now, |job| (job.anchor, job.is_bounded) = (anchor, true))
                .unwrap();
            assert!(edit.is_least);
            assert!(found.iter().all(|w| (0.0..=1.0).contains(w)), "{found:?}");
            let from = if anchor == Anchor::Current { &now } else { &face.prior.mean };
            let expected = least_in_box(&face, &pins, from);
            assert!(apart(&found, &expected) < CLOSE, "{seed}: {found:?} {expected:?}");
            held += found.iter().filter(|w| **w == 0.0 || **w == 1.0).count();
        }
    }
    assert!(held > 30, "pins pull at the bounds: {held}");
}

/// Solves for every choice of weights held at 0 or 1; returns the minimum in the box.
fn least_in_box(face: &Face, pins: &[Pin], anchor: &[f64]) -> Vec<f64> {
    let (b, rest) = face.rows(pins);
    let strength = 1.0 / f64::from(face.prior.fit.beta);
    let n = face.shape_len();
    let precision = inverse(&face.prior.covariance);
    let hessian = &precision + b.transpose() * &b * faer::Scale(strength);
    let missing: Vec<f64> = targets(pins).iter().zip(&rest).map(|(t, r)| t - r).collect();
    let right: Vec<f64> = (0..n)
        .map(|i| {
            let pulled: f64 = (0..b.nrows()).map(|r| strength * b[(r, i)] * missing[r]).sum();
            pulled + (0..n).map(|j| precision[(i, j)] * anchor[j]).sum::<f64>()
        })
        .collect();
    let cost = |w: &[f64]| -> f64 {
        let of = |i: usize| -> f64 { (0..n).map(|j| hessian[(i, j)] * w[j]).sum() };
        (0..n).map(|i| w[i] * (0.5 * of(i) - right[i])).sum()
    };
    let mut best = (f64::INFINITY, Vec::new());
    for code in 0..3usize.pow(n as u32) {
        let way = |i: usize| code / 3usize.pow(i as u32) % 3;
        let mut w: Vec<f64> = (0..n).map(|i| [0.0, 0.0, 1.0][way(i)]).collect();
        let free: Vec<usize> = (0..n).filter(|i| way(*i) == 0).collect();
        if !free.is_empty() {
            let own = Mat::from_fn(free.len(), free.len(), |i, j| hessian[(free[i], free[j])]);
            let pulled: Vec<f64> = free
                .iter()
                .map(|&i| right[i] - (0..n).map(|j| hessian[(i, j)] * w[j]).sum::<f64>())
                .collect();
            free.iter().zip(solved(&own, &pulled)).for_each(|(i, x)| w[*i] = x);
        }
        if w.iter().all(|w| (-1e-12..=1.0 + 1e-12).contains(w)) && cost(&w) < best.0 {
            best = (cost(&w), w);
        }
    }
    best.1
}

#[test]
fn without_a_pin_weights_stay_as_they_are() {
    let face = Face::new(8, 3);
    // Includes weights outside the bounds.
    let now: Vec<f64> = (0..8).map(|i| f64::from(i as f32 * 0.3 - 0.7)).collect();
    for anchor in ANCHORS {
        // No shape moves the last vertex; the second pin constrains only one of its coordinates.
        let last = VERTICES as u32 - 1;
        let fixed =
            [Pin::new(last, [9.0; 3]), Pin::new(last, [1.0; 3]).masked([false, true, false])];
        for (pins, unreachable) in [(&fixed[..0], 0), (&fixed[..], 2)] {
            let (found, edit) = face
                .solve(pins, &now, |job| (job.anchor, job.is_bounded) = (anchor, true))
                .unwrap();
            assert_eq!(found, now);
            assert_eq!((edit.unreachable_len, edit.norm, edit.round_len), (unreachable, 0.0, 0));
        }
        // Among other pins, the fixed pin changes nothing.
        let pins = three();
        let (alone, _) = face.solve(&pins, &now, |job| job.anchor = anchor).unwrap();
        let with: Vec<Pin> = pins.into_iter().chain(fixed).collect();
        let (found, edit) = face.solve(&with, &now, |job| job.anchor = anchor).unwrap();
        assert_eq!((found, edit.unreachable_len), (alone, 2));
    }
}

#[test]
fn pins_on_one_vertex_count_as_their_mean_by_stiffness() {
    let face = Face::new(10, 4);
    let now = weights(10, 1);
    let (a, b) = ([0.4, 0.0, 0.2], [0.1, -0.6, 0.3]);
    let both = [Pin::new(20, a).with_stiffness(3.0), Pin::new(20, b)];
    let mean = [0, 1, 2].map(|i: usize| (3.0 * a[i] + b[i]) / 4.0);
    let one = [Pin::new(20, mean).with_stiffness(4.0)];
    let (found, _) = face.solve(&both, &now, |_| ()).unwrap();
    let (expected, _) = face.solve(&one, &now, |_| ()).unwrap();
    assert!(apart(&found, &expected) < 1e-6);
    let (plain, _) = face.solve(&[Pin::new(20, a)], &now, |_| ()).unwrap();
    assert!(apart(&plain, &expected) > 1e-3);
}

#[test]
fn conflicting_pins_end_where_least_squares_do() {
    // One shape moves all pinned vertices, whose targets differ: the solution is their mean.
    let mut skin = skin(1, &mut Numbers::new(7));
    skin.rest_positions = vec![[0.0; 3]; VERTICES];
    skin.shapes.deltas[0] = vec![[1.0, 0.0, 0.0]; VERTICES];
    let mut prior = Face::new(1, 7).prior;
    prior.covariance[(0, 0)] = 1e6;
    let face = Face::of(skin, prior);
    let pins = [(3, 0.9), (4, 0.1), (5, -0.1)].map(|(v, x)| Pin::new(v, [x, 5.0, 0.0]));
    let (found, _) = face.solve(&pins, &[0.0], |job| job.beta = 1e-6).unwrap();
    assert!((found[0] - 0.3).abs() < 1e-6, "{found:?}");
}

#[test]
fn the_order_of_pins_changes_no_bit() {
    let face = Face::new(30, 5);
    let now = weights(30, 2);
    let mut pins: Vec<Pin> =
        (0..8).map(|i| Pin::new(11 * i, [0.1 * i as f32, 0.3, -0.2])).collect();
    pins.push(Pin::new(22, [0.5, 0.5, 0.1]).with_stiffness(0.3));
    pins.push(Pin::new(22, [0.2, 0.5, 0.1]));
    let (first, _) = face.solve(&pins, &now, |job| job.is_bounded = true).unwrap();
    for by in [3, 7, 9] {
        pins.rotate_left(by);
        pins.swap(0, 5);
        let (found, _) = face.solve(&pins, &now, |job| job.is_bounded = true).unwrap();
        assert_eq!(found, first);
    }
}

#[test]
fn a_drag_is_a_solve_anew_to_the_last_bit() {
    let face = Face::new(25, 6);
    let now = weights(25, 3);
    let mut scratch = face.scratch(4);
    for is_bounded in [false, true] {
        let mut rounds = [0; 2];
        for step in 0..12 {
            let by = step as f32 * 0.05;
            let mut pins = three();
            pins.push(Pin::new(100, [by, -0.5 * by, 0.3]));
            let set = |job: &mut sinew_runtime::PinJob<'_>| job.is_bounded = is_bounded;
            let (found, drag) = face.solve_in(&mut scratch, &pins, &now, set).unwrap();
            let (expected, anew) = face.solve(&pins, &now, set).unwrap();
            assert!(drag.is_least && anew.is_least, "{drag:?} {anew:?}");
            assert_eq!(found, expected, "{step}");
            assert_eq!(drag.norm, anew.norm);
            rounds = [rounds[0] + drag.round_len, rounds[1] + anew.round_len];
        }
        assert!(!is_bounded || rounds[0] < rounds[1], "held weights are remembered: {rounds:?}");
    }
    // Factors that were kept for other pins, terms and priors are not reused.
    let other = Face::new(25, 60);
    let pins = three();
    for (name, set) in CHANGES {
        let (found, _) = face.solve_in(&mut scratch, &pins, &now, set).unwrap();
        assert_eq!(found, face.solve(&pins, &now, set).unwrap().0, "{name}");
    }
    let (found, _) = other.solve_in(&mut scratch, &pins, &now, |_| ()).unwrap();
    assert_eq!(found, other.solve(&pins, &now, |_| ()).unwrap().0);
    let stiff: Vec<Pin> = pins.iter().map(|pin| pin.with_stiffness(7.0)).collect();
    let (found, _) = other.solve_in(&mut scratch, &stiff, &now, |_| ()).unwrap();
    assert_eq!(found, other.solve(&stiff, &now, |_| ()).unwrap().0);
}

type Change = fn(&mut sinew_runtime::PinJob<'_>);

const CHANGES: [(&str, Change); 5] = [
    ("nothing", |_| ()),
    ("beta", |job| job.beta = 0.3),
    ("symmetry", |job| job.symmetry = 2.0),
    ("bounds", |job| job.is_bounded = true),
    ("cancelling", |job| job.cancels = true),
];

#[test]
fn a_sticky_pin_moves_nothing() {
    let face = Face::new(15, 8);
    let now = weights(15, 4);
    let model = Model::from_bytes(&face.file).unwrap();
    let skin = model.first::<Skin>().unwrap();
    let narrow: Vec<f32> = now.iter().map(|w| *w as f32).collect();
    let pins: Vec<Pin> =
        [4u32, 50, 90].map(|v| Pin::new(v, skin.place(v, &[], &narrow).unwrap())).to_vec();
    let (found, edit) = face.solve(&pins, &now, |job| job.is_bounded = true).unwrap();
    assert!(apart(&found, &now) < 1e-6 && edit.norm < 1e-4, "{}", edit.norm);
    assert_eq!(skin.place(VERTICES as u32, &[], &narrow), None);
}

#[test]
fn stiff_pins_are_met_and_soft_ones_ignored() {
    let face = Face::new(20, 9);
    let now = weights(20, 5);
    // Three scalars, which 20 shapes can satisfy.
    let pins = [Pin::new(30, [0.3, 0.2, -0.4])];
    let (b, rest) = face.rows(&pins);
    let miss = |w: &[f64]| {
        (0..3)
            .map(|i| {
                let own: f64 = (0..20).map(|j| b[(i, j)] * w[j]).sum();
                (own + rest[i] - f64::from(pins[0].target[i])).powi(2)
            })
            .sum::<f64>()
            .sqrt()
    };
    let (stiff, most) = face.solve(&pins, &now, |job| job.beta = 1e-12).unwrap();
    assert!(miss(&stiff) < 1e-6, "{}", miss(&stiff));
    let (soft, least) = face.solve(&pins, &now, |job| job.beta = 1e12).unwrap();
    assert!(apart(&soft, &now) < 1e-7 && least.norm < 1e-4 * most.norm);
    let (mean, _) =
        face.solve(&pins, &now, |job| (job.beta, job.anchor) = (1e12, Anchor::Mean)).unwrap();
    assert!(apart(&mean, &face.prior.mean) < 1e-6);
}
