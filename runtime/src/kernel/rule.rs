//! Choice of kernel, and rules for queries outside the data and for outputs.

use super::function::Kernel;
use crate::named::named;

named! {
    /// Rule for a query outside the data (METHOD §2.6).
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    #[repr(u8)]
    #[cfg_attr(not(feature = "internals"), non_exhaustive)]
    pub enum QueryRule {
        /// Free: the function extrapolates.
        Free = 0, "free";
        /// Clamp: each feature is clamped to its range.
        Clamp = 1, "clamp";
        /// Fade: values approach the neutral values.
        Fade = 2, "fade";
    }
    /// Every rule, by number.
    pub ALL;
    /// Returns its name, as in FORMAT.md.
    pub name;
}

named! {
    /// Rule for dividing the marked outputs by their sum.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    #[repr(u8)]
    #[cfg_attr(not(feature = "internals"), non_exhaustive)]
    pub enum Normalise {
        /// Never.
        Never = 0, "never";
        /// For a sum above 1e-12.
        Always = 1, "always";
        /// For a sum above 1.
        AboveOne = 2, "above 1";
    }
    /// Every rule, by number.
    pub ALL;
    /// Returns its name, as in FORMAT.md.
    pub name;
}

impl Normalise {
    /// Returns the sum above which outputs are divided.
    pub(super) const fn least(self) -> f32 {
        match self {
            Self::Never => f32::INFINITY,
            Self::Always => 1.0e-12,
            Self::AboveOne => 1.0,
        }
    }
}

/// Section `kernel_rule`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KernelRule {
    /// G.
    pub kernel: Kernel,
    /// Rule for a query outside the data.
    pub query: QueryRule,
    /// Rule for dividing the marked outputs by their sum.
    pub normalise: Normalise,
    /// Squared distances at which a centre's nearness starts to fall, and reaches 0. Both are 0
    /// without a confidence.
    pub fade: (f32, f32),
}

impl KernelRule {
    /// Bytes of section `kernel_rule`.
    pub const BYTES: usize = 12;

    /// Encodes the rule, little-endian.
    pub fn to_bytes(&self) -> [u8; Self::BYTES] {
        let Self { kernel, query, normalise, fade: (start, end) } = *self;
        let ([s0, s1, s2, s3], [e0, e1, e2, e3]) = (start.to_le_bytes(), end.to_le_bytes());
        let [k, p] = [kernel.number(), kernel.parameter()];
        [k, p, query as u8, normalise as u8, s0, s1, s2, s3, e0, e1, e2, e3]
    }

    /// Decodes the rule.
    ///
    /// # Errors
    /// The first unknown number. For a known kernel with an unknown parameter, the parameter.
    pub fn from_bytes(bytes: &[u8; Self::BYTES]) -> Result<Self, u8> {
        let [k, p, q, n, s0, s1, s2, s3, e0, e1, e2, e3] = *bytes;
        let is_known = Kernel::ALL.iter().any(|kernel| kernel.number() == k);
        let kernel = Kernel::from_number(k, p).ok_or(if is_known { p } else { k })?;
        let query = *QueryRule::ALL.get(usize::from(q)).ok_or(q)?;
        let normalise = *Normalise::ALL.get(usize::from(n)).ok_or(n)?;
        let float = f32::from_le_bytes;
        let fade = (float([s0, s1, s2, s3]), float([e0, e1, e2, e3]));
        Ok(Self { kernel, query, normalise, fade })
    }

    /// Whether the fade starts before it ends, or is absent and not needed.
    pub(super) fn is_sound(&self) -> bool {
        match self.fade {
            (0.0, 0.0) => self.query != QueryRule::Fade,
            (start, end) => 0.0 <= start && start < end,
        }
    }

    /// Whether a confidence is computed.
    pub(super) fn has_fade(&self) -> bool {
        self.fade.1 > 0.0
    }
}
