//! Stage shapes, from weights to a rest mesh.

use crate::backend::{Backend, Failure, part, poisoned_attributes};
use crate::cpu::Cpu;
use crate::finding::Finding;
use crate::shapes::ShapeSubject;
use crate::tolerance::{self, UNDERFLOW};
use sinew_gpu::layout::{Attribute, ShapesBatch};

/// Compares positions, normals and tangents of the whole mesh. Then compares a range of vertices
/// with interleaved attributes, bit by bit with the backend's whole mesh.
///
/// # Errors
/// The backend's error.
pub fn body(backend: &dyn Backend, subject: &ShapeSubject<'_>) -> Result<Vec<Finding>, Failure> {
    let batch = ShapesBatch::new(&subject.skin, subject.face_len);
    let (found, cpu) = (shaped_by(backend, subject, &batch)?, shaped_by(&Cpu, subject, &batch)?);
    let all = ["positions", "normals", "tangents"].map(Finding::new);
    let attributes = if subject.skin.has_tangents() { 3 } else { 2 };
    let mut findings: Vec<_> = all.into_iter().take(attributes).collect();
    for face in 0..subject.face_len {
        let weights = part(&subject.weights, subject.face_len, face);
        for vertex in 0..subject.skin.vertex_len() {
            let right = tolerance::shapes(subject, vertex, weights, backend.arithmetic());
            for ((finding, own), (value, error)) in
                findings.iter_mut().zip(places(&batch)).zip(right)
            {
                let errors: Vec<_> = error.iter().map(|error| error + UNDERFLOW).collect();
                let at = place(&own, face, vertex);
                let range = at..at + value.len();
                finding.compare(&found[range.clone()], &cpu[range], &value, &errors);
            }
        }
    }
    let aside = side_by_side(subject);
    let ranged = shaped_by(backend, subject, &aside)?;
    let mut range = Finding::new("a range, side by side");
    for face in 0..subject.face_len {
        for (i, vertex) in aside.vertices.clone().enumerate() {
            for ((own, whole), len) in places(&aside).zip(places(&batch)).zip([3, 3, 4]) {
                let (at, from) = (place(&own, face, i), place(&whole, face, vertex));
                range.equal(&ranged[at..][..len], &found[from..][..len]);
            }
        }
    }
    findings.push(range);
    Ok(findings)
}

/// Describes a range that starts and ends inside blocks, with interleaved attributes and gaps.
fn side_by_side(subject: &ShapeSubject<'_>) -> ShapesBatch {
    let len = subject.skin.vertex_len();
    let vertices = len / 3..(len - len / 7).max(len / 3 + 1);
    let batch = ShapesBatch { vertices, ..ShapesBatch::new(&subject.skin, subject.face_len) };
    let instance_stride = instance_stride(&batch);
    let own = |before| Some(Attribute { offset: FIRST + before, stride: STRIDE, instance_stride });
    ShapesBatch {
        positions: own(0),
        normals: own(3),
        tangents: own(6).filter(|_| subject.skin.has_tangents()),
        ..batch
    }
}

/// First float of the first vertex, and floats from a vertex to the next, with one unused.
const FIRST: usize = 1;
const STRIDE: usize = 11;

fn instance_stride(batch: &ShapesBatch) -> usize {
    STRIDE * batch.vertices.len() + 3
}

fn places(batch: &ShapesBatch) -> impl Iterator<Item = Attribute> {
    [batch.positions, batch.normals, batch.tangents].into_iter().flatten()
}

/// Returns the first float of an attribute of a face's vertex.
fn place(attribute: &Attribute, face: usize, vertex: usize) -> usize {
    attribute.offset + face * attribute.instance_stride + vertex * attribute.stride
}

/// Shapes a batch of all faces.
///
/// # Errors
/// The backend's error.
pub fn shaped_by(
    backend: &dyn Backend,
    subject: &ShapeSubject<'_>,
    batch: &ShapesBatch,
) -> Result<Vec<f32>, Failure> {
    let attributes = [(batch.positions, 3), (batch.normals, 3), (batch.tangents, 4)];
    let mut out = poisoned_attributes(&attributes, batch.vertices.len(), batch.instance_len);
    backend.shapes(subject, batch, &mut out)?;
    Ok(out)
}
