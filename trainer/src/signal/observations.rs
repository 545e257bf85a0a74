//! Observations of a function as a person writes them, and the function.

use super::choose::{Ladder, likeliest_of, unit};
use super::covariance::Covariance;
use super::deviation::Compared;
use super::error::{Remedy, SignalError, Subject, Told, check_positive};
use super::functional::Functional;
use super::kriging::{Kriging, Process, check};
use super::mean::Mean;
use super::repeated::news;
use super::sum::sum;
use crate::formats::FormatError;
use crate::formats::extension::{extension, unknown_format};
use crate::formats::json;
use crate::scattered::deviation::{F32_ERROR, ROOM};
use serde::Deserialize;
use serde_json::Value;
use std::path::Path;

/// Most centres of a function whose covariance is chosen: more take long to measure.
const CENTRES: usize = 16_384;

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
    /// The covariance was given, not chosen.
    given: bool,
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
    /// [`SignalError::Number`], [`SignalError::Observation`], [`SignalError::Contradiction`], and those of
    /// [`Covariance::parse`].
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
        check(&process, &functionals, &values)?;
        process.check()?;
        variance.map_or(Ok(()), |variance| check_positive("variance", variance))?;
        let f32_error = f32_error.or(written).unwrap_or(F32_ERROR);
        check_positive("f32 error", f32_error)?;
        // With noise a repetition says something new.
        let numbers = match noise > 0.0 {
            true => (0..values.len()).collect(),
            false => news(&functionals, &values)?,
        };
        let mut out = Self {
            name: own.unwrap_or_else(|| name.to_owned()),
            process,
            variance,
            functionals: numbers.iter().map(|&at| functionals[at]).collect(),
            values: numbers.iter().map(|&at| values[at]).collect(),
            f32_error,
            repeated: values.len() - numbers.len(),
            numbers,
            given: given.is_some(),
        };
        if given.is_none() {
            out.choose();
        }
        Ok(out)
    }

    /// Takes the likeliest covariance whose function can be solved for, and whose file is near it. Short lengths are tried
    /// if none of the usual ones will do, and no offset is the reason. If none at all will do, the covariance of the nearest
    /// file is taken.
    fn choose(&mut self) {
        let names: &[&str] = if self.is_of_values() { &OF_VALUES } else { &OF_ANY };
        let observed = (self.functionals.as_slice(), self.values.as_slice());
        let mut nearest: Option<(f64, Remedy, Covariance)> = None;
        let ladders = [Some(Ladder::usual(observed.0)), Ladder::short(observed.0)];
        for ladder in ladders.into_iter().flatten() {
            for room in [ROOM, 1.0] {
                let sound = |covariance: &Covariance| match self.deviation(covariance) {
                    Ok(deviation) => deviation <= room * self.f32_error,
                    Err(SignalError::Deviation { deviation, remedy, .. }) => {
                        if nearest.as_ref().is_none_or(|(least, ..)| deviation < *least) {
                            nearest = Some((deviation, remedy, covariance.clone()));
                        }
                        false
                    }
                    Err(_) => false,
                };
                let found = likeliest_of(self.process.noise, observed, names, ladder, sound);
                if let Some(covariance) = found {
                    self.process.covariance = covariance;
                    return;
                }
            }
            let offset =
                |remedy: &Remedy| matches!(remedy, Remedy::Values(..) | Remedy::Inputs(..));
            if nearest.as_ref().is_some_and(|(_, remedy, _)| offset(remedy)) {
                break;
            }
        }
        if let Some((.., covariance)) = nearest {
            self.process.covariance = covariance;
        }
    }

    /// Measures by how much the file of a covariance's function is off, over the function's range; infinite if it has too
    /// many centres.
    fn deviation(&self, covariance: &Covariance) -> Result<f64, SignalError> {
        let process = Process { covariance: covariance.clone(), ..self.process.clone() };
        let fit = Kriging::new(&process, &self.functionals, &self.values)?;
        let sum = sum(&process, &self.functionals, &self.numbers, &fit)?;
        if sum.centres.ncols() > CENTRES {
            return Ok(f64::INFINITY);
        }
        Compared::new(&self.functionals, &fit, self.f32_error).check(&sum, self.remedy())
    }

    fn is_of_values(&self) -> bool {
        self.functionals.iter().all(|of| matches!(of, Functional::Value { .. }))
    }

    /// Says what to change where rounding decides what the function is.
    pub fn remedy(&self) -> &'static str {
        match (self.given, self.is_of_values()) {
            (false, _) => "give a noise",
            (true, true) => {
                "take a shorter length, a rougher covariance or a noise, or leave `covariance` out"
            }
            // Derivatives and averages are kernels of one covariance only.
            (true, false) => "take a shorter length or a noise, or leave `covariance` out",
        }
    }

    /// Fits the function.
    ///
    /// # Errors
    /// Those of [`Kriging::new`].
    pub fn fit(&self) -> Result<Kriging, SignalError> {
        let found = Kriging::new(&self.process, &self.functionals, &self.values);
        found.map_err(|error| match error {
            SignalError::IllConditioned { rcond, told, .. } => {
                let told = told.map(|told| Told { at: self.numbers[told.at], ..told });
                SignalError::IllConditioned { rcond, told, remedy: self.remedy() }
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
