//! Values against f64, for every kernel and every size.

use super::bound::of_values;
use super::exact::Exact;
use super::{evaluate, with};
use crate::common::{apart, bits};
use models::{KernelContent, Pieces, Rng};
use sinew_runtime::kernel::{Kernel, KernelCounts, QueryRule};
use sinew_runtime::{Envelope, KernelMap, Model};

fn double(query: &[f32]) -> Vec<f64> {
    query.iter().map(|x| f64::from(*x)).collect()
}

#[test]
fn values_are_within_the_bound() {
    let mut rng = Rng(7);
    let kernels = Kernel::ALL.into_iter().chain([2, 5, 20].map(|l| Kernel::Wendland { l }));
    let (mut worst, mut queries) = (0.0f64, 0);
    for kernel in kernels {
        for d in [1, 2, 3, 7, 36].into_iter().step_by(apart(4)) {
            for n in [1, 2, 8, 9, 64].into_iter().step_by(apart(4)) {
                let mut content = KernelContent::plain(kernel, [d, n, 2]);
                // Distances of about 1, where a kernel changes most.
                let size = 1.0 / (d as f32).sqrt();
                content.centres.iter_mut().flatten().for_each(|t| *t *= size);
                with(&content, |map| {
                    for i in 0..20 {
                        let query = content.query(&mut rng, [0.3, 1.0, 3.0, 30.0][i % 4] * size);
                        let exact = Exact::new(&content, &double(&query));
                        let (found, confidence) = evaluate(&map, &query).unwrap();
                        assert_eq!(confidence, 1.0);
                        for ((found, value), bound) in
                            found.iter().zip(&exact.values).zip(of_values(&content, &exact))
                        {
                            // The lower end of the exponential, and subnormal numbers.
                            let least = 2e-38 * n as f64;
                            let error = (f64::from(*found) - value).abs() / (bound + least);
                            assert!(error <= 1.0, "{kernel:?} {d} {n} {query:?} {error}");
                            worst = worst.max(error);
                        }
                        queries += 1;
                    }
                });
            }
        }
    }
    assert!(worst > 0.2 && queries > 60, "{worst} of {queries}");
}

#[test]
fn every_kind_of_input_is_within_the_bound() {
    let mut rng = Rng(11);
    for kernel in Kernel::ALL.into_iter().step_by(apart(5)) {
        for query_rule in [QueryRule::Free, QueryRule::Clamp] {
            let mut content = KernelContent::every(kernel);
            content.rule.query = query_rule;
            with(&content, |map| {
                let mut worst = 0.0f64;
                for i in 0..200 / apart(50) {
                    let query = content.query(&mut rng, [0.5, 1.0, 4.0][i % 3]);
                    let exact = Exact::new(&content, &double(&query));
                    let (found, confidence) = evaluate(&map, &query).unwrap();
                    assert!((f64::from(confidence) - exact.confidence(&content)).abs() < 1e-4);
                    let bounds = of_values(&content, &exact);
                    // The first output and the vector equal their values.
                    for (place, value) in [(0, 0), (3, 3), (4, 4), (5, 5)] {
                        let error = (f64::from(found[place]) - exact.values[value]).abs();
                        assert!(error <= bounds[value], "{kernel:?} {query:?} {place} {error}");
                        worst = worst.max(error / bounds[value]);
                    }
                }
                assert!(worst > 0.01, "{worst}");
            });
        }
    }
}

#[test]
fn a_quaternion_and_its_opposite_are_one_query() {
    let mut rng = Rng(3);
    let content = KernelContent::every(Kernel::Cubic);
    with(&content, |map| {
        for _ in 0..50 {
            let query = content.query(&mut rng, 1.0);
            let mut opposite = query.clone();
            // Scalar and vector come first, then five rotations.
            opposite[4..].chunks_mut(4).step_by(2).flatten().for_each(|x| *x = -*x);
            let (a, b) = (evaluate(&map, &query).unwrap(), evaluate(&map, &opposite).unwrap());
            assert_eq!((bits(&a.0), a.1.to_bits()), (bits(&b.0), b.1.to_bits()));
            // Quaternions of any length, up to rounding.
            let mut longer = query.clone();
            longer[4..].iter_mut().for_each(|x| *x *= 1.7);
            let longer = evaluate(&map, &longer).unwrap().0;
            let apart = a.0.iter().zip(&longer).map(|(a, b)| (a - b).abs() / (1.0 + a.abs()));
            assert!(apart.fold(0.0, f32::max) < 1e-4);
        }
    });
}

