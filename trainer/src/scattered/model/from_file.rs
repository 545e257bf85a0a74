//! A function in a file: its inputs as they were given, and all of it but its variance.

use super::function::{Figures, KernelModel};
use super::input::{Input, InputKind};
use super::output::{Output, OutputKind};
use crate::regression::fade::Fade;
use crate::regression::rotations::Feature;
use crate::scattered::sum::{KernelSum, Term};
use faer::Mat;
use sinew_runtime::kernel::{
    InputKind as FileInput, KernelMap, NO_TERM, OutputKind as FileOutput, OutputRow,
};

impl KernelModel {
    /// Widens a file's function; the variance stays there.
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

/// Returns the inputs of a file's function, of weight 1.
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
