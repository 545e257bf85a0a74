//! How a file holds the groups of proxies and their kernel maps.

use crate::bake::BakeError;
use crate::bake::sections::{blocks, check_len, check_shape, narrow};
use crate::envelope::model::{Group, Input};
use faer::Col;
use sinew_runtime::envelope::{GroupConfidence, GroupRow};

/// What the sections `groups` and `corrections` hold, and the scratch that they need.
pub(super) struct GroupSections {
    pub(super) rows: Vec<u8>,
    pub(super) words: Vec<u8>,
    pub(super) scratch_len: usize,
}

/// Writes all groups.
pub(super) fn write(groups: &[Group]) -> Result<GroupSections, BakeError> {
    let mut out = GroupSections { rows: Vec::new(), words: Vec::new(), scratch_len: 0 };
    let mut proxies = 0;
    for group in groups {
        check_len("proxies before a group", proxies, group.proxies.start)?;
        proxies = group.proxies.end;
        let row = group.row(out.words.len() / 4)?;
        group.check()?;
        out.scratch_len = out.scratch_len.max(row.scratch_len());
        out.rows.extend(row.to_bytes());
        out.words.extend(group.words()?);
    }
    Ok(out)
}

impl Group {
    fn row(&self, offset: usize) -> Result<GroupRow, BakeError> {
        let confidence = self.map.confidence;
        Ok(GroupRow {
            joint: narrow("joint of a group", self.joint)?,
            kernel: self.map.kernel.number(),
            certainty_len: narrow("certainty values of a group", confidence.len)?,
            input_len: narrow("inputs of a group", self.inputs.len())?,
            centre_len: narrow("centres of a group", self.map.centres.ncols())?,
            rank: narrow("rank of a group", self.outputs.ncols())?,
            proxy_len: narrow("proxies of a group", self.proxies.len())?,
            offset: narrow("correction words", offset)?,
            confidence: GroupConfidence {
                reach: confidence.reach as f32,
                linear: confidence.linear as f32,
                signal: confidence.signal as f32,
                noise: confidence.noise as f32,
            },
        })
    }

    fn check(&self) -> Result<(), BakeError> {
        let (d, n, r) = (self.inputs.len(), self.map.centres.ncols(), self.outputs.ncols());
        check_len("coordinates of a group's centres", d, self.map.centres.nrows())?;
        let coefficients = ["rows of a group's coefficients", "columns of a group's coefficients"];
        check_shape(coefficients, [r + self.map.confidence.len, n + d], &self.map.coefficients)?;
        check_len("rows of a group's outputs", 12 * self.proxies.len(), self.outputs.nrows())
    }

    fn words(&self) -> Result<Vec<u8>, BakeError> {
        let d = self.inputs.len();
        let mut out = Vec::new();
        for &Input { feature, .. } in &self.inputs {
            out.extend(narrow::<u32>("feature of a group", feature)?.to_le_bytes());
        }
        out.resize(4 * d.next_multiple_of(8), 0);
        let column = |values: Vec<f64>| blocks(Col::from_iter(values).as_mat());
        let centres = &self.map.centres;
        out.extend(column(self.inputs.iter().map(|input| input.weight).collect()));
        out.extend(blocks(centres.transpose()));
        // Of the rounded centres, so that the map is exactly 0 at rest.
        let at_rest = |k: usize| self.map.kernel.at_rest((0..d).map(|i| centres[(i, k)] as f32));
        out.extend(column((0..centres.ncols()).map(|k| f64::from(at_rest(k))).collect()));
        out.extend(blocks(self.map.coefficients.as_ref()));
        out.extend(blocks(self.outputs.as_ref()));
        Ok(out)
    }
}
