//! A loaded file, with access to its parts by kind and by name.

use crate::envelope::{self, Envelope, EnvelopeCounts};
#[cfg(feature = "filter")]
use crate::filter::{self, Filter};
use crate::format::part::{Asked, Part, PartLayout};
use crate::format::refusal::{Checked, Loading, Refused};
use crate::format::{
    FileError, FileId, Manifest, PartKind, PartRow, SectionKind, SectionRow, Space,
};
#[cfg(feature = "kernel")]
use crate::kernel::{self, KernelMap};
use crate::limits::Limits;
#[cfg(feature = "prior")]
use crate::prior::{self, Prior};
#[cfg(feature = "record")]
use crate::record::{self, Record};
use crate::skin::{self, Skin};
#[cfg(feature = "views")]
use crate::views::{self, Views};
use core::fmt;

/// A validated model over any storage of bytes: `&[u8]`, `Vec<u8>`, `Arc<[u8]>`, a mapped file.
///
/// Loading stores only offsets. Envelopes, skins and kernels are views that borrow the model and
/// cost nothing to make. A model can therefore be stored, shared between threads, and replaced like
/// any other value. Bytes that change after loading may give wrong numbers, never a panic.
#[derive(Clone, Copy)]
pub struct Model<B> {
    bytes: B,
    contents: Contents,
}

/// Offsets that loading stores.
#[derive(Clone, Copy)]
struct Contents {
    manifest: Manifest,
    /// The first part of each kind, in the order of [`PartKind::ALL`].
    firsts: [PartLayout; PartKind::ALL.len()],
}

/// One section of a file, of a known or an unknown kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Section<'a> {
    /// The section's row in the section table; `row.part` indexes [`Model::parts`].
    pub row: SectionRow,
    /// The section's content.
    pub bytes: &'a [u8],
}

impl<B: AsRef<[u8]>> Model<B> {
    /// Loads a model in place, within the default [`Limits`].
    ///
    /// # Errors
    /// See [`Model::from_bytes_with`].
    pub fn from_bytes(bytes: B) -> Result<Self, FileError> {
        Self::from_bytes_with(bytes, &Limits::DEFAULT)
    }

    /// Loads a model in place and checks all of it, in the order of FORMAT.md. The time is bounded
    /// by the file's length. Never panics, for any input.
    ///
    /// The bytes need no alignment.
    ///
    /// # Errors
    /// Every kind of [`FileError`]; the kind's documentation states its cause.
    pub fn from_bytes_with(bytes: B, limits: &Limits) -> Result<Self, FileError> {
        let mut model = Self { bytes, contents: Contents::NOTHING };
        let loading = Loading::new(model.bytes.as_ref(), limits);
        match model.contents.read(&loading) {
            Ok(()) => Ok(model),
            Err(Refused) => Err(loading.error()),
        }
    }

