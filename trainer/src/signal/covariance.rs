//! Covariances of stationary processes, in f64 (METHOD §4): the correlation of two values as a function of their signed
//! distance. Families with parameters, and tables made positive definite.

use super::faults::check_positive;
use super::lags::Table;
use crate::Error;
use sinew_runtime::kernel::Kernel;

/// An even, positive definite function C of a signed distance d, with C(0) = 1.
#[derive(Clone, Debug, PartialEq)]
pub enum Covariance {
    /// `exp(-d²/2l²)`: infinitely differentiable.
    SquaredExponential {
        /// l.
        length: f64,
    },
    /// `exp(-|d|/l)`: continuous, not differentiable.
    OrnsteinUhlenbeck {
        /// l.
        length: f64,
    },
    /// `(1 + a) exp(-a)`, `a = √3 |d|/l`: once differentiable.
    Matern32 {
        /// l.
        length: f64,
    },
    /// `(1 + a + a²/3) exp(-a)`, `a = √5 |d|/l`: twice differentiable.
    Matern52 {
        /// l.
        length: f64,
    },
    /// `exp(-(d/l)²) cos(2π d/T)`.
    Oscillating {
        /// l.
        length: f64,
        /// T.
        period: f64,
    },
    /// Values at even distances, interpolated linearly.
    Table(Table),
}

/// Use of a covariance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// A signal.
    Signal,
    /// An image.
    Image,
    /// Observations of a function.
    Observations,
}

impl Subject {
    /// Returns the error of an unknown covariance.
    fn unknown(self, found: &str) -> Error {
        let (named, others) = match self {
            Self::Signal => ("", "auto, estimated, a table (.csv), or"),
            Self::Image => (" for an image", "auto, a table (.csv), or"),
            Self::Observations => (" for observations", "auto, or"),
        };
        Error::value(format!(
            "there is no covariance \"{found}\"{named}: expected {others} squared exponential, ornstein-uhlenbeck, matern \
             3/2 or matern 5/2 with a length, oscillating with a length and a period, as \"matern 3/2:4\" or \
             \"oscillating:8,3\""
        ))
    }
}

impl Covariance {
    /// Evaluates C(d).
    pub fn value(&self, d: f64) -> f64 {
        match self {
            Self::SquaredExponential { length } => libm::exp(-0.5 * (d / length) * (d / length)),
            Self::OrnsteinUhlenbeck { length } => libm::exp(-d.abs() / length),
            Self::Matern32 { length } => {
                let a = 3.0f64.sqrt() * d.abs() / length;
                (1.0 + a) * libm::exp(-a)
            }
            Self::Matern52 { length } => {
                let a = 5.0f64.sqrt() * d.abs() / length;
                (1.0 + a + a * a / 3.0) * libm::exp(-a)
            }
            Self::Oscillating { length, period } => {
                libm::exp(-(d / length) * (d / length)) * libm::cos(turns(d, *period))
            }
            Self::Table(table) => table.value(d),
        }
    }

    /// Evaluates dC/dd, an odd function; NaN unless [`Self::is_smooth`].
    pub fn slope(&self, d: f64) -> f64 {
        match self {
            Self::SquaredExponential { length } => -d / (length * length) * self.value(d),
            Self::Matern32 { length } => {
                let a = 3.0f64.sqrt() * d.abs() / length;
                -3.0 * d / (length * length) * libm::exp(-a)
            }
            Self::Matern52 { length } => {
                let a = 5.0f64.sqrt() * d.abs() / length;
                -5.0 / 3.0 * d / (length * length) * (1.0 + a) * libm::exp(-a)
            }
            Self::Oscillating { length, period } => {
                let (w, at) = (turns(1.0, *period), turns(d, *period));
                let falls = libm::exp(-(d / length) * (d / length));
                falls * (-2.0 * d / (length * length) * libm::cos(at) - w * libm::sin(at))
            }
            Self::OrnsteinUhlenbeck { .. } | Self::Table(_) => f64::NAN,
        }
    }

    /// Evaluates d²C/dd², an even function; NaN unless [`Self::is_smooth`].
    pub fn curvature(&self, d: f64) -> f64 {
        match self {
            Self::SquaredExponential { length } => {
                let square = length * length;
                (d * d / square - 1.0) / square * self.value(d)
            }
            Self::Matern32 { length } => {
                let a = 3.0f64.sqrt() * d.abs() / length;
                -3.0 / (length * length) * (1.0 - a) * libm::exp(-a)
            }
            Self::Matern52 { length } => {
                let a = 5.0f64.sqrt() * d.abs() / length;
                -5.0 / 3.0 / (length * length) * (1.0 + a - a * a) * libm::exp(-a)
            }
            Self::Oscillating { length, period } => {
                let (w, at, square) = (turns(1.0, *period), turns(d, *period), length * length);
                let falls = libm::exp(-d * d / square);
                let even = (4.0 * d * d / square - 2.0) / square - w * w;
                falls * (even * libm::cos(at) + 4.0 * d * w / square * libm::sin(at))
            }
            Self::OrnsteinUhlenbeck { .. } | Self::Table(_) => f64::NAN,
        }
    }

