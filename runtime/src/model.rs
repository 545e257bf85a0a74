//! A loaded file: what it holds, by kind and by name.

use crate::envelope::{self, Envelope, EnvelopeLayout};
use crate::format::{FileError, FileId, Manifest, PartKind, PartRow, SectionRow, Space};
use crate::limits::Limits;
use crate::skin::{self, Skin, SkinLayout};
use core::fmt;

/// A validated model in whatever its bytes are kept: `&[u8]`, `Vec<u8>`, `Arc<[u8]>`, a mapped file.
///
/// What loading finds is offsets. Envelopes and skins are views that borrow the model and cost nothing
/// to make, so that a model can be stored, shared between threads, and replaced like any other value.
/// Bytes that change after loading may give wrong numbers, never a panic.
#[derive(Clone, Copy)]
pub struct Model<B> {
    bytes: B,
    manifest: Manifest,
    envelope: Option<EnvelopeLayout>,
    skin: Option<SkinLayout>,
}

/// One section of a file, known to this reader or not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Section<'a> {
    /// Its row in the section table; `row.part` indexes [`Model::parts`].
    pub row: SectionRow,
    /// Its content.
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

    /// Loads a model in place and checks all of it, in the order that FORMAT.md lists and
    /// in time bounded by the file's length. Never panics, for any input.
    ///
    /// The bytes need no alignment.
    ///
    /// # Errors
    /// Every kind of [`FileError`]; each says what makes it.
    pub fn from_bytes_with(bytes: B, limits: &Limits) -> Result<Self, FileError> {
        let file = bytes.as_ref();
        let manifest = Manifest::read(file, limits)?;
        let (mut envelope, mut skin) = (None, None);
        for kind in PartKind::ALL {
            for part in parts_of(&manifest, file, kind) {
                let checked = match kind {
                    PartKind::Envelope => {
                        check_envelope(&manifest, file, part, limits, &mut envelope)
                    }
                    PartKind::Skin => check_skin(&manifest, file, part, limits, &mut skin),
                };
                checked.map_err(|error| error.part(part))?;
            }
        }
        Ok(Self { bytes, manifest, envelope, skin })
    }

    /// Returns the first envelope; `None` if the file has none.
    pub fn envelope(&self) -> Option<Envelope<'_>> {
        self.envelope.map(|layout| Envelope::new(layout, self.bytes.as_ref()))
    }

    /// Returns the first skin; `None` if the file has none, as one of a palette alone.
    pub fn skin(&self) -> Option<Skin<'_>> {
        self.skin.map(|layout| Skin::new(layout, self.bytes.as_ref()))
    }

    /// Lists the envelopes. What is found of each is read from its sections' rows: keep
    /// [`Envelope::layout`] of those that are needed each frame.
    pub fn envelopes(&self) -> impl Iterator<Item = Envelope<'_>> {
        let file = self.bytes.as_ref();
        parts_of(&self.manifest, file, PartKind::Envelope)
            .filter_map(move |part| envelope_at(&self.manifest, file, part))
    }

    /// Lists the skins; keep [`Skin::layout`] likewise.
    pub fn skins(&self) -> impl Iterator<Item = Skin<'_>> {
        let file = self.bytes.as_ref();
        parts_of(&self.manifest, file, PartKind::Skin).filter_map(move |part| {
            let layout = skin_layout(&self.manifest, file, part, &Limits::FORMAT).ok()?;
            Some(Skin::new(layout, file))
        })
    }

    /// Returns the envelope of this name.
    pub fn envelope_named(&self, name: &str) -> Option<Envelope<'_>> {
        self.envelopes().find(|envelope| envelope.name() == name)
    }

    /// Returns the skin of this name.
    pub fn skin_named(&self, name: &str) -> Option<Skin<'_>> {
        self.skins().find(|skin| skin.name() == name)
    }

    /// Returns the envelope whose palette a skin of this model follows.
    pub fn envelope_of(&self, skin: &Skin<'_>) -> Option<Envelope<'_>> {
        let part = skin.counts().envelope()?;
        match self.envelope() {
            Some(first) if first.part() == usize::from(part) => Some(first),
            _ => envelope_at(&self.manifest, self.bytes.as_ref(), part),
        }
    }

    /// Lists the parts, unknown ones included.
    pub fn parts(&self) -> impl ExactSizeIterator<Item = PartRow> {
        self.manifest.parts(self.bytes.as_ref())
    }

    /// Lists the sections, unknown ones included, in the order of the file.
    pub fn sections(&self) -> impl ExactSizeIterator<Item = Section<'_>> {
        let file = self.bytes.as_ref();
        self.manifest
            .sections(file)
            .map(move |row| Section { row, bytes: self.manifest.span(&row).bytes(file) })
    }

    /// Returns the blob: all sections, at the offsets that their rows state. What a GPU is given.
    pub fn blob(&self) -> &[u8] {
        self.manifest.blob(self.bytes.as_ref())
    }

    /// Returns the space of the file's numbers: its axes and its unit.
    pub fn space(&self) -> Space {
        self.manifest.space()
    }

    /// Tells which file it is, for layouts and plans that were made of it.
    pub fn id(&self) -> FileId {
        self.manifest.id()
    }

    /// Returns the bytes.
    pub fn as_bytes(&self) -> &[u8] {
        self.bytes.as_ref()
    }

    /// Gives the bytes back.
    pub fn into_bytes(self) -> B {
        self.bytes
    }
}

