//! Observations of a function as a person writes them, and the function.

use super::choose::likeliest_of;
use super::covariance::Covariance;
use super::error::SignalError;
use super::functional::Functional;
use super::kriging::{Kriging, Process};
use super::mean::Mean;
use crate::formats::FormatError;
use crate::formats::extension::{extension, unknown_format};
use serde::Deserialize;
use std::path::Path;

/// Families that a part kernel can be, of values alone.
const OF_VALUES: [&str; 4] =
    ["ornstein-uhlenbeck", "matern 3/2", "matern 5/2", "squared exponential"];
/// Those that it can be of derivatives and averages too.
const OF_ANY: [&str; 1] = ["squared exponential"];

/// Observations of one function, and what it is thought to be.
#[derive(Clone, Debug)]
pub struct Observations {
    /// The function's name.
    pub name: String,
    /// What it is thought to be.
    pub process: Process,
    /// The variance of the process, where it is known.
    pub variance: Option<f64>,
    /// What is observed, n.
    pub functionals: Vec<Functional>,
    /// What was found, n.
    pub values: Vec<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    name: Option<String>,
    covariance: Option<String>,
    #[serde(default)]
    mean: Mean,
    #[serde(default)]
    noise: f64,
    variance: Option<f64>,
    observations: Vec<WrittenObservation>,
}

#[derive(Deserialize)]
#[serde(untagged, deny_unknown_fields)]
enum WrittenObservation {
    Value { at: f64, value: f64 },
    Derivative { at: f64, derivative: f64 },
    Average { from: f64, to: f64, average: f64 },
}

impl Observations {
    /// Reads JSON: `observations`, each `{"at": x, "value": y}`, `{"at": x, "derivative": y}` or `{"from": a, "to": b,
    /// "average": y}`, and, where they are given, `name`, `covariance`, `mean`, `noise` and `variance`.
    ///
    /// # Errors
    /// [`SignalError::Format`], [`SignalError::Json`], [`SignalError::Empty`], and those of [`Covariance::parse`].
    pub fn read(path: &Path) -> Result<Self, SignalError> {
        if extension(path) != "json" {
            return Err(unknown_format(path, ".json").into());
        }
        let text = std::fs::read(path).map_err(FormatError::Read)?;
        let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
        Self::parse(&text, &stem.unwrap_or_default())
    }

    /// Reads the same of bytes; the name where they have none.
    ///
    /// # Errors
    /// Likewise.
    pub fn parse(text: &[u8], name: &str) -> Result<Self, SignalError> {
        let Written { name: own, covariance, mean, noise, variance, observations } =
            serde_json::from_slice(text)?;
        if observations.is_empty() {
            return Err(SignalError::Empty);
        }
        let (functionals, values): (Vec<_>, Vec<_>) =
            observations.iter().map(WrittenObservation::read).unzip();
        let covariance = match covariance.as_deref() {
            None | Some("auto") => {
                let is_value = |of: &Functional| matches!(of, Functional::Value { .. });
                let only_values = functionals.iter().all(is_value);
                let names: &[&str] = if only_values { &OF_VALUES } else { &OF_ANY };
                likeliest_of(&functionals, &values, names)
            }
            Some(text) => Covariance::parse(text)?,
        };
        let process = Process { covariance, mean, noise };
        let name = own.unwrap_or_else(|| name.to_owned());
        Ok(Self { name, process, variance, functionals, values })
    }

    /// Fits the function.
    ///
    /// # Errors
    /// Those of [`Kriging::new`].
    pub fn fit(&self) -> Result<Kriging, SignalError> {
        Kriging::new(&self.process, &self.functionals, &self.values)
    }

    /// Returns the variance of the process: that which is given, or the likeliest.
    pub fn variance(&self, fit: &Kriging) -> f64 {
        self.variance.unwrap_or_else(|| fit.variance())
    }
}

impl WrittenObservation {
    fn read(&self) -> (Functional, f64) {
        match *self {
            Self::Value { at, value } => (Functional::Value { at }, value),
            Self::Derivative { at, derivative } => (Functional::Derivative { at }, derivative),
            Self::Average { from, to, average } => (Functional::Average { from, to }, average),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(text: &str) -> String {
        Observations::parse(text.as_bytes(), "f").and_then(|of| of.fit()).err().unwrap().to_string()
    }

    #[test]
    fn values_derivatives_and_averages_are_read() {
        let text = br#"{"covariance": "matern 5/2:2", "mean": "linear", "observations": [
            {"at": 0, "value": 1}, {"at": 1, "derivative": -2}, {"from": 2, "to": 3, "average": 0.5}]}"#;
        let read = Observations::parse(text, "f").unwrap();
        assert_eq!(read.process.covariance, Covariance::Matern52 { length: 2.0 });
        assert_eq!((read.process.mean, read.values.clone()), (Mean::Linear, vec![1.0, -2.0, 0.5]));
        assert_eq!(read.functionals[2], Functional::Average { from: 2.0, to: 3.0 });
        let fit = read.fit().unwrap();
        assert!((fit.predict(&Functional::Derivative { at: 1.0 }).value + 2.0).abs() < 1e-10);
    }

    #[test]
    fn what_is_wrong_is_named() {
        let of =
            |rest: &str| format!("{{\"covariance\": \"matern 1/2:1\", \"observations\": {rest}}}");
        assert_eq!(said(&of("[]")), "there are no observations");
        let empty = said(&of(r#"[{"from": 1, "to": 1, "average": 2}]"#));
        assert_eq!(empty, "observation 0: expected `from` below `to`");
        let rough = said(&of(r#"[{"at": 0, "value": 1}, {"at": 0, "derivative": 1}]"#));
        assert!(
            rough.starts_with("observation 1: functions of covariance ornstein-uhlenbeck"),
            "{rough}"
        );
        assert!(
            said(&of(r#"[{"at": 0}]"#)).contains("did not match"),
            "{}",
            said(&of(r#"[{"at": 0}]"#))
        );
        let twice = said(&of(r#"[{"at": 0, "value": 1}, {"at": 0, "value": 2}]"#));
        assert!(twice.contains("take a shorter length") || twice.contains("definite"), "{twice}");
        let unknown = said(r#"{"covariance": "cubic:1", "observations": [{"at": 0, "value": 1}]}"#);
        assert!(unknown.starts_with("there is no covariance \"cubic:1\""), "{unknown}");
    }

    #[test]
    fn one_observation_makes_a_constant() {
        let read =
            Observations::parse(br#"{"observations": [{"at": 2, "value": 7}]}"#, "f").unwrap();
        let found = read.fit().unwrap().predict(&Functional::Value { at: 50.0 });
        assert!((found.value - 7.0).abs() < 1e-12);
    }
}
