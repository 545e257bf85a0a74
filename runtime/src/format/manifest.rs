//! Reads the message and its two tables. The result is offsets, which outlive the bytes.

use super::error::{FileErrorKind as Kind, saturated};
use super::message::{ALIGNMENT, CHECKSUM_OFFSET, FEATURES, HEAD_BYTES, MAGIC, VERSION, checksum};
use super::refusal::{Checked, Loading, Refused};
use super::sections::SectionKind;
use super::space::Space;
use super::tables::{EVALUATED, Element, PartRow, REQUIRED, SectionRow};
use core::num::NonZeroU16;

/// Places where a file can end early, as errors number them.
const HEAD: usize = 0;
const PART_TABLE: usize = 1;
const SECTION_TABLE: usize = 2;
const PADDING: usize = 3;
const BLOB: usize = 4;

/// Position of bytes in the file; a file has less than 4 GiB.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Span {
    start: u32,
    len: u32,
}

impl Span {
    /// The empty span. Real spans start behind the head.
    pub(crate) const NONE: Self = Self { start: 0, len: 0 };

    /// Returns the span of a slice of a file.
    fn of(part: &[u8], file: &[u8]) -> Self {
        let start = part.as_ptr().addr().saturating_sub(file.as_ptr().addr());
        Self { start: narrow(start), len: narrow(part.len()) }
    }

    /// Returns the bytes; empty if the file is too short.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn bytes(self, file: &[u8]) -> &[u8] {
        file.get(self.start as usize..)
            .and_then(|tail| tail.get(..self.len as usize))
            .unwrap_or_default()
    }

    /// Returns its length in bytes.
    pub(crate) const fn len(self) -> usize {
        self.len as usize
    }
}

fn narrow(value: usize) -> u32 {
    u32::try_from(value).unwrap_or(u32::MAX)
}

/// Start of the section table and of the blob in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Tables {
    sections: u32,
    blob: u32,
}

impl Tables {
    /// The tables of no file.
    pub(crate) const NOTHING: Self = Self { sections: 0, blob: 0 };

    /// Whether the tables belong to a file. A file has a head before its blob.
    pub(crate) const fn is_some(self) -> bool {
        self.blob != 0
    }

    /// Returns the content of the section in row `number`, counted from 1.
    #[inline]
    pub(crate) fn section(self, number: u16, file: &[u8]) -> Option<&[u8]> {
        let start = (self.sections as usize).wrapping_add(SectionRow::BYTES * usize::from(number));
        let row = file.get(..start)?.last_chunk()?;
        self.content(&SectionRow::from_bytes(row), file)
    }

    /// Returns the content of a row's section; `None` if the file is too short.
    #[inline]
    fn content<'a>(self, row: &SectionRow, file: &'a [u8]) -> Option<&'a [u8]> {
        let blob = file.get(self.blob as usize..)?;
        blob.get(row.offset as usize..)?.get(..row.bytes as usize)
    }
}

/// Identity of a file, without reading it: its length and its stated checksum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileId {
    len: u32,
    checksum: u32,
}

impl FileId {
    /// The identity of no file.
    pub(crate) const NONE: Self = Self { len: 0, checksum: 0 };

    /// Returns its numbers.
    #[cfg(feature = "prior")]
    pub(crate) const fn words(self) -> [u32; 2] {
        [self.len, self.checksum]
    }

    /// Reads the identity; `None` if the bytes are too short for a file.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) fn of(file: &[u8]) -> Option<Self> {
        let checksum = file.get(CHECKSUM_OFFSET..)?.first_chunk()?;
        Some(Self { len: narrow(file.len()), checksum: u32::from_le_bytes(*checksum) })
    }
}

/// The head of a file whose tables have been checked.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Manifest {
    id: FileId,
    parts: Span,
    sections: Span,
    blob: Span,
}

