//! Energy of a sum of kernels, and its gradient by all parameters (METHOD §3).

use super::least_squares::solve;
use super::options::{Entries, Options, wrong_number};
use crate::Error;
use crate::numeric::columns::dot;
use crate::regression::function::Exact;
use crate::scattered::sum::{monomials, powers, squared};
use faer::MatRef;
use sinew_runtime::kernel::Kernel;

/// Energy `Σ|y_i - f(x_i)|² + λN (|c|² + |b|²)` of N samples.
pub(super) struct Energy {
    kernel: Kernel,
    /// λN.
    ridge: f64,
    learned: Entries,
    /// N.
    pub(super) sample_len: usize,
    /// d.
    pub(super) input_len: usize,
    /// Inputs u, d per sample.
    pub(super) inputs: Vec<f64>,
    /// Values y, N per value.
    values: Vec<f64>,
    /// Values of the monomials, N per term.
    monomials: Vec<f64>,
}

/// Parameters of a sum, or a gradient by them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Parameters {
    /// Centres t, d each.
    pub(super) centres: Vec<f64>,
    /// Metric W by rows, d each.
    pub(super) metric: Vec<f64>,
    /// Coefficients `[c b]`, n + terms per value.
    pub(super) coefficients: Vec<f64>,
}

/// Parameters and their energy.
#[derive(Clone, Debug)]
pub(super) struct Point {
    /// Parameters of the sum.
    pub(super) parameters: Parameters,
    /// Energy E.
    pub(super) energy: f64,
    measured: Measured,
    /// Values of kernels and monomials, N per column.
    basis: Vec<f64>,
    /// Residuals Δ, N per value.
    residuals: Vec<f64>,
}

/// Products of samples and centres with the metric.
#[derive(Clone, Debug)]
struct Measured {
    /// W u, e per sample.
    samples: Vec<f64>,
    /// W t, e per centre.
    centres: Vec<f64>,
}

impl Energy {
    /// Takes sites x (N x d) and values y (N x m).
    ///
    /// - `shift`, `scale`: d each, turn x into u.
    ///
    /// # Errors
    /// - If there are no samples, inputs or values.
    /// - If a length does not match the samples.
    /// - If the ridge is negative or not finite.
    pub(super) fn new(
        sites: MatRef<'_, f64>,
        values: MatRef<'_, f64>,
        shift: &[f64],
        scale: &[f64],
        options: &Options,
    ) -> Result<Self, Error> {
        let (sample_len, input_len, value_len) = (sites.nrows(), sites.ncols(), values.ncols());
        let rows = options.metric.start.nrows();
        if sample_len == 0 || input_len == 0 || value_len == 0 {
            return Err(Error::missing(format!(
                "nothing to learn from: {sample_len} samples of {input_len} inputs and {value_len} values"
            )));
        }
        for (name, expected, found) in [
            ("samples' values", sample_len, values.nrows()),
            ("inputs' shifts", input_len, shift.len()),
            ("inputs' scales", input_len, scale.len()),
            ("columns of the metric", input_len, options.metric.start.ncols()),
            ("rows of the metric", rows.max(1), rows),
        ] {
            if found != expected {
                let message = format!("{name}: expected {expected}, found {found}");
                return Err(Error::mismatch(message));
            }
        }
        if !(options.ridge >= 0.0 && options.ridge.is_finite()) {
            return Err(wrong_number("the ridge", options.ridge));
        }
        let scaled = |row: usize, i: usize| (sites[(row, i)] - shift[i]) * scale[i];
        let inputs: Vec<f64> =
            (0..sample_len).flat_map(|row| (0..input_len).map(move |i| scaled(row, i))).collect();
        let terms = options.degree.map_or_else(Vec::new, |degree| monomials(input_len, degree));
        let mut by_term = vec![0.0; terms.len() * sample_len];
        for (i, u) in inputs.chunks_exact(input_len).enumerate() {
            for (term, value) in powers(&terms, u).into_iter().enumerate() {
                by_term[term * sample_len + i] = value;
            }
        }
        Ok(Self {
            kernel: options.kernel,
            ridge: options.ridge * sample_len as f64,
            learned: options.metric.learned,
            sample_len,
            input_len,
            inputs,
            values: values.col_iter().flat_map(|column| column.iter().copied()).collect(),
            monomials: by_term,
        })
    }

