//! Error of f32 arithmetic: at most METHOD §2.7's E.

use crate::kernel::common::{halton, json, random, rows};
use faer::Mat;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew_runtime::kernel::Kernel;
use sinew_trainer::ErrorKind;
use sinew_trainer::regression::arithmetic::Arithmetic;
use sinew_trainer::regression::function::Exact;
use sinew_trainer::regression::rotations::Feature;
use sinew_trainer::scattered::bound::{bound, largest, rounded};
use sinew_trainer::scattered::deviation::Probe;
use sinew_trainer::scattered::model::{Input, InputKind};
use sinew_trainer::scattered::solver::options::wendland;
use sinew_trainer::scattered::sum::{KernelSum, Term, monomials};

const IEEE: Arithmetic = Arithmetic::IEEE;

/// Evaluates the function in f32, one operation after another, in the order of the file's format.
fn in_f32(sum: &KernelSum, x: &[f32]) -> Vec<f32> {
    let f32s = |of: &[f64]| of.iter().map(|x| *x as f32).collect::<Vec<f32>>();
    let (shift, scale) = (f32s(&sum.shift), f32s(&sum.scale));
    let u: Vec<f32> = (0..x.len()).map(|i| (x[i] - shift[i]) * scale[i]).collect();
    let z: Vec<f32> = match &sum.metric {
        None => u.clone(),
        Some(w) => (0..w.nrows())
            .map(|r| u.iter().enumerate().fold(0.0, |z, (i, u)| z + w[(r, i)] as f32 * u))
            .collect(),
    };
    let mut basis = Vec::new();
    for k in 0..sum.centres.ncols() {
        let apart = |(i, z): (usize, &f32)| z - sum.centres[(i, k)] as f32;
        let s = z.iter().enumerate().map(apart).fold(0.0, |s, apart| s + apart * apart);
        basis.push(kernel_in_f32(sum.kernel, s));
    }
    for term in &sum.terms {
        basis.push(match *term {
            Term::One => 1.0,
            Term::Product { earlier, input } => basis[sum.centres.ncols() + earlier] * u[input],
        });
    }
    (0..sum.value_len())
        .map(|o| {
            let products = basis.iter().enumerate();
            products.fold(0.0, |y, (k, value)| y + sum.coefficients[(o, k)] as f32 * value)
        })
        .collect()
}

fn kernel_in_f32(kernel: Kernel, s: f32) -> f32 {
    let r = s.sqrt();
    match kernel {
        Kernel::Linear => -r,
        Kernel::ThinPlate if s == 0.0 => 0.0,
        Kernel::ThinPlate => 0.5 * s * s.ln(),
        Kernel::Cubic => s * r,
        Kernel::Quintic => -(s * s * r),
        Kernel::Multiquadric => -(1.0 + s).sqrt(),
        Kernel::InverseMultiquadric => 1.0 / (1.0 + s).sqrt(),
        Kernel::InverseQuadratic => 1.0 / (1.0 + s),
        Kernel::Gaussian => (-s).exp(),
        Kernel::Matern12 => (-r).exp(),
        Kernel::Matern32 => {
            let a = (3.0 * s).sqrt();
            (1.0 + a) * (-a).exp()
        }
        Kernel::Matern52 => {
            let a = (5.0 * s).sqrt();
            (1.0 + (a + a * a * (1.0 / 3.0))) * (-a).exp()
        }
        Kernel::Wendland { l } => {
            let left = if r < 1.0 { 1.0 - r } else { 0.0 };
            let power = (0..l).fold(left, |product, _| product * left);
            power * ((f32::from(l) + 1.0) * r + 1.0)
        }
        Kernel::Hat { power } => {
            let fallen = match power {
                1 => r,
                3 => s * r,
                _ => s * s * r,
            };
            if r < 1.0 { 1.0 - fallen } else { 0.0 }
        }
    }
}

