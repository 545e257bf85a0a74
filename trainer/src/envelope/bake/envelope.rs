//! Writes an envelope, its groups and their kernel maps as a part of a file.

use crate::Error;
use crate::bake::Part;
use crate::bake::sections::{blocks, check_len, check_shape, floats, names, narrow, words};
use crate::envelope::model::{EnvelopeModel, FeatureOrder, Group, Input, Key, Reconstruction};
use crate::examples::{Matrix3x4, Skeleton};
use crate::numeric::trs::Place;
use faer::Col;
use nalgebra::{Matrix4, Matrix6, SMatrix};
use sinew_runtime::envelope::{
    ENVELOPE_SECTIONS, EnvelopeCounts, GroupConfidence, GroupRow, NO_JOINT,
};
use sinew_runtime::format::{Element, PartKind, SectionKind};

impl EnvelopeModel {
    /// Writes the envelope as a part.
    ///
    /// # Errors
    /// Those of [`FileModel::bake`](crate::envelope::model::FileModel::bake) that concern an envelope.
    pub(super) fn part(&self) -> Result<Part, Error> {
        let (group_rows, corrections, scratch_len) = self.group_sections()?;
        let counts = self.counts(scratch_len)?;
        let matrices = self.reconstruction.as_ref();
        let matrices = matrices.map(|r| (blocks(r.c1.as_ref()), blocks(r.c2.as_ref())));
        let (c1, c2) = matrices.unwrap_or_default();
        let curve_names = self.curves.iter().map(|curve| &curve.name);
        let all_names = [&self.name].into_iter().chain(&self.skeleton.names).chain(curve_names);
        let stretch = self.keys().iter().flat_map(|key| rows(&stretch_of(key))).collect();
        let curve_ranges: Vec<f64> = self.curves.iter().flat_map(|curve| curve.range).collect();
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
            (SectionKind::Groups, group_rows),
            (SectionKind::Corrections, corrections),
            (SectionKind::StretchRanges, floats(self.stretch_ranges.as_deref().unwrap_or(&[]))),
            (SectionKind::KeyStretches, stretch),
            (SectionKind::CurveRanges, floats(&curve_ranges)),
            (SectionKind::HelperPlaces, places(&self.places)),
        ];
        debug_assert!(contents.iter().map(|(kind, _)| *kind).eq(ENVELOPE_SECTIONS));
        let own = contents.into_iter().filter(|(kind, _)| counts.has(*kind));
        let sections =
            own.map(|(kind, content)| (kind, kind != SectionKind::HelperPlaces, content)).collect();
        Ok(Part { kind: PartKind::Envelope, sections, element: Element::F32 })
    }

    /// Checks that the arrays have matching lengths, and counts them.
    fn counts(&self, correction_len: usize) -> Result<EnvelopeCounts, Error> {
        let (j, p) = (self.joint_len(), self.proxy_len());
        check_len("joint names", j, self.skeleton.names.len())?;
        check_len("rest frames", j, self.skeleton.rest.len())?;
        check_len("pose ranges", j, self.pose_ranges.len())?;
        check_len("pose gaps", j, self.pose_gaps.len())?;
        check_len("stretch ranges", j, self.stretch_ranges.as_ref().map_or(j, Vec::len))?;
        check_len("helper places", p, self.places.len())?;
        if let Some(Reconstruction { c1, c2, .. }) = &self.reconstruction {
            check_shape(["rows of c1", "columns of c1"], [4 * p, 3 * p], c1)?;
            check_shape(["rows of c2", "columns of c2"], [4 * p, 4 * j], c2)?;
        }
        Ok(EnvelopeCounts {
            predictor: self.predictor(),
            joint_len: narrow("joints", j)?,
            proxy_len: narrow("helpers", p)?,
            root: narrow("root", self.skeleton.root())?,
            group_len: narrow("groups", self.groups.len())?,
            correction_len: narrow("scratch", correction_len)?,
            stretches: self.stretch_ranges.is_some(),
            curve_len: narrow("curves", self.curves.len())?,
            helper_kind: self.helper_kind,
        })
    }
}