    /// Returns the first envelope; `None` if the file has none.
    pub fn envelope(&self) -> Option<Envelope<'_>> {
        self.contents.first(PartKind::Envelope, self.bytes.as_ref()).map(Envelope)
    }

    /// Returns the first skin; `None` if the file has none, for example a palette-only file.
    pub fn skin(&self) -> Option<Skin<'_>> {
        self.contents.first(PartKind::Skin, self.bytes.as_ref()).map(Skin)
    }

    /// Lists the envelopes. Each item reads the rows of its sections: keep [`Envelope::layout`] for
    /// envelopes that are needed every frame.
    pub fn envelopes(&self) -> impl Iterator<Item = Envelope<'_>> {
        self.parts_of(PartKind::Envelope).map(Envelope)
    }

    /// Lists the skins. Keep [`Skin::layout`] for every frame.
    pub fn skins(&self) -> impl Iterator<Item = Skin<'_>> {
        self.parts_of(PartKind::Skin).map(Skin)
    }

    /// Returns the envelope with this name.
    pub fn envelope_named(&self, name: &str) -> Option<Envelope<'_>> {
        self.envelopes().find(|envelope| envelope.name() == name)
    }

    /// Returns the skin with this name.
    pub fn skin_named(&self, name: &str) -> Option<Skin<'_>> {
        self.skins().find(|skin| skin.name() == name)
    }

    /// Returns the first kernel; `None` if the file has none.
    #[cfg(feature = "kernel")]
    pub fn kernel(&self) -> Option<KernelMap<'_>> {
        self.contents.first(PartKind::Kernel, self.bytes.as_ref()).map(KernelMap)
    }

    /// Lists the kernels. Keep [`KernelMap::layout`] for every frame.
    #[cfg(feature = "kernel")]
    pub fn kernels(&self) -> impl Iterator<Item = KernelMap<'_>> {
        self.parts_of(PartKind::Kernel).map(KernelMap)
    }

    /// Returns the kernel with this name.
    #[cfg(feature = "kernel")]
    pub fn kernel_named(&self, name: &str) -> Option<KernelMap<'_>> {
        self.kernels().find(|kernel| kernel.name() == name)
    }

    /// Returns the first prior; `None` if the file has none.
    #[cfg(feature = "prior")]
    pub fn prior(&self) -> Option<Prior<'_>> {
        self.contents.first(PartKind::Prior, self.bytes.as_ref()).map(Prior)
    }

    /// Lists the priors. Keep [`Prior::layout`] for every frame.
    #[cfg(feature = "prior")]
    pub fn priors(&self) -> impl Iterator<Item = Prior<'_>> {
        self.parts_of(PartKind::Prior).map(Prior)
    }

    /// Returns the prior with this name.
    #[cfg(feature = "prior")]
    pub fn prior_named(&self, name: &str) -> Option<Prior<'_>> {
        self.priors().find(|prior| prior.name() == name)
    }

    /// Returns the first object of key views; `None` if the file has none.
    #[cfg(feature = "views")]
    pub fn views(&self) -> Option<Views<'_>> {
        self.contents.first(PartKind::Views, self.bytes.as_ref()).map(Views)
    }

    /// Lists the objects of key views. Keep [`Views::layout`] for every frame.
    #[cfg(feature = "views")]
    pub fn all_views(&self) -> impl Iterator<Item = Views<'_>> {
        self.parts_of(PartKind::Views).map(Views)
    }

    /// Returns the object of key views with this name.
    #[cfg(feature = "views")]
    pub fn views_named(&self, name: &str) -> Option<Views<'_>> {
        self.all_views().find(|views| views.name() == name)
    }

    /// Returns the first filter; `None` if the file has none.
    #[cfg(feature = "filter")]
    pub fn filter(&self) -> Option<Filter<'_>> {
        self.contents.first(PartKind::Filter, self.bytes.as_ref()).map(Filter)
    }

    /// Lists the filters. Keep [`Filter::layout`] for every frame.
    #[cfg(feature = "filter")]
    pub fn filters(&self) -> impl Iterator<Item = Filter<'_>> {
        self.parts_of(PartKind::Filter).map(Filter)
    }

    /// Returns the filter with this name.
    #[cfg(feature = "filter")]
    pub fn filter_named(&self, name: &str) -> Option<Filter<'_>> {
        self.filters().find(|filter| filter.name() == name)
    }

    /// Returns the training record of an envelope; `None` if the file has none.
    #[cfg(feature = "record")]
    pub fn record_of(&self, envelope: &Envelope<'_>) -> Option<Record<'_>> {
        self.records().find(|record| record.name() == envelope.name())
    }

    /// Lists the records.
    #[cfg(feature = "record")]
    pub fn records(&self) -> impl Iterator<Item = Record<'_>> {
        self.parts_of(PartKind::Record).map(Record)
    }

    /// Returns a map of an object in this model.
    #[cfg(feature = "views")]
    pub fn map_of(&self, views: &Views<'_>, map: usize) -> Option<KernelMap<'_>> {
        let part = u16::try_from(views.map_part(map)?).ok()?;
        self.part(PartKind::Kernel, part).map(KernelMap)
    }

    /// Returns the skin whose shape weights a prior of this model describes.
    #[cfg(feature = "prior")]
    pub fn skin_of(&self, prior: &Prior<'_>) -> Option<Skin<'_>> {
        self.part(PartKind::Skin, u16::try_from(prior.counts().skin).ok()?).map(Skin)
    }

    /// Returns the envelope whose palette a skin of this model follows.
    pub fn envelope_of(&self, skin: &Skin<'_>) -> Option<Envelope<'_>> {
        let part = skin.counts().envelope()?;
        match self.envelope() {
            Some(first) if first.part() == usize::from(part) => Some(first),
            _ => self.part(PartKind::Envelope, part).map(Envelope),
        }
    }

    /// Lists the parts, including unknown kinds.
    pub fn parts(&self) -> impl ExactSizeIterator<Item = PartRow> {
        self.contents.manifest.parts(self.bytes.as_ref())
    }

    /// Lists the sections in the order of the file, including unknown kinds.
    pub fn sections(&self) -> impl ExactSizeIterator<Item = Section<'_>> {
        let file = self.bytes.as_ref();
        self.contents
            .manifest
            .sections(file)
            .map(move |row| Section { row, bytes: self.contents.manifest.section(&row, file) })
    }

    /// Returns the blob for upload to a GPU: all sections, at the offsets in their rows.
    pub fn blob(&self) -> &[u8] {
        self.contents.manifest.blob(self.bytes.as_ref())
    }

    /// Returns the coordinate space of the file: its axes and its unit.
    pub fn space(&self) -> Space {
        Space::of(self.bytes.as_ref())
    }

    /// Returns the file's identity, which layouts and plans made from it store.
    pub fn id(&self) -> FileId {
        self.contents.manifest.id()
    }

    /// Returns the bytes.
    pub fn as_bytes(&self) -> &[u8] {
        self.bytes.as_ref()
    }

    /// Returns the storage and drops the model.
    pub fn into_bytes(self) -> B {
        self.bytes
    }

    /// Lists the parts of a kind.
    fn parts_of(&self, kind: PartKind) -> impl Iterator<Item = Part<'_>> {
        let parts = parts_of(&self.contents.manifest, self.bytes.as_ref(), kind);
        parts.filter_map(move |part| self.part(kind, part))
    }

    /// Finds a part of a kind by its row in the part table.
    fn part(&self, kind: PartKind, part: u16) -> Option<Part<'_>> {
        let file = self.bytes.as_ref();
        let loading = Loading::new(file, &Limits::FORMAT);
        let mut view = Part::new(file);
        find_part(&loading, &self.contents.manifest, (kind, part), &mut view).ok()?;
        Some(view)
    }
}