/// Evaluates METHOD's formula as written, without polynomials, shift and scale.
fn methods(sum: &KernelSum, x: &[f64]) -> f64 {
    let u = 2f64.powi(-24);
    let roundings = match sum.kernel {
        Kernel::Gaussian | Kernel::Matern12 => 2.0,
        Kernel::ThinPlate => 3.0,
        Kernel::Matern32 => 4.0,
        Kernel::Matern52 => 7.0,
        Kernel::Linear => 1.0,
        Kernel::Cubic | Kernel::Multiquadric | Kernel::InverseQuadratic => 2.0,
        Kernel::Quintic | Kernel::InverseMultiquadric => 3.0,
        Kernel::Wendland { l } => 2.0 * f64::from(l) + 4.0,
        Kernel::Hat { .. } => panic!("METHOD has none"),
    };
    let (n, d) = (sum.centres.ncols() as f64, x.len() as f64);
    let term = |k: usize| {
        let s: f64 = x.iter().enumerate().map(|(i, x)| (x - sum.centres[(i, k)]).powi(2)).sum();
        let (g, slope) = (sum.kernel.exact(s), sum.kernel.slope(s));
        let c = sum.coefficients[(0, k)].abs();
        c * (roundings * g.abs() + (d + 6.0) * (s * slope).abs() + (n + 1.0) * g.abs())
    };
    u * (0..sum.centres.ncols()).map(term).sum::<f64>()
}

#[test]
fn the_references_configurations_stay_within_methods_bound_and_ours() {
    let Some(file) = json("../reference/f32_bound.json") else { return };
    let cases = file.as_array().unwrap();
    assert_eq!(cases.len(), 45);
    for (seed, case) in cases.iter().enumerate() {
        let number = |name: &str| case[name].as_u64().unwrap() as usize;
        let (n, d, scale) = (number("n"), number("d"), case["scale"].as_f64().unwrap());
        let kernel = match case["kernel"].as_str().unwrap() {
            "gaussian" => Kernel::Gaussian,
            "imq" => Kernel::InverseMultiquadric,
            "mq" => Kernel::Multiquadric,
            "tps_half_s_ln_s" => Kernel::ThinPlate,
            "wendland_c2" => Kernel::Wendland { l: 3 },
            name => panic!("{name}"),
        };
        // For numbers between -1 and 1 the mean squared distance is 2 d / 3; the reference's is
        // scale².
        let spread = scale / (2.0 * d as f64 / 3.0).sqrt();
        let weight = case["sum_abs_c"].as_f64().unwrap() / n as f64;
        let sum = rounded(&KernelSum {
            kernel,
            shift: vec![0.0; d],
            scale: vec![1.0; d],
            metric: None,
            centres: random(seed as u64, d, n) * faer::Scale(spread),
            terms: Vec::new(),
            coefficients: random(100 + seed as u64, 1, n) * faer::Scale(2.0 * weight),
        });
        for query in rows(&random(200 + seed as u64, 200, d)) {
            let query: Vec<f32> = query.iter().map(|x| (x * spread) as f32).collect();
            let x: Vec<f64> = query.iter().map(|x| f64::from(*x)).collect();
            let error = (f64::from(in_f32(&sum, &query)[0]) - sum.evaluate(&x)[0]).abs();
            let (method, own) = (methods(&sum, &x), bound(&sum, &x, &vec![0.0; d], IEEE)[0]);
            assert!(error <= method, "{kernel:?} {n} {d} {scale}: {:.2}", error / method);
            // Our bound adds underflow, and the steepest slope over the possible distances.
            assert!(
                (own / method - 1.0).abs() < 1e-3 || own < 1e-30,
                "{kernel:?} {}",
                own / method
            );
        }
    }
}

