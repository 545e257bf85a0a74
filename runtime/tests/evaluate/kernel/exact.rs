//! METHOD §2 in f64, from the plain lists: independent of the runtime.

use models::KernelContent;
use sinew_runtime::kernel::{
    InputKind, InputRow, Kernel, NO_TERM, Normalise, OutputKind, QueryRule,
};

/// A query in f64.
pub(crate) struct Exact {
    /// Features shifted and scaled.
    pub(crate) u: Vec<f64>,
    /// Coordinates for distances.
    pub(crate) z: Vec<f64>,
    /// Squared distances to the centres.
    pub(crate) s: Vec<f64>,
    /// Monomials.
    pub(crate) terms: Vec<f64>,
    /// Values.
    pub(crate) values: Vec<f64>,
}

pub(crate) fn kernel(kernel: Kernel, s: f64) -> f64 {
    let r = s.sqrt();
    let (a, b) = ((3.0 * s).sqrt(), (5.0 * s).sqrt());
    match kernel {
        Kernel::Linear => -r,
        Kernel::ThinPlate => {
            if s == 0.0 {
                0.0
            } else {
                s * r.ln()
            }
        }
        Kernel::Cubic => r.powi(3),
        Kernel::Quintic => -r.powi(5),
        Kernel::Multiquadric => -(1.0 + s).sqrt(),
        Kernel::InverseMultiquadric => (1.0 + s).powf(-0.5),
        Kernel::InverseQuadratic => 1.0 / (1.0 + s),
        Kernel::Gaussian => (-s).exp(),
        Kernel::Matern12 => (-r).exp(),
        Kernel::Matern32 => (1.0 + a) * (-a).exp(),
        Kernel::Matern52 => (1.0 + b + b * b / 3.0) * (-b).exp(),
        Kernel::Wendland { l } => {
            let l = f64::from(l);
            (1.0 - r).max(0.0).powf(l + 1.0) * ((l + 1.0) * r + 1.0)
        }
        Kernel::Hat { power } => (1.0 - r.powi(power.into())).max(0.0),
    }
}

/// s dG/ds, from differences of twelve places.
pub(crate) fn steepness(k: Kernel, s: f64) -> f64 {
    let h = 1e-4;
    (kernel(k, s * (1.0 + h)) - kernel(k, s * (1.0 - h))) / (2.0 * h)
}

/// The vector part of q v q* / |q|², the rotation of v.
fn rotated([x, y, z, w]: [f64; 4], v: [f64; 3]) -> [f64; 3] {
    let length = (x * x + y * y + z * z + w * w).sqrt();
    let (q, w) = ([x, y, z].map(|x| x / length), w / length);
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let once = cross(q, v);
    let twice = cross(q, once);
    [0, 1, 2].map(|i| v[i] + 2.0 * (w * once[i] + twice[i]))
}

fn features(input: &InputRow, numbers: &[f64]) -> Vec<f64> {
    let axis = input.axis.map(f64::from);
    let q = || [numbers[0], numbers[1], numbers[2], numbers[3]];
    let row = |r: usize| {
        let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|v| rotated(q(), v));
        columns.map(|column| column[r])
    };
    // The angle of the twist, from the quaternion's part along the axis.
    let half = || {
        let [x, y, z, w] = q();
        let about = x * axis[0] + y * axis[1] + z * axis[2];
        (if w < 0.0 { -about } else { about }).atan2(w.abs())
    };
    match input.kind {
        InputKind::Scalar | InputKind::Vector3 => numbers.to_vec(),
        InputKind::Rotation => [row(0), row(1), row(2)].concat(),
        InputKind::TwoRows => [row(0), row(1)].concat(),
        InputKind::Swing => rotated(q(), axis).to_vec(),
        InputKind::Twist => {
            // cos²(swing / 2) (cos τ, sin τ), with the swing from the rotated axis.
            let turned = rotated(q(), axis);
            let cosine = (0..3).map(|i| turned[i] * axis[i]).sum::<f64>();
            let near = (1.0 + cosine) / 2.0;
            vec![near * (2.0 * half()).cos(), near * (2.0 * half()).sin()]
        }
        InputKind::TwistAngle => vec![2.0 * half()],
    }
}

