//! Rows of section `groups`, and the sizes that follow from a row.

use super::confidence::GroupConfidence;
use crate::linear::padded;

/// Row of section `groups`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroupRow {
    /// Dominant joint.
    pub joint: u16,
    /// Number of a [`super::GroupKernel`].
    pub kernel: u8,
    /// Values of the map whose squares sum to the explained variance, m.
    pub certainty_len: u8,
    /// Inputs, d.
    pub input_len: u16,
    /// Centres, n; a group without centres adds nothing.
    pub centre_len: u16,
    /// Latent values, r.
    pub rank: u16,
    /// Helpers of the group, which follow the previous group's helpers.
    pub proxy_len: u16,
    /// First word of the group in section `corrections`.
    pub offset: u32,
    /// Parameters of the group's confidence.
    pub confidence: GroupConfidence,
}

/// Sizes of a group's kernel map.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape {
    /// Inputs, d.
    pub(crate) input_len: usize,
    /// Centres, n.
    pub(crate) centre_len: usize,
    /// Latent values, r.
    pub(crate) rank: usize,
    /// Values h behind the latent values, whose squares sum to the explained variance, m.
    pub(crate) certainty_len: usize,
    /// Outputs, o.
    pub(crate) output_len: usize,
}

impl GroupRow {
    /// Bytes of a row.
    pub const BYTES: usize = 32;

    /// Counts the group's words in section `corrections`; no product of the sizes overflows.
    pub fn words(&self) -> u64 {
        2 * padded(usize::from(self.input_len)) as u64 + self.shape().words()
    }

    /// Counts the floats of scratch that the evaluation of the group needs.
    pub fn scratch_len(&self) -> usize {
        self.shape().scratch_len()
    }

    /// Returns the sizes of the group's kernel map, with 12 outputs for each helper.
    pub(crate) fn shape(&self) -> Shape {
        Shape {
            input_len: usize::from(self.input_len),
            centre_len: usize::from(self.centre_len),
            rank: usize::from(self.rank),
            certainty_len: usize::from(self.certainty_len),
            output_len: 12 * usize::from(self.proxy_len),
        }
    }

    /// Writes the row, little-endian.
    pub fn to_bytes(&self) -> [u8; Self::BYTES] {
        let [j0, j1] = self.joint.to_le_bytes();
        let [d0, d1] = self.input_len.to_le_bytes();
        let [n0, n1] = self.centre_len.to_le_bytes();
        let [r0, r1] = self.rank.to_le_bytes();
        let [p0, p1] = self.proxy_len.to_le_bytes();
        let [reach, linear, signal, noise] = self.confidence.words();
        let words = [
            [j0, j1, self.kernel, self.certainty_len],
            [d0, d1, n0, n1],
            [r0, r1, p0, p1],
            self.offset.to_le_bytes(),
            reach,
            linear,
            signal,
            noise,
        ];
        let mut out = [0; Self::BYTES];
        out.copy_from_slice(words.as_flattened());
        out
    }

    /// Reads a row.
    pub fn from_bytes(bytes: &[u8; Self::BYTES]) -> Self {
        let [j0, j1, kernel, certainty_len, lengths @ ..] = *bytes;
        let [d0, d1, n0, n1, r0, r1, p0, p1, words @ ..] = lengths;
        let [o0, o1, o2, o3, floats @ ..] = words;
        let [e0, e1, e2, e3, l0, l1, l2, l3, s0, s1, s2, s3, t0, t1, t2, t3] = floats;
        let confidence = GroupConfidence {
            reach: f32::from_le_bytes([e0, e1, e2, e3]),
            linear: f32::from_le_bytes([l0, l1, l2, l3]),
            signal: f32::from_le_bytes([s0, s1, s2, s3]),
            noise: f32::from_le_bytes([t0, t1, t2, t3]),
        };
        Self {
            joint: u16::from_le_bytes([j0, j1]),
            kernel,
            certainty_len,
            input_len: u16::from_le_bytes([d0, d1]),
            centre_len: u16::from_le_bytes([n0, n1]),
            rank: u16::from_le_bytes([r0, r1]),
            proxy_len: u16::from_le_bytes([p0, p1]),
            offset: u32::from_le_bytes([o0, o1, o2, o3]),
            confidence,
        }
    }
}

impl Shape {
    /// Counts the floats of a map in the file; sizes below 2^20 cannot overflow the count.
    fn words(&self) -> u64 {
        let Self { input_len: d, centre_len: n, rank: r, output_len: o, .. } = *self;
        let rows = |len: usize| padded(len) as u64;
        let columns = |len: usize| len as u64;
        rows(n) * columns(d) + rows(n) + rows(self.values()) * columns(n + d) + rows(o) * columns(r)
    }

    /// Counts the floats of scratch of a map: x, g, [z h] and y, each in whole blocks.
    fn scratch_len(&self) -> usize {
        let Self { input_len, centre_len, output_len, .. } = *self;
        padded(input_len) + padded(centre_len) + padded(self.values()) + padded(output_len)
    }

    /// Counts the values of [z h], r + m.
    pub(super) fn values(&self) -> usize {
        self.rank + self.certainty_len
    }
}