    /// Returns whether functions of this process have a derivative.
    pub const fn is_smooth(&self) -> bool {
        !matches!(self, Self::OrnsteinUhlenbeck { .. } | Self::Table(_))
    }

    /// Returns the piece length for quadrature: between multiples of this distance a polynomial of low degree fits C.
    pub(super) fn step(&self) -> f64 {
        match self {
            Self::SquaredExponential { length }
            | Self::OrnsteinUhlenbeck { length }
            | Self::Matern32 { length }
            | Self::Matern52 { length } => 0.5 * length,
            Self::Oscillating { length, period } => 0.25 * length.min(*period),
            Self::Table(table) => table.step,
        }
    }

    /// Returns the distance beyond which C is negligible in f64.
    pub(super) fn reach(&self) -> f64 {
        match self {
            Self::SquaredExponential { length } => 9.0 * length,
            Self::OrnsteinUhlenbeck { length } => 40.0 * length,
            Self::Matern32 { length } | Self::Matern52 { length } => 26.0 * length,
            Self::Oscillating { length, .. } => 6.5 * length,
            Self::Table(table) => table.reach(),
        }
    }

    /// Returns the matching kernel and its factor for distances; `None` if no kernel matches.
    pub fn kernel(&self) -> Option<(Kernel, f64)> {
        Some(match self {
            Self::SquaredExponential { length } => (Kernel::Gaussian, 0.5f64.sqrt() / length),
            Self::OrnsteinUhlenbeck { length } => (Kernel::Matern12, 1.0 / length),
            Self::Matern32 { length } => (Kernel::Matern32, 1.0 / length),
            Self::Matern52 { length } => (Kernel::Matern52, 1.0 / length),
            Self::Oscillating { .. } | Self::Table(_) => return None,
        })
    }

    /// Converts to another unit of distance, in which distances are `times` as large.
    pub fn scaled(&self, times: f64) -> Self {
        let mut out = self.clone();
        if let Self::Table(table) = &mut out {
            table.step *= times;
        }
        out.parameters().into_iter().for_each(|(_, number)| *number *= times);
        out
    }

    /// Returns the family's covariance of another length.
    pub(super) fn with_length(&self, length: f64) -> Self {
        let mut out = self.clone();
        out.parameters().into_iter().take(1).for_each(|(_, number)| *number = length);
        out
    }

    /// Lists the length and the period with their names; a table has none.
    fn parameters(&mut self) -> Vec<(&'static str, &mut f64)> {
        match self {
            Self::SquaredExponential { length }
            | Self::OrnsteinUhlenbeck { length }
            | Self::Matern32 { length }
            | Self::Matern52 { length } => vec![("length", length)],
            Self::Oscillating { length, period } => vec![("length", length), ("period", period)],
            Self::Table(_) => Vec::new(),
        }
    }

    /// Returns the family's name.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::SquaredExponential { .. } => "squared exponential",
            Self::OrnsteinUhlenbeck { .. } => "ornstein-uhlenbeck",
            Self::Matern32 { .. } => "matern 3/2",
            Self::Matern52 { .. } => "matern 5/2",
            Self::Oscillating { .. } => "oscillating",
            Self::Table(_) => "table",
        }
    }

    /// Formats the name and parameters for [`Self::parse`].
    pub fn describe(&self) -> String {
        let mut own = self.clone();
        let short = |(_, x): (_, &mut f64)| match (1e-2..1e6).contains(&*x) {
            true => format!("{x:.4}"),
            false => format!("{x:.4e}"),
        };
        let numbers: Vec<String> = own.parameters().into_iter().map(short).collect();
        let colon = if numbers.is_empty() { "" } else { ":" };
        self.name().to_owned() + colon + &numbers.join(",")
    }

    /// Parses a name with parameters: `matern 3/2:4`, `oscillating:8,3`.
    ///
    /// - `subject`: the covariance's use, for error messages.
    ///
    /// # Errors
    /// If the name is unknown, the parameters are wrong, or a length or period is not positive and finite.
    pub fn parse(text: &str, subject: Subject) -> Result<Self, Error> {
        let unknown = || subject.unknown(text);
        let (name, numbers) = text.split_once(':').ok_or_else(unknown)?;
        let numbers = numbers.split(',').map(|number| number.trim().parse());
        let numbers: Vec<f64> = numbers.collect::<Result<_, _>>().map_err(|_| unknown())?;
        Self::named(name.trim(), &numbers).ok_or_else(unknown)?.checked()
    }

    /// Creates a covariance from a name and parameters; `None` if the name or the number of parameters is wrong.
    pub(super) fn named(name: &str, numbers: &[f64]) -> Option<Self> {
        Some(match (name, numbers) {
            ("squared exponential" | "gaussian", &[length]) => Self::SquaredExponential { length },
            ("ornstein-uhlenbeck" | "matern 1/2", &[length]) => Self::OrnsteinUhlenbeck { length },
            ("matern 3/2", &[length]) => Self::Matern32 { length },
            ("matern 5/2", &[length]) => Self::Matern52 { length },
            ("oscillating", &[length, period]) => Self::Oscillating { length, period },
            _ => return None,
        })
    }

    /// Checks that lengths and periods are positive and finite.
    ///
    /// # Errors
    /// If a length or period is not.
    pub(super) fn checked(mut self) -> Result<Self, Error> {
        for (name, number) in self.parameters() {
            check_positive(name, *number)?;
        }
        Ok(self)
    }
}

