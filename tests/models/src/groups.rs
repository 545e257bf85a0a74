//! Groups of proxies with their kernel maps, whose fields may be invalid.

use crate::bytes::{blocks, floats, group_row, words};
use crate::pieces::Pieces;
use crate::rng::Rng;
use crate::shape::Shape;
use sinew_runtime::envelope::{GroupConfidence, GroupKernel, GroupRow, NO_JOINT};
use sinew_runtime::format::SectionKind;

/// Number of certainty values m of a sample.
const CERTAINTY: usize = 2;

/// A group as plain lists.
#[derive(Clone)]
pub struct GroupContent {
    /// Dominant joint; [`NO_JOINT`] without joints.
    pub joint: usize,
    /// Kernel of the group's map.
    pub kernel: GroupKernel,
    /// Number of proxies p.
    pub proxies: usize,
    /// d inputs: feature and weight.
    pub inputs: Vec<(u32, f32)>,
    /// n centres of d numbers.
    pub centres: Vec<Vec<f32>>,
    /// r rows of n + d, then m rows.
    pub coefficients: Vec<Vec<f32>>,
    /// Number of certainty values m.
    pub certainty: usize,
    /// 12 p rows of r.
    pub outputs: Vec<Vec<f32>>,
    /// How the values of the last m rows count.
    pub confidence: GroupConfidence,
}

impl GroupContent {
    /// Makes a group of random numbers for a sample of a shape; `sizes` is `[d, n, r]`. Every second
    /// input is a strain or a curve, if the shape has any.
    pub fn sample(rng: &mut Rng, shape: Shape, proxies: usize, sizes: [usize; 3]) -> Self {
        let [d, n, r] = sizes;
        let mut list =
            |len: usize, scale: f32| (0..len).map(|_| rng.unit() * scale).collect::<Vec<_>>();
        let inputs = list(d, 1.0).into_iter().enumerate();
        let of_joints = 12 * shape.joints;
        let others = shape.feature_len() - of_joints;
        let feature = |i: usize| match (of_joints, others) {
            (0, _) => i % others,
            (_, 0) => (5 * i + 1) % of_joints,
            _ if i.is_multiple_of(2) => (5 * i + 1) % of_joints,
            _ => of_joints + others - 1 - 7 * (i / 2) % others,
        };
        Self {
            joint: proxies.checked_rem(shape.joints).unwrap_or(NO_JOINT.into()),
            kernel: GroupKernel::ALL[(d + n) % GroupKernel::ALL.len()],
            proxies,
            inputs: inputs.map(|(i, x)| (feature(i) as u32, 1.5 + x)).collect(),
            centres: (0..n).map(|_| list(d, 0.5)).collect(),
            coefficients: (0..r + CERTAINTY).map(|_| list(n + d, 0.5)).collect(),
            certainty: CERTAINTY,
            outputs: (0..12 * proxies).map(|_| list(r, 0.5)).collect(),
            confidence: GroupConfidence { reach: 8.0, linear: 0.25, signal: 2.0, noise: 3.0 },
        }
    }

    /// Evaluates the kernel of each centre at x = 0, as a reader computes it.
    pub fn rest(&self) -> Vec<f32> {
        self.centres.iter().map(|t| self.kernel.at_rest(t.iter().copied())).collect()
    }

    /// Returns the group's row of section `groups`; the group's words start at `offset`.
    pub fn row(&self, offset: usize) -> GroupRow {
        GroupRow {
            joint: self.joint as u16,
            kernel: self.kernel.number(),
            certainty_len: self.certainty as u8,
            input_len: self.inputs.len() as u16,
            centre_len: self.centres.len() as u16,
            rank: (self.coefficients.len() - self.certainty) as u16,
            proxy_len: self.proxies as u16,
            offset: offset as u32,
            confidence: self.confidence,
        }
    }

    /// Returns the group's words of section `corrections`.
    pub fn words(&self) -> Vec<u8> {
        let d = self.inputs.len().next_multiple_of(8);
        let mut features = vec![0; d];
        let mut weights = vec![0.0; d];
        for (i, &(feature, weight)) in self.inputs.iter().enumerate() {
            (features[i], weights[i]) = (feature, weight);
        }
        let mut rest = self.rest();
        rest.resize(rest.len().next_multiple_of(8), 0.0);
        let factor = self.kernel.centre_factor();
        let doubled = |t: &Vec<f32>| t.iter().map(|t| factor * t).collect();
        let centres: Vec<Vec<f32>> = self.centres.iter().map(doubled).collect();
        let matrices = [&centres, &self.coefficients, &self.outputs].map(|m| blocks(m));
        let [centres, coefficients, outputs] = matrices;
        [words(&features), floats(&weights), centres, floats(&rest), coefficients, outputs].concat()
    }

    /// Returns the floats of scratch, by the formula of FORMAT.md.
    fn scratch(&self) -> usize {
        let lens = [self.inputs.len(), self.centres.len(), self.coefficients.len()];
        lens.into_iter().chain([12 * self.proxies]).map(|len| 8 * len.div_ceil(8)).sum()
    }
}

/// Splits the P proxies of a sample into up to three groups of different sizes and kernels.
pub fn sample_groups(shape: Shape) -> Vec<GroupContent> {
    let mut rng = Rng(1992);
    let sizes = [[5, 11, 3], [9, 3, 1], [1, 17, 10]];
    let mut left = shape.proxies;
    let mut groups = Vec::new();
    for (i, sizes) in sizes.into_iter().enumerate() {
        let own = if i == 2 { left } else { left.min(i + 1) };
        if own > 0 {
            groups.push(GroupContent::sample(&mut rng, shape, own, sizes));
        }
        left -= own;
    }
    groups
}

impl Pieces {
    /// Replaces the groups of the first envelope, and every value that depends on them.
    ///
    /// # Panics
    /// If the file has no envelope.
    pub fn set_groups(&mut self, groups: &[GroupContent]) {
        let (mut rows, mut words) = (Vec::new(), Vec::new());
        for group in groups {
            rows.extend(group_row(&group.row(words.len() / 4)));
            words.extend(group.words());
        }
        let scratch = groups.iter().map(GroupContent::scratch).max().unwrap_or(0);
        self.set_word(SectionKind::EnvelopeCounts, 4, groups.len() as u32);
        self.set_word(SectionKind::EnvelopeCounts, 5, scratch as u32);
        *self.section(SectionKind::Groups) = rows;
        *self.section(SectionKind::Corrections) = words;
    }

    /// Changes a row of the groups of the first envelope.
    ///
    /// # Panics
    /// If the file has no envelope.
    pub fn edit_group(&mut self, group: usize, edit: impl FnOnce(&mut GroupRow)) {
        let rows = self.section(SectionKind::Groups).as_chunks_mut().0;
        let mut row = GroupRow::from_bytes(&rows[group]);
        edit(&mut row);
        rows[group] = group_row(&row);
    }
}