impl Manifest {
    /// The manifest of no file.
    pub(crate) const NOTHING: Self =
        Self { id: FileId::NONE, parts: Span::NONE, sections: Span::NONE, blob: Span::NONE };

    /// Reads and checks the bytes before the blob: steps 1 to 4 of FORMAT.md.
    pub(crate) fn read(&mut self, loading: &Loading<'_>) -> Checked {
        let file = loading.file;
        let (parts, sections, _, blob) = message(loading)?;
        // A decoded file is long enough for an identity.
        self.id = FileId::of(file).unwrap_or(FileId::NONE);
        self.parts = Span::of(parts, file);
        self.sections = Span::of(sections, file);
        self.blob = Span::of(blob, file);
        self.check_parts(loading)?;
        self.check_sections(loading)
    }

    /// Returns the file's identity.
    pub(crate) const fn id(&self) -> FileId {
        self.id
    }

    /// Returns the blob.
    pub(crate) fn blob<'a>(&self, file: &'a [u8]) -> &'a [u8] {
        self.blob.bytes(file)
    }

    /// Lists the part table.
    pub(crate) fn parts<'a>(
        &self,
        file: &'a [u8],
    ) -> impl ExactSizeIterator<Item = PartRow> + use<'a> {
        self.parts.bytes(file).as_chunks().0.iter().map(PartRow::from_bytes)
    }

    /// Lists the section table.
    pub(crate) fn sections<'a>(
        &self,
        file: &'a [u8],
    ) -> impl ExactSizeIterator<Item = SectionRow> + use<'a> {
        self.sections.bytes(file).as_chunks().0.iter().map(SectionRow::from_bytes)
    }

    /// Returns the content of a section.
    pub(crate) fn section<'a>(&self, row: &SectionRow, file: &'a [u8]) -> &'a [u8] {
        self.tables().content(row, file).unwrap_or_default()
    }

    /// Returns the start of the tables and of the blob.
    pub(crate) const fn tables(&self) -> Tables {
        Tables { sections: self.sections.start, blob: self.blob.start }
    }

    /// Finds the first row of a part's section of one kind. Returns the row's number, counted from
    /// 1, and the section's length.
    #[inline(never)]
    pub(crate) fn find(&self, file: &[u8], part: u16, kind: u16) -> Option<(NonZeroU16, u32)> {
        for (index, row) in self.sections(file).enumerate() {
            if (row.part, row.kind) == (part, kind) {
                return Some((NonZeroU16::new((index + 1) as u16)?, row.bytes));
            }
        }
        None
    }

    /// Returns the element type of a part's section of one kind.
    pub(crate) fn element(&self, file: &[u8], part: u16, kind: SectionKind) -> Option<Element> {
        let mut rows = self.sections(file);
        let row = rows.find(|row| (row.part, row.kind) == (part, kind.number()))?;
        Element::ALL.get(usize::from(row.element)).copied()
    }

    fn check_parts(&self, loading: &Loading<'_>) -> Checked {
        let file = loading.file;
        if !self.parts.len().is_multiple_of(PartRow::BYTES) || self.parts.len() == 0 {
            let values = [PartRow::BYTES as u32, self.parts.len];
            return Err(loading.refuse(Kind::Malformed, None, PART_TABLE, values));
        }
        check_limit(loading, 1, loading.limits.parts.into(), self.parts(file).len())?;
        for (part, row) in (0..).zip(self.parts(file)) {
            let unknown = if row.flags & !REQUIRED != 0 {
                row.flags
            } else if row.required() && !is_evaluated(row) {
                row.kind
            } else {
                continue;
            };
            loading.of_part(part);
            return Err(loading.refuse(Kind::Unsupported, None, 0, [0, unknown.into()]));
        }
        Ok(())
    }

    fn check_sections(&self, loading: &Loading<'_>) -> Checked {
        let file = loading.file;
        if !self.sections.len().is_multiple_of(SectionRow::BYTES) {
            let values = [SectionRow::BYTES as u32, self.sections.len];
            return Err(loading.refuse(Kind::Malformed, None, SECTION_TABLE, values));
        }
        check_limit(loading, 2, loading.limits.sections.into(), self.sections(file).len())?;
        let mut end = 0;
        for (index, row) in self.sections(file).enumerate() {
            // A blob has less than 4 GiB.
            let past = row.offset.saturating_add(row.bytes);
            let part = self.parts(file).nth(row.part.into());
            if let Some(unknown) = part.and_then(|part| unknown(part, &row)) {
                loading.of_part(row.part);
                return Err(loading.refuse(Kind::Unsupported, None, index, [0, unknown.into()]));
            } else if part.is_none() {
                let values = [self.parts(file).len() as u32, row.part.into()];
                return Err(loading.refuse(Kind::PartIndex, None, index, values));
            }
            let (kind, values) = if !(row.offset as usize).is_multiple_of(ALIGNMENT) {
                (Kind::Alignment, [ALIGNMENT as u32, row.offset])
            } else if row.offset < end {
                (Kind::Overlap, [end, row.offset])
            } else if past as usize > self.blob.len() {
                (Kind::Bounds, [self.blob.len, past])
            } else {
                end = past;
                continue;
            };
            return Err(refuse_row(loading, kind, index, &row, values));
        }
        for (index, row) in self.sections(file).enumerate() {
            let first = self.find(file, row.part, row.kind);
            if first.is_some_and(|(number, _)| usize::from(number.get()) <= index) {
                return Err(refuse_row(loading, Kind::Duplicate, index, &row, [0; 2]));
            }
        }
        Ok(())
    }
}

