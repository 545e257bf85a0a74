//! A part of any kind: the offsets that loading stores, and access to its sections.

use super::error::{FileErrorKind as Kind, saturated};
use super::manifest::{FileId, Manifest, Tables};
use super::refusal::{Checked, Loading};
use super::rule::{ALWAYS, OPTIONAL, Rule};
use super::tables::PartKind;
use crate::linear::Le;
use core::num::NonZeroU16;

/// Largest number of counts of any kind of part.
pub(crate) const COUNTS: usize = if cfg!(feature = "views") {
    11
} else if cfg!(feature = "shapes") {
    9
} else {
    8
};
/// Largest number of sizes in the rules of any kind of part.
const SIZES: usize =
    match (cfg!(feature = "views"), cfg!(feature = "shapes"), cfg!(feature = "kernel")) {
        (true, ..) => 13,
        (false, true, _) => 12,
        (false, false, true) => 10,
        (false, false, false) => 7,
    };
/// Largest number of sections in the rules of any kind of part.
pub(crate) const SECTIONS: usize = if cfg!(feature = "shapes") {
    17
} else if cfg!(feature = "views") {
    16
} else {
    // Those of an envelope.
    12 + 2 * cfg!(feature = "stretch") as usize
        + cfg!(feature = "curves") as usize
        + cfg!(feature = "trs") as usize
};

/// Counts of a part and the offsets of its arrays. The layout borrows nothing: it can be kept beside
/// the file's bytes, and makes views every frame.
#[derive(Clone, Copy, Debug)]
pub struct PartLayout {
    file: FileId,
    part: u16,
    /// Number of the part's kind; 0 for no part.
    kind: u16,
    /// The part's counts, in the order of the file, then values that follow from other parts.
    pub(crate) counts: [u32; COUNTS],
    /// Row of each section in the section table, counted from 1, in the order of the rules.
    rows: [Option<NonZeroU16>; SECTIONS],
    tables: Tables,
}

/// View of one kind of part, which [`crate::Model`] makes. Not nameable outside this crate.
pub trait View<'a>: Sized {
    /// Kind of the part.
    const KIND: PartKind;

    /// Makes the view of a part of the kind.
    fn of(part: Part<'a>) -> Self;
}

/// Part of a model: an [`crate::Envelope`], a [`crate::Skin`], or a part of another kind.
///
/// Only views of this crate implement the trait.
pub trait ModelPart<'a>: View<'a> {
    /// Returns the part's name.
    fn name(&self) -> &'a str;

    /// Returns the layout, to open the part again later.
    fn layout(&self) -> PartLayout;
}

/// Defines the members that views of all kinds of parts share: layout, location, name and counts.
macro_rules! view {
    ($view:ident, $kind:ident, |$words:ident| -> $counts:ident { $read:expr }) => {
        impl<'a> $view<'a> {
            /// Returns the layout, to open the part again later.
            pub const fn layout(&self) -> $crate::PartLayout {
                self.0.layout
            }

            /// Returns the identity of the part's file.
            #[cfg_attr(feature = "internals", visibility::make(pub))]
            pub(crate) const fn file(&self) -> $crate::format::FileId {
                self.0.id()
            }

            /// Returns the part's index in [`crate::Model::parts`]. The rows of
            /// [`crate::Model::sections`] refer to the index.
            #[cfg_attr(feature = "internals", visibility::make(pub))]
            pub(crate) const fn part(&self) -> usize {
                self.0.index()
            }

            /// Returns the part's name.
            pub fn name(&self) -> &'a str {
                self.names().get(0).unwrap_or_default()
            }

            /// Returns its counts.
            #[cfg_attr(feature = "internals", visibility::make(pub))]
            pub(crate) const fn counts(&self) -> $counts {
                let $words = &self.0.layout.counts;
                $read
            }
        }

        impl<'a> $crate::format::part::View<'a> for $view<'a> {
            const KIND: $crate::format::PartKind = $crate::format::PartKind::$kind;

            fn of(part: $crate::format::part::Part<'a>) -> Self {
                Self(part)
            }
        }

        impl<'a> $crate::ModelPart<'a> for $view<'a> {
            fn name(&self) -> &'a str {
                self.name()
            }

            fn layout(&self) -> $crate::PartLayout {
                self.layout()
            }
        }

        impl core::fmt::Debug for $view<'_> {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                let (name, counts) = (self.name(), self.counts());
                let mut out = f.debug_struct(stringify!($view));
                out.field("name", &name).field("counts", &counts).finish()
            }
        }
    };
}
pub(crate) use view;

/// Properties and sizes of a part, derived from its counts, for its rules.
pub(crate) struct Asked {
    /// Bits of the part's properties, including [`ALWAYS`].
    pub(crate) has: u8,
    /// Sizes whose products are numbers of elements; the first is 1.
    pub(crate) sizes: [u32; SIZES],
}

impl Asked {
    /// Properties for the section of counts itself.
    pub(crate) const COUNTS: Self = Self::new(ALWAYS, [1]);

    /// Makes the value from the bits and N sizes, the first of which is 1.
    pub(crate) const fn new<const N: usize>(has: u8, sizes: [u32; N]) -> Self {
        let mut asked = Self { has, sizes: [0; SIZES] };
        let mut at = 0;
        while at < N {
            asked.sizes[at] = sizes[at];
            at += 1;
        }
        asked
    }
}

