//! Kernel part of a file: the sections of a function, as in FORMAT.md.

use super::model::{InputKind, KernelModel, Output, OutputKind};
use super::sum::Term;
use crate::Error;
use crate::bake::sections::{blocks, floats, names, narrow, words};
use crate::bake::{Part, Sections};
use crate::regression::rotations::Feature;
use sinew_runtime::format::{Element, PartKind, SectionKind};
use sinew_runtime::kernel::{
    InputKind as FileInput, InputRow, KernelCounts, KernelFit, KernelRule, NO_TERM,
    OutputKind as FileOutput, OutputRow,
};

/// Bakes a function into a part.
///
/// # Errors
/// If a count does not fit the file.
pub fn part(model: &KernelModel) -> Result<Part, Error> {
    let sum = &model.sum;
    let variance = model.variance.as_ref();
    let counts = KernelCounts {
        input_len: narrow("inputs", model.inputs.len())?,
        output_len: narrow("outputs", model.outputs.len())?,
        feature_len: narrow("features", sum.shift.len())?,
        metric_len: narrow("rows of the metric", sum.metric.as_ref().map_or(0, |w| w.nrows()))?,
        centre_len: narrow("centres", sum.centres.ncols())?,
        term_len: narrow("terms", sum.terms.len())?,
        value_len: narrow("values", sum.value_len())?,
        variance_len: narrow("rows of the variance", variance.map_or(0, |v| v.whitening.nrows()))?,
    };
    let own = model.inputs.iter().map(|input| &input.name);
    let named = std::iter::once(&model.name).chain(own);
    let named = named.chain(model.outputs.iter().map(|output| &output.name));
    let mut sections: Sections = vec![
        (SectionKind::KernelCounts, true, words(&counts.words())),
        (SectionKind::Names, true, names(named)?),
        (SectionKind::KernelRule, true, rule(model).to_bytes().to_vec()),
        (SectionKind::Inputs, true, inputs(model)),
        (SectionKind::Outputs, true, model.outputs.iter().flat_map(output).collect()),
        (SectionKind::Features, true, features(model)),
    ];
    if let Some(metric) = &sum.metric {
        sections.push((SectionKind::Metric, true, blocks(metric.as_ref())));
    }
    sections.push((SectionKind::KernelCentres, true, blocks(sum.centres.transpose())));
    sections.push((SectionKind::Terms, true, terms(&sum.terms)?));
    sections.push((SectionKind::KernelCoefficients, true, blocks(sum.coefficients.as_ref())));
    if let Some(variance) = variance {
        let matrices = [&variance.whitening, &variance.reproducing, &variance.polynomial];
        let mut content: Vec<u8> = matrices.into_iter().flat_map(|m| blocks(m.as_ref())).collect();
        content.extend(floats(&variance.deviations));
        sections.push((SectionKind::Variance, true, content));
    }
    let fit = KernelFit {
        rms_residual: model.fit.residual_rms as f32,
        left_out_rms: model.fit.left_out_rms as f32,
        rounding_error: model.fit.bound as f32,
        reciprocal_condition: model.fit.rcond as f32,
    };
    sections.push((SectionKind::KernelFit, true, floats(&fit.figures().map(f64::from))));
    Ok(Part { kind: PartKind::Kernel, sections, element: Element::F32 })
}

fn rule(model: &KernelModel) -> KernelRule {
    let [start, end] = [model.fade.start, model.fade.end].map(|s| s as f32);
    KernelRule {
        kernel: model.sum.kernel,
        query: model.query,
        normalise: model.normalise,
        fade: if start < end { (start, end) } else { (0.0, 0.0) },
    }
}

fn inputs(model: &KernelModel) -> Vec<u8> {
    let row = |kind: InputKind| {
        let of = |kind| InputRow { kind, euler: None, axis: [0.0; 3] };
        let about = |kind, axis: [f64; 3]| InputRow { axis: axis.map(|x| x as f32), ..of(kind) };
        match kind {
            InputKind::Scalar => of(FileInput::Scalar),
            InputKind::Vector3 => of(FileInput::Vector3),
            InputKind::Rotation { feature, order } => {
                let row = match feature {
                    Feature::Matrix => of(FileInput::Rotation),
                    Feature::TwoRows => of(FileInput::TwoRows),
                    Feature::Swing(axis) => about(FileInput::Swing, axis),
                    Feature::Twist(axis) => about(FileInput::Twist, axis),
                    Feature::TwistAngle(axis) => about(FileInput::TwistAngle, axis),
                };
                InputRow { euler: order, ..row }
            }
        }
    };
    model.inputs.iter().flat_map(|input| row(input.kind).to_bytes()).collect()
}

fn output(output: &Output) -> [u8; OutputRow::BYTES] {
    let of = |kind, neutral: [f64; 4]| OutputRow {
        kind,
        is_marked: false,
        range: (0.0, 0.0),
        neutral: neutral.map(|x| x as f32),
    };
    let row = match output.kind {
        OutputKind::Scalar { low, high, normalised, neutral } => OutputRow {
            is_marked: normalised,
            range: (low as f32, high as f32),
            ..of(FileOutput::Scalar, [neutral, 0.0, 0.0, 0.0])
        },
        OutputKind::Vector3 { neutral: [x, y, z] } => of(FileOutput::Vector3, [x, y, z, 0.0]),
        OutputKind::Rotation { neutral } => of(FileOutput::Rotation, neutral),
    };
    row.to_bytes()
}

fn features(model: &KernelModel) -> Vec<u8> {
    let rows = model.sum.shift.iter().zip(&model.sum.scale).zip(&model.ranges);
    let rows = rows.map(|((shift, scale), [low, high])| [*shift, *scale, *low, *high]);
    floats(rows.collect::<Vec<_>>().as_flattened())
}

fn terms(terms: &[Term]) -> Result<Vec<u8>, Error> {
    let mut out = Vec::new();
    for term in terms {
        let pair: [u16; 2] = match *term {
            Term::One => [NO_TERM; 2],
            Term::Product { earlier, input } => {
                [narrow("terms", earlier)?, narrow("features", input)?]
            }
        };
        out.extend(pair.map(u16::to_le_bytes).as_flattened());
    }
    Ok(out)
}
