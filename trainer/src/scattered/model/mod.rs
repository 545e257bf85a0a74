//! Functions from named inputs to named outputs: fitted to a problem, baked into a file, or read from a file.

mod input;
mod output;

pub(crate) use input::features;
pub use input::{Input, InputKind, query_numbers};
pub use output::{Output, OutputKind};

use crate::Error;
use crate::regression::confidence::Fade;
use crate::regression::rotations::Feature;
use crate::scattered::solver::leave_one_out::Variance;
use crate::scattered::sum::{KernelSum, Term};
use faer::Mat;
use output::output_numbers;
use sinew_runtime::kernel::{
    InputKind as FileInput, KernelMap, NO_TERM, Normalise, OutputKind as FileOutput, OutputRow,
    QueryRule,
};

/// Function from named inputs to named outputs.
#[derive(Clone, Debug)]
pub struct KernelModel {
    /// Name of the function.
    pub name: String,
    /// Inputs of the function.
    pub inputs: Vec<Input>,
    /// Outputs of the function.
    pub outputs: Vec<Output>,
    /// Sum of kernels, as a function of the inputs' features.
    pub sum: KernelSum,
    /// Least and greatest value of each feature in the samples.
    pub ranges: Vec<[f64; 2]>,
    /// Rule for queries far from the samples.
    pub query: QueryRule,
    /// Distances from the centres over which the confidence falls.
    pub fade: Fade,
    /// Rule by which outputs are divided by their sum.
    pub normalise: Normalise,
    /// Variance of the function, if kept.
    pub variance: Option<Variance>,
    /// Quality of the fit.
    pub fit: Figures,
}

/// Quality of a fit, in the values' units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figures {
    /// RMS residual of the values at the samples.
    pub residual_rms: f64,
    /// RMS error of samples that the others predict.
    pub left_out_rms: f64,
    /// Bound of the f32 error over the samples and their box.
    pub bound: f64,
    /// Reciprocal condition of the solved system; 0 without a system.
    pub rcond: f64,
}

/// Result of a function at a query.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluated {
    /// Numbers of all outputs.
    pub numbers: Vec<f64>,
    /// Confidence that the samples give to the query, in [0, 1].
    pub confidence: f64,
}

impl KernelModel {
    /// Evaluates the function.
    ///
    /// - `given`: numbers of all inputs.
    ///
    /// # Errors
    /// If the number of values is wrong, a value is not finite, or a quaternion is zero or not finite.
    pub fn evaluate(&self, given: &[f64]) -> Result<Evaluated, Error> {
        let x = self.features(given)?;
        let mut values = self.sum.evaluate(&x);
        let z = self.sum.measured(&self.sum.scaled(&x));
        let confidence = self.fade.confidence(self.sum.squared_distances(&z));
        if self.query == QueryRule::Fade {
            let neutral = self.outputs.iter().flat_map(|output| output.kind.neutral());
            for (value, neutral) in values.iter_mut().zip(neutral) {
                *value = neutral + confidence * (*value - neutral);
            }
        }
        let neutral = |error: Error| error.within("input \"neutral\"");
        let numbers = output_numbers(&self.outputs, self.normalise, &values).map_err(neutral)?;
        Ok(Evaluated { numbers, confidence })
    }

    /// Computes features. The rule `Clamp` limits them to the ranges of the samples.
    fn features(&self, given: &[f64]) -> Result<Vec<f64>, Error> {
        let mut x = features(&self.inputs, given)?;
        if self.query == QueryRule::Clamp {
            for (x, [low, high]) in x.iter_mut().zip(&self.ranges) {
                *x = x.max(*low).min(*high);
            }
        }
        Ok(x)
    }

    /// Reads a file's function in f64, without its variance.
    pub fn from_file(map: &KernelMap<'_>) -> Self {
        let (rule, fit) = (map.rule(), map.fit());
        let features =
            (0..).map_while(|feature| map.feature(feature)).map(|row| row.map(f64::from));
        let output = |(number, row): (usize, OutputRow)| {
            let name = map.output_name(number).unwrap_or_default().to_owned();
            Output { name, kind: output_kind(&row) }
        };
        Self {
            name: map.name().to_owned(),
            inputs: inputs_of(map),
            outputs: map.outputs().enumerate().map(output).collect(),
            sum: sum_of(map),
            ranges: features.map(|[_, _, low, high]| [low, high]).collect(),
            query: rule.query,
            fade: Fade { start: rule.fade.0.into(), end: rule.fade.1.into() },
            normalise: rule.normalise,
            variance: None,
            fit: Figures {
                residual_rms: fit.rms_residual.into(),
                left_out_rms: fit.left_out_rms.into(),
                bound: fit.rounding_error.into(),
                rcond: fit.reciprocal_condition.into(),
            },
        }
    }
}

fn sum_of(map: &KernelMap<'_>) -> KernelSum {
    let counts = map.counts();
    let [d, e, n, t, m] = [
        counts.feature_len,
        counts.metric_len,
        counts.centre_len,
        counts.term_len,
        counts.value_len,
    ]
    .map(|len| len as usize);
    let matrix = |rows: usize, columns: usize, entry: &dyn Fn(usize, usize) -> Option<f32>| {
        Mat::from_fn(rows, columns, |r, c| f64::from(entry(r, c).unwrap_or_default()))
    };
    let figure = |place: usize| {
        (0..d).filter_map(|feature| Some(f64::from(map.feature(feature)?[place]))).collect()
    };
    let term = |[earlier, input]: [u16; 2]| match earlier {
        NO_TERM => Term::One,
        _ => Term::Product { earlier: earlier.into(), input: input.into() },
    };
    KernelSum {
        kernel: map.rule().kernel,
        shift: figure(0),
        scale: figure(1),
        metric: (e > 0).then(|| matrix(e, d, &|r, c| map.metric_entry(r, c))),
        centres: matrix(counts.coordinate_len() as usize, n, &|i, k| map.centre(k, i)),
        terms: (0..t).filter_map(|number| map.term(number).map(term)).collect(),
        coefficients: matrix(m, n + t, &|r, c| map.coefficient(r, c)),
    }
}

fn output_kind(row: &OutputRow) -> OutputKind {
    let neutral @ [x, y, z, _] = row.neutral.map(f64::from);
    match row.kind {
        FileOutput::Scalar => OutputKind::Scalar {
            low: row.range.0.into(),
            high: row.range.1.into(),
            normalised: row.is_marked,
            neutral: x,
        },
        FileOutput::Vector3 => OutputKind::Vector3 { neutral: [x, y, z] },
        FileOutput::Rotation => OutputKind::Rotation { neutral },
    }
}

/// Returns the inputs of a file's function, each of weight 1.
pub fn inputs_of(map: &KernelMap<'_>) -> Vec<Input> {
    let input = |(number, row): (usize, sinew_runtime::kernel::InputRow)| {
        let axis = row.axis.map(f64::from);
        let rotation = |feature| InputKind::Rotation { feature, order: row.euler };
        let kind = match row.kind {
            FileInput::Scalar => InputKind::Scalar,
            FileInput::Vector3 => InputKind::Vector3,
            FileInput::Rotation => rotation(Feature::Matrix),
            FileInput::TwoRows => rotation(Feature::TwoRows),
            FileInput::Swing => rotation(Feature::Swing(axis)),
            FileInput::Twist => rotation(Feature::Twist(axis)),
            FileInput::TwistAngle => rotation(Feature::TwistAngle(axis)),
        };
        let name = map.input_name(number).unwrap_or_default().to_owned();
        Input { name, kind, weight: 1.0 }
    };
    map.inputs().enumerate().map(input).collect()
}
