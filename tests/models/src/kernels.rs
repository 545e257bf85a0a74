//! Kernel parts as plain lists, whose fields may be invalid.

use crate::bytes::{blocks, floats, halves, input_row, kernel_rule, names, output_row, words};
use crate::message::head;
use crate::pieces::{Content, Pieces};
use crate::rng::Rng;
use sinew_runtime::format::{PartKind, PartRow, SectionKind};
use sinew_runtime::kernel::{
    InputKind, InputRow, KERNEL_SECTIONS, Kernel, KernelFit, KernelRule, NO_TERM, Normalise,
    OutputKind, OutputRow, QueryRule,
};

/// A kernel as plain lists.
#[derive(Clone)]
pub struct KernelContent {
    /// Name of the part.
    pub name: String,
    /// The kernel, and its rules for queries and outputs.
    pub rule: KernelRule,
    /// I inputs: name and row.
    pub inputs: Vec<(String, InputRow)>,
    /// O outputs: name and row.
    pub outputs: Vec<(String, OutputRow)>,
    /// d features: shift, scale, minimum, maximum.
    pub features: Vec<[f32; 4]>,
    /// e rows of d; empty without a metric.
    pub metric: Vec<Vec<f32>>,
    /// n centres of e numbers, or of d without a metric.
    pub centres: Vec<Vec<f32>>,
    /// T terms: the earlier term and the feature.
    pub terms: Vec<[u16; 2]>,
    /// m rows of n + T coefficients.
    pub coefficients: Vec<Vec<f32>>,
    /// Matrices of the variance.
    pub variance: Option<VarianceContent>,
    /// Errors of the fit.
    pub fit: KernelFit,
}

/// Matrices of the variance, as plain lists.
#[derive(Clone)]
pub struct VarianceContent {
    /// A: r rows of n + T.
    pub factor: Vec<Vec<f32>>,
    /// B: n rows of T.
    pub mixed: Vec<Vec<f32>>,
    /// H: T rows of T.
    pub polynomial: Vec<Vec<f32>>,
    /// m.
    pub deviations: Vec<f32>,
}

/// A range without limits.
const ANY: (f32, f32) = (f32::MIN, f32::MAX);

impl KernelContent {
    /// Makes a kernel of random numbers with every kind of input and of output, a metric, a
    /// polynomial of degree 2 and a variance: I = 7, R = 24, d = 25, e = 5, n = 11, m = 9, r = 6.
    pub fn every(kernel: Kernel) -> Self {
        let mut rng = Rng(1992);
        let inputs: Vec<_> =
            InputKind::ALL.map(|kind| (kind.name().to_owned(), input(kind))).into();
        let outputs = vec![
            ("free".to_owned(), scalar(false, ANY, 0.25)),
            ("kept".to_owned(), scalar(true, (-0.5, 0.75), 0.0)),
            ("marked".to_owned(), scalar(true, (0.0, 2.0), 0.5)),
            ("place".to_owned(), output(OutputKind::Vector3, [0.5, -1.0, 2.0, 0.0])),
            ("turn".to_owned(), output(OutputKind::Rotation, [0.48, -0.6, 0.0, 0.64])),
        ];
        let d = 25;
        let mut terms = vec![[NO_TERM; 2]];
        terms.extend((0..d).map(|i| [0, i]));
        // The square of feature 3, and its product with the last feature.
        terms.extend([[4, 3], [4, d - 1]]);
        let (d, e, n, m, t, r) = (usize::from(d), 5, 11, 9, terms.len(), 6);
        Self {
            name: "every".to_owned(),
            rule: rule(kernel),
            inputs,
            outputs,
            features: (0..d)
                .map(|i| [0.03 * i as f32 - 0.2, 0.5 + 0.02 * i as f32, -0.8, 0.7])
                .collect(),
            metric: matrix(&mut rng, e, d, 0.4),
            centres: matrix(&mut rng, n, e, 0.6),
            terms,
            coefficients: matrix(&mut rng, m, n + t, 0.3),
            variance: Some(VarianceContent {
                factor: matrix(&mut rng, r, n + t, 0.02),
                mixed: matrix(&mut rng, n, t, 0.01),
                polynomial: matrix(&mut rng, t, t, 0.01),
                deviations: (0..m).map(|i| 0.5 + i as f32).collect(),
            }),
            fit: KernelFit::from_figures([0.01, 0.02, 1e-6, 1e-3]),
        }
    }

