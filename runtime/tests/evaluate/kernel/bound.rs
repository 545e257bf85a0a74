//! Error bound of single precision: METHOD §2.7's E.

use super::exact::{Exact, kernel, steepness};
use models::KernelContent;
use sinew_runtime::kernel::Kernel;

/// Half of a unit in the last place of 1.
pub(crate) const U: f64 = 1.0 / 16_777_216.0;
/// Error of the exponential and the logarithm in ULPs, from `numeric.rs`.
const A: f64 = 1.0;

/// Roundings of a kernel except the distance's: METHOD's ρ.
fn roundings(kernel: Kernel) -> f64 {
    match kernel {
        Kernel::Linear => 1.0,
        Kernel::ThinPlate => 2.0 * A + 1.0,
        Kernel::Cubic | Kernel::Multiquadric | Kernel::InverseQuadratic => 2.0,
        Kernel::Quintic | Kernel::InverseMultiquadric => 3.0,
        Kernel::Gaussian | Kernel::Matern12 => 2.0 * A,
        Kernel::Matern32 => 2.0 * A + 2.0,
        Kernel::Matern52 => 2.0 * A + 5.0,
        Kernel::Wendland { l } => 2.0 * f64::from(l) + 4.0,
        // 1 minus the fallen part, with at most 3 roundings.
        Kernel::Hat { .. } => 4.0,
    }
}

/// E of each value at a query: the features' error from divisions and sums, carried through the
/// metric, the kernels, the monomials and the sum.
pub(crate) fn of_values(content: &KernelContent, exact: &Exact) -> Vec<f64> {
    let (k, d, n) = (content.rule.kernel, exact.u.len() as f64, exact.s.len() as f64);
    let has_rotations = content.inputs.iter().any(|(_, input)| input.kind.is_rotation());
    // Twelve roundings of numbers below 2 in a matrix entry, a swing or a twist; none for a scalar
    // or a vector.
    let feature = |u: f64, [shift, scale, ..]: [f32; 4]| {
        let x = u / f64::from(scale) + f64::from(shift);
        let own = if has_rotations { 12.0 * U * (1.0 + x.abs()) } else { 0.0 };
        f64::from(scale) * (own + U * (x - f64::from(shift)).abs()) + U * u.abs()
    };
    let is_bare = content.features.iter().all(|[shift, scale, ..]| (*shift, *scale) == (0.0, 1.0));
    let of_u = exact.u.iter().zip(&content.features);
    let of_u: Vec<f64> = of_u
        .map(|(u, figures)| if is_bare && !has_rotations { 0.0 } else { feature(*u, *figures) })
        .collect();
    let of_z: Vec<f64> = match content.metric.as_slice() {
        [] => of_u.clone(),
        rows => rows
            .iter()
            .map(|row| {
                let entries = row.iter().zip(exact.u.iter().zip(&of_u));
                entries.map(|(w, (u, of_u))| f64::from(w.abs()) * (of_u + d * U * u.abs())).sum()
            })
            .collect(),
    };
    let mut of_terms: Vec<f64> = Vec::new();
    for [earlier, input] in &content.terms {
        let (earlier, input) = (usize::from(*earlier), usize::from(*input));
        let product = |earlier: usize| {
            let (t, u) = (exact.terms[earlier].abs(), exact.u[input].abs());
            of_terms[earlier] * u + t * of_u[input] + U * t * u
        };
        let error = if exact.terms.get(earlier).is_none() { 0.0 } else { product(earlier) };
        of_terms.push(error);
    }
    let columns = n + exact.terms.len() as f64 + 1.0;
    let of_kernel = |(s, centre): (&f64, &Vec<f32>)| {
        let steep = steepness(k, *s).abs();
        let scale = if matches!(k, Kernel::Hat { .. }) { 1.0 } else { kernel(k, *s).abs() };
        let apart = exact.z.iter().zip(centre).zip(&of_z);
        let moved: f64 = apart.map(|((z, t), of_z)| 2.0 * (z - f64::from(*t)).abs() * of_z).sum();
        let by_distance = if *s > 0.0 { steep * moved / s } else { 0.0 };
        U * (roundings(k) * scale + (exact.z.len() as f64 + 6.0) * steep) + by_distance
    };
    let of_kernels: Vec<f64> = exact.s.iter().zip(&content.centres).map(of_kernel).collect();
    let basis = exact.s.iter().map(|s| kernel(k, *s)).chain(exact.terms.iter().copied());
    let basis: Vec<(f64, f64)> = basis.zip(of_kernels.into_iter().chain(of_terms)).collect();
    let of_value = |row: &Vec<f32>| {
        let each = row.iter().zip(&basis);
        each.map(|(c, (g, of_g))| f64::from(c.abs()) * (of_g + columns * U * g.abs())).sum::<f64>()
    };
    content.coefficients.iter().map(of_value).collect()
}
