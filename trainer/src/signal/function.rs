//! A function of observations with its names, a part kernel.

use super::deviation::{Compared, input};
use super::error::SignalError;
use super::functional::Functional;
use super::kriging::Kriging;
use super::observations::Observations;
use super::sum::sum;
use crate::numeric::columns::ends;
use crate::regression::fade::Fade;
use crate::scattered::bound::largest;
use crate::scattered::model::{Figures, KernelModel, Output, OutputKind};
use faer::Mat;
use sinew_runtime::kernel::{Normalise, QueryRule};

/// Makes a function with its names from a fit. Also returns the largest deviation of its file, over the function's range:
/// at the places of the observations and at 1,000 queries between.
///
/// # Errors
/// Those of [`sum`], and [`SignalError::Deviation`] of a deviation above the limit.
pub fn function(
    observations: &Observations,
    fit: &Kriging,
) -> Result<(KernelModel, f64), SignalError> {
    let Observations { name, process, functionals, values, f32_error, numbers, .. } = observations;
    let sum = sum(process, functionals, numbers, fit)?;
    let deviation =
        Compared::new(functionals, fit, *f32_error).check(&sum, observations.remedy())?;
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

#[cfg(test)]
mod tests {
    use super::*;

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
    fn what_no_kernel_is_says_what_can() {
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