    /// Makes a kernel of random numbers with d scalar inputs, m scalar outputs, n centres and no
    /// other feature.
    pub fn plain(kernel: Kernel, [d, n, m]: [usize; 3]) -> Self {
        let mut rng = Rng(2015);
        let name = |i: usize| format!("number {i}");
        Self {
            name: "plain".to_owned(),
            rule: KernelRule { fade: (0.0, 0.0), ..rule(kernel) },
            inputs: (0..d).map(|i| (name(i), input(InputKind::Scalar))).collect(),
            outputs: (0..m).map(|o| (name(o), scalar(false, ANY, 0.0))).collect(),
            features: vec![[0.0, 1.0, -1.0, 1.0]; d],
            metric: Vec::new(),
            centres: matrix(&mut rng, n, d, 1.0),
            terms: Vec::new(),
            coefficients: matrix(&mut rng, m, n, 1.0),
            variance: None,
            fit: KernelFit::default(),
        }
    }

    /// Makes a kernel that drives a servo from two levers and the twist of a joint about x. The
    /// output is a number within [-1, 1]; queries are clamped to the range of the data.
    pub fn servo() -> Self {
        let mut rng = Rng(25);
        let [lever, twist] = [InputKind::Scalar, InputKind::Twist].map(input);
        let twist = InputRow { axis: [1.0, 0.0, 0.0], ..twist };
        let terms = vec![[NO_TERM; 2], [0, 0], [0, 1], [0, 2], [0, 3]];
        Self {
            name: "servo".to_owned(),
            rule: KernelRule {
                query: QueryRule::Clamp,
                fade: (2.0, 8.0),
                ..rule(Kernel::ThinPlate)
            },
            inputs: vec![("left".into(), lever), ("right".into(), lever), ("wrist".into(), twist)],
            outputs: vec![("servo".to_owned(), scalar(false, (-1.0, 1.0), 0.0))],
            features: vec![[0.0, 1.0, -1.0, 1.0]; 4],
            centres: matrix(&mut rng, 24, 4, 1.0),
            coefficients: matrix(&mut rng, 1, 24 + terms.len(), 0.1),
            terms,
            ..Self::plain(Kernel::ThinPlate, [1, 1, 1])
        }
    }

    /// Lists the golden kernels, one for each function. Each has a number, a vector and a rotation
    /// as inputs, the rotation in a different form each time; rules, metrics and variances
    /// alternate.
    pub fn goldens() -> Vec<Self> {
        Kernel::ALL.into_iter().enumerate().map(|(i, kernel)| Self::golden(kernel, i)).collect()
    }

    fn golden(kernel: Kernel, i: usize) -> Self {
        let mut rng = Rng(16 + i as u64);
        let rotation = InputKind::ALL[2 + i % 5];
        let inputs = [InputKind::Scalar, InputKind::Vector3, rotation];
        let d = inputs.map(InputKind::feature_len).iter().sum::<usize>();
        let (n, m, c) = (9 + i % 3, 8, if i.is_multiple_of(2) { 3 } else { d });
        let terms = (0..d as u16).map(|feature| [0, feature]);
        let terms: Vec<_> = [[NO_TERM; 2]].into_iter().chain(terms).take(i % 2 * d + 1).collect();
        let t = terms.len();
        let variance = VarianceContent {
            factor: matrix(&mut rng, 3, n + t, 0.1),
            mixed: matrix(&mut rng, n, t, 0.05),
            polynomial: matrix(&mut rng, t, t, 0.1),
            deviations: vec![0.5; m],
        };
        let (query, normalise) = (QueryRule::ALL[i % 3], Normalise::ALL[i / 3 % 3]);
        Self {
            name: format!("{} {}", kernel.name(), kernel.parameter()),
            rule: KernelRule { query, normalise, ..rule(kernel) },
            inputs: inputs.map(|kind| (kind.name().to_owned(), input(kind))).into(),
            outputs: vec![
                ("one".to_owned(), scalar(true, (0.0, 1.0), 0.25)),
                ("other".to_owned(), scalar(true, ANY, 0.5)),
                ("place".to_owned(), output(OutputKind::Vector3, [0.5, -1.0, 2.0, 0.0])),
                ("turn".to_owned(), output(OutputKind::Rotation, [0.48, -0.6, 0.0, 0.64])),
            ],
            features: vec![[0.125, 0.75, -1.5, 1.25]; d],
            metric: if c == d { Vec::new() } else { matrix(&mut rng, c, d, 0.5) },
            centres: matrix(&mut rng, n, c, 1.0),
            coefficients: matrix(&mut rng, m, n + t, 0.5),
            terms,
            variance: (i % 5 == 1).then_some(variance),
            fit: KernelFit::default(),
        }
    }