#[test]
fn samples_come_back_and_cones_have_their_tip() {
    // One centre, coefficient 2: the kernel itself.
    for kernel in Kernel::ALL {
        let mut content = KernelContent::plain(kernel, [2, 1, 1]);
        content.coefficients = vec![vec![2.0]];
        let centre = content.centres[0].clone();
        let found = with(&content, |map| evaluate(&map, &centre).unwrap().0[0]);
        assert_eq!(found, 2.0 * kernel.value(0.0), "{kernel:?}");
    }
}

#[test]
fn a_polynomial_alone_and_nothing_at_all() {
    let mut content = KernelContent::plain(Kernel::Gaussian, [2, 0, 1]);
    content.terms = vec![[u16::MAX; 2], [0, 0], [1, 1], [2, 1]];
    content.coefficients = vec![vec![0.5, -2.0, 3.0, 0.25]];
    let (x, y) = (0.75f32, -0.5f32);
    let found = with(&content, |map| evaluate(&map, &[x, y]).unwrap());
    assert_eq!(found, (vec![0.5 - 2.0 * x + 3.0 * x * y + 0.25 * x * y * y], 1.0));
    // Neither centres nor terms: 0, and confidence 0 with a fade.
    content.terms.clear();
    content.coefficients = vec![Vec::new()];
    assert_eq!(with(&content, |map| evaluate(&map, &[x, y]).unwrap()), (vec![0.0], 1.0));
    content.rule.fade = (1.0, 2.0);
    assert_eq!(with(&content, |map| evaluate(&map, &[x, y]).unwrap()), (vec![0.0], 0.0));
}

#[test]
fn accessors_give_what_was_written() {
    let content = KernelContent::every(Kernel::Wendland { l: 14 });
    let bytes = Pieces::kernels(&[KernelContent::servo(), content.clone()]).bytes();
    let model = Model::from_bytes(bytes.as_slice()).unwrap();
    assert_eq!(model.all::<KernelMap>().count(), 2);
    assert_eq!(model.first::<KernelMap>().unwrap().name(), "servo");
    assert!(model.named::<KernelMap>("arm").is_none() && model.first::<Envelope>().is_none());
    let map = model.named::<KernelMap>("every").unwrap();
    assert_eq!(
        (map.part(), map.file(), map.rule(), map.fit()),
        (1, model.id(), content.rule, content.fit)
    );
    let counts = KernelCounts::from_words([7, 5, 25, 5, 11, 28, 9, 6]);
    assert_eq!(map.counts(), counts);
    assert_eq!(content.counts().map(|len| len as u32), counts.words());
    assert_eq!((map.query_len(), map.result_len()), (content.query_len(), 10));
    for (i, (name, input)) in content.inputs.iter().enumerate() {
        assert_eq!(map.input_name(i), Some(name.as_str()));
        assert_eq!(map.inputs().nth(i), Some(*input));
    }
    for (o, (name, output)) in content.outputs.iter().enumerate() {
        assert_eq!(map.output_name(o), Some(name.as_str()));
        assert_eq!(map.outputs().nth(o), Some(*output));
    }
    assert_eq!(
        (map.input_name(7), map.output_name(5), map.output_name(usize::MAX)),
        (None, None, None)
    );
    let shape = |rows: &[Vec<f32>], entry: &dyn Fn(usize, usize) -> Option<f32>| {
        for (r, row) in rows.iter().enumerate() {
            for (c, x) in row.iter().enumerate() {
                assert_eq!(entry(r, c), Some(*x));
            }
            assert_eq!(entry(r, row.len()), None);
        }
        assert_eq!(entry(rows.len(), 0), None);
    };
    shape(&content.metric, &|r, c| map.metric_entry(r, c));
    shape(&content.centres, &|k, i| map.centre(k, i));
    shape(&content.coefficients, &|r, c| map.coefficient(r, c));
    assert!((0..28).all(|t| map.term(t) == Some(content.terms[t])) && map.term(28).is_none());
    assert!(
        (0..25).all(|i| map.feature(i) == Some(content.features[i])) && map.feature(25).is_none()
    );
    let layout = map.layout();
    assert_eq!(layout.open::<KernelMap>(&bytes).map(|map| map.name()), Some("every"));
    assert!(layout.open::<KernelMap>(&bytes[1..]).is_none());
}
