//! Why scattered data gave no function.

use super::system::described;
use crate::regression::function::is_scale_invariant;
use sinew_runtime::kernel::Kernel;

/// Scattered data that no function was fitted to; rows and columns count from 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum KernelError {
    /// There are no samples, no inputs, or no values.
    #[error("there are no {what}")]
    Empty {
        /// What there is none of.
        what: &'static str,
    },
    /// Sites and values are not as many.
    #[error("expected a row of values for each of {sites} sites, found {values}")]
    Rows {
        /// Rows of the sites.
        sites: usize,
        /// Rows of the values.
        values: usize,
    },
    /// A number is infinite or not a number.
    #[error("{what} of row {row}, column {column} is not finite")]
    NotFinite {
        /// A site or a value.
        what: &'static str,
        /// Its row.
        row: usize,
        /// Its column.
        column: usize,
    },
    /// Blocks of inputs do not make up a site.
    #[error("blocks of inputs have {blocks} columns, sites {columns}")]
    Blocks {
        /// Columns of all blocks.
        blocks: usize,
        /// Columns of the sites.
        columns: usize,
    },
    /// A number that was asked for is out of its range.
    #[error("{what} is {found}, expected {expected}")]
    Option {
        /// Which one.
        what: &'static str,
        /// What it is.
        found: f64,
        /// What it may be.
        expected: &'static str,
    },
    /// Two samples at one place have different values.
    #[error("rows {first} and {second} have {} and different values", same_site(*distance))]
    Conflict {
        /// The earlier row.
        first: usize,
        /// The later row.
        second: usize,
        /// Distance of their sites, over the mean distance.
        distance: f64,
    },
    /// No fit solves with the kernel.
    #[error("no fit solves with the kernel \"{}\": it is for imports", .0.name())]
    ImportOnly(Kernel),
    /// The polynomials fall short of the kernel's order.
    #[error(
        "the kernel \"{}\" needs polynomials of degree {least} or more{}",
        kernel.name(),
        asked.map_or(", found none".into(), |asked| format!(", found degree {asked}"))
    )]
    Degree {
        /// The kernel.
        kernel: Kernel,
        /// The degree asked for.
        asked: Option<usize>,
        /// The least one.
        least: usize,
    },
    /// A centre is not a sample.
    #[error("centre {centre} is not one of {samples} samples, or is there twice")]
    Centre {
        /// The centre.
        centre: usize,
        /// Samples after merging.
        samples: usize,
    },
    /// Rounding decides what the function is.
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
        /// By how much its equations are missed, over the range of the values; 0 of least squares.
        missed: f64,
    },
    /// A file's numbers are too far from the function.
    #[error(
        "in single precision the function is off by {deviation:.1e} of its values' range, more than \
         {limit:.1e}: {cause}, or allow it by --f32-error"
    )]
    Deviation {
        /// The largest deviation that was measured, over the range.
        deviation: f64,
        /// What is allowed.
        limit: f64,
        /// What it comes from.
        cause: DeviationCause,
    },
    /// A smoothing is to be chosen, and no candidate can predict samples that it has not seen.
    #[error(
        "no smoothing can be chosen: it takes samples that the others predict, and there are too few (or too few \
         groups); give `smoothing` a number"
    )]
    NoChoice,
}

/// Says how near two sites are that count as one.
pub fn same_site(distance: f64) -> String {
    match distance > 0.0 {
        true => format!("sites that are {distance:.1e} of the mean distance apart"),
        false => "the same site".to_owned(),
    }
}

impl KernelError {
    /// Returns true if another width or another kernel may fit.
    pub fn is_of_width(&self) -> bool {
        let of_kernel =
            matches!(self, Self::Deviation { cause: DeviationCause::Kernel { .. }, .. });
        of_kernel || matches!(self, Self::IllConditioned { .. })
    }
}

/// Cause of a file's deviation; written as its remedy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DeviationCause {
    /// f32 rounds an input by more than the limit allows.
    #[error(
        "take the offset off the input \"{name}\" (numbers up to {largest:.3e} do not fit single precision)"
    )]
    Input {
        /// The input.
        name: String,
        /// Its largest number.
        largest: f64,
    },
    /// f32 rounds a value by more than the limit allows.
    #[error(
        "take the offset off the values (numbers up to {largest:.3e} with a range of {range:.3e} do not fit \
         single precision)"
    )]
    Values {
        /// The largest value.
        largest: f64,
        /// Its range.
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
        /// The kernel.
        kernel: Kernel,
        /// Options that do fit, where they are known.
        other: Option<String>,
    },
}