/// Returns the phase at a distance, in radians.
fn turns(d: f64, period: f64) -> f64 {
    std::f64::consts::TAU * d / period
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::ErrorKind;

    /// Returns one covariance per family.
    pub(in crate::signal) fn families() -> Vec<Covariance> {
        let length = 1.3;
        let lags = [1.0, 0.5, 0.1, -0.2, -0.1];
        vec![
            Covariance::SquaredExponential { length },
            Covariance::OrnsteinUhlenbeck { length },
            Covariance::Matern32 { length },
            Covariance::Matern52 { length },
            Covariance::Oscillating { length: 3.0, period: 2.1 },
            Covariance::Table(Table::new(&lags, 0.7).unwrap().0),
        ]
    }

    #[test]
    fn every_family_is_one_at_zero_and_even_with_exact_derivatives() {
        for covariance in families() {
            assert!((covariance.value(0.0) - 1.0).abs() < 1e-15);
            for d in [0.2, 0.9, 2.3, 4.0] {
                assert_eq!(covariance.value(d), covariance.value(-d), "{covariance:?}");
                if !covariance.is_smooth() {
                    continue;
                }
                let h = 1e-5;
                let difference = |f: &dyn Fn(f64) -> f64| (f(d + h) - f(d - h)) / (2.0 * h);
                let slope = difference(&|d| covariance.value(d));
                assert!((slope - covariance.slope(d)).abs() < 1e-9, "{covariance:?} {d}");
                let curvature = difference(&|d| covariance.slope(d));
                assert!((curvature - covariance.curvature(d)).abs() < 1e-8, "{covariance:?} {d}");
                assert_eq!(covariance.slope(d), -covariance.slope(-d));
                assert_eq!(covariance.curvature(d), covariance.curvature(-d));
            }
        }
    }

    #[test]
    fn families_vanish_beyond_their_reach_and_scale_with_the_unit() {
        for covariance in families() {
            let reach = covariance.reach();
            assert!(covariance.value(1.001 * reach).abs() < 1e-15, "{covariance:?}");
            let scaled = covariance.scaled(3.0);
            assert!((scaled.value(2.7) - covariance.value(0.9)).abs() < 1e-14, "{covariance:?}");
            assert!((scaled.reach() - 3.0 * reach).abs() < 1e-9);
        }
    }

    #[test]
    fn descriptions_parse_back_and_unknown_names_are_refused() {
        for covariance in families().into_iter().take(5) {
            assert_eq!(
                Covariance::parse(&covariance.describe(), Subject::Signal).unwrap(),
                covariance
            );
        }
        let small = Covariance::Matern32 { length: 2.5e-7 };
        assert_eq!(Covariance::parse(&small.describe(), Subject::Signal).unwrap(), small);
        for text in ["matern 3/2", "matern:1", "oscillating:3", "matern 3/2:x", ""] {
            let error = Covariance::parse(text, Subject::Signal).unwrap_err();
            let expected = format!("there is no covariance \"{text}\": expected ");
            assert!(error.message().starts_with(&expected), "{error}");
        }
        for text in ["matern 3/2:0", "oscillating:1,-2", "gaussian:nan", "gaussian:inf"] {
            let error = Covariance::parse(text, Subject::Signal).unwrap_err();
            assert_eq!(error.kind(), ErrorKind::Value);
            assert!(
                error.message().contains(": expected a finite number above 0, found "),
                "{error}"
            );
        }
    }
}
