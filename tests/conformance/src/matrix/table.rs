//! The table: one column for each backend, one row for each stage.

use crate::backend::{Backend, Failure};
use crate::cpu::Cpu;
use crate::filters::FilterSubject;
use crate::finding::{Finding, sound};
use crate::gpu::Gpu;
use crate::kernels::KernelSubject;
use crate::shapes::ShapeSubject;
use crate::stages::{applies, body, filter, kernel, shapes, whole};
use crate::subject::Subject;
use serde::Serialize;
use sinew_gpu::headless::{Device, DeviceInfo};
use sinew_gpu::layout::Stage;

/// All measurements.
#[derive(Clone, Debug, Serialize)]
pub struct Matrix {
    /// Version of the project.
    pub version: &'static str,
    /// Number of models.
    pub model_len: usize,
    /// Number of poses of all models together.
    pub pose_len: usize,
    /// Number of kernels.
    pub kernel_len: usize,
    /// Number of queries of all kernels together.
    pub query_len: usize,
    /// The backends; the CPU first.
    pub backends: Vec<Column>,
}

/// A device through one API, or the CPU.
#[derive(Clone, Debug, Serialize)]
pub struct Column {
    /// `cpu`, `wgpu` or `vulkan`.
    pub api: &'static str,
    /// The device's name.
    pub device: String,
    /// Driver and version.
    pub driver: String,
    /// Stages of the envelope and its skin; then `whole`, from pose to skin; then kernels, shapes
    /// and filters.
    pub stages: Vec<Row>,
}

/// A stage on a device.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Its name.
    pub stage: &'static str,
    /// Values compared.
    pub cases: usize,
    /// Number of values that differ from the CPU's in a bit.
    pub differing: usize,
    /// The largest deviation from the oracle, in units of the tolerance; infinite (in JSON null) if
    /// it cannot be measured.
    pub worst: f64,
    /// The failure, if any.
    pub failure: Option<String>,
}

/// The subjects that every backend evaluates.
pub struct Scope<'a> {
    /// Characters, with poses.
    pub subjects: Vec<Subject<'a>>,
    /// Kernels, with queries.
    pub kernels: Vec<KernelSubject<'a>>,
    /// Skins with shapes, with weights.
    pub shaped: Vec<ShapeSubject<'a>>,
    /// Filters, with signals.
    pub filters: Vec<FilterSubject<'a>>,
}

impl Matrix {
    /// Measures the CPU.
    pub fn new(scope: &Scope<'_>) -> Self {
        let Scope { subjects, kernels, .. } = scope;
        let mut out = Self {
            version: env!("CARGO_PKG_VERSION"),
            model_len: subjects.len(),
            pose_len: subjects.iter().map(|subject| subject.poses.len()).sum(),
            kernel_len: kernels.len(),
            query_len: kernels.iter().map(KernelSubject::query_len).sum(),
            backends: Vec::new(),
        };
        let (device, driver) = (std::env::consts::ARCH.to_owned(), "sinew-runtime".to_owned());
        let stages = rows(&Cpu, scope);
        out.backends.push(Column { api: "cpu", device, driver, stages });
        out
    }

    /// Measures a device and adds its column.
    pub fn add(&mut self, device: &dyn Device, scope: &Scope<'_>) {
        let rows = rows(&Gpu::new(device), scope);
        self.backends.push(Column::of(device.info(), rows));
    }

    /// Adds a column for a device that cannot be opened.
    pub fn add_unopened(&mut self, info: &DeviceInfo, failure: &dyn std::fmt::Display) {
        let failure = Some(failure.to_string());
        let row = Row { stage: "opening", cases: 0, differing: 0, worst: f64::INFINITY, failure };
        self.backends.push(Column::of(info, vec![row]));
    }

    /// Whether every stage is within its tolerance on every device.
    pub fn holds(&self) -> bool {
        self.backends.iter().all(Column::holds)
    }
}

impl Column {
    fn of(info: &DeviceInfo, stages: Vec<Row>) -> Self {
        let driver = format!("{} {}", info.driver, info.driver_info).trim_end().to_owned();
        Self { api: info.api, device: info.name.clone(), driver, stages }
    }

    fn holds(&self) -> bool {
        self.stages.iter().all(|row| row.failure.is_none())
    }
}

/// Compares each stage on every subject that has the stage: models, kernels, skins with shapes, and
/// filters.
fn rows(backend: &dyn Backend, scope: &Scope<'_>) -> Vec<Row> {
    let alone = |stage: &Stage| matches!(stage, Stage::Kernel | Stage::Shapes | Stage::Filter);
    let of_envelope = Stage::ALL.into_iter().filter(|stage| !alone(stage));
    let stage = |stage: Stage| {
        let own = scope.subjects.iter();
        let own = own.filter(|subject| applies(stage, backend, &subject.loaded));
        let run = |own: &Subject<'_>| (own.described(), body(stage)(backend, own));
        row(stage.name(), own.map(run))
    };
    let skinned = scope.subjects.iter().filter(|subject| subject.loaded.skin.vertex_len() > 0);
    let whole = row("whole", skinned.map(|own| (own.described(), whole::body(backend, own))));
    let kernels = scope.kernels.iter().map(|own| (own.described(), kernel::body(backend, own)));
    let kernel = row(Stage::Kernel.name(), kernels);
    let shaped = scope.shaped.iter().map(|own| (own.described(), shapes::body(backend, own)));
    let shaped = row(Stage::Shapes.name(), shaped);
    let filters = scope.filters.iter().map(|own| (own.described(), filter::body(backend, own)));
    let filter = row(Stage::Filter.name(), filters);
    of_envelope.map(stage).chain([whole, kernel, shaped, filter]).collect()
}

/// Adds up the findings of a stage over its subjects, each with its description.
fn row(
    stage: &'static str,
    found: impl Iterator<Item = (String, Result<Vec<Finding>, Failure>)>,
) -> Row {
    let mut row = Row { stage, cases: 0, differing: 0, worst: 0.0, failure: None };
    for (described, found) in found {
        let failure = match found {
            Ok(findings) => {
                row.add(&findings);
                sound(&findings).err().map(|mismatch| mismatch.to_string())
            }
            Err(failure) => {
                row.worst = f64::INFINITY;
                Some(failure.to_string())
            }
        };
        let named = |failure| format!("{described}: {failure}");
        row.failure = row.failure.or(failure.map(named));
    }
    if row.cases == 0 && row.failure.is_none() {
        row.failure = Some("nothing was compared".to_owned());
    }
    row
}

impl Row {
    fn add(&mut self, findings: &[Finding]) {
        for finding in findings {
            self.cases += finding.values;
            self.differing += finding.differing;
            self.worst = self.worst.max(finding.worst);
        }
    }
}

/// Formats a count with a thin space before each three digits.
pub(super) fn grouped(number: usize) -> String {
    let digits = number.to_string();
    let mut out = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            out.push('\u{202f}');
        }
        out.push(digit);
    }
    out
}

/// Formats a deviation with three digits.
pub(super) fn ratio(worst: f64) -> String {
    match worst {
        0.0 => "0".to_owned(),
        worst if worst.is_finite() => format!("{worst:.3}"),
        _ => "∞".to_owned(),
    }
}