/// Writes parents, the evaluation order (breadth first, then by index), and the inverse of that order.
fn hierarchy(skeleton: &Skeleton) -> Result<Vec<u8>, Error> {
    let (parents, root) = (&skeleton.parents, skeleton.root());
    let mut order: Vec<usize> = (0..parents.len()).filter(|&joint| joint == root).collect();
    let mut next = 0;
    while let Some(&parent) = order.get(next) {
        order.extend((0..parents.len()).filter(|&j| parents[j] == Some(parent) && j != root));
        next += 1;
    }
    let rank = |joint: usize| {
        let apart = || Error::value(format!("joint {joint} does not descend from the root"));
        order.iter().position(|&j| j == joint).ok_or_else(apart)
    };
    let ranks = (0..parents.len()).map(rank).collect::<Result<Vec<_>, _>>()?;
    let mut out = Vec::new();
    for parent in parents {
        out.extend(joint_number(*parent)?);
    }
    for joint in order.into_iter().chain(ranks) {
        out.extend(joint_number(Some(joint))?);
    }
    Ok(out)
}

/// Encodes a joint index; `None` becomes [`NO_JOINT`].
fn joint_number(joint: Option<usize>) -> Result<[u8; 2], Error> {
    joint.map_or(Ok(NO_JOINT), |joint| narrow("joint", joint)).map(u16::to_le_bytes)
}

/// Writes the inverses of the rest frames: rows of 3 x 4 matrices.
fn inverse_binds(rest_frames: &[Matrix3x4]) -> Result<Vec<u8>, Error> {
    let mut out = Vec::new();
    for (joint, [x, y, z]) in rest_frames.iter().enumerate() {
        let rows = [*x, *y, *z, [0.0, 0.0, 0.0, 1.0]];
        let frame = Matrix4::from_row_slice(rows.as_flattened());
        let singular =
            || Error::value(format!("the rest frame of joint {joint} cannot be inverted"));
        let inverse = frame.try_inverse().ok_or_else(singular)?;
        // Columns of the transpose are rows of the inverse.
        out.extend(floats(&inverse.transpose().as_slice()[..12]));
    }
    Ok(out)
}

/// Writes the keys: joints, twists and shear.
fn keys(keys: &[Key]) -> Result<Vec<u8>, Error> {
    let mut out = Vec::new();
    for key in keys {
        out.extend(joint_number(Some(key.joint))?);
        out.extend(joint_number(key.residual.map(|(joint, _)| joint))?);
        out.extend(rows(&key.twist));
        out.extend(rows(&key.residual.map(|(_, twist)| twist).unwrap_or_default()));
        out.extend(rows(&key.shear.fixed_columns::<6>(0).into_owned()));
    }
    Ok(out)
}

/// Returns the part of a key's shear that follows the strain.
fn stretch_of(key: &Key) -> Matrix6<f64> {
    key.shear.fixed_columns::<6>(6).into_owned()
}

/// Writes a matrix row by row.
fn rows<const R: usize, const C: usize>(matrix: &SMatrix<f64, R, C>) -> Vec<u8> {
    floats(matrix.transpose().as_slice())
}

/// Writes the rest origins: the last columns of the rest frames.
fn origins(rest: &[Matrix3x4]) -> Vec<u8> {
    floats(&rest.iter().flat_map(|rows| rows.map(|row| row[3])).collect::<Vec<_>>())
}

/// Writes the places of helpers: the centre, then the upper triangle of the spread, row by row.
fn places(places: &[Place]) -> Vec<u8> {
    let of = |Place { centre: c, spread: s }: &Place| {
        let upper = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|at| s[at]);
        [c.x, c.y, c.z].into_iter().chain(upper)
    };
    floats(&places.iter().flat_map(of).collect::<Vec<_>>())
}