/// Checks an envelope, and keeps the first.
#[inline(never)]
fn check_envelope(
    manifest: &Manifest,
    file: &[u8],
    part: u16,
    limits: &Limits,
    first: &mut Option<EnvelopeLayout>,
) -> Result<(), FileError> {
    let envelope = Envelope::new(envelope::check::layout(manifest, file, part, limits)?, file);
    envelope::check::content(&envelope)?;
    first.get_or_insert(envelope.layout());
    Ok(())
}

/// Checks a skin, and keeps the first.
#[inline(never)]
fn check_skin(
    manifest: &Manifest,
    file: &[u8],
    part: u16,
    limits: &Limits,
    first: &mut Option<SkinLayout>,
) -> Result<(), FileError> {
    let skin = Skin::new(skin_layout(manifest, file, part, limits)?, file);
    skin::check::content(&skin)?;
    first.get_or_insert(skin.layout());
    Ok(())
}

/// Lists the parts of a kind; a reader's limits keep their number below 65,536.
fn parts_of<'a>(
    manifest: &Manifest,
    file: &'a [u8],
    kind: PartKind,
) -> impl Iterator<Item = u16> + use<'a> {
    let rows = (0..).zip(manifest.parts(file));
    rows.filter(move |(_, row)| row.kind == kind.number()).map(|(part, _)| part)
}

/// Finds the envelope at a place in the part table.
fn envelope_at<'a>(manifest: &Manifest, file: &'a [u8], part: u16) -> Option<Envelope<'a>> {
    let row = manifest.parts(file).nth(part.into())?;
    let is_envelope = row.kind == PartKind::Envelope.number();
    let layout = envelope::check::layout(manifest, file, part, &Limits::FORMAT).ok();
    layout.filter(|_| is_envelope).map(|layout| Envelope::new(layout, file))
}

/// Finds the skin at a place in the part table.
fn skin_layout(
    manifest: &Manifest,
    file: &[u8],
    part: u16,
    limits: &Limits,
) -> Result<SkinLayout, FileError> {
    let palette_len = |part| Some(envelope_at(manifest, file, part)?.palette_len());
    skin::check::layout(manifest, file, part, limits, palette_len)
}

impl<B: AsRef<[u8]>> fmt::Debug for Model<B> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.parts()).finish()
    }
}
