//! An envelope's parts, and how a file holds them.

use super::error::BakeError;
use super::groups::{self, Group};
use super::sections::{Sections, blocks, check_len, floats, names, narrow, words};
use crate::examples::Matrix3x4;
use nalgebra::Matrix4;
use sinew_runtime::envelope::{
    Certificate, ENVELOPE_SECTIONS, EnvelopeCounts, NO_JOINT, Predictor,
};
use sinew_runtime::format::SectionKind;

/// Everything that an envelope holds: what predicts a palette from a pose.
#[derive(Clone, Debug)]
pub struct EnvelopeParts {
    /// Name of the part.
    pub name: String,
    /// J names.
    pub joint_names: Vec<String>,
    /// Parent of each joint, J; `None` for the root alone.
    pub parents: Vec<Option<usize>>,
    /// The reference root.
    pub root: usize,
    /// Model-space rest frame of each joint, J; the file holds their inverses, and their origins
    /// if there are groups.
    pub rest_frames: Vec<Matrix3x4>,
    /// The proxies' reconstruction; `None` for the kernel predictor, of joints and helpers.
    pub reconstruction: Option<Reconstruction>,
    /// Kernel maps of the helpers, or of what the reconstruction leaves over. Their proxies follow
    /// each other and are all there are; a rotational envelope has no group.
    pub groups: Vec<Group>,
    /// Largest rotation of each joint relative to its parent in training, J, in radians.
    pub pose_ranges: Vec<f64>,
    /// What the fit was measured to reach.
    pub certificate: Certificate,
}

/// What predicts the transforms of P proxies: `t = c1 d + c2 q`.
#[derive(Clone, Debug)]
pub struct Reconstruction {
    /// Key predictors, P.
    pub keys: Vec<Key>,
    /// c1, row-major, 4 P x 3 P.
    pub c1: Vec<f64>,
    /// c2, row-major, 4 P x 4 J.
    pub c2: Vec<f64>,
}

impl EnvelopeParts {
    /// Returns the predictor that the parts make.
    pub fn predictor(&self) -> Predictor {
        match &self.reconstruction {
            None => Predictor::Kernel,
            Some(_) if self.groups.is_empty() => Predictor::Rotational,
            Some(_) => Predictor::Hybrid,
        }
    }

    /// Counts the proxies, P.
    pub fn proxy_len(&self) -> usize {
        let helpers = self.groups.iter().map(|group| group.proxies).sum();
        self.reconstruction.as_ref().map_or(helpers, |r| r.keys.len())
    }

    /// Counts the transforms of the palette.
    pub fn palette_len(&self) -> usize {
        let joints = if self.reconstruction.is_some() { 0 } else { self.parents.len() };
        joints + self.proxy_len()
    }

    /// Writes its sections.
    pub(super) fn sections(&self) -> Result<Sections, BakeError> {
        let groups = groups::write(&self.groups)?;
        let counts = self.counts(groups.scratch_len)?;
        let reconstruction = self.reconstruction.as_ref();
        let contents = [
            (SectionKind::EnvelopeCounts, words(&counts.words())),
            (SectionKind::Certificate, floats(&self.certificate.figures().map(f64::from))),
            (SectionKind::Names, names([&self.name].into_iter().chain(&self.joint_names))?),
            (SectionKind::Hierarchy, hierarchy(self)?),
            (SectionKind::InverseBinds, inverse_binds(&self.rest_frames)?),
            (SectionKind::Keys, keys(reconstruction.map_or(&[], |r| &r.keys))?),
            (
                SectionKind::C1,
                reconstruction.map_or(Vec::new(), |r| blocks(&r.c1, 3 * r.keys.len())),
            ),
            (
                SectionKind::C2,
                reconstruction.map_or(Vec::new(), |r| blocks(&r.c2, 4 * self.parents.len())),
            ),
            (SectionKind::PoseRanges, floats(&self.pose_ranges)),
            (SectionKind::Origins, origins(self)),
            (SectionKind::Groups, groups.rows),
            (SectionKind::Corrections, groups.words),
        ];
        debug_assert!(contents.iter().map(|(kind, _)| *kind).eq(ENVELOPE_SECTIONS));
        let own = contents.into_iter().filter(|(kind, _)| counts.has(*kind));
        Ok(own.map(|(kind, content)| (kind, true, content)).collect())
    }

    /// Checks the arrays against each other and counts them.
    fn counts(&self, correction_len: usize) -> Result<EnvelopeCounts, BakeError> {
        let (j, p) = (self.parents.len(), self.proxy_len());
        check_len("joint names", j, self.joint_names.len())?;
        check_len("rest frames", j, self.rest_frames.len())?;
        check_len("pose ranges", j, self.pose_ranges.len())?;
        if let Some(reconstruction) = &self.reconstruction {
            check_len("c1", 12 * p * p, reconstruction.c1.len())?;
            check_len("c2", 16 * p * j, reconstruction.c2.len())?;
        }
        if self.predictor().corrects() {
            let helpers = self.groups.iter().map(|group| group.proxies).sum();
            check_len("proxies of all groups", p, helpers)?;
        }
        Ok(EnvelopeCounts {
            predictor: self.predictor(),
            joint_len: narrow("joints", j)?,
            proxy_len: narrow("proxies", p)?,
            root: narrow("root", self.root)?,
            group_len: narrow("groups", self.groups.len())?,
            correction_len: narrow("scratch", correction_len)?,
        })
    }
}

/// A key predictor: `D = Q_p exp(A theta_b) [exp(A' theta_c)] (I + sym(H [theta_b; theta_p]))`.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// The joint b that it follows.
    pub joint: usize,
    /// A = u W, rows.
    pub twist: [[f64; 3]; 3],
    /// The residual joint c and its A', rows.
    pub residual: Option<(usize, [[f64; 3]; 3])>,
    /// H, rows xx, xy, xz, yy, yz, zz.
    pub shear: [[f64; 6]; 6],
}

/// Writes parents, the evaluation order (breadth first, by number), and its inverse.
fn hierarchy(parts: &EnvelopeParts) -> Result<Vec<u8>, BakeError> {
    let parents = &parts.parents;
    let mut order = Vec::from([parts.root]);
    let mut next = 0;
    while let Some(&parent) = order.get(next) {
        order.extend((0..parents.len()).filter(|&j| parents[j] == Some(parent) && j != parts.root));
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
        out.extend(floats(key.twist.as_flattened()));
        out.extend(floats(key.residual.map_or([[0.0; 3]; 3], |(_, twist)| twist).as_flattened()));
        out.extend(floats(key.shear.as_flattened()));
    }
    Ok(out)
}

/// Writes each joint's rest origin: its rest frame's last column.
fn origins(parts: &EnvelopeParts) -> Vec<u8> {
    let origins = parts.rest_frames.iter().flat_map(|rows| rows.map(|row| row[3]));
    floats(&origins.collect::<Vec<_>>())
}