impl EnvelopeModel {
    /// Writes the sections `groups` and `corrections`: all groups and their kernel maps. Also returns the length of
    /// their scratch.
    fn group_sections(&self) -> Result<(Vec<u8>, Vec<u8>, usize), Error> {
        let (mut rows, mut corrections) = (Vec::new(), Vec::new());
        let (mut proxies, mut scratch_len) = (0, 0);
        for group in &self.groups {
            check_len("helpers before a group", proxies, group.proxies.start)?;
            proxies = group.proxies.end;
            let joint = if self.joint_len() > 0 { Some(group.joint) } else { None };
            let row = group.row(joint, corrections.len() / 4)?;
            group.check()?;
            scratch_len = scratch_len.max(row.scratch_len());
            rows.extend(row.to_bytes());
            corrections.extend(group.words(self.feature_order())?);
        }
        Ok((rows, corrections, scratch_len))
    }
}

impl Group {
    /// Returns the row of the group.
    ///
    /// - `joint`: its dominant joint; `None` if the envelope has no joint.
    /// - `offset`: of its words in the section `corrections`.
    fn row(&self, joint: Option<usize>, offset: usize) -> Result<GroupRow, Error> {
        let confidence = self.map.confidence;
        Ok(GroupRow {
            joint: joint.map_or(Ok(NO_JOINT), |joint| narrow("joint of a group", joint))?,
            kernel: self.map.kernel.number(),
            certainty_len: narrow("certainty values of a group", confidence.len)?,
            input_len: narrow("inputs of a group", self.inputs.len())?,
            centre_len: narrow("centres of a group", self.map.centres.ncols())?,
            rank: narrow("rank of a group", self.outputs.ncols())?,
            proxy_len: narrow("helpers of a group", self.proxies.len())?,
            offset: narrow("correction words", offset)?,
            confidence: GroupConfidence {
                reach: confidence.reach as f32,
                linear: confidence.linear as f32,
                signal: confidence.signal as f32,
                noise: confidence.noise as f32,
            },
        })
    }

    /// Checks that the arrays of the group have matching shapes.
    fn check(&self) -> Result<(), Error> {
        let (d, n, r) = (self.inputs.len(), self.map.centres.ncols(), self.outputs.ncols());
        check_len("coordinates of a group's centres", d, self.map.centres.nrows())?;
        let coefficients = ["rows of a group's coefficients", "columns of a group's coefficients"];
        check_shape(coefficients, [r + self.map.confidence.len, n + d], &self.map.coefficients)?;
        check_len("rows of a group's outputs", 12 * self.proxies.len(), self.outputs.nrows())
    }

    /// Writes the arrays of the group, each padded to blocks.
    ///
    /// - `order`: of the features.
    fn words(&self, order: FeatureOrder) -> Result<Vec<u8>, Error> {
        let d = self.inputs.len();
        let mut out = Vec::new();
        for &Input { feature, .. } in &self.inputs {
            let index = order.index(feature);
            out.extend(narrow::<u32>("feature of a group", index)?.to_le_bytes());
        }
        out.resize(4 * d.next_multiple_of(8), 0);
        let column = |values: Vec<f64>| blocks(Col::from_iter(values).as_mat());
        let centres = &self.map.centres;
        out.extend(column(self.inputs.iter().map(|input| input.weight).collect()));
        let factor = f64::from(self.map.kernel.centre_factor());
        out.extend(blocks((faer::Scale(factor) * centres.transpose()).as_ref()));
        // From the rounded centres, so that the map is exactly 0 at rest.
        let at_rest = |k: usize| self.map.kernel.at_rest((0..d).map(|i| centres[(i, k)] as f32));
        out.extend(column((0..centres.ncols()).map(|k| f64::from(at_rest(k))).collect()));
        out.extend(blocks(self.map.coefficients.as_ref()));
        out.extend(blocks(self.outputs.as_ref()));
        Ok(out)
    }
}