#[test]
fn a_hundred_thousand_queries_of_every_kernel_stay_within_the_bound() {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let (mut queries, mut worst) = (0, 0.0f64);
    while queries < 100_000 {
        for own in Kernel::ALL {
            let (d, n) = (random.random_range(1..=36), random.random_range(1..=64));
            let kernel =
                if matches!(own, Kernel::Wendland { .. }) { wendland(d).unwrap() } else { own };
            let degree = random.random_range(0..4usize);
            let plain = random.random::<bool>();
            let terms =
                if d > 6 && degree > 2 || degree == 3 { Vec::new() } else { monomials(d, degree) };
            let scale = 10f64.powf(2.0 * random.random::<f64>() - 1.0) / (d as f64).sqrt();
            let mut wave = |rows: usize, columns: usize, most: f64| {
                Mat::from_fn(rows, columns, |_, _| most * (2.0 * random.random::<f64>() - 1.0))
            };
            let metric = (!plain && d > 2).then(|| wave(d - 1, d, 1.0));
            let sum = rounded(&KernelSum {
                kernel,
                shift: if plain { vec![0.0; d] } else { rows(&wave(1, d, 3.0)).concat() },
                scale: if plain { vec![scale; d] } else { rows(&wave(1, d, scale)).concat() },
                centres: wave(metric.as_ref().map_or(d, Mat::nrows), n, 2.0 * scale),
                metric,
                coefficients: wave(2, n + terms.len(), 10.0),
                terms,
            });
            for q in 0..32 {
                let x: Vec<f32> = match q % 4 {
                    // On a centre, if there is no metric.
                    0 if sum.metric.is_none() => (0..d)
                        .map(|i| (sum.shift[i] + sum.centres[(i, 0)] / sum.scale[i]) as f32)
                        .collect(),
                    _ => (0..d)
                        .map(|i| (sum.shift[i] + 4.0 * random.random::<f64>() - 2.0) as f32)
                        .collect(),
                };
                let exact: Vec<f64> = x.iter().map(|x| f64::from(*x)).collect();
                let bounds = bound(&sum, &exact, &vec![0.0; d], IEEE);
                let truth = sum.evaluate(&exact);
                for (o, found) in in_f32(&sum, &x).iter().enumerate() {
                    let error = (f64::from(*found) - truth[o]).abs();
                    assert!(
                        error <= bounds[o],
                        "{kernel:?} {n} {d}: {error:.1e} {:.1e}",
                        bounds[o]
                    );
                    worst = worst.max(error / bounds[o]);
                }
                queries += 1;
            }
        }
    }
    println!("at most {worst:.2} of the bound");
    assert!(worst > 0.3, "the bound is not far above what happens: {worst:.2}");
}

#[test]
fn inputs_that_are_off_are_within_the_bound_too() {
    for kernel in Kernel::ALL {
        let sum = KernelSum {
            kernel,
            shift: vec![0.25, -0.5],
            scale: vec![0.5, 0.5],
            metric: None,
            centres: halton(1, 2, 5),
            terms: monomials(2, 2),
            coefficients: random(3, 1, 11),
        };
        for query in rows(&random(4, 200, 2)) {
            for off in [1e-7, 1e-3] {
                let bound = bound(&sum, &query, &[off, off], IEEE)[0];
                for (a, b) in [(off, off), (off, -off), (-off, off), (-off, -off)] {
                    let moved = sum.evaluate(&[query[0] + a, query[1] + b])[0];
                    assert!((moved - sum.evaluate(&query)[0]).abs() <= bound, "{kernel:?} {off}");
                }
            }
        }
    }
}

#[test]
fn the_largest_bound_is_over_the_samples_and_their_box() {
    let sites = halton(1, 20, 2);
    let sum = rounded(&KernelSum {
        kernel: Kernel::Cubic,
        shift: vec![0.1, 0.2],
        scale: vec![1.5, 0.7],
        metric: None,
        centres: random(5, 2, 8),
        terms: monomials(2, 1),
        coefficients: random(6, 2, 11),
    });
    let found = largest(&sum, &sites);
    let at_samples = |o: usize| {
        let own = rows(&sites).into_iter().map(|x| {
            let x: Vec<f64> = x.iter().map(|x| f64::from(*x as f32)).collect();
            bound(&sum, &x, &[0.0, 0.0], IEEE)[o]
        });
        own.fold(0.0, f64::max)
    };
    for (o, found) in found.iter().enumerate() {
        assert!(*found >= at_samples(o) && *found < 2.0 * at_samples(o));
    }
    // On a dense grid the bound is hardly larger than at the samples, even at the corners.
    let dense =
        (0..=40).flat_map(|i| (0..=40).map(move |k| [f64::from(i) / 40.0, f64::from(k) / 40.0]));
    let most = dense.map(|x| bound(&sum, &x, &[0.0, 0.0], IEEE)[0]).fold(0.0, f64::max);
    assert!(found[0] > 0.6 * most);
}

