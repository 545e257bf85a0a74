//! Options of a fit.

use super::error::KernelError;
use super::polynomial::RANK_F64;
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
    /// Share of a column below which a polynomial is rounding: [`RANK_F64`], or [`super::polynomial::RANK_F32`] for
    /// sites that were f32.
    pub rank: f64,
}

impl Options {
    /// Makes options that interpolate: a width of the mean distance, and the least polynomial that the kernel allows,
    /// but at least a constant.
    pub fn new(kernel: Kernel) -> Self {
        let degree = Some(order(kernel).unwrap_or(0).saturating_sub(1));
        Self { kernel, epsilon: 1.0, smoothing: 0.0, degree, centres: None, rank: RANK_F64 }
    }

    /// Checks that a fit with these options is possible.
    ///
    /// # Errors
    /// If no fit solves with the kernel, epsilon is not positive, the smoothing is negative, or the degree is below the
    /// kernel's order.
    pub fn check(&self) -> Result<(), KernelError> {
        let Self { kernel, epsilon, smoothing, degree, .. } = *self;
        let order = order(kernel).ok_or(KernelError::ImportOnly(kernel))?;
        if !(epsilon > 0.0 && epsilon.is_finite()) {
            let (what, expected) = ("epsilon", "a finite number above 0");
            return Err(KernelError::Option { what, found: epsilon, expected });
        }
        if !(smoothing >= 0.0 && smoothing.is_finite()) {
            let (what, expected) = ("the smoothing", "a finite number that is not negative");
            return Err(KernelError::Option { what, found: smoothing, expected });
        }
        if degree.map_or(0, |degree| degree + 1) < order {
            return Err(KernelError::Degree { kernel, asked: degree, least: order - 1 });
        }
        Ok(())
    }
}

/// Returns the Wendland kernel that is positive definite in `inputs` dimensions; `None` if there are too many.
pub fn wendland(inputs: usize) -> Option<Kernel> {
    Kernel::from_number(12, u8::try_from(inputs / 2 + 2).ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kernel_except_hats_has_valid_options() {
        for kernel in Kernel::ALL {
            let found = Options::new(kernel).check();
            let import_only = matches!(kernel, Kernel::Hat { .. });
            assert_eq!(
                found,
                if import_only { Err(KernelError::ImportOnly(kernel)) } else { Ok(()) }
            );
        }
    }

    #[test]
    fn options_out_of_range_are_named() {
        let good = Options::new(Kernel::ThinPlate);
        for bad in [
            Options { epsilon: 0.0, ..good },
            Options { epsilon: f64::INFINITY, ..good },
            Options { smoothing: -1e-9, ..good },
            Options { smoothing: f64::NAN, ..good },
        ] {
            assert!(matches!(bad.check(), Err(KernelError::Option { .. })));
        }
        for asked in [None, Some(0)] {
            let expected = KernelError::Degree { kernel: Kernel::ThinPlate, asked, least: 1 };
            assert_eq!(Options { degree: asked, ..good }.check(), Err(expected));
        }
        assert_eq!(Options { degree: None, ..Options::new(Kernel::Gaussian) }.check(), Ok(()));
    }

    #[test]
    fn wendlands_kernel_grows_with_the_inputs() {
        assert_eq!(wendland(3), Some(Kernel::Wendland { l: 3 }));
        assert_eq!(wendland(4), Some(Kernel::Wendland { l: 4 }));
        assert_eq!(wendland(1000), None);
    }
}
