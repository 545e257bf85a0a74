//! Observations of a function as a person writes them, and the function.

use super::choose::{likeliest_of, unit};
use super::covariance::Covariance;
use super::error::{SignalError, Subject, Told};
use super::functional::Functional;
use super::kriging::{Kriging, Process, check};
use super::mean::Mean;
use super::sum::{exact, probe, sum};
use crate::formats::FormatError;
use crate::formats::extension::{extension, unknown_format};
use crate::formats::json;
use crate::kernel::deviation::{F32_ERROR, ROOM};
use serde::Deserialize;
use serde_json::Value;
use std::path::Path;

/// Two observations of one thing agree within this share of their magnitude: a few units in the last place of f32.
const AGREE: f64 = 1e-6;

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
    /// Largest deviation of the file, over the function's range.
    pub f32_error: f64,
    /// The number of each as it is written, n: those that say nothing new are left out.
    pub numbers: Vec<usize>,
    /// How many say nothing new.
    pub repeated: usize,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object with `observations`")]
struct Written {
    name: Option<String>,
    covariance: Option<String>,
    #[serde(default)]
    mean: Mean,
    #[serde(default)]
    noise: f64,
    variance: Option<f64>,
    f32_error: Option<f64>,
    observations: Vec<Value>,
}

impl Observations {
    /// Reads JSON: `observations`, each `{"at": x, "value": y}`, `{"at": x, "derivative": y}` or `{"from": a, "to": b,
    /// "average": y}`, and, where they are given, `name`, `covariance`, `mean`, `noise`, `variance` and `f32_error`.
    ///
    /// - `f32_error`: the largest deviation of the baked file, over the function's range; replaces the one in the JSON.
    ///
    /// # Errors
    /// [`SignalError::Format`], [`SignalError::Json`], [`SignalError::Empty`], [`SignalError::Written`],
    /// [`SignalError::Contradiction`], and those of [`Covariance::parse`].
    pub fn read(path: &Path, f32_error: Option<f64>) -> Result<Self, SignalError> {
        if extension(path) != "json" {
            return Err(unknown_format(path, ".json").into());
        }
        let text = std::fs::read(path).map_err(FormatError::Read)?;
        let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
        Self::parse(&text, &stem.unwrap_or_default(), f32_error)
    }

    /// Reads the same of bytes; the name where they have none.
    ///
    /// # Errors
    /// Likewise.
    pub fn parse(text: &[u8], name: &str, f32_error: Option<f64>) -> Result<Self, SignalError> {
        let Written {
            name: own,
            covariance,
            mean,
            noise,
            variance,
            f32_error: written,
            observations,
        } = json::read(text)?;
        let read = observations.iter().enumerate().map(|(at, of)| observation(at, of));
        let all = read.collect::<Result<Vec<_>, _>>()?;
        let (functionals, values): (Vec<_>, Vec<_>) = all.into_iter().unzip();
        let given = match covariance.as_deref() {
            None | Some("auto") => None,
            Some(text) => Some(Covariance::parse(text, Subject::Observations)?),
        };
        // Until it is chosen: one that has derivatives.
        let first = Covariance::SquaredExponential { length: unit(&functionals) };
        let process = Process { covariance: given.clone().unwrap_or(first), mean, noise };
        process.check()?;
        check(&process, &functionals, &values)?;
        let numbers = news(&functionals, &values, noise)?;
        let mut out = Self {
            name: own.unwrap_or_else(|| name.to_owned()),
            process,
            variance,
            functionals: numbers.iter().map(|&at| functionals[at]).collect(),
            values: numbers.iter().map(|&at| values[at]).collect(),
            f32_error: f32_error.or(written).unwrap_or(F32_ERROR),
            repeated: values.len() - numbers.len(),
            numbers,
        };
        if given.is_none() {
            out.choose();
        }
        Ok(out)
    }

    /// Takes the likeliest covariance whose function can be solved for, and whose file is near it.
    fn choose(&mut self) {
        let is_value = |of: &Functional| matches!(of, Functional::Value { .. });
        let only_values = self.functionals.iter().all(is_value);
        let names: &[&str] = if only_values { &OF_VALUES } else { &OF_ANY };
        let likeliest = |room: f64| {
            let sound = |covariance: &Covariance| {
                let process = Process { covariance: covariance.clone(), ..self.process.clone() };
                self.deviation(&process).is_ok_and(|deviation| deviation <= room * self.f32_error)
            };
            likeliest_of(&self.functionals, &self.values, names, sound)
        };
        if let Some(covariance) = likeliest(ROOM).or_else(|| likeliest(1.0)) {
            self.process.covariance = covariance;
        }
    }

