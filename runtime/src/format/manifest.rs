//! Reads the message and its two tables: what is found is offsets, which outlive the bytes.

use super::error::{FileError, FileErrorKind as Kind, saturated};
use super::message::{
    ALIGNMENT, CHECKSUM_OFFSET, FEATURES, HEAD_BYTES, MAGIC, SPACE_OFFSET, VERSION, checksum,
};
use super::rule::{OPTIONAL, Rule};
use super::space::Space;
use super::tables::{PartKind, PartRow, REQUIRED, SectionKind, SectionRow};
use crate::limits::Limits;

/// Where bytes lie in the file; a file has less than 4 GiB.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Span {
    start: u32,
    len: u32,
}

impl Span {
    /// Where there is nothing: no file reaches so far.
    pub(crate) const NONE: Self = Self { start: u32::MAX, len: 0 };

    /// Whether there is something, if only an empty section.
    pub(crate) const fn is_some(self) -> bool {
        self.start != u32::MAX
    }

    /// Returns the span of bytes that are a part of a file.
    fn of(part: &[u8], file: &[u8]) -> Self {
        let start = part.as_ptr().addr().saturating_sub(file.as_ptr().addr());
        Self { start: narrow(start), len: narrow(part.len()) }
    }

    /// Returns the bytes; none of a file that does not reach so far.
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

/// Tells files apart, without reading them: by their length and the checksum that they state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileId {
    len: u32,
    checksum: u32,
}

impl FileId {
    /// Reads it; `None` of bytes that are too short to be a file.
    pub fn of(file: &[u8]) -> Option<Self> {
        let checksum = file.get(CHECKSUM_OFFSET..)?.first_chunk()?;
        Some(Self { len: narrow(file.len()), checksum: u32::from_le_bytes(*checksum) })
    }
}

/// The head of a file whose tables have been checked.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Manifest {
    id: FileId,
    space: [u8; 8],
    parts: Span,
    sections: Span,
    blob: Span,
}

impl Manifest {
    /// Reads and checks what stands before the blob: steps 1 to 4 of FORMAT.md.
    pub(crate) fn read(file: &[u8], limits: &Limits) -> Result<Self, FileError> {
        let (space, (parts, sections, _, blob)) = message(file, limits)?;
        if let Err(at) = Space::from_bytes(space) {
            return Err(FileError::of_file(Kind::Malformed, at.into(), [0; 2]));
        }
        // A file that has been decoded is long enough to have one.
        let id = FileId::of(file).unwrap_or(FileId { len: 0, checksum: 0 });
        let manifest = Self {
            id,
            space,
            parts: Span::of(parts, file),
            sections: Span::of(sections, file),
            blob: Span::of(blob, file),
        };
        manifest.check_parts(file, limits)?;
        manifest.check_sections(file, limits)?;
        Ok(manifest)
    }

    /// Tells which file was read.
    pub(crate) const fn id(&self) -> FileId {
        self.id
    }

