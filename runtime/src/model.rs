//! A loaded file, with access to its parts by kind and by name.

use crate::envelope::{self, Envelope, EnvelopeCounts};
#[cfg(feature = "filter")]
use crate::filter::{self, Filter};
use crate::format::part::{Asked, ModelPart, Part, PartLayout};
use crate::format::refusal::{Checked, Loading, Refused};
use crate::format::{
    EVALUATED, FileError, FileId, Manifest, PartKind, PartRow, SectionKind, SectionRow, Space,
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
    /// The first part of each kind, in the order of [`EVALUATED`].
    firsts: [PartLayout; EVALUATED.len()],
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

    /// Returns the first part of a kind: `model.first::<Envelope>()`. Returns `None` if the file has
    /// none; a palette-only file has no [`Skin`].
    pub fn first<'a, P: ModelPart<'a>>(&'a self) -> Option<P> {
        self.contents.first(P::KIND, self.bytes.as_ref()).map(P::of)
    }

    /// Lists the parts of a kind. Each item reads the rows of its sections: keep the part's
    /// [`PartLayout`] for parts that are needed every frame.
    pub fn all<'a, P: ModelPart<'a>>(&'a self) -> impl Iterator<Item = P> {
        let parts = parts_of(&self.contents.manifest, self.bytes.as_ref(), P::KIND);
        parts.filter_map(|part| self.part(part))
    }

    /// Returns the part of a kind with this name: `model.named::<Skin>("body")`.
    pub fn named<'a, P: ModelPart<'a>>(&'a self, name: &str) -> Option<P> {
        self.all::<P>().find(|part| part.name() == name)
    }

    /// Returns a map of an object in this model.
    #[cfg(feature = "views")]
    pub fn map_of(&self, views: &Views<'_>, map: usize) -> Option<KernelMap<'_>> {
        self.part(u16::try_from(views.map_part(map)?).ok()?)
    }

    /// Returns the skin whose shape weights a prior of this model describes.
    #[cfg(feature = "prior")]
    pub fn skin_of(&self, prior: &Prior<'_>) -> Option<Skin<'_>> {
        self.part(u16::try_from(prior.counts().skin).ok()?)
    }

    /// Returns the envelope whose palette a skin of this model follows.
    pub fn envelope_of(&self, skin: &Skin<'_>) -> Option<Envelope<'_>> {
        let part = skin.counts().envelope()?;
        match self.first::<Envelope<'_>>() {
            Some(first) if first.part() == usize::from(part) => Some(first),
            _ => self.part(part),
        }
    }

    /// Lists the parts, including unknown kinds.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) fn parts(&self) -> impl ExactSizeIterator<Item = PartRow> {
        self.contents.manifest.parts(self.bytes.as_ref())
    }

    /// Lists the sections in the order of the file, including unknown kinds.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) fn sections(&self) -> impl ExactSizeIterator<Item = Section<'_>> {
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

    /// Finds a part by its row in the part table.
    fn part<'a, P: ModelPart<'a>>(&'a self, part: u16) -> Option<P> {
        let file = self.bytes.as_ref();
        let loading = Loading::new(file, &Limits::FORMAT);
        let mut view = Part::new(file);
        find_part(&loading, &self.contents.manifest, (P::KIND, part), &mut view).ok()?;
        Some(P::of(view))
    }
}

impl Contents {
    const NOTHING: Self =
        Self { manifest: Manifest::NOTHING, firsts: [PartLayout::NOTHING; EVALUATED.len()] };

    /// Reads and checks all of a file.
    #[inline(never)]
    fn read(&mut self, loading: &Loading<'_>) -> Checked {
        let Self { manifest, firsts } = self;
        manifest.read(loading)?;
        for (kind, first) in EVALUATED.iter().zip(firsts) {
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
                    #[allow(
                        unreachable_patterns,
                        reason = "kinds that this build does not evaluate"
                    )]
                    _ => Ok(()),
                }?;
            }
        }
        Ok(())
    }

    /// Returns the first part of a kind.
    fn first<'a>(&self, kind: PartKind, file: &'a [u8]) -> Option<Part<'a>> {
        let (_, layout) = EVALUATED.iter().zip(&self.firsts).find(|(own, _)| **own == kind)?;
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
        #[allow(unreachable_patterns, reason = "kinds that this build does not evaluate")]
        _ => return Ok(()),
    };
    out.enter(loading, manifest, (kind, part), rules)?;
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
        #[allow(unreachable_patterns, reason = "kinds that this build does not evaluate")]
        _ => Asked::COUNTS,
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
        let mut out = f.debug_struct("Model");
        out.field("bytes", &self.bytes.as_ref().len());
        out.field("parts", &Parts(self)).finish()
    }
}

/// The parts of a model that this build evaluates, by kind.
struct Parts<'a, B>(&'a Model<B>);

impl<B: AsRef<[u8]>> fmt::Debug for Parts<'_, B> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(model) = self;
        let mut out = f.debug_list();
        out.entries(model.all::<Envelope<'_>>()).entries(model.all::<Skin<'_>>());
        #[cfg(feature = "kernel")]
        out.entries(model.all::<KernelMap<'_>>());
        #[cfg(feature = "prior")]
        out.entries(model.all::<Prior<'_>>());
        #[cfg(feature = "views")]
        out.entries(model.all::<Views<'_>>());
        #[cfg(feature = "filter")]
        out.entries(model.all::<Filter<'_>>());
        #[cfg(feature = "record")]
        out.entries(model.all::<Record<'_>>());
        out.finish()
    }
}