/// Whether this build evaluates the kind of a part.
fn is_evaluated(row: PartRow) -> bool {
    EVALUATED.iter().any(|kind| kind.number() == row.kind)
}

/// Finds an unknown value in the row of a part's section. Element types are checked only for known
/// kinds of parts.
fn unknown(part: PartRow, row: &SectionRow) -> Option<u16> {
    let is_known = is_evaluated(part);
    if u16::from(row.flags) & !REQUIRED != 0 {
        Some(row.flags.into())
    } else if row.reserved != 0 {
        Some(row.reserved)
    } else if is_known && !SectionKind::takes(row.kind, row.element) {
        Some(row.element.into())
    } else {
        None
    }
}

/// Whether errors name their section in detail. Errors of the section table then name the section
/// and its bytes, and errors of truncated files name the section. On bare targets flash is small:
/// table errors give only the row, and a truncated file expects one byte more.
const IS_DETAILED: bool = cfg!(not(target_os = "none"));

/// Refuses a row of the section table, and names its part and section.
#[cold]
fn refuse_row(
    loading: &Loading<'_>,
    kind: Kind,
    index: usize,
    row: &SectionRow,
    values: [u32; 2],
) -> Refused {
    if !IS_DETAILED {
        return loading.refuse(kind, None, index, [0; 2]);
    }
    loading.of_part(row.part);
    loading.refuse(kind, SectionKind::from_number(row.kind), index, values)
}

/// The byte strings of a message: part rows, section rows, padding, blob.
type Strings<'a> = (&'a [u8], &'a [u8], &'a [u8], &'a [u8]);

