//! Observations of a function in JSON, and their function as a kernel part.

use super::choose::{Ladder, OF_VALUES, likeliest_of, unit};
use super::covariance::{Covariance, Subject};
use super::faults::check_positive;
use super::functional::Functional;
use super::kriging::{Kriging, Mean, Process, check};
use super::repeated::independent;
use super::sum::{Compared, Remedy, input, sum};
use crate::Error;
use crate::formats::extension::{extension, unknown_format};
use crate::formats::json;
use crate::numeric::columns::ends;
use crate::regression::confidence::Fade;
use crate::scattered::bound::largest;
use crate::scattered::deviation::{F32_ERROR, ROOM, too_far};
use crate::scattered::model::{Figures, KernelModel, Output, OutputKind};
use faer::Mat;
use serde::Deserialize;
use serde_json::Value;
use sinew_runtime::kernel::{Normalise, QueryRule};
use std::path::Path;

/// Most centres of a candidate function while the covariance is chosen; larger candidates take too long to measure.
const CENTRES: usize = 16_384;

/// Families that a kernel part can represent for derivatives and averages too.
const OF_ANY: [&str; 1] = ["squared exponential"];

/// Observations of a function, with the prior model of the function.
#[derive(Clone, Debug)]
pub struct Observations {
    /// The function's name.
    pub name: String,
    /// Prior model of the function.
    pub process: Process,
    /// Accepted variance of the process; `None` to estimate the variance.
    pub variance: Option<f64>,
    /// Observed functionals, n.
    pub functionals: Vec<Functional>,
    /// Observed values, n.
    pub values: Vec<f64>,
    /// Largest allowed deviation of the file, relative to the function's range.
    pub f32_error: f64,
    /// Original number of each observation, n; redundant observations are left out.
    pub numbers: Vec<usize>,
    /// Number of redundant observations.
    pub repeated: usize,
    /// Whether the user gave the covariance.
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
    /// Reads JSON with the field `observations`: a list of `{"at": x, "value": y}`, `{"at": x, "derivative": y}` and
    /// `{"from": a, "to": b, "average": y}`. Optional fields: `name`, `covariance`, `mean`, `noise`, `variance` and
    /// `f32_error`.
    ///
    /// - `f32_error`: largest allowed deviation of the baked file, relative to the function's range; replaces the JSON
    ///   field.
    ///
    /// # Errors
    /// - If the file cannot be read, or is not JSON of this form.
    /// - If there are no observations.
    /// - If a number is out of its range, or a box has no width.
    /// - If an observation contradicts the value that others imply.
    /// - Errors of [`Covariance::parse`].
    pub fn read(path: &Path, f32_error: Option<f64>) -> Result<Self, Error> {
        if extension(path) != "json" {
            return Err(unknown_format(path, ".json"));
        }
        let text = std::fs::read(path).map_err(Error::read)?;
        let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
        Self::parse(&text, &stem.unwrap_or_default(), f32_error)
    }

