//! What a part asks of its sections, as a table: presence, length, and what floats may be.

use super::message::MAGNITUDE_MAX;
use super::sections::SectionKind;

/// What a part asks of its section of one kind.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rule {
    pub(crate) section: SectionKind,
    /// Bit of what a part must have for the section to be there; [`ALWAYS`] and [`OPTIONAL`] are any
    /// part's, and together with [`OPTIONAL`] a bit allows what it else asks for.
    pub(crate) has: u8,
    /// Bytes of an element.
    pub(crate) each: u8,
    /// Which two of the part's sizes multiply to the number of elements.
    pub(crate) sizes: [u8; 2],
    /// Bytes of what its content states its own length in, so that it may be longer; `None` where the
    /// length is exact.
    pub(crate) or_more: Option<u8>,
    /// Its floats; `None` where they are not all of an element's words, or of all but the first.
    pub(crate) floats: Option<Floats>,
}

/// Where the floats of an element stand, and what they may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Floats {
    /// Words before them that are none.
    pub(crate) after: u8,
    allowed: Allowed,
}

/// What floats may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Allowed {
    Signed,
    Unsigned,
    /// Anything finite: where an overflow is a call's error, no number is too large for a file.
    #[cfg(feature = "kernel")]
    Finite,
}

/// A section that every part of its kind has.
pub(crate) const ALWAYS: u8 = 1;
/// A section that a part may have.
pub(crate) const OPTIONAL: u8 = 2;

impl Rule {
    /// Makes the rule of a section that is always there, and not of floats alone.
    pub(crate) const fn new(section: SectionKind, each: u8, sizes: [u8; 2]) -> Self {
        Self { section, has: ALWAYS, each, sizes, or_more: None, floats: None }
    }

    /// Makes the rule of a section of floats.
    pub(crate) const fn floats(section: SectionKind, each: u8, sizes: [u8; 2]) -> Self {
        Self::new(section, each, sizes).floats_after(0)
    }

    /// Says that all of an element but so many words are floats.
    pub(crate) const fn floats_after(self, after: u8) -> Self {
        Self { floats: Some(Floats { after, allowed: Allowed::Signed }), ..self }
    }

    /// Says what a part must have for the section to be there.
    pub(crate) const fn with(self, has: u8) -> Self {
        Self { has, ..self }
    }

    /// Says that the content states its own length, in so many bytes beside its elements.
    pub(crate) const fn or_more(self, bytes: u8) -> Self {
        Self { or_more: Some(bytes), ..self }
    }

    /// Says that no float may be negative.
    pub(crate) const fn unsigned(self) -> Self {
        Self { floats: Some(Floats { after: 0, allowed: Allowed::Unsigned }), ..self }
    }

    /// Says that its floats, all of an element but so many words, may be as large as floats are.
    #[cfg(feature = "kernel")]
    pub(crate) const fn finite_after(self, after: u8) -> Self {
        Self { floats: Some(Floats { after, allowed: Allowed::Finite }), ..self }
    }

    /// Computes the length in bytes, the least if it may be longer; `None` if the product overflows.
    pub(crate) fn bytes(&self, sizes: &[u32]) -> Option<u64> {
        let size = |at: u8| u64::from(sizes.get(usize::from(at)).copied().unwrap_or_default());
        let [a, b] = self.sizes;
        let elements = (size(a) * size(b)).checked_mul(self.each.into())?;
        elements.checked_add(self.or_more.unwrap_or_default().into())
    }

    /// Lists the sections of rules.
    pub(crate) const fn sections<const N: usize>(rules: &[Self; N]) -> [SectionKind; N] {
        let mut out = [SectionKind::Names; N];
        let mut at = 0;
        while at < N {
            out[at] = rules[at].section;
            at += 1;
        }
        out
    }

    /// Returns the place of a section's rule, at compile time: one that has none does not compile.
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
    /// Returns the least and the greatest.
    pub(crate) const fn range(self) -> [f32; 2] {
        match self.allowed {
            Allowed::Signed => [-MAGNITUDE_MAX, MAGNITUDE_MAX],
            Allowed::Unsigned => [0.0, MAGNITUDE_MAX],
            #[cfg(feature = "kernel")]
            Allowed::Finite => [f32::MIN, f32::MAX],
        }
    }
}
