//! Rules for the sections of a part: presence, length, and allowed floats.

use super::message::MAGNITUDE_MAX;
use super::sections::SectionKind;

/// Rule for one kind of section in a part.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rule {
    pub(crate) section: SectionKind,
    /// Bit of the property that requires the section. Any part has [`ALWAYS`] and [`OPTIONAL`]. A
    /// bit combined with [`OPTIONAL`] allows the section instead of requiring it.
    pub(crate) has: u8,
    /// Bytes of an element.
    pub(crate) each: u8,
    /// Indices of the two sizes whose product is the number of elements.
    pub(crate) sizes: [u8; 2],
    /// Bytes of a content that states its own length, so that the section may be longer. `None` if
    /// the length is exact.
    pub(crate) or_more: Option<u8>,
    /// The floats of the section. `None` if an element mixes floats with other words in any other
    /// way.
    pub(crate) floats: Option<Floats>,
}

/// Position and range of the floats in an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Floats {
    /// Words before the floats.
    pub(crate) after: u8,
    allowed: Allowed,
}

/// Allowed values of floats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Allowed {
    Signed,
    Unsigned,
    /// Any finite value. For sections whose overflow is an error of the call.
    #[cfg(feature = "kernel")]
    Finite,
}

/// Bit for a section that every part of its kind has.
pub(crate) const ALWAYS: u8 = 1;
/// Bit for a section that a part may have.
pub(crate) const OPTIONAL: u8 = 2;

impl Rule {
    /// Makes the rule of a required section without a check of floats.
    pub(crate) const fn new(section: SectionKind, each: u8, sizes: [u8; 2]) -> Self {
        Self { section, has: ALWAYS, each, sizes, or_more: None, floats: None }
    }

    /// Makes the rule of a required section of floats.
    pub(crate) const fn floats(section: SectionKind, each: u8, sizes: [u8; 2]) -> Self {
        Self::new(section, each, sizes).floats_after(0)
    }

    /// Sets that an element is `after` other words, then floats.
    pub(crate) const fn floats_after(self, after: u8) -> Self {
        Self { floats: Some(Floats { after, allowed: Allowed::Signed }), ..self }
    }

    /// Sets the property bits that require the section.
    pub(crate) const fn with(self, has: u8) -> Self {
        Self { has, ..self }
    }

    /// Sets that the content states its own length, in `bytes` bytes beyond its elements.
    pub(crate) const fn or_more(self, bytes: u8) -> Self {
        Self { or_more: Some(bytes), ..self }
    }

    /// Sets that no float may be negative.
    pub(crate) const fn unsigned(self) -> Self {
        Self { floats: Some(Floats { after: 0, allowed: Allowed::Unsigned }), ..self }
    }

    /// Sets that an element is `after` other words, then floats of any finite size.
    #[cfg(feature = "kernel")]
    pub(crate) const fn finite_after(self, after: u8) -> Self {
        Self { floats: Some(Floats { after, allowed: Allowed::Finite }), ..self }
    }

    /// Computes the length in bytes, or the least length if the section may be longer. `None` if
    /// the product overflows.
    pub(crate) fn bytes(&self, sizes: &[u32]) -> Option<u64> {
        let size = |at: u8| u64::from(sizes.get(usize::from(at)).copied().unwrap_or_default());
        let [a, b] = self.sizes;
        let elements = (size(a) * size(b)).checked_mul(self.each.into())?;
        elements.checked_add(self.or_more.unwrap_or_default().into())
    }

    /// Lists the sections of a table of rules.
    pub(crate) const fn sections<const N: usize>(rules: &[Self; N]) -> [SectionKind; N] {
        let mut out = [SectionKind::Names; N];
        let mut at = 0;
        while at < N {
            out[at] = rules[at].section;
            at += 1;
        }
        out
    }

    /// Returns the index of a section's rule at compile time. A section without a rule does not
    /// compile.
    pub(crate) const fn place(rules: &[Self], section: SectionKind) -> usize {
        let mut at = 0;
        while rules[at].section.number() != section.number() {
            at += 1;
        }
        at
    }

    /// Finds the rule of a section.
    pub(crate) fn of(rules: &[Self], section: SectionKind) -> Option<&Self> {
        rules.iter().find(|rule| rule.section == section)
    }
}

impl Floats {
    /// Returns the least and the greatest allowed value.
    pub(crate) const fn range(self) -> [f32; 2] {
        match self.allowed {
            Allowed::Signed => [-MAGNITUDE_MAX, MAGNITUDE_MAX],
            Allowed::Unsigned => [0.0, MAGNITUDE_MAX],
            #[cfg(feature = "kernel")]
            Allowed::Finite => [f32::MIN, f32::MAX],
        }
    }
}
