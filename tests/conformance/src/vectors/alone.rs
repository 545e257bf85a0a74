//! Cases of one stage: a kernel with queries, the shapes of a skin with weights, a filter with signals.

use super::written::{Tolerance, Written, numbers_tolerance};
use super::{Folder, VectorError};
use crate::backend::part;
use crate::cpu::Cpu;
use crate::filters::FilterSubject;
use crate::kernels::KernelSubject;
use crate::shapes::ShapeSubject;
use crate::stages::filter::finer_by;
use crate::stages::kernel::outputs_of;
use crate::stages::shapes::shaped_by;
use crate::tolerance::{self, Arithmetic};
use serde::Serialize;
use sinew_gpu::layout::{Attribute, ShapesBatch, Stage};
use sinew_runtime::filter::Samples;

#[derive(Serialize)]
struct KernelCounts {
    queries: usize,
    query_len: usize,
    output_len: usize,
}

/// Evaluates a kernel, and writes queries and outputs into a folder with the name of the case.
///
/// # Errors
/// [`VectorError`]
pub(super) fn kernel(
    case: &str,
    bytes: &[u8],
    query_len: usize,
    folder: &Folder,
) -> Result<(), VectorError> {
    let subject = KernelSubject::new(bytes, query_len);
    let (n, r, len) = (query_len, subject.kernel.query_len(), subject.kernel.result_len());
    let counts = KernelCounts { queries: n, query_len: r, output_len: len };
    let mut written = Written::new(case, None, counts);
    let (outputs, confidences) = outputs_of(&Cpu, &subject)?;
    written.array("query", vec![n, r], &subject.queries);
    written.array("output", vec![n, len], &outputs);
    written.array("confidence", vec![n], &confidences);
    let bounds = (0..n).map(|i| {
        let query = part(&subject.queries, n, i);
        tolerance::kernel(&subject.oracle, query, Arithmetic::VULKAN)
    });
    let (numbers, certain): (Vec<_>, Vec<_>) = bounds.unzip();
    let mut tolerances = Tolerance::new();
    for (i, right) in numbers.iter().enumerate() {
        let found = part(&outputs, n, i).iter();
        let right = right.value.iter().zip(&right.error);
        found.zip(right).for_each(|(x, (value, error))| tolerances.add(*x, *value, *error));
    }
    let confidence = numbers_tolerance(&confidences, &certain);
    let outputs = vec![("output", tolerances.0), ("confidence", confidence)];
    written.stage(Stage::Kernel.name(), &["query"], outputs);
    written.write(bytes, folder)
}

#[derive(Serialize)]
struct ShapeCounts {
    faces: usize,
    shapes: usize,
    vertices: usize,
}

/// Evaluates the shapes of a skin, and writes weights and meshes into a folder with the name of the
/// case.
///
/// # Errors
/// [`VectorError`]
pub(super) fn shapes(
    case: &str,
    bytes: &[u8],
    face_len: usize,
    folder: &Folder,
) -> Result<(), VectorError> {
    let subject = ShapeSubject::new(bytes, face_len);
    let (n, s, v) = (face_len, subject.skin.shape_len(), subject.skin.vertex_len());
    let mut written = Written::new(case, None, ShapeCounts { faces: n, shapes: s, vertices: v });
    written.array("weight", vec![n, s], &subject.weights);
    let batch = ShapesBatch::new(&subject.skin, n);
    let found = shaped_by(&Cpu, &subject, &batch)?;
    let attributes = [
        ("positions", batch.positions, 3),
        ("normals", batch.normals, 3),
        ("tangents", batch.tangents, 4),
    ];
    let attributes: Vec<_> = attributes
        .into_iter()
        .filter_map(|(name, attribute, len)| Some((name, attribute?, len)))
        .collect();
    let mut values = vec![Vec::new(); attributes.len()];
    let mut tolerances: Vec<_> = attributes.iter().map(|_| Tolerance::new()).collect();
    for (face, vertex) in (0..n).flat_map(|face| (0..v).map(move |vertex| (face, vertex))) {
        let weights = part(&subject.weights, n, face);
        let right = tolerance::shapes(&subject, vertex, weights, Arithmetic::VULKAN);
        for (i, (value, error)) in right.iter().enumerate() {
            let (_, Attribute { offset, stride, instance_stride }, len) = attributes[i];
            let own = &found[offset + face * instance_stride + vertex * stride..][..len];
            values[i].extend_from_slice(own);
            let right = value.iter().zip(error);
            own.iter().zip(right).for_each(|(x, (value, e))| tolerances[i].add(*x, *value, *e));
        }
    }
    let mut outputs = Vec::new();
    for (((name, _, len), values), tolerance) in attributes.iter().zip(&values).zip(tolerances) {
        written.array(name, vec![n, v, *len], values);
        outputs.push((*name, tolerance.0));
    }
    written.stage(Stage::Shapes.name(), &["weight"], outputs);
    written.write(bytes, folder)
}

#[derive(Serialize)]
struct FilterCounts {
    signals: usize,
    samples: usize,
    lanes: usize,
    factor: usize,
}

/// Makes signals finer, and writes them into a folder with the name of the case.
///
/// # Errors
/// [`VectorError`]
pub(super) fn filter(
    case: &str,
    bytes: &[u8],
    subject: &FilterSubject<'_>,
    folder: &Folder,
) -> Result<(), VectorError> {
    let Samples { signal_len: signals, sample_len: samples, lane_len: lanes } = subject.shape;
    let factor = subject.filter.factor();
    let mut written = Written::new(case, None, FilterCounts { signals, samples, lanes, factor });
    let fine = finer_by(&Cpu, subject)?;
    written.array("sample", vec![signals, samples, lanes], &subject.samples);
    written.array("fine", vec![signals, samples * factor, lanes], &fine);
    let mut tolerance = Tolerance::new();
    for (place, found) in fine.iter().enumerate() {
        let (value, error) = tolerance::filter(subject, place);
        tolerance.add(*found, value, error);
    }
    written.stage(Stage::Filter.name(), &["sample"], vec![("fine", tolerance.0)]);
    written.write(bytes, folder)
}
