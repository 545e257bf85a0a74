//! From values to outputs: fades, ranges, normalisation, rotations.

use super::bound::of_values;
use super::exact::Exact;
use super::{evaluate, with};
use crate::common::apart;
use models::{KernelContent, Rng};
use sinew_runtime::kernel::{Kernel, Normalise, QueryRule};

fn double(query: &[f32]) -> Vec<f64> {
    query.iter().map(|x| f64::from(*x)).collect()
}

#[test]
fn outputs_are_those_of_their_closed_forms() {
    let mut rng = Rng(19);
    let (mut faded, mut kept, mut brought) = (0, 0, 0);
    for query_rule in QueryRule::ALL {
        for normalise in Normalise::ALL {
            let mut content = KernelContent::every(Kernel::Multiquadric);
            (content.rule.query, content.rule.normalise) = (query_rule, normalise);
            with(&content, |map| {
                for _ in 0..100 / apart(50) {
                    let query = content.query(&mut rng, 1.0);
                    let exact = Exact::new(&content, &double(&query));
                    let (found, confidence) = evaluate(&map, &query).unwrap();
                    let expected = exact.outputs(&content);
                    let largest = of_values(&content, &exact).into_iter().fold(0.0, f64::max);
                    // A rotation moves by half of its vector's error. A confidence adds its own
                    // error times the values. A sum near 0 magnifies errors.
                    let sum = [1, 2].map(|at| expected[at]).iter().sum::<f64>().abs();
                    let values = exact.values.iter().fold(1.0, |most: f64, x| most.max(x.abs()));
                    let tolerance = 4.0 * largest + 1e-5 * values;
                    for (place, (found, expected)) in found.iter().zip(&expected).enumerate() {
                        let error = (f64::from(*found) - expected).abs();
                        let is_brought = [1, 2].contains(&place) && sum.abs() < 0.2;
                        assert!(is_brought || error <= tolerance, "{place} {found} {expected}");
                    }
                    faded += usize::from(confidence > 0.01 && confidence < 0.99);
                    kept += usize::from([-0.5, 0.75].contains(&found[1]));
                    brought += usize::from((found[1] + found[2] - 1.0).abs() < 1e-6);
                    let square = found[6..].iter().map(|x| x * x).sum::<f32>();
                    assert!((square - 1.0).abs() < 1e-5, "{square}");
                }
            });
        }
    }
    let all = faded > 50 && kept > 50 && brought > 50;
    assert!(cfg!(miri) || all, "{faded} {kept} {brought}");
}

#[test]
fn a_fade_ends_at_the_neutral_and_starts_at_the_values() {
    let mut content = KernelContent::every(Kernel::Linear);
    content.rule.query = QueryRule::Fade;
    let mut query = content.query(&mut Rng(1), 1.0);
    let far = {
        query[0] = 1e4;
        with(&content, |map| evaluate(&map, &query).unwrap())
    };
    assert_eq!(far, (vec![0.25, 0.0, 0.5, 0.5, -1.0, 2.0, 0.48, -0.6, 0.0, 0.64], 0.0));
    // With a distant fade every centre has nearness 1: the bits of a kernel without fade.
    query[0] = 0.3;
    content.rule.fade = (1e6, 2e6);
    let near = with(&content, |map| evaluate(&map, &query).unwrap());
    content.rule.query = QueryRule::Free;
    assert_eq!(near, with(&content, |map| evaluate(&map, &query).unwrap()));
    assert_eq!(near.1, 1.0);
}

#[test]
fn sums_are_brought_to_one_where_the_rule_says() {
    // Three scalars with constant values.
    let content = |normalise, values: [f32; 3], marked: [bool; 3]| {
        let mut content = KernelContent::plain(Kernel::Gaussian, [1, 0, 3]);
        content.rule.normalise = normalise;
        content.terms = vec![[u16::MAX; 2]];
        content.coefficients = values.map(|value| vec![value]).to_vec();
        for ((_, output), marked) in content.outputs.iter_mut().zip(marked) {
            (output.is_marked, output.range) = (marked, (0.0, f32::MAX));
        }
        with(&content, |map| evaluate(&map, &[0.0]).unwrap().0)
    };
    use Normalise::{AboveOne, Always, Never};
    let all = [true; 3];
    assert_eq!(content(Never, [1.0, 2.0, 1.0], all), [1.0, 2.0, 1.0]);
    assert_eq!(content(Always, [1.0, 2.0, 1.0], all), [0.25, 0.5, 0.25]);
    assert_eq!(content(Always, [0.125, 0.25, 0.125], all), [0.25, 0.5, 0.25]);
    assert_eq!(content(AboveOne, [1.0, 2.0, 1.0], all), [0.25, 0.5, 0.25]);
    assert_eq!(content(AboveOne, [0.125, 0.25, 0.125], all), [0.125, 0.25, 0.125]);
    assert_eq!(content(Always, [1.0, 7.0, 3.0], [true, false, true]), [0.25, 7.0, 0.75]);
    assert_eq!(content(Always, [1.0, -7.0, 3.0], all), [0.25, 0.0, 0.75]);
    assert_eq!(
        content(Always, [0.0, -1.0, 1e-13], all),
        [0.0, 0.0, 1e-13],
        "nothing to bring to 1"
    );
}

#[test]
fn a_clamped_query_is_the_nearest_of_the_box() {
    let content = KernelContent::servo();
    with(&content, |map| {
        let near = evaluate(&map, &[1.0, -1.0, 0.3, 0.1, 0.0, 0.9]).unwrap();
        assert_eq!(evaluate(&map, &[40.0, -1.5, 0.3, 0.1, 0.0, 0.9]).unwrap(), near);
        let mut seen = [false; 2];
        for i in (0..400).step_by(apart(10)) {
            let query = content.query(&mut Rng(i), 1.0);
            let [x] = evaluate(&map, &query).unwrap().0[..] else { panic!() };
            assert!((-1.0..=1.0).contains(&x));
            seen[usize::from(x > 0.0)] = true;
        }
        assert_eq!(seen, [true; 2]);
    });
}