impl Exact {
    /// Computes the values of a query, with features clamped if that is the rule.
    pub(crate) fn new(content: &KernelContent, query: &[f64]) -> Self {
        let mut left = query;
        let mut raw = Vec::new();
        for (_, input) in &content.inputs {
            let (own, rest) = left.split_at(input.kind.number_len());
            raw.extend(features(input, own));
            left = rest;
        }
        let is_clamped = content.rule.query == QueryRule::Clamp;
        let u = raw.iter().zip(&content.features).map(|(x, figures)| {
            let [shift, scale, low, high] = figures.map(f64::from);
            (if is_clamped { x.clamp(low, high) } else { *x } - shift) * scale
        });
        let u: Vec<f64> = u.collect();
        let sum =
            |row: &[f32], x: &[f64]| row.iter().zip(x).map(|(a, x)| f64::from(*a) * x).sum::<f64>();
        let z = match content.metric.as_slice() {
            [] => u.clone(),
            rows => rows.iter().map(|row| sum(row, &u)).collect(),
        };
        let squared =
            |t: &Vec<f32>| z.iter().zip(t).map(|(z, t)| (z - f64::from(*t)).powi(2)).sum();
        let s: Vec<f64> = content.centres.iter().map(squared).collect();
        let mut terms: Vec<f64> = Vec::new();
        for [earlier, input] in &content.terms {
            let is_first = *earlier == NO_TERM;
            let product = || terms[usize::from(*earlier)] * u[usize::from(*input)];
            terms.push(if is_first { 1.0 } else { product() });
        }
        let basis = s.iter().map(|s| kernel(content.rule.kernel, *s)).chain(terms.iter().copied());
        let basis: Vec<f64> = basis.collect();
        let values = content.coefficients.iter().map(|row| sum(row, &basis)).collect();
        Self { u, z, s, terms, values }
    }

    /// w of METHOD §2.6.
    pub(crate) fn confidence(&self, content: &KernelContent) -> f64 {
        let (start, end) = content.rule.fade;
        if end == 0.0 {
            return 1.0;
        }
        let near = |s: &f64| {
            let u = ((f64::from(end) - s) / f64::from(end - start)).clamp(0.0, 1.0);
            u * u * u * (10.0 - 15.0 * u + 6.0 * u * u)
        };
        1.0 - self.s.iter().map(|s| 1.0 - near(s)).product::<f64>()
    }

    /// The outputs' numbers, and the sensitivity of each to errors of its values.
    pub(crate) fn outputs(&self, content: &KernelContent) -> Vec<f64> {
        let w = match content.rule.query {
            QueryRule::Fade => self.confidence(content),
            _ => 1.0,
        };
        let mut values = self.values.as_slice();
        let mut out = Vec::new();
        let mut marked = Vec::new();
        for (_, output) in &content.outputs {
            let (own, rest) = values.split_at(output.kind.value_len());
            values = rest;
            let neutral = output.neutral.map(f64::from);
            let faded = |i: usize, neutral: f64| neutral + w * (own[i] - neutral);
            match output.kind {
                OutputKind::Scalar => {
                    let (low, high) = output.range;
                    if output.is_marked {
                        marked.push(out.len());
                    }
                    out.push(faded(0, neutral[0]).clamp(low.into(), high.into()));
                }
                OutputKind::Vector3 => out.extend((0..3).map(|i| faded(i, neutral[i]))),
                OutputKind::Rotation => {
                    let v = [0, 1, 2].map(|i| faded(i, 0.0));
                    out.extend(hamilton(neutral, turn(v)));
                }
            }
        }
        let sum: f64 = marked.iter().map(|at| out[*at]).sum();
        let is_brought = match content.rule.normalise {
            Normalise::Never => false,
            Normalise::Always => sum > 1e-12,
            Normalise::AboveOne => sum > 1.0,
        };
        if is_brought {
            marked.into_iter().for_each(|at| out[at] /= sum);
        }
        out
    }
}

/// The quaternion of a vector of length 4 tan(angle / 4), from its angle.
fn turn(v: [f64; 3]) -> [f64; 4] {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let half = 2.0 * (length / 4.0).atan();
    let by = if length > 0.0 { half.sin() / length } else { 0.0 };
    [v[0] * by, v[1] * by, v[2] * by, half.cos()]
}

fn hamilton(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    let part = |[x, y, z, w]: [f64; 4]| ([x, y, z], w);
    let ((a, aw), (b, bw)) = (part(a), part(b));
    let v = |i: usize| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        aw * b[i] + bw * a[i] + a[j] * b[k] - a[k] * b[j]
    };
    [v(0), v(1), v(2), aw * bw - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]]
}