    /// Evaluates the energy.
    pub(super) fn at(&self, parameters: Parameters) -> Point {
        let (measured, basis) = self.basis(&parameters);
        self.point(parameters, measured, basis)
    }

    /// Computes the least energy with these centres and this metric, and stores the coefficients of that energy.
    pub(super) fn solved(&self, mut parameters: Parameters) -> Point {
        let (measured, basis) = self.basis(&parameters);
        parameters.coefficients = if self.ridge > 0.0 {
            let count = basis.len() / self.sample_len;
            let root = self.ridge.sqrt();
            let below = |column: usize, row: usize| if row == column { root } else { 0.0 };
            let columns = basis.chunks_exact(self.sample_len).enumerate();
            let design = columns.flat_map(|(k, column)| {
                column.iter().copied().chain((0..count).map(move |row| below(k, row)))
            });
            let right = self
                .values
                .chunks_exact(self.sample_len)
                .flat_map(|column| column.iter().copied().chain(std::iter::repeat_n(0.0, count)));
            solve(design.collect(), right.collect(), self.sample_len + count)
        } else {
            solve(basis.clone(), self.values.clone(), self.sample_len)
        };
        self.point(parameters, measured, basis)
    }

    /// Computes the gradient; 0 for entries of W that are not learned.
    ///
    /// Let z = W u, τ = W t, and q_ia = (c_a·Δ_i) G'_ia. Then ∂E/∂z_i = -4 Σ_a q_ia (z_i - τ_a) and ∂E/∂τ_a = 4 Σ_i
    /// q_ia (z_i - τ_a). METHOD's ∂E/∂t is Wᵀ ∂E/∂τ. METHOD's ∂E/∂W is the sum of ∂E/∂z_i u_iᵀ and ∂E/∂τ_a t_aᵀ.
    pub(super) fn gradient(&self, point: &Point) -> Parameters {
        let Point { parameters, measured, basis, residuals, .. } = point;
        let [n, e] = [&parameters.centres, &parameters.metric].map(|of| of.len() / self.input_len);
        let count = n + self.term_len();
        let mut by_sample = vec![0.0; e];
        let mut by_centre = vec![0.0; e * n];
        let mut metric = vec![0.0; parameters.metric.len()];
        for i in 0..self.sample_len {
            let z = &measured.samples[i * e..][..e];
            by_sample.fill(0.0);
            for a in 0..n {
                let centre = &measured.centres[a * e..][..e];
                let coefficients = parameters.coefficients[a..].iter().step_by(count);
                let of_sample = residuals[i..].iter().step_by(self.sample_len);
                let product: f64 = coefficients.zip(of_sample).map(|(c, left)| c * left).sum();
                let share = 4.0 * product * self.kernel.slope(squared(z, centre.iter()));
                for (r, (z, t)) in z.iter().zip(centre).enumerate() {
                    by_sample[r] -= share * (z - t);
                    by_centre[a * e + r] += share * (z - t);
                }
            }
            self.add_outer(&mut metric, &by_sample, self.input(i));
        }
        let mut centres = vec![0.0; parameters.centres.len()];
        for a in 0..n {
            let by = &by_centre[a * e..][..e];
            let place = a * self.input_len..(a + 1) * self.input_len;
            self.add_outer(&mut metric, by, &parameters.centres[place.clone()]);
            for (row, by) in parameters.metric.chunks_exact(self.input_len).zip(by) {
                centres[place.clone()].iter_mut().zip(row).for_each(|(t, w)| *t += w * by);
            }
        }
        let columns = || basis.chunks_exact(self.sample_len);
        let of_values = residuals.chunks_exact(self.sample_len);
        let downhill = of_values.flat_map(|left| columns().map(|column| dot(column, left)));
        let coefficients = downhill.zip(&parameters.coefficients);
        let coefficients = coefficients.map(|(down, c)| 2.0 * (self.ridge * c - down)).collect();
        Parameters { centres, metric, coefficients }
    }