impl Contents {
    const NOTHING: Self =
        Self { manifest: Manifest::NOTHING, firsts: [PartLayout::NOTHING; PartKind::ALL.len()] };

    /// Reads and checks all of a file.
    #[inline(never)]
    fn read(&mut self, loading: &Loading<'_>) -> Checked {
        let Self { manifest, firsts } = self;
        manifest.read(loading)?;
        for (kind, first) in PartKind::ALL.iter().zip(firsts) {
            for part in parts_of(manifest, loading.file, *kind) {
                loading.of_part(part);
                let mut view = Part::new(loading.file);
                find_part(loading, manifest, (*kind, part), &mut view)?;
                first.keep(&view.layout);
                match kind {
                    PartKind::Envelope => envelope::check::content(&Envelope(view), loading),
                    PartKind::Skin => skin::check::content(&Skin(view), loading),
                    #[cfg(feature = "kernel")]
                    PartKind::Kernel => kernel::check::content(&KernelMap(view), loading),
                    #[cfg(feature = "prior")]
                    PartKind::Prior => prior::check_content(&Prior(view), loading),
                    #[cfg(feature = "views")]
                    PartKind::Views => {
                        let part_len = manifest.parts(loading.file).len();
                        let outputs = |part| output_rows(loading, manifest, part);
                        views::check::content(&Views(view), loading, part_len, outputs)
                    }
                    #[cfg(feature = "filter")]
                    PartKind::Filter => filter::check_content(&Filter(view), loading),
                    #[cfg(feature = "record")]
                    PartKind::Record => record::check_content(&Record(view), loading),
                }?;
            }
        }
        Ok(())
    }

    /// Returns the first part of a kind.
    fn first<'a>(&self, kind: PartKind, file: &'a [u8]) -> Option<Part<'a>> {
        let (_, layout) = PartKind::ALL.iter().zip(&self.firsts).find(|(own, _)| **own == kind)?;
        layout.is_some().then_some(Part { layout: *layout, file })
    }
}

