//! How a file holds an envelope.

use super::groups;
use crate::bake::sections::{blocks, check_len, check_shape, floats, names, narrow, words};
use crate::bake::{BakeError, Part};
use crate::envelope::model::{EnvelopeModel, Key, Reconstruction};
use crate::examples::{Matrix3x4, Skeleton};
use nalgebra::{Matrix4, SMatrix};
use sinew_runtime::envelope::{ENVELOPE_SECTIONS, EnvelopeCounts, NO_JOINT};
use sinew_runtime::format::{Element, PartKind, SectionKind};

impl EnvelopeModel {
    /// Writes the part.
    pub(super) fn part(&self) -> Result<Part, BakeError> {
        let groups = groups::write(&self.groups)?;
        let counts = self.counts(groups.scratch_len)?;
        let matrices = self.reconstruction.as_ref();
        let matrices = matrices.map(|r| (blocks(r.c1.as_ref()), blocks(r.c2.as_ref())));
        let (c1, c2) = matrices.unwrap_or_default();
        let all_names = [&self.name].into_iter().chain(&self.skeleton.names);
        let contents = [
            (SectionKind::EnvelopeCounts, words(&counts.words())),
            (SectionKind::Certificate, floats(&self.certificate.figures().map(f64::from))),
            (SectionKind::Names, names(all_names)?),
            (SectionKind::Hierarchy, hierarchy(&self.skeleton)?),
            (SectionKind::InverseBinds, inverse_binds(&self.skeleton.rest)?),
            (SectionKind::Keys, keys(self.keys())?),
            (SectionKind::C1, c1),
            (SectionKind::C2, c2),
            (SectionKind::PoseRanges, floats(&[&*self.pose_ranges, &self.pose_gaps].concat())),
            (SectionKind::Origins, origins(&self.skeleton.rest)),
            (SectionKind::Groups, groups.rows),
            (SectionKind::Corrections, groups.words),
        ];
        debug_assert!(contents.iter().map(|(kind, _)| *kind).eq(ENVELOPE_SECTIONS));
        let own = contents.into_iter().filter(|(kind, _)| counts.has(*kind));
        let sections = own.map(|(kind, content)| (kind, true, content)).collect();
        Ok(Part { kind: PartKind::Envelope, sections, element: Element::F32 })
    }

    /// Checks the arrays against each other and counts them.
    fn counts(&self, correction_len: usize) -> Result<EnvelopeCounts, BakeError> {
        let (j, p) = (self.joint_len(), self.proxy_len());
        check_len("joint names", j, self.skeleton.names.len())?;
        check_len("rest frames", j, self.skeleton.rest.len())?;
        check_len("pose ranges", j, self.pose_ranges.len())?;
        check_len("pose gaps", j, self.pose_gaps.len())?;
        if let Some(Reconstruction { c1, c2, .. }) = &self.reconstruction {
            check_shape(["rows of c1", "columns of c1"], [4 * p, 3 * p], c1)?;
            check_shape(["rows of c2", "columns of c2"], [4 * p, 4 * j], c2)?;
        }
        Ok(EnvelopeCounts {
            predictor: self.predictor(),
            joint_len: narrow("joints", j)?,
            proxy_len: narrow("proxies", p)?,
            root: narrow("root", self.skeleton.root())?,
            group_len: narrow("groups", self.groups.len())?,
            correction_len: narrow("scratch", correction_len)?,
        })
    }
}

/// Writes parents, the evaluation order (breadth first, by number), and its inverse.
fn hierarchy(skeleton: &Skeleton) -> Result<Vec<u8>, BakeError> {
    let (parents, root) = (&skeleton.parents, skeleton.root());
    let mut order = Vec::from([root]);
    let mut next = 0;
    while let Some(&parent) = order.get(next) {
        order.extend((0..parents.len()).filter(|&j| parents[j] == Some(parent) && j != root));
        next += 1;
    }
    let rank = |joint: usize| order.iter().position(|&j| j == joint);
    let ranks = (0..parents.len())
        .map(|joint| rank(joint).ok_or(BakeError::Hierarchy { joint }))
        .collect::<Result<Vec<_>, _>>()?;
    let mut out = Vec::new();
    for parent in parents {
        out.extend(joint_number(*parent)?);
    }
    for joint in order.into_iter().chain(ranks) {
        out.extend(joint_number(Some(joint))?);
    }
    Ok(out)
}

fn joint_number(joint: Option<usize>) -> Result<[u8; 2], BakeError> {
    joint.map_or(Ok(NO_JOINT), |joint| narrow("joint", joint)).map(u16::to_le_bytes)
}

fn inverse_binds(rest_frames: &[Matrix3x4]) -> Result<Vec<u8>, BakeError> {
    let mut out = Vec::new();
    for (joint, [x, y, z]) in rest_frames.iter().enumerate() {
        let rows = [*x, *y, *z, [0.0, 0.0, 0.0, 1.0]];
        let frame = Matrix4::from_row_slice(rows.as_flattened());
        let inverse = frame.try_inverse().ok_or(BakeError::RestFrame { joint })?;
        // The transpose's columns are the rows.
        out.extend(floats(&inverse.transpose().as_slice()[..12]));
    }
    Ok(out)
}

fn keys(keys: &[Key]) -> Result<Vec<u8>, BakeError> {
    let mut out = Vec::new();
    for key in keys {
        out.extend(joint_number(Some(key.joint))?);
        out.extend(joint_number(key.residual.map(|(joint, _)| joint))?);
        out.extend(rows(&key.twist));
        out.extend(rows(&key.residual.map(|(_, twist)| twist).unwrap_or_default()));
        out.extend(rows(&key.shear));
    }
    Ok(out)
}

/// Writes a matrix row by row.
fn rows<const R: usize, const C: usize>(matrix: &SMatrix<f64, R, C>) -> Vec<u8> {
    floats(matrix.transpose().as_slice())
}

/// Writes each joint's rest origin: its rest frame's last column.
fn origins(rest: &[Matrix3x4]) -> Vec<u8> {
    floats(&rest.iter().flat_map(|rows| rows.map(|row| row[3])).collect::<Vec<_>>())
}