    /// Returns m.
    pub(super) fn value_len(&self) -> usize {
        self.values.len() / self.sample_len
    }

    /// Returns the inputs u of a sample, d.
    pub(super) fn input(&self, sample: usize) -> &[f64] {
        &self.inputs[sample * self.input_len..][..self.input_len]
    }

    /// Returns the number of monomials.
    pub(super) fn term_len(&self) -> usize {
        self.monomials.len() / self.sample_len
    }

    /// Returns true if an entry of W is learned; entries count by rows.
    pub(super) fn learns(&self, entry: usize) -> bool {
        match self.learned {
            Entries::None => false,
            Entries::Diagonal => entry / self.input_len == entry % self.input_len,
            Entries::All => true,
        }
    }

    /// Returns the product of W with each point of a list, d numbers per point.
    pub(super) fn measured(&self, metric: &[f64], points: &[f64]) -> Vec<f64> {
        let rows = || metric.chunks_exact(self.input_len);
        let points = points.chunks_exact(self.input_len);
        points.flat_map(|point| rows().map(|row| dot(row, point))).collect()
    }

    fn basis(&self, parameters: &Parameters) -> (Measured, Vec<f64>) {
        let e = parameters.metric.len() / self.input_len;
        let samples = self.measured(&parameters.metric, &self.inputs);
        let centres = self.measured(&parameters.metric, &parameters.centres);
        let mut basis = Vec::with_capacity(self.monomials.len() + self.sample_len);
        for centre in centres.chunks_exact(e) {
            let squared = samples.chunks_exact(e).map(|z| squared(z, centre.iter()));
            basis.extend(squared.map(|s| self.kernel.exact(s)));
        }
        basis.extend(&self.monomials);
        (Measured { samples, centres }, basis)
    }

    fn point(&self, parameters: Parameters, measured: Measured, basis: Vec<f64>) -> Point {
        let count = (basis.len() / self.sample_len).max(1);
        let mut residuals = self.values.clone();
        let of_values = residuals.chunks_exact_mut(self.sample_len);
        for (left, own) in of_values.zip(parameters.coefficients.chunks_exact(count)) {
            for (column, c) in basis.chunks_exact(self.sample_len).zip(own) {
                left.iter_mut().zip(column).for_each(|(left, value)| *left -= c * value);
            }
        }
        let coefficients = &parameters.coefficients;
        let energy = dot(&residuals, &residuals) + self.ridge * dot(coefficients, coefficients);
        Point { parameters, energy, measured, basis, residuals }
    }

