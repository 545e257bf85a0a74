//! Stage skin, on the palettes of the poses.

use super::gradients::exact;
use crate::backend::{Backend, Failure, Whole, part, poisoned_out};
use crate::cpu::Cpu;
use crate::finding::Finding;
use crate::subject::Subject;
use crate::tolerance::{self, Arithmetic, Inexact, Transform, UNDERFLOW};
use sinew_gpu::layout::{Attribute, SkinBatch};
use sinew_runtime::{Matrix3x4, Skin};

/// Every attribute of every vertex of n instances, one list for each attribute.
#[derive(Debug)]
pub struct Skinned {
    /// Positions.
    pub positions: Vec<f32>,
    /// Normals.
    pub normals: Vec<f32>,
    /// Tangents; empty if the model has none.
    pub tangents: Vec<f32>,
}

/// Compares positions, normals and tangents.
///
/// # Errors
/// The backend's error.
pub fn body(backend: &dyn Backend, subject: &Subject<'_>) -> Result<Vec<Finding>, Failure> {
    let n = subject.poses.len();
    let palettes = whole_of(&Cpu, subject)?.palettes;
    let found = skinned_by(backend, subject, &palettes)?;
    let cpu = skinned_by(&Cpu, subject, &palettes)?;
    let mut findings = findings(&subject.loaded.skin);
    for i in 0..n {
        let (found, cpu) = (found.at(n, i), cpu.at(n, i));
        let palette = exact(part(&palettes, n, i));
        compare(&mut findings, (&found, &cpu), subject, &palette, backend.arithmetic());
    }
    Ok(findings)
}

/// Starts a finding for each attribute of a skin.
pub fn findings(skin: &Skin<'_>) -> Vec<Finding> {
    let all = ["positions", "normals", "tangents"].map(Finding::new);
    all.into_iter().take(if skin.has_tangents() { 3 } else { 2 }).collect()
}

/// Evaluates every pose, from pose to skin.
///
/// # Errors
/// The backend's error.
pub fn whole_of(backend: &dyn Backend, subject: &Subject<'_>) -> Result<Whole, Failure> {
    let (envelope, n) = (&subject.loaded.envelope, subject.poses.len());
    let skin = SkinBatch::new(&subject.loaded.skin);
    let mut out = Whole::poisoned(envelope, &skin, n);
    backend.whole(&subject.loaded, subject.inputs(), &skin, &mut out)?;
    Ok(out)
}

/// Skins the whole mesh by every palette.
///
/// # Errors
/// The backend's error.
pub fn skinned_by(
    backend: &dyn Backend,
    subject: &Subject<'_>,
    palettes: &[Matrix3x4],
) -> Result<Skinned, Failure> {
    let n = palettes.len() / subject.loaded.envelope.palette_len();
    let skin = SkinBatch::new(&subject.loaded.skin);
    let mut out = poisoned_out(&skin, n);
    backend.skin(&subject.loaded, palettes, &skin, &mut out)?;
    Ok(Skinned::gather(&out, &skin, n))
}

impl Skinned {
    /// Gathers the attributes of n instances from a backend's floats.
    pub fn gather(out: &[f32], skin: &SkinBatch, n: usize) -> Self {
        let pick = |attribute: Option<Attribute>, own: usize| -> Vec<f32> {
            let Some(attribute) = attribute else { return Vec::new() };
            let starts = places(&attribute, skin, n);
            starts.flat_map(|start| out[start..start + own].iter().copied()).collect()
        };
        Self {
            positions: pick(skin.positions, 3),
            normals: pick(skin.normals, 3),
            tangents: pick(skin.tangents, 4),
        }
    }

    /// Returns the attributes of instance i.
    pub fn at(&self, n: usize, i: usize) -> [&[f32]; 3] {
        [&self.positions, &self.normals, &self.tangents].map(|list| part(list, n, i))
    }
}

/// Lists the first float of an attribute for each vertex of each instance.
pub fn places(attribute: &Attribute, skin: &SkinBatch, n: usize) -> impl Iterator<Item = usize> {
    let (Attribute { offset, stride, instance_stride }, len) = (*attribute, skin.vertices.len());
    (0..n).flat_map(move |i| (0..len).map(move |v| offset + i * instance_stride + v * stride))
}

/// Compares one instance's skin with the CPU's bits, and with the oracle's skin by the given
/// palette.
pub fn compare(
    findings: &mut [Finding],
    (found, cpu): (&[&[f32]; 3], &[&[f32]; 3]),
    subject: &Subject<'_>,
    palette: &Inexact<Transform>,
    arithmetic: Arithmetic,
) {
    let (mut expected, mut tolerances) = ([const { Vec::new() }; 3], [const { Vec::new() }; 3]);
    for (number, vertex) in subject.skin.vertices().enumerate() {
        let own = (&subject.loaded.skin, number);
        let skinned = tolerance::skin(own, &vertex, palette, arithmetic);
        expected[0].extend(&skinned.position);
        tolerances[0].extend(skinned.position_error.iter().map(|e| e + UNDERFLOW));
        expected[1].extend(&skinned.normal.value);
        tolerances[1].extend([skinned.normal.error + UNDERFLOW; 3]);
        if let Some((tangent, hand)) = skinned.tangent {
            expected[2].extend(tangent.value.push(hand).iter());
            // The handedness is copied.
            let along = tangent.error + UNDERFLOW;
            tolerances[2].extend([along, along, along, 0.0]);
        }
    }
    for (attribute, finding) in findings.iter_mut().enumerate() {
        let (found, cpu) = (found[attribute], cpu[attribute]);
        finding.compare(found, cpu, &expected[attribute], &tolerances[attribute]);
    }
}
