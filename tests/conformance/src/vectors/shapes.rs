//! One skin with weights of its shapes, and the rest meshes that they make.

use super::tolerances::Tolerance;
use super::written::Written;
use super::{Folder, VectorError};
use crate::backend::{Cpu, part};
use crate::shapes::ShapeSubject;
use crate::stages::shapes::shaped_by;
use crate::tolerance::{self, Arithmetic};
use serde::Serialize;
use sinew_gpu::layout::{Attribute, ShapesBatch, Stage};

#[derive(Serialize)]
struct Counts {
    faces: usize,
    shapes: usize,
    vertices: usize,
}

/// Shapes a skin, and writes it into a folder of the case's name.
///
/// # Errors
/// [`VectorError`]
pub(super) fn write(
    case: &str,
    bytes: &[u8],
    face_len: usize,
    folder: &Folder,
) -> Result<(), VectorError> {
    let subject = ShapeSubject::new(bytes, face_len);
    let (n, s, v) = (face_len, subject.skin.shape_len(), subject.skin.vertex_len());
    let mut written = Written::new(case, None, Counts { faces: n, shapes: s, vertices: v });
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
