//! A group of proxies, read in place (METHOD §1.9).

use super::group_kernel::GroupKernel;
use super::group_map::Map;
use super::group_row::GroupRow;
use super::trust::Trust;
use super::view::Envelope;
use crate::linear::Le;
use crate::linear::padded;
use core::fmt;
use core::ops::Range;

/// Proxies that share a dominant joint and one kernel map, `K = outputs (C (G(s) - rest) + A x)`,
/// of inputs `x_i = weight_i phi[feature_i]`.
///
/// Accessors by number return `None` beyond their range.
#[derive(Clone)]
pub struct Group<'a> {
    /// The dominant joint.
    pub joint: usize,
    /// G.
    pub kernel: GroupKernel,
    /// The proxies, of `0..proxy_len`.
    pub proxies: Range<usize>,
    /// How well it knows a pose.
    pub trust: Trust,
    features: &'a [Le],
    weights: &'a [Le],
    pub(crate) map: Map<'a>,
}

impl<'a> Group<'a> {
    fn new(row: &GroupRow, proxies: Range<usize>, words: &'a [Le]) -> Option<Self> {
        let (shape, trust) = (row.shape(), row.trust);
        let kernel = GroupKernel::from_number(row.kernel)?;
        let (features, words) = words.split_at_checked(padded(shape.input_len))?;
        let (weights, words) = words.split_at_checked(padded(shape.input_len))?;
        let map = Map::new(shape, kernel, trust, words)?;
        let joint = row.joint.into();
        Some(Self { joint, kernel, proxies, trust, features, weights, map })
    }

    /// Returns d, the number of inputs.
    pub fn input_len(&self) -> usize {
        self.map.shape.input_len
    }

    /// Returns n, the number of centres. A group without any adds nothing.
    pub fn centre_len(&self) -> usize {
        self.map.shape.centre_len
    }

    /// Returns r, the number of latent values.
    pub fn rank(&self) -> usize {
        self.map.shape.rank
    }

    /// Returns m, the number of values that tell how well a pose is known.
    pub fn certainty_len(&self) -> usize {
        self.map.shape.certainty_len
    }

    /// Returns an input: the index of its feature, 12 j + 4 r + c, and its weight.
    pub fn input(&self, i: usize) -> Option<(usize, f32)> {
        self.inputs().nth(i)
    }

    /// Lists the d inputs.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = (usize, f32)> + use<'a> {
        let inputs = self.features.iter().zip(self.weights).take(self.input_len());
        inputs.map(|(feature, weight)| {
            (u32::from_le_bytes(*feature) as usize, f32::from_le_bytes(*weight))
        })
    }

    /// Returns coordinate i of centre k.
    pub fn centre(&self, k: usize, i: usize) -> Option<f32> {
        self.map.centre(k, i)
    }

    /// Returns the kernel of centre k at x = 0, which is subtracted.
    pub fn rest(&self, k: usize) -> Option<f32> {
        self.map.rest(k)
    }

    /// Returns a coefficient of [C A] ((r + m) x (n + d)): the latent values' rows, then those of the m.
    pub fn coefficient(&self, row: usize, column: usize) -> Option<f32> {
        self.map.coefficient(row, column)
    }

    /// Returns a coefficient of the outputs (12 p x r): row 12 l + 4 r + c is entry r, c of the
    /// group's l-th proxy.
    pub fn output(&self, row: usize, column: usize) -> Option<f32> {
        self.map.output(row, column)
    }
}

impl fmt::Debug for Group<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { joint, kernel, proxies, trust, .. } = self;
        f.debug_struct("Group")
            .field("joint", joint)
            .field("kernel", kernel)
            .field("proxies", proxies)
            .field("trust", trust)
            .finish_non_exhaustive()
    }
}

impl<'a> Envelope<'a> {
    /// Lists the G groups; their proxies follow each other.
    pub fn groups(&self) -> impl Iterator<Item = Group<'a>> + use<'a> {
        let words = self.corrections();
        let mut end = 0;
        self.group_rows().map_while(move |row| {
            let start = end;
            end += usize::from(row.proxy_len);
            Group::new(&row, start..end, words.get(row.offset as usize..)?)
        })
    }

    /// Returns a group.
    pub fn group(&self, index: usize) -> Option<Group<'a>> {
        self.groups().nth(index)
    }
}
