//! Which kernel it is, and what it does with queries outside the data and with its outputs.

use super::function::Kernel;

/// What is done with a query outside the data (METHOD §2.6).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum QueryRule {
    /// Nothing: the function goes on as it does.
    Free = 0,
    /// Each feature is kept within its range.
    Clamp = 1,
    /// Values tend to the neutral ones.
    Fade = 2,
}

impl QueryRule {
    /// Every rule, by number.
    pub const ALL: [Self; 3] = [Self::Free, Self::Clamp, Self::Fade];

    /// Returns its name, as FORMAT.md has it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Free => "free",
            Self::Clamp => "clamp",
            Self::Fade => "fade",
        }
    }
}

/// Which sums of the marked outputs are brought to 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Normalise {
    /// None.
    Never = 0,
    /// Every one that is above 1e-12.
    Always = 1,
    /// Those above 1.
    AboveOne = 2,
}

impl Normalise {
    /// Every way, by number.
    pub const ALL: [Self; 3] = [Self::Never, Self::Always, Self::AboveOne];

    /// Returns its name, as FORMAT.md has it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Never => "never",
            Self::Always => "always",
            Self::AboveOne => "above 1",
        }
    }

    /// Returns the sum above which sums are brought to 1.
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
    /// What is done with a query outside the data.
    pub query: QueryRule,
    /// Which sums of the marked outputs are brought to 1.
    pub normalise: Normalise,
    /// Squared distances at which a centre stops to vouch for a query wholly, and at all; both are 0 where
    /// no confidence is computed.
    pub fade: (f32, f32),
}

impl KernelRule {
    /// Bytes of section `kernel_rule`.
    pub const BYTES: usize = 12;

    /// Writes it, little-endian.
    pub fn to_bytes(&self) -> [u8; Self::BYTES] {
        let Self { kernel, query, normalise, fade: (start, end) } = *self;
        let ([s0, s1, s2, s3], [e0, e1, e2, e3]) = (start.to_le_bytes(), end.to_le_bytes());
        let [k, p] = [kernel.number(), kernel.parameter()];
        [k, p, query as u8, normalise as u8, s0, s1, s2, s3, e0, e1, e2, e3]
    }

    /// Reads it.
    ///
    /// # Errors
    /// The number that stands for nothing: of a kernel, its parameter if the kernel is known.
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

    /// Whether the fade starts and then ends, or there is none and none is asked for.
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