/// Returns the first N counts of a part.
pub(crate) const fn first_counts<const N: usize>(counts: &[u32; COUNTS]) -> [u32; N] {
    match counts.first_chunk() {
        Some(first) => *first,
        None => [0; N],
    }
}

impl PartLayout {
    /// The layout of no part, which opens nothing.
    pub(crate) const NOTHING: Self = Self {
        file: FileId::NONE,
        part: 0,
        kind: 0,
        counts: [0; COUNTS],
        rows: [None; SECTIONS],
        tables: Tables::NOTHING,
    };

    /// Stores another layout, unless one is stored already.
    pub(crate) fn keep(&mut self, other: &Self) {
        if !self.is_some() {
            *self = *other;
        }
    }

    /// Whether it is the layout of a part.
    pub(crate) const fn is_some(&self) -> bool {
        self.tables.is_some()
    }

    /// Whether the part has the section of a rule, which may be empty.
    pub(crate) const fn has(&self, place: usize) -> bool {
        self.rows[place].is_some()
    }

    /// Opens the part again: `layout.open::<Envelope>(bytes)`.
    ///
    /// Returns `None` if the part is of another kind, or if the bytes have another length or stated
    /// checksum than the file of this layout. Nothing is read again. With other changes in the bytes
    /// the part gives wrong results, but never panics.
    pub fn open<'a, P: ModelPart<'a>>(&self, file: &'a [u8]) -> Option<P> {
        let is_same = self.kind == P::KIND.number() && FileId::of(file) == Some(self.file);
        is_same.then_some(P::of(Part { layout: *self, file }))
    }
}

/// A part and its file.
#[derive(Clone, Copy)]
pub struct Part<'a> {
    pub(crate) layout: PartLayout,
    pub(crate) file: &'a [u8],
}

impl<'a> Part<'a> {
    /// Makes the view of no part yet, in a file.
    pub(crate) const fn new(file: &'a [u8]) -> Self {
        Self { layout: PartLayout::NOTHING, file }
    }

    /// Starts the search for the sections of a part.
    ///
    /// # Errors
    /// [`Kind::Unsupported`]: a section is required and not in the rules.
    #[inline(never)]
    pub(crate) fn enter(
        &mut self,
        loading: &Loading<'_>,
        manifest: &Manifest,
        (kind, part): (PartKind, u16),
        rules: &[Rule],
    ) -> Checked {
        for (index, row) in manifest.sections(self.file).enumerate() {
            let is_known = rules.iter().any(|rule| rule.section.number() == row.kind);
            if row.part == part && row.required() && !is_known {
                return Err(loading.refuse(Kind::Unsupported, None, index, [0, row.kind.into()]));
            }
        }
        let layout = &mut self.layout;
        (layout.file, layout.part, layout.tables) = (manifest.id(), part, manifest.tables());
        layout.kind = kind.number();
        Ok(())
    }

    /// Reads the counts, whose section has been found.
    pub(crate) fn read_counts(&mut self) {
        let words = self.bytes(0).as_chunks().0;
        for (count, word) in self.layout.counts.iter_mut().zip(words) {
            *count = u32::from_le_bytes(*word);
        }
    }

    /// Finds the part's sections, and checks them against the rules.
    ///
    /// # Errors
    /// [`Kind::Missing`], [`Kind::Unexpected`] and [`Kind::Length`].
    #[inline(never)]
    pub(crate) fn find_sections(
        &mut self,
        loading: &Loading<'_>,
        manifest: &Manifest,
        rules: &[Rule],
        asked: &Asked,
    ) -> Checked {
        for (rule, out) in rules.iter().zip(&mut self.layout.rows) {
            let row = manifest.find(self.file, self.layout.part, rule.section.number());
            let (number, found) = row.unzip();
            let expected = rule.bytes(&asked.sizes).map_or(u32::MAX, saturated);
            let has = rule.has == OPTIONAL || asked.has & rule.has != 0;
            let (kind, values) = match found {
                Some(_) if !has => (Kind::Unexpected, [0; 2]),
                Some(found) if found < expected || found > expected && rule.or_more.is_none() => {
                    (Kind::Length, [expected, found])
                }
                None if has && rule.has & OPTIONAL == 0 => (Kind::Missing, [0; 2]),
                _ => {
                    *out = number;
                    continue;
                }
            };
            return Err(loading.refuse(kind, Some(rule.section), 0, values));
        }
        Ok(())
    }

    /// Returns the identity of the part's file.
    pub(crate) const fn id(&self) -> FileId {
        self.layout.file
    }

    /// Returns its index in the part table.
    pub(crate) const fn index(&self) -> usize {
        self.layout.part as usize
    }

    /// Returns the bytes of a rule's section; empty if the part lacks the section.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn bytes(&self, place: usize) -> &'a [u8] {
        let PartLayout { rows, tables, .. } = &self.layout;
        let row = rows.get(place).copied().flatten();
        row.and_then(|row| tables.section(row.get(), self.file)).unwrap_or_default()
    }

    /// Returns array `number` of N words from the section of a rule with `len` arrays. The check of
    /// `number` also covers bytes that changed after loading, where the section may be longer.
    pub(crate) fn entry<const N: usize>(
        &self,
        place: usize,
        len: usize,
        number: usize,
    ) -> Option<&'a [Le; N]> {
        self.array(place).get(number).filter(|_| number < len)
    }

    /// Splits the section of a rule into arrays of N words.
    pub(crate) fn array<const N: usize>(&self, place: usize) -> &'a [[Le; N]] {
        self.bytes(place).as_chunks().0.as_chunks().0
    }
}
