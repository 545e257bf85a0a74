//! Errors of a fit to scattered data.

use crate::regression::function::is_scale_invariant;
use sinew_runtime::kernel::Kernel;

/// Reasons why there is no fit; rows and columns count from 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum KernelError {
    /// There are no samples, no inputs, or no values.
    #[error("there are no {what}")]
    Empty {
        /// Samples, inputs or values.
        what: &'static str,
    },
    /// The numbers of sites and values differ.
    #[error("expected a row of values for each of {sites} sites, found {values}")]
    Rows {
        /// Number of sites.
        sites: usize,
        /// Number of rows of values.
        values: usize,
    },
    /// A number is infinite or not a number.
    #[error("{what} of row {row}, column {column} is not finite")]
    NotFinite {
        /// Site or value.
        what: &'static str,
        /// Row of the number.
        row: usize,
        /// Column of the number.
        column: usize,
    },
    /// The blocks have more or fewer columns than the sites.
    #[error("blocks of inputs have {blocks} columns, sites {columns}")]
    Blocks {
        /// Number of columns of all blocks.
        blocks: usize,
        /// Number of columns of the sites.
        columns: usize,
    },
    /// An option is out of its range.
    #[error("{what} is {found}, expected {expected}")]
    Option {
        /// Name of the option.
        what: &'static str,
        /// Value of the option.
        found: f64,
        /// Allowed values.
        expected: &'static str,
    },
    /// Two samples of one site have different values.
    #[error("rows {first} and {second} have {} and different values", same_site(*distance))]
    Conflict {
        /// Row of the earlier sample.
        first: usize,
        /// Row of the later sample.
        second: usize,
        /// Distance of their sites, over the mean distance.
        distance: f64,
    },
    /// No fit solves with the kernel.
    #[error("no fit solves with the kernel \"{}\": it is for imports", .0.name())]
    ImportOnly(Kernel),
    /// The degree of the polynomials is below the kernel's order.
    #[error(
        "the kernel \"{}\" needs polynomials of degree {least} or more{}",
        kernel.name(),
        asked.map_or(", found none".into(), |asked| format!(", found degree {asked}"))
    )]
    Degree {
        /// Kernel of the fit.
        kernel: Kernel,
        /// Degree in the options.
        asked: Option<usize>,
        /// Least degree of the kernel.
        least: usize,
    },
    /// A centre is not a sample, or occurs twice.
    #[error("centre {centre} is not one of {samples} samples, or is given twice")]
    Centre {
        /// Index of the centre.
        centre: usize,
        /// Number of samples after merging.
        samples: usize,
    },
    /// Rounding errors would determine the function.
    #[error(
        "the fit is ill-conditioned ({}{}): smooth more, take a narrower kernel or fewer centres",
        described(*rcond),
        match *missed > 0.0 {
            true if missed.is_finite() => format!(", samples missed by {missed:.1e} of their range"),
            true => ", numbers beyond f64".to_owned(),
            false => String::new(),
        }
    )]
    IllConditioned {
        /// Reciprocal condition of the system.
        rcond: f64,
        /// Largest residual of the equations, over the range of the values; 0 for least squares.
        missed: f64,
    },
    /// The deviation of a file from the function is too large.
    #[error(
        "in single precision the function is off by {deviation:.1e} of its values' range, more than \
         {limit:.1e}: {cause}, or allow it by --f32-error"
    )]
    Deviation {
        /// Largest measured deviation, over the range.
        deviation: f64,
        /// Largest allowed deviation.
        limit: f64,
        /// Cause of the deviation.
        cause: DeviationCause,
    },
    /// The smoothing is free, and no candidate can predict samples that it has not seen.
    #[error(
        "no smoothing can be chosen: it takes samples that the others predict, and there are too few (or too few \
         groups); give `smoothing` a number"
    )]
    NoChoice,
}

/// Describes the distance of two sites that count as the same site.
pub fn same_site(distance: f64) -> String {
    match distance > 0.0 {
        true => format!("sites that are {distance:.1e} of the mean distance apart"),
        false => "the same site".to_owned(),
    }
}

impl KernelError {
    /// Returns true if another width or another kernel may fit.
    pub fn is_caused_by_kernel(&self) -> bool {
        let of_kernel =
            matches!(self, Self::Deviation { cause: DeviationCause::Kernel { .. }, .. });
        of_kernel || matches!(self, Self::IllConditioned { .. })
    }
}

/// Cause of a file's deviation; its text is the remedy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DeviationCause {
    /// Rounding an input to f32 exceeds the limit.
    #[error(
        "take the offset off the input \"{name}\" (numbers up to {largest:.3e} do not fit single precision)"
    )]
    Input {
        /// Name of the input.
        name: String,
        /// Largest number of the input.
        largest: f64,
    },
    /// Rounding a value to f32 exceeds the limit.
    #[error(
        "take the offset off the values (numbers up to {largest:.3e} with a range of {range:.3e} do not fit \
         single precision)"
    )]
    Values {
        /// Largest value.
        largest: f64,
        /// Range of the value.
        range: f64,
    },
    /// The kernels are too wide or too smooth.
    #[error(
        "take {}{}a rougher kernel, smooth more, take fewer centres",
        other.as_ref().map_or(String::new(), |other| format!("{other}, which fits, or ")),
        match is_scale_invariant(*kernel) {
            true => "",
            false => "a narrower kernel (a larger epsilon, a shorter length) or ",
        }
    )]
    Kernel {
        /// Kernel of the fit.
        kernel: Kernel,
        /// Options that fit, if they are known.
        other: Option<String>,
    },
}

/// Formats a reciprocal condition for error messages. Below f64's precision no digit is known.
pub(crate) fn described(rcond: f64) -> String {
    if rcond < f64::EPSILON {
        format!("reciprocal condition below {:.0e}", f64::EPSILON)
    } else {
        format!("reciprocal condition {rcond:.1e}")
    }
}

#[cfg(test)]
mod tests {
    use super::described;

    #[test]
    fn conditions_below_f64_precision_are_named_so() {
        assert_eq!(described(3.4e-9), "reciprocal condition 3.4e-9");
        for rcond in [0.0, 1e-17] {
            assert_eq!(described(rcond), "reciprocal condition below 2e-16");
        }
    }
}