/// Checks the fields before the tables: size, magic, version, checksum, features, padding, space.
fn message<'a>(loading: &Loading<'a>) -> Checked<Strings<'a>> {
    let file = loading.file;
    let wrong = |kind, values| Err(loading.refuse(kind, None, 0, values));
    check_limit(loading, 0, loading.limits.file_bytes, file.len())?;
    let word = |at: usize| file.get(at..).and_then(<[u8]>::first_chunk).copied();
    let (Some(magic), Some(&version)) = (word(0), file.get(MAGIC.len())) else {
        return Err(cut_off(loading));
    };
    if magic != MAGIC {
        return wrong(Kind::NotAModel, [MAGIC, magic].map(u32::from_le_bytes));
    }
    if version != VERSION {
        return wrong(Kind::Version, [VERSION.into(), version.into()]);
    }
    let read = file.get(HEAD_BYTES..).and_then(|rest| postcard::take_from_bytes(rest).ok());
    let (strings, rest): (Strings<'_>, _) = read.ok_or_else(|| cut_off(loading))?;
    let stated = u32::from_le_bytes(word(CHECKSUM_OFFSET).unwrap_or_default());
    let found = checksum(file);
    if stated != found {
        return wrong(Kind::Checksum, [stated, found]);
    }
    let features = u32::from_le_bytes(word(MAGIC.len() + 1).unwrap_or_default());
    if features & !FEATURES != 0 {
        return wrong(Kind::Unsupported, [FEATURES, features & !FEATURES]);
    }
    let (_, _, padding, blob) = strings;
    if !rest.is_empty() {
        let values = [file.len() - rest.len(), file.len()].map(narrow);
        return Err(loading.refuse(Kind::Malformed, None, BLOB, values));
    }
    let blob_start = file.len() - blob.len();
    if !blob_start.is_multiple_of(ALIGNMENT) || !padding.iter().all(|&byte| byte == 0) {
        let values = [ALIGNMENT, blob_start].map(narrow);
        return Err(loading.refuse(Kind::Malformed, None, PADDING, values));
    }
    let space = Space::bytes(file);
    if let Some(at) = Space::invalid_byte(space) {
        let found = space.into_iter().nth(at).unwrap_or_default();
        return Err(loading.refuse(Kind::Space, None, at, [0, found.into()]));
    }
    Ok(strings)
}

/// Refuses a file that ends before its byte strings do.
#[cold]
fn cut_off(loading: &Loading<'_>) -> Refused {
    let file = loading.file;
    let (mut place, mut expected) = (HEAD, HEAD_BYTES);
    if !IS_DETAILED {
        (place, expected) = (BLOB, file.len() + 1);
    } else if let Some(mut rest) = file.get(HEAD_BYTES..) {
        let mut sections = rest;
        for string in PART_TABLE..=BLOB {
            // If the length itself is cut off, one more byte is expected.
            let at_end = rest.get(rest.len()..).unwrap_or_default();
            let (len, after) = postcard::take_from_bytes(rest).unwrap_or((1, at_end));
            (place, expected) = (string, (file.len() - after.len()).saturating_add(len));
            let Some((own, after)) = after.split_at_checked(len) else {
                if string == BLOB
                    && let Some(refused) = cut_section(loading, sections, after.len())
                {
                    return refused;
                }
                break;
            };
            if string == SECTION_TABLE {
                sections = own;
            }
            rest = after;
        }
    }
    loading.refuse(Kind::Truncated, None, place, [expected, file.len()].map(narrow))
}

/// Refuses a file whose blob of `blob_len` bytes ends inside a section. Returns `None` if the blob
/// ends behind the known sections.
#[cold]
fn cut_section(loading: &Loading<'_>, sections: &[u8], blob_len: usize) -> Option<Refused> {
    let mut rows = sections.as_chunks().0.iter().map(SectionRow::from_bytes);
    let left = |row: &SectionRow| blob_len.saturating_sub(row.offset as usize);
    let row = rows.find(|row| left(row) < row.bytes as usize)?;
    let section = SectionKind::from_number(row.kind)?;
    loading.of_part(row.part);
    Some(loading.refuse(Kind::Truncated, Some(section), 0, [row.bytes, narrow(left(&row))]))
}

fn check_limit(loading: &Loading<'_>, index: usize, most: u32, found: usize) -> Checked {
    let found = saturated(found as u64);
    if found <= most {
        return Ok(());
    }
    Err(loading.refuse(Kind::Limit, None, index, [most, found]))
}