    /// Returns the space of its numbers.
    pub(crate) fn space(&self) -> Space {
        // It has been read before.
        Space::from_bytes(self.space).unwrap_or_default()
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

    /// Returns where a section lies in the file.
    pub(crate) fn span(&self, row: &SectionRow) -> Span {
        Span { start: self.blob.start.saturating_add(row.offset), len: row.bytes }
    }

    /// Finds a part's section of one kind; [`Span::NONE`] if there is none.
    fn find(&self, file: &[u8], part: u16, kind: SectionKind) -> Span {
        let is_it = |row: &SectionRow| row.part == part && row.kind == kind.number();
        self.sections(file).find(is_it).map_or(Span::NONE, |row| self.span(&row))
    }

    /// Reads the counts of a part.
    ///
    /// # Errors
    /// [`Kind::Missing`] and [`Kind::Length`] of their section.
    #[inline(never)]
    pub(crate) fn counts(
        &self,
        file: &[u8],
        part: u16,
        section: SectionKind,
        out_counts: &mut [u32],
    ) -> Result<(), FileError> {
        let found = self.find(file, part, section);
        if !found.is_some() {
            return Err(FileError::of(Kind::Missing, section, 0, [0; 2]));
        }
        let expected = 4 * out_counts.len();
        if found.len() != expected {
            let values = [expected as u32, found.len() as u32];
            return Err(FileError::of(Kind::Length, section, 0, values));
        }
        for (count, word) in out_counts.iter_mut().zip(found.bytes(file).as_chunks().0) {
            *count = u32::from_le_bytes(*word);
        }
        Ok(())
    }

    /// Finds the sections of a part, and holds them to its rules.
    ///
    /// - `has`: bits of what the part has, [`super::rule::ALWAYS`] among them.
    /// - `sizes`: what rules multiply to the number of elements.
    ///
    /// # Errors
    /// [`Kind::Missing`], [`Kind::Unexpected`] and [`Kind::Length`].
    #[inline(never)]
    pub(crate) fn find_all(
        &self,
        (file, part): (&[u8], u16),
        rules: &[Rule],
        (has, sizes): (u8, &[u32]),
        out_spans: &mut [Span],
    ) -> Result<(), FileError> {
        for (rule, out) in rules.iter().zip(out_spans) {
            let span = self.find(file, part, rule.section);
            let (expected, found) = (rule.bytes(sizes).unwrap_or(u64::MAX), span.len() as u64);
            let fits = found == expected || rule.or_more.is_some() && found > expected;
            let kind = match (has & rule.has != 0, span.is_some()) {
                (true, false) => Kind::Missing,
                (false, true) if rule.has != OPTIONAL => Kind::Unexpected,
                (_, true) if !fits => Kind::Length,
                _ => {
                    *out = span;
                    continue;
                }
            };
            let lengths = [expected, found].map(saturated);
            let values = if kind == Kind::Length { lengths } else { [0; 2] };
            return Err(FileError::of(kind, rule.section, 0, values));
        }
        Ok(())
    }

    /// Checks that a part requires a reader to know no sections but those of its rules.
    pub(crate) fn check_known(
        &self,
        file: &[u8],
        part: u16,
        rules: &[Rule],
    ) -> Result<(), FileError> {
        for (index, row) in self.sections(file).enumerate() {
            let is_known = rules.iter().any(|rule| rule.section.number() == row.kind);
            if row.part == part && row.required() && !is_known {
                return Err(FileError::of_file(Kind::Unsupported, index, [0, row.kind.into()]));
            }
        }
        Ok(())
    }

    fn check_parts(&self, file: &[u8], limits: &Limits) -> Result<(), FileError> {
        if !self.parts.len().is_multiple_of(PartRow::BYTES) || self.parts.len() == 0 {
            return Err(FileError::of_file(Kind::Malformed, 0, [0; 2]));
        }
        check_limit(1, limits.parts.into(), self.parts(file).len())?;
        for (part, row) in (0..).zip(self.parts(file)) {
            let is_known = !row.required() || PartKind::from_number(row.kind).is_some();
            let unknown = if row.flags & !REQUIRED != 0 { row.flags } else { row.kind };
            if row.flags & !REQUIRED != 0 || !is_known {
                let error = FileError::of_file(Kind::Unsupported, 0, [0, unknown.into()]);
                return Err(error.part(part));
            }
        }
        Ok(())
    }

    fn check_sections(&self, file: &[u8], limits: &Limits) -> Result<(), FileError> {
        if !self.sections.len().is_multiple_of(SectionRow::BYTES) {
            return Err(FileError::of_file(Kind::Malformed, 0, [0; 2]));
        }
        check_limit(2, limits.sections.into(), self.sections(file).len())?;
        let mut end = 0;
        for (index, row) in self.sections(file).enumerate() {
            self.check_section(file, index, &row)?;
            let start = u64::from(row.offset);
            let past = start + u64::from(row.bytes);
            let kind = if !(row.offset as usize).is_multiple_of(ALIGNMENT) {
                Kind::Alignment
            } else if start < end {
                Kind::Overlap
            } else if past > self.blob.len() as u64 {
                Kind::Bounds
            } else {
                end = past;
                continue;
            };
            return Err(FileError::of_file(kind, index, [0; 2]));
        }
        for (index, row) in self.sections(file).enumerate() {
            let mut before = self.sections(file).take(index);
            if before.any(|other| (other.part, other.kind) == (row.part, row.kind)) {
                return Err(FileError::of_file(Kind::Duplicate, index, [0; 2]));
            }
        }
        Ok(())
    }

    /// Checks what a row says, as far as its kind is known.
    fn check_section(&self, file: &[u8], index: usize, row: &SectionRow) -> Result<(), FileError> {
        let Some(part) = self.parts(file).nth(row.part.into()) else {
            let values = [self.parts(file).len() as u32, row.part.into()];
            return Err(FileError::of_file(Kind::PartIndex, index, values));
        };
        let kind = SectionKind::from_number(row.kind);
        let kind = kind.filter(|_| PartKind::from_number(part.kind).is_some());
        let unknown = if u16::from(row.flags) & !REQUIRED != 0 {
            row.flags.into()
        } else if row.reserved != 0 {
            row.reserved
        } else if kind.is_some_and(|kind| kind.element().number() != row.element) {
            row.element.into()
        } else {
            return Ok(());
        };
        let error = FileError::of_file(Kind::Unsupported, index, [0, unknown.into()]);
        Err(error.part(row.part))
    }
}

/// The byte strings of a message: part rows, section rows, padding, blob.
type Strings<'a> = (&'a [u8], &'a [u8], &'a [u8], &'a [u8]);

/// Checks what stands before the tables: size, magic, version, checksum, features, padding.
fn message<'a>(file: &'a [u8], limits: &Limits) -> Result<([u8; 8], Strings<'a>), FileError> {
    let wrong = |kind, values| Err(FileError::of_file(kind, 0, values));
    check_limit(0, limits.file_bytes, file.len())?;
    let word = |at: usize| file.get(at..).and_then(<[u8]>::first_chunk).copied();
    let (Some(magic), Some(&version)) = (word(0), file.get(MAGIC.len())) else {
        return wrong(Kind::Malformed, [0; 2]);
    };
    if magic != MAGIC {
        return wrong(Kind::NotAModel, [MAGIC, magic].map(u32::from_le_bytes));
    }
    if version != VERSION {
        return wrong(Kind::Version, [VERSION.into(), version.into()]);
    }
    let strings = file.get(HEAD_BYTES..).and_then(|rest| postcard::take_from_bytes(rest).ok());
    let space = file.get(SPACE_OFFSET..).and_then(<[u8]>::first_chunk::<8>);
    let (Some((strings, rest)), Some(space)) = (strings, space) else {
        return wrong(Kind::Malformed, [0; 2]);
    };
    let stated = u32::from_le_bytes(word(CHECKSUM_OFFSET).unwrap_or_default());
    let found = checksum(file);
    if stated != found {
        return wrong(Kind::Checksum, [stated, found]);
    }
    let features = u32::from_le_bytes(word(MAGIC.len() + 1).unwrap_or_default());
    if features & !FEATURES != 0 {
        return wrong(Kind::Unsupported, [FEATURES, features & !FEATURES]);
    }
    let (_, _, padding, blob): Strings<'_> = strings;
    let blob_start = file.len() - blob.len();
    let is_zero = padding.iter().all(|&byte| byte == 0);
    if !rest.is_empty() || !blob_start.is_multiple_of(ALIGNMENT) || !is_zero {
        return wrong(Kind::Malformed, [0; 2]);
    }
    Ok((*space, strings))
}

fn check_limit(index: usize, most: u32, found: usize) -> Result<(), FileError> {
    let found = saturated(found as u64);
    if found <= most {
        return Ok(());
    }
    Err(FileError::of_file(Kind::Limit, index, [most, found]))
}