/// Makes `a + b x` of one number, with a kernel of weight 0.
fn line(a: f64, b: f64) -> KernelSum {
    KernelSum {
        kernel: Kernel::Gaussian,
        shift: vec![0.0],
        scale: vec![1.0],
        metric: None,
        centres: Mat::zeros(1, 1),
        terms: monomials(1, 1),
        coefficients: Mat::from_fn(1, 3, |_, k| [0.0, a, b][k]),
    }
}

fn scalar() -> Vec<Input> {
    vec![Input { name: "x".to_owned(), kind: InputKind::Scalar, weight: 1.0 }]
}

#[test]
fn a_files_deviation_is_measured_and_refused_above_the_limit() {
    let probe = |sites: &[f64], range, limit| {
        let sites: Vec<Vec<f64>> = sites.iter().map(|x| vec![*x]).collect();
        Probe::new(&scalar(), &sites, vec![range], limit).unwrap()
    };
    // 2^24 + 1 becomes 2^24 in a file: an error of 1.
    let odd = line(16_777_217.0, 0.0);
    let of =
        |range: f64, limit: f64| probe(&[0.0, 1.0], range, limit).check(&odd, |x| odd.evaluate(x));
    assert_eq!(of(500.0, 2.1e-3).unwrap(), 1.0 / 500.0);
    let refused = of(500.0, 1e-3).unwrap_err();
    assert_eq!(refused.kind(), ErrorKind::Fit);
    assert_eq!(
        refused.to_string(),
        "in single precision the function is off by 2.0e-3 of its values' range, more than 1.0e-3: take the offset \
         off the values (numbers up to 1.678e7 with a range of 5.000e2 do not fit single precision), or allow it by \
         --f32-error"
    );
    // Samples that are equal in f32: from 1e8 on, its numbers are 8 apart. Queries between the
    // samples are rounded to f32 numbers.
    let far = line(-1e8, 1.0);
    let found = probe(&[1e8, 1e8 + 3.0], 3.0, 1.0).deviation(&far, |x| far.evaluate(x));
    assert_eq!(found, 1.0);
    let near = probe(&[1e8, 1e8 + 16.0], 16.0, 1.0).deviation(&far, |x| far.evaluate(x));
    assert_eq!(near, 0.0);
    // A NaN in the reference is an infinite deviation.
    assert_eq!(probe(&[0.0], 1.0, 1.0).deviation(&odd, |_| vec![f64::NAN]), f64::INFINITY);
    // A number outside the range of f32 has an infinite deviation.
    let huge = line(1e39, 0.0);
    assert_eq!(probe(&[0.0], 1.0, 1.0).deviation(&huge, |x| huge.evaluate(x)), f64::INFINITY);
}

#[test]
fn rotations_are_measured_between_their_samples_whatever_their_signs() {
    let kind = InputKind::Rotation { feature: Feature::Matrix, order: None };
    let inputs = [Input { name: "q".to_owned(), kind, weight: 1.0 }];
    // 20 and 22 degrees about z, the second by the quaternion of the other sign. The kernel is
    // centred at 21 degrees, and falls to 0.9994 at both. On the longer arc between the two it is
    // 0.
    let turned = |degrees: f64| {
        let half = 0.5 * degrees.to_radians();
        [0.0, 0.0, half.sin(), half.cos()]
    };
    let sites = [turned(20.0).to_vec(), turned(22.0).map(|x| -2.0 * x).to_vec()];
    let centre = Feature::Matrix.of(turned(21.0)).unwrap();
    let sum = KernelSum {
        kernel: Kernel::Gaussian,
        shift: vec![0.0; 9],
        scale: vec![1.0; 9],
        metric: None,
        centres: Mat::from_fn(9, 1, |i, _| centre[i]),
        terms: Vec::new(),
        coefficients: Mat::from_fn(1, 1, |_, _| 1.0),
    };
    let probe = Probe::new(&inputs, &sites, vec![1.0], 1e-3).unwrap();
    assert!(probe.deviation(&sum, |x| sum.evaluate(x)) < 1e-6);
    let most = probe.deviation(&sum, |_| vec![1.0]);
    assert!((5e-4..7e-4).contains(&most), "{most}");
}
