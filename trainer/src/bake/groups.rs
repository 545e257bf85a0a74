//! The groups of proxies and their kernel maps, as a file holds them.

use super::error::BakeError;
use super::sections::{blocks, check_len, narrow};
use sinew_runtime::envelope::GroupRow;
use sinew_runtime::kernel::Kernel;

/// Proxies that share a dominant joint and one kernel map: `K = outputs (C (G(s) - G(s at rest)) +
/// A x)`, of inputs `x_i = weight_i phi[feature_i]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// The dominant joint.
    pub joint: usize,
    /// G.
    pub kernel: Kernel,
    /// Number of proxies, p: those that follow the previous group's.
    pub proxies: usize,
    /// Feature, 12 j + 4 r + c, and weight of each input, d.
    pub inputs: Vec<(usize, f64)>,
    /// Centres in weighted coordinates, n lists of d.
    pub centres: Vec<Vec<f64>>,
    /// [C A], row-major, r x (n + d).
    pub coefficients: Vec<f64>,
    /// Latent values, r.
    pub rank: usize,
    /// Outputs, row-major, 12 p x r; row 12 l + 4 r + c is entry r, c of the group's l-th proxy.
    pub outputs: Vec<f64>,
    /// Squared distances at which a centre stops to vouch for a pose wholly, and at all.
    pub fade: (f64, f64),
}

/// What the sections `groups` and `corrections` hold, and the scratch that they need.
pub(super) struct Groups {
    pub(super) rows: Vec<u8>,
    pub(super) words: Vec<u8>,
    pub(super) scratch_len: usize,
}

/// Writes all groups.
pub(super) fn write(groups: &[Group]) -> Result<Groups, BakeError> {
    let mut out = Groups { rows: Vec::new(), words: Vec::new(), scratch_len: 0 };
    for group in groups {
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
        Ok(GroupRow {
            joint: narrow("joint of a group", self.joint)?,
            kernel: self.kernel.number(),
            reserved: 0,
            input_len: narrow("inputs of a group", self.inputs.len())?,
            centre_len: narrow("centres of a group", self.centres.len())?,
            rank: narrow("rank of a group", self.rank)?,
            proxy_len: narrow("proxies of a group", self.proxies)?,
            offset: narrow("correction words", offset)?,
            fade_start: self.fade.0 as f32,
            fade_end: self.fade.1 as f32,
        })
    }

    fn check(&self) -> Result<(), BakeError> {
        let (d, n, r) = (self.inputs.len(), self.centres.len(), self.rank);
        for centre in &self.centres {
            check_len("centre of a group", d, centre.len())?;
        }
        check_len("coefficients of a group", r * (n + d), self.coefficients.len())?;
        check_len("outputs of a group", 12 * self.proxies * r, self.outputs.len())
    }

    fn words(&self) -> Result<Vec<u8>, BakeError> {
        let (d, n) = (self.inputs.len(), self.centres.len());
        let mut out = Vec::new();
        for &(feature, _) in &self.inputs {
            out.extend(narrow::<u32>("feature of a group", feature)?.to_le_bytes());
        }
        out.resize(4 * d.next_multiple_of(8), 0);
        let weights: Vec<_> = self.inputs.iter().map(|&(_, weight)| weight).collect();
        out.extend(blocks(&weights, 1));
        out.extend(blocks(&self.centres.concat(), d));
        // Of the rounded centres, so that the map is exactly 0 at rest.
        let rest = self.centres.iter().map(|t| self.kernel.at_rest(t.iter().map(|&t| t as f32)));
        out.extend(blocks(&rest.map(f64::from).collect::<Vec<_>>(), 1));
        out.extend(blocks(&self.coefficients, n + d));
        out.extend(blocks(&self.outputs, self.rank));
        Ok(out)
    }
}