/// Finds a part's counts and sections, and checks the counts against the sections.
#[inline(never)]
fn find_part(
    loading: &Loading<'_>,
    manifest: &Manifest,
    (kind, part): (PartKind, u16),
    out: &mut Part<'_>,
) -> Checked {
    let file = loading.file;
    let rules = match kind {
        PartKind::Envelope => &envelope::RULES[..],
        PartKind::Skin => &skin::RULES,
        #[cfg(feature = "kernel")]
        PartKind::Kernel => &kernel::RULES,
        #[cfg(feature = "prior")]
        PartKind::Prior => &prior::RULES,
        #[cfg(feature = "views")]
        PartKind::Views => &views::RULES,
        #[cfg(feature = "filter")]
        PartKind::Filter => &filter::RULES,
        #[cfg(feature = "record")]
        PartKind::Record => &record::RULES,
    };
    out.enter(loading, manifest, part, rules)?;
    // The counts come first in the rules.
    out.find_sections(loading, manifest, rules.get(..1).unwrap_or_default(), &Asked::COUNTS)?;
    out.read_counts();
    let asked = match kind {
        PartKind::Envelope => envelope::check::counts(&out.layout.counts, loading)?,
        PartKind::Skin => {
            let palette_len = |part| palette_len(loading, manifest, part);
            let part_len = manifest.parts(file).len();
            let element = |kind| manifest.element(file, part, kind);
            skin::check::counts(&mut out.layout.counts, loading, part_len, palette_len, element)?
        }
        #[cfg(feature = "kernel")]
        PartKind::Kernel => kernel::check::counts(&out.layout.counts, loading)?,
        #[cfg(feature = "prior")]
        PartKind::Prior => {
            let shape_len = |part| shape_len(loading, manifest, part);
            let part_len = manifest.parts(file).len();
            prior::check_counts(&out.layout.counts, loading, part_len, shape_len)?
        }
        #[cfg(feature = "views")]
        PartKind::Views => views::check::counts(&out.layout.counts, loading)?,
        #[cfg(feature = "filter")]
        PartKind::Filter => filter::check_counts(&out.layout.counts, loading)?,
        #[cfg(feature = "record")]
        PartKind::Record => record::check_counts(&out.layout.counts, loading)?,
    };
    out.find_sections(loading, manifest, rules, &asked)
}

/// Returns the palette length of a part if the part is an envelope. All counts have been checked
/// before.
fn palette_len(loading: &Loading<'_>, manifest: &Manifest, part: u16) -> Option<u32> {
    let row = manifest.parts(loading.file).nth(part.into())?;
    let (number, _) = manifest.find(loading.file, part, SectionKind::EnvelopeCounts.number())?;
    let counts = manifest.tables().section(number.get(), loading.file)?;
    let words = counts.as_chunks().0.first_chunk()?.map(u32::from_le_bytes);
    let len = EnvelopeCounts::from_words(words)?.palette_len() as u32;
    (row.kind == PartKind::Envelope.number()).then_some(len)
}

/// Returns the number of shapes of a part if the part is a skin. All counts have been checked
/// before.
#[cfg(feature = "prior")]
fn shape_len(loading: &Loading<'_>, manifest: &Manifest, part: u16) -> Option<u32> {
    let row = manifest.parts(loading.file).nth(part.into())?;
    let (number, _) = manifest.find(loading.file, part, SectionKind::SkinCounts.number())?;
    let counts = manifest.tables().section(number.get(), loading.file)?;
    let words = counts.as_chunks().0.first_chunk()?.map(u32::from_le_bytes);
    let len = skin::SkinCounts::from_words(words).shape_len;
    (row.kind == PartKind::Skin.number()).then_some(len)
}

/// Returns the output rows of a part if the part is a kernel. All rows have been checked before.
#[cfg(feature = "views")]
fn output_rows<'a>(
    loading: &Loading<'a>,
    manifest: &Manifest,
    part: u16,
) -> Option<&'a [[u8; kernel::OutputRow::BYTES]]> {
    let row = manifest.parts(loading.file).nth(part.into())?;
    let (number, _) = manifest.find(loading.file, part, SectionKind::Outputs.number())?;
    let rows = manifest.tables().section(number.get(), loading.file)?.as_chunks().0;
    (row.kind == PartKind::Kernel.number()).then_some(rows)
}

/// Lists the parts of a kind. The reader's limits keep their number below 65,536.
fn parts_of<'a>(
    manifest: &Manifest,
    file: &'a [u8],
    kind: PartKind,
) -> impl Iterator<Item = u16> + use<'a> {
    let rows = (0..).zip(manifest.parts(file));
    rows.filter(move |(_, row)| row.kind == kind.number()).map(|(part, _)| part)
}

impl<B: AsRef<[u8]>> fmt::Debug for Model<B> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.parts()).finish()
    }
}