    /// Measures by how much the file of a process' function is off, over the function's range.
    fn deviation(&self, process: &Process) -> Result<f64, SignalError> {
        let fit = Kriging::new(process, &self.functionals, &self.values)?;
        let sum = sum(process, &self.functionals, &self.numbers, &fit)?;
        Ok(probe(&self.functionals, &fit, self.f32_error)?.deviation(&sum, exact(&fit)))
    }

    /// Fits the function.
    ///
    /// # Errors
    /// Those of [`Kriging::new`].
    pub fn fit(&self) -> Result<Kriging, SignalError> {
        let found = Kriging::new(&self.process, &self.functionals, &self.values);
        found.map_err(|error| match error {
            SignalError::IllConditioned { rcond, told } => {
                let told = told.map(|told| Told { at: self.numbers[told.at], ..told });
                SignalError::IllConditioned { rcond, told }
            }
            error => error,
        })
    }

    /// Returns the variance of the process: that which is given, or the likeliest.
    pub fn variance(&self, fit: &Kriging) -> f64 {
        self.variance.unwrap_or_else(|| fit.variance())
    }
}

/// Reads one observation.
fn observation(at: usize, of: &Value) -> Result<(Functional, f64), SignalError> {
    let number = |key: &str| of.get(key).and_then(Value::as_f64);
    let len = of.as_object().map_or(0, |fields| fields.len());
    let found = match (number("at"), number("from"), number("to"), len) {
        (Some(at), None, None, 2) => {
            let value = number("value").map(|value| (Functional::Value { at }, value));
            value.or_else(|| Some((Functional::Derivative { at }, number("derivative")?)))
        }
        (None, Some(from), Some(to), 3) => {
            number("average").map(|average| (Functional::Average { from, to }, average))
        }
        _ => None,
    };
    found.ok_or_else(|| SignalError::Written { at, found: of.to_string() })
}

/// Lists the observations that say something new. Without noise two of one thing that agree are one.
///
/// # Errors
/// [`SignalError::Contradiction`] of two that do not.
fn news(functionals: &[Functional], values: &[f64], noise: f64) -> Result<Vec<usize>, SignalError> {
    let mut out: Vec<usize> = Vec::with_capacity(values.len());
    for (second, of) in functionals.iter().enumerate() {
        let same = out.iter().copied().find(|&first| noise == 0.0 && functionals[first] == *of);
        let Some(first) = same else {
            out.push(second);
            continue;
        };
        let (one, other) = (values[first], values[second]);
        if (one - other).abs() > AGREE * one.abs().max(other.abs()) {
            return Err(SignalError::Contradiction { first, second, one, other });
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(text: &str) -> String {
        Observations::parse(text.as_bytes(), "f", None)
            .and_then(|of| of.fit())
            .err()
            .unwrap()
            .to_string()
    }

    #[test]
    fn values_derivatives_and_averages_are_read() {
        let text = br#"{"covariance": "matern 5/2:2", "mean": "linear", "observations": [
            {"at": 0, "value": 1}, {"at": 1, "derivative": -2}, {"from": 2, "to": 3, "average": 0.5}]}"#;
        let read = Observations::parse(text, "f", None).unwrap();
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
        let wrong = said(&of(r#"[{"at": 0, "value": 1}, {"at": 0}]"#));
        assert!(wrong.starts_with("observation 1: expected {\"at\": x, \"value\": y}"), "{wrong}");
        let twice = said(&of(r#"[{"at": 0, "value": 1}, {"at": 0, "value": 2}]"#));
        assert!(twice.starts_with("observations 0 and 1 contradict each other"), "{twice}");
        let unknown = said(r#"{"covariance": "cubic:1", "observations": [{"at": 0, "value": 1}]}"#);
        assert!(unknown.starts_with("there is no covariance \"cubic:1\""), "{unknown}");
    }

    #[test]
    fn one_observation_makes_a_constant() {
        let read = Observations::parse(br#"{"observations": [{"at": 2, "value": 7}]}"#, "f", None)
            .unwrap();
        let found = read.fit().unwrap().predict(&Functional::Value { at: 50.0 });
        assert!((found.value - 7.0).abs() < 1e-12);
    }
}