    /// Returns the length R of a query.
    pub fn query_len(&self) -> usize {
        self.inputs.iter().map(|(_, input)| input.kind.number_len()).sum()
    }

    /// Makes a query of numbers within `scale`; rotations have any length and direction.
    pub fn query(&self, rng: &mut Rng, scale: f32) -> Vec<f32> {
        (0..self.query_len()).map(|_| rng.unit() * scale).collect()
    }

    /// Returns I, O, d, e, n, T, m, r.
    pub fn counts(&self) -> [usize; 8] {
        [
            self.inputs.len(),
            self.outputs.len(),
            self.features.len(),
            self.metric.len(),
            self.centres.len(),
            self.terms.len(),
            self.coefficients.len(),
            self.variance.as_ref().map_or(0, |variance| variance.factor.len()),
        ]
    }

    /// Writes the sections that the kernel needs.
    ///
    /// # Panics
    /// If the order of sections differs from FORMAT.md.
    fn sections(&self) -> Vec<(SectionKind, Vec<u8>)> {
        let own: Vec<_> = self.inputs.iter().map(|(name, _)| name.clone()).collect();
        let others = self.outputs.iter().map(|(name, _)| name.clone());
        let all = own.into_iter().chain(others).collect::<Vec<_>>();
        let variance = self.variance.as_ref().map(|variance| {
            let matrices =
                [&variance.factor, &variance.mixed, &variance.polynomial].map(|m| blocks(m));
            [matrices.concat(), floats(&variance.deviations)].concat()
        });
        let written = vec![
            (SectionKind::KernelCounts, Some(words(&self.counts().map(|len| len as u32)))),
            (SectionKind::Names, Some(names(&self.name, &all))),
            (SectionKind::KernelRule, Some(kernel_rule(&self.rule).to_vec())),
            (
                SectionKind::Inputs,
                Some(self.inputs.iter().flat_map(|(_, row)| input_row(row)).collect()),
            ),
            (
                SectionKind::Outputs,
                Some(self.outputs.iter().flat_map(|(_, row)| output_row(row)).collect()),
            ),
            (SectionKind::Features, Some(floats(self.features.as_flattened()))),
            (SectionKind::Metric, Some(blocks(&self.metric)).filter(|_| !self.metric.is_empty())),
            (SectionKind::KernelCentres, Some(blocks(&self.centres))),
            (SectionKind::Terms, Some(halves(self.terms.as_flattened()))),
            (SectionKind::KernelCoefficients, Some(blocks(&self.coefficients))),
            (SectionKind::Variance, variance),
            (SectionKind::KernelFit, Some(floats(&self.fit.figures()))),
        ];
        assert!(written.iter().map(|(kind, _)| *kind).eq(KERNEL_SECTIONS));
        written.into_iter().filter_map(|(kind, bytes)| Some((kind, bytes?))).collect()
    }
}

impl Pieces {
    /// Makes a file of kernels only, one part each.
    ///
    /// # Panics
    /// If the order of sections differs from FORMAT.md.
    pub fn kernels(contents: &[KernelContent]) -> Self {
        let sections = contents.iter().zip(0..).flat_map(|(content, part)| {
            let own = content.sections().into_iter();
            own.map(move |(kind, bytes)| Content::new(kind, part, bytes))
        });
        let row = PartRow { kind: PartKind::Kernel.number(), flags: 1 };
        let parts = vec![row; contents.len()];
        Self { head: head::SOUND, parts, sections: sections.collect() }
    }
}

/// Returns a rule that does not fade queries but reports their confidence.
fn rule(kernel: Kernel) -> KernelRule {
    let (query, normalise) = (QueryRule::Free, Normalise::Never);
    KernelRule { kernel, query, normalise, fade: (0.5, 4.0) }
}

fn input(kind: InputKind) -> InputRow {
    let axis = if kind.has_axis() { [0.48, 0.6, 0.64] } else { [0.0; 3] };
    InputRow { kind, euler: None, axis }
}

fn scalar(is_marked: bool, range: (f32, f32), neutral: f32) -> OutputRow {
    let kind = OutputKind::Scalar;
    OutputRow { kind, is_marked, range, neutral: [neutral, 0.0, 0.0, 0.0] }
}

fn output(kind: OutputKind, neutral: [f32; 4]) -> OutputRow {
    OutputRow { kind, is_marked: false, range: (0.0, 0.0), neutral }
}

/// Makes rows of random numbers within `size`.
fn matrix(rng: &mut Rng, rows: usize, columns: usize, size: f32) -> Vec<Vec<f32>> {
    (0..rows).map(|_| (0..columns).map(|_| rng.unit() * size).collect()).collect()
}