    /// Adds `left rightᵀ` to the learned entries of a matrix like W.
    fn add_outer(&self, matrix: &mut [f64], left: &[f64], right: &[f64]) {
        for (r, (row, left)) in matrix.chunks_exact_mut(self.input_len).zip(left).enumerate() {
            match self.learned {
                Entries::None => {}
                Entries::Diagonal => {
                    if let (Some(entry), Some(right)) = (row.get_mut(r), right.get(r)) {
                        *entry += left * right;
                    }
                }
                Entries::All => row.iter_mut().zip(right).for_each(|(w, right)| *w += left * right),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::options::{Method, Metric, Start};
    use super::*;
    use faer::Mat;

    const CENTRES: usize = 4;

    fn wave(k: usize) -> f64 {
        (0.37 * (k * k + k) as f64 + 0.1).sin()
    }

    /// Returns the energy of 15 samples with 3 inputs and 2 values.
    fn energy(kernel: Kernel, learned: Entries) -> Energy {
        let options = Options {
            kernel,
            centres: CENTRES,
            degree: Some(1),
            ridge: 1e-3,
            metric: Metric { start: Mat::zeros(2, 3), learned },
            start: Start::Random,
            method: Method::VariableProjection,
            seeds: Vec::new(),
            evaluations: 0,
        };
        let sites = Mat::from_fn(15, 3, |r, c| 2.0 * wave(3 * r + c) + 5.0);
        let values = Mat::from_fn(15, 2, |r, c| wave(2 * r + c + 50));
        let (shift, scale) = ([5.0; 3], [0.5, 0.7, 0.6]);
        Energy::new(sites.as_ref(), values.as_ref(), &shift, &scale, &options).unwrap()
    }

    fn parameters() -> Parameters {
        let list = |from: usize, len: usize| (from..from + len).map(wave).collect();
        Parameters {
            centres: list(100, CENTRES * 3),
            metric: list(120, 2 * 3),
            coefficients: list(130, 2 * (CENTRES + 4)),
        }
    }

    /// Lists all parameters in turn.
    fn entries(parameters: &mut Parameters) -> impl Iterator<Item = &mut f64> {
        let Parameters { centres, metric, coefficients } = parameters;
        centres.iter_mut().chain(metric).chain(coefficients)
    }

    /// Compares with central differences, to 1e-6 of the largest.
    fn compare(
        kernel: Kernel,
        at: &Parameters,
        gradient: &mut Parameters,
        value: impl Fn(Parameters) -> f64,
    ) {
        const STEP: f64 = 1e-6;
        let found: Vec<f64> = entries(gradient).map(|g| *g).collect();
        let largest = found.iter().fold(0.0, |a, b| b.abs().max(a));
        for (k, found) in found.into_iter().enumerate() {
            let moved = |step: f64| {
                let mut at = at.clone();
                entries(&mut at).nth(k).into_iter().for_each(|x| *x += step);
                value(at)
            };
            let expected = (moved(STEP) - moved(-STEP)) / (2.0 * STEP);
            assert!(
                (found - expected).abs() < 1e-6 * largest,
                "{kernel:?} {k}: {found} {expected}"
            );
        }
    }

    #[test]
    fn the_gradient_is_that_of_the_energy() {
        for kernel in Kernel::ALL {
            let energy = energy(kernel, Entries::All);
            let at = parameters();
            let mut gradient = energy.gradient(&energy.at(at.clone()));
            compare(kernel, &at, &mut gradient, |at| energy.at(at).energy);
        }
    }

    #[test]
    fn at_an_infinite_slope_the_gradient_is_the_middle() {
        for kernel in [Kernel::Linear, Kernel::Matern12, Kernel::ThinPlate] {
            let energy = energy(kernel, Entries::All);
            let mut at = parameters();
            at.centres[..3].copy_from_slice(energy.input(6));
            let mut gradient = energy.gradient(&energy.at(at.clone()));
            compare(kernel, &at, &mut gradient, |at| energy.at(at).energy);
        }
    }

    #[test]
    fn the_gradient_at_solved_coefficients_is_that_of_the_least_energy() {
        for kernel in Kernel::ALL {
            let energy = energy(kernel, Entries::All);
            let solved = energy.solved(parameters());
            let mut gradient = energy.gradient(&solved);
            assert!(gradient.coefficients.iter().all(|g| g.abs() < 1e-10), "{kernel:?}");
            gradient.coefficients.clear();
            let at = Parameters { coefficients: Vec::new(), ..parameters() };
            compare(kernel, &at, &mut gradient, |at| energy.solved(at).energy);
        }
    }

    #[test]
    fn entries_that_are_not_learned_have_no_gradient() {
        let of = |learned| {
            let energy = energy(Kernel::Gaussian, learned);
            energy.gradient(&energy.at(parameters()))
        };
        let [none, diagonal, all] = [Entries::None, Entries::Diagonal, Entries::All].map(of);
        assert_eq!(none.metric, [0.0; 6]);
        let [a, _, _, _, b, _] = all.metric[..] else { panic!("W is 2 x 3") };
        assert!(a != 0.0 && b != 0.0);
        assert_eq!(diagonal.metric, [a, 0.0, 0.0, 0.0, b, 0.0]);
        assert!(none.centres == all.centres && none.coefficients == all.coefficients);
    }
}
