//! Options of a fit.

use crate::Error;
use crate::regression::function::order;
use sinew_runtime::kernel::Kernel;

/// Options of a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Kernel G.
    pub kernel: Kernel,
    /// Reciprocal of the width, in distances whose mean is 1.
    pub epsilon: f64,
    /// Smoothing λ, on the kernel matrix's diagonal; 0 interpolates.
    pub smoothing: f64,
    /// Degree of the polynomial; `None` for no polynomial.
    pub degree: Option<usize>,
    /// Largest number of centres, for least squares. `None`, or the number of samples or more, makes every sample a
    /// centre.
    pub centres: Option<usize>,
}

impl Options {
    /// Makes options that interpolate: a width of the mean distance, and the least polynomial that the kernel allows,
    /// but at least a constant.
    pub fn new(kernel: Kernel) -> Self {
        let degree = Some(order(kernel).unwrap_or(0).saturating_sub(1));
        Self { kernel, epsilon: 1.0, smoothing: 0.0, degree, centres: None }
    }

    /// Checks that a fit with these options is possible.
    ///
    /// # Errors
    /// If no fit solves with the kernel, epsilon is not positive, the smoothing is negative, or the degree is below the
    /// kernel's order.
    pub fn check(&self) -> Result<(), Error> {
        let Self { kernel, epsilon, smoothing, degree, .. } = *self;
        let name = kernel.name();
        let import_only = || {
            let message = format!("no fit solves with the kernel \"{name}\": it is for imports");
            Error::unsupported(message)
        };
        let order = order(kernel).ok_or_else(import_only)?;
        if !(epsilon > 0.0 && epsilon.is_finite()) {
            return Err(out_of_range("epsilon", epsilon, "a finite number above 0"));
        }
        if !(smoothing >= 0.0 && smoothing.is_finite()) {
            let expected = "a finite number that is not negative";
            return Err(out_of_range("the smoothing", smoothing, expected));
        }
        if degree.map_or(0, |degree| degree + 1) < order {
            let found = degree.map_or("none".to_owned(), |degree| format!("degree {degree}"));
            let least = order - 1;
            return Err(Error::value(format!(
                "the kernel \"{name}\" needs polynomials of degree {least} or more, found {found}"
            )));
        }
        Ok(())
    }
}

/// Returns the error of a number that is out of its range.
pub(crate) fn out_of_range(what: &str, found: f64, expected: &str) -> Error {
    Error::value(format!("{what} is {found}, expected {expected}"))
}

/// Returns the Wendland kernel that is positive definite in `inputs` dimensions; `None` if there are too many.
pub fn wendland(inputs: usize) -> Option<Kernel> {
    Kernel::from_number(12, u8::try_from(inputs / 2 + 2).ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ErrorKind;

    #[test]
    fn every_kernel_except_hats_has_valid_options() {
        for kernel in Kernel::ALL {
            let found = Options::new(kernel).check().map_err(|error| error.to_string());
            let name = kernel.name();
            let import_only =
                format!("no fit solves with the kernel \"{name}\": it is for imports");
            let is_hat = matches!(kernel, Kernel::Hat { .. });
            assert_eq!(found, if is_hat { Err(import_only) } else { Ok(()) });
        }
    }

    #[test]
    fn options_out_of_range_are_named() {
        let good = Options::new(Kernel::ThinPlate);
        for (bad, what) in [
            (Options { epsilon: 0.0, ..good }, "epsilon is 0, expected "),
            (Options { epsilon: f64::INFINITY, ..good }, "epsilon is inf, expected "),
            (Options { smoothing: -1e-9, ..good }, "the smoothing is -0.000000001, expected "),
            (Options { smoothing: f64::NAN, ..good }, "the smoothing is NaN, expected "),
        ] {
            let error = bad.check().unwrap_err();
            assert!(error.message().starts_with(what), "{error}");
            assert_eq!(error.kind(), ErrorKind::Value);
        }
        for (degree, found) in [(None, "none"), (Some(0), "degree 0")] {
            let error = Options { degree, ..good }.check().unwrap_err();
            let name = Kernel::ThinPlate.name();
            let expected = format!(
                "the kernel \"{name}\" needs polynomials of degree 1 or more, found {found}"
            );
            assert_eq!(error.to_string(), expected);
        }
        assert!(Options { degree: None, ..Options::new(Kernel::Gaussian) }.check().is_ok());
    }

    #[test]
    fn wendlands_kernel_grows_with_the_inputs() {
        assert_eq!(wendland(3), Some(Kernel::Wendland { l: 3 }));
        assert_eq!(wendland(4), Some(Kernel::Wendland { l: 4 }));
        assert_eq!(wendland(1000), None);
    }
}