    /// Parses the JSON of [`Self::read`] from bytes.
    ///
    /// - `name`: default for the function's name.
    ///
    /// # Errors
    /// The errors of [`Self::read`], except for reading the file.
    pub fn parse(text: &[u8], name: &str, f32_error: Option<f64>) -> Result<Self, Error> {
        let written: Written = json::read(text)?;
        let Written { mean, noise, variance, .. } = written;
        let read = written.observations.iter().enumerate().map(|(at, of)| observation(at, of));
        let all = read.collect::<Result<Vec<_>, _>>()?;
        let (functionals, values): (Vec<_>, Vec<_>) = all.into_iter().unzip();
        let given = match written.covariance.as_deref() {
            None | Some("auto") => None,
            Some(text) => Some(Covariance::parse(text, Subject::Observations)?),
        };
        // Placeholder until the covariance is chosen; this family has derivatives.
        let first = Covariance::SquaredExponential { length: unit(&functionals) };
        let process = Process { covariance: given.clone().unwrap_or(first), mean, noise };
        check(&process, &functionals, &values)?;
        process.check()?;
        variance.map_or(Ok(()), |variance| check_positive("variance", variance))?;
        let f32_error = f32_error.or(written.f32_error).unwrap_or(F32_ERROR);
        check_positive("f32 error", f32_error)?;
        // With noise, a repeated observation adds information.
        let numbers = match noise > 0.0 {
            true => (0..values.len()).collect(),
            false => independent(&functionals, &values)?,
        };
        let mut out = Self {
            name: written.name.unwrap_or_else(|| name.to_owned()),
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

    /// Chooses the likeliest covariance that can be solved for and baked within the allowed deviation. Tries short
    /// lengths only if no usual length works, unless an offset causes the deviation. If nothing works, takes the
    /// covariance with the smallest deviation.
    fn choose(&mut self) {
        let names: &[&str] = if self.is_of_values() { &OF_VALUES } else { &OF_ANY };
        let observed = (self.functionals.as_slice(), self.values.as_slice());
        let mut nearest: Option<(f64, Remedy, Covariance)> = None;
        let ladders = [Some(Ladder::usual(observed.0)), Ladder::short(observed.0)];
        for ladder in ladders.into_iter().flatten() {
            for room in [ROOM, 1.0] {
                let sound = |covariance: &Covariance| match self.deviation(covariance) {
                    Some((deviation, None)) => deviation <= room * self.f32_error,
                    Some((deviation, Some(remedy))) => {
                        if nearest.as_ref().is_none_or(|(least, ..)| deviation < *least) {
                            nearest = Some((deviation, remedy, covariance.clone()));
                        }
                        false
                    }
                    None => false,
                };
                let families = names.iter().filter_map(|name| Covariance::named(name, &[1.0]));
                let families = families.map(|family| (ladder, family));
                let found = likeliest_of(self.process.noise, observed, families, sound);
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

    /// Measures the deviation of a covariance's baked function, relative to the function's range; infinite if there are
    /// too many centres. `None` if the function cannot be solved for or baked.
    ///
    /// Also returns the suggested change for a deviation above the limit.
    fn deviation(&self, covariance: &Covariance) -> Option<(f64, Option<Remedy>)> {
        let process = Process { covariance: covariance.clone(), ..self.process.clone() };
        let fit = Kriging::new(&process, &self.functionals, &self.values).ok()?;
        let sum = sum(&process, &self.functionals, &self.numbers, &fit).ok()?;
        if sum.centres.ncols() > CENTRES {
            return Some((f64::INFINITY, None));
        }
        let compared = Compared::new(&self.functionals, &fit, self.f32_error);
        compared.deviation(&sum, self.remedy()).ok()
    }

    fn is_of_values(&self) -> bool {
        self.functionals.iter().all(|of| matches!(of, Functional::Value { .. }))
    }

    /// Returns the suggested change for an ill-conditioned or inaccurate fit.
    pub fn remedy(&self) -> &'static str {
        match (self.given, self.is_of_values()) {
            (false, _) => "give a noise",
            (true, true) => {
                "take a shorter length, a rougher covariance or a noise, or leave `covariance` out"
            }
            // Only one family represents derivatives and averages.
            (true, false) => "take a shorter length or a noise, or leave `covariance` out",
        }
    }

    /// Fits the function.
    ///
    /// # Errors
    /// Errors of [`Kriging::new`].
    pub fn fit(&self) -> Result<Kriging, Error> {
        let Self { process, functionals, values, numbers, .. } = self;
        Kriging::numbered(process, functionals, values, |at| numbers[at], self.remedy())
    }

    /// Returns the variance of the process: given, or the likeliest.
    pub fn variance(&self, fit: &Kriging) -> f64 {
        self.variance.unwrap_or_else(|| fit.variance())
    }
}

/// Creates the kernel model of a fitted function. Also returns the largest deviation of the file, relative to the
/// function's range: at the observations and at 1,000 places between.
///
/// # Errors
/// Errors of [`sum`]; if the deviation is above the limit.
pub fn function(observations: &Observations, fit: &Kriging) -> Result<(KernelModel, f64), Error> {
    let Observations { name, process, functionals, values, f32_error, numbers, .. } = observations;
    let sum = sum(process, functionals, numbers, fit)?;
    let compared = Compared::new(functionals, fit, *f32_error);
    let (deviation, remedy) = compared.deviation(&sum, observations.remedy())?;
    if let Some(remedy) = remedy {
        return Err(too_far(deviation, *f32_error, remedy));
    }
    let places: Vec<f64> = functionals.iter().map(Functional::middle).collect();
    let sites = Mat::from_fn(places.len(), 1, |i, _| places[i]);
    let misses = functionals.iter().zip(values).map(|(of, y)| (fit.value(of) - y).powi(2));
    let figures = Figures {
        residual_rms: (misses.sum::<f64>() / values.len() as f64).sqrt(),
        left_out_rms: 0.0,
        bound: largest(&sum, &sites).into_iter().fold(0.0, f64::max),
        rcond: 0.0,
    };
    let [low, high] = [f32::MIN, f32::MAX].map(f64::from);
    let free = OutputKind::Scalar { low, high, normalised: false, neutral: 0.0 };
    let model = KernelModel {
        name: name.clone(),
        inputs: vec![input()],
        outputs: vec![Output { name: "value".to_owned(), kind: free }],
        sum,
        ranges: vec![ends(&places)],
        query: QueryRule::Free,
        fade: Fade { start: 0.0, end: 0.0 },
        normalise: Normalise::Never,
        variance: None,
        fit: figures,
    };
    Ok((model, deviation))
}

/// Parses one observation.
fn observation(at: usize, of: &Value) -> Result<(Functional, f64), Error> {
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
    found.ok_or_else(|| {
        Error::value(format!(
            "observation {at}: expected {{\"at\": x, \"value\": y}}, {{\"at\": x, \"derivative\": y}} or \
             {{\"from\": a, \"to\": b, \"average\": y}}, found {of}"
        ))
    })
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
    fn errors_name_the_observation() {
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

    #[test]
    fn mixed_observations_become_kernels() {
        let text = br#"{"covariance": "squared exponential:1.5", "mean": "linear", "observations": [
            {"at": 0, "value": 1}, {"at": 1.5, "derivative": -2}, {"from": 3, "to": 9, "average": 0.5},
            {"at": 5, "value": 2}, {"at": 8, "value": 1}]}"#;
        let observations = Observations::parse(text, "f", None).unwrap();
        let fit = observations.fit().unwrap();
        let (model, deviation) = function(&observations, &fit).unwrap();
        for step in -10..=100 {
            let x = 0.1 * f64::from(step);
            let found = model.evaluate(&[x]).unwrap().numbers[0];
            let expected = fit.predict(&Functional::Value { at: x }).value;
            // Coefficients are rounded to f32.
            assert!((found - expected).abs() < 1e-5, "{x}: {found} {expected}");
        }
        assert!(model.fit.bound < 1e-3 && model.fit.residual_rms < 1e-9 && deviation < 1e-5);
    }

    #[test]
    fn unsupported_functions_list_the_supported_ones() {
        let refused = |covariance: &str, rest: &str| {
            let text = format!(
                "{{\"covariance\": \"{covariance}\", \"observations\": [{{\"at\": 0, \"value\": 1}}{rest}]}}"
            );
            let observations = Observations::parse(text.as_bytes(), "f", None).unwrap();
            let fit = observations.fit().unwrap();
            function(&observations, &fit).map(|_| ()).map_err(|error| error.to_string())
        };
        let error = refused("oscillating:3,2", "").unwrap_err();
        assert!(
            error.starts_with("no part kernel holds covariance oscillating: it can hold values"),
            "{error}"
        );
        let error = refused("matern 5/2:1", ", {\"at\": 1, \"derivative\": 1}").unwrap_err();
        assert!(error.contains("observation 1, which is no value"), "{error}");
        assert!(refused("matern 5/2:1", ", {\"at\": 1, \"value\": 1}").is_ok());
    }
}
