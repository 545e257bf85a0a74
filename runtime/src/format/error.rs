//! Errors of files.

use super::SectionKind;
use super::tables::{EVALUATED, PartKind};
use core::fmt;

/// Reason why a file was refused, with its place. FORMAT.md lists the checks in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(not(feature = "internals"), non_exhaustive)]
pub struct FileError {
    /// Kind of the mistake.
    pub kind: FileErrorKind,
    /// Row of the part in the part table; `None` for the file as a whole.
    pub part: Option<u16>,
    /// The section, or the section of a table row if its kind is known. `None` for the message and
    /// its tables.
    pub section: Option<SectionKind>,
    /// Index of the element: in the section's own elements, or in rows of a table.
    pub index: u32,
    /// Expected value, or the bound that was broken; `u32::MAX` also means a larger value.
    pub expected: u32,
    /// Value found; `u32::MAX` also means a larger value.
    pub found: u32,
}

/// Kinds of mistakes in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
#[cfg_attr(not(feature = "internals"), non_exhaustive)]
pub enum FileErrorKind {
    /// The first four bytes, `found`, are not the magic of a model.
    NotAModel,
    /// The file has format version `found`; this reader knows `expected`.
    Version,
    /// The message contradicts itself, at place `index`:
    ///
    /// 1 or 2: the part table or the section table has `found` bytes, expected rows of `expected`
    /// bytes.
    ///
    /// 3: the blob starts at byte `found`, expected a multiple of `expected` after zeros.
    ///
    /// 4: the file has `found` bytes, expected `expected`, the end of the blob.
    Malformed,
    /// The file was changed after writing: it states checksum `expected`, and has checksum `found`.
    Checksum,
    /// A count exceeds the caller's [`crate::Limits`] or the format's own limit. Without a section,
    /// `index` 0 means bytes of the file, 1 parts, 2 sections; otherwise `index` is a count of the
    /// section.
    Limit,
    /// This reader does not know `found`. The value is feature bits; flags or the kind of a part or
    /// section; an element type, a predictor, a kernel, or a reserved number other than 0.
    Unsupported,
    /// Row `index` of the section table names part `found`; the file has `expected` parts.
    PartIndex,
    /// Row `index` of the section table starts at byte `found` of the blob, expected a multiple of `expected`.
    Alignment,
    /// Row `index` of the section table starts at byte `found` of the blob; the previous row ends
    /// at `expected`.
    Overlap,
    /// Row `index` of the section table ends at byte `found` of the blob, which has `expected`
    /// bytes.
    Bounds,
    /// Row `index` of the section table repeats a kind of its part.
    Duplicate,
    /// The part lacks the section.
    Missing,
    /// The part's counts exclude this section.
    Unexpected,
    /// The section has `found` bytes, expected `expected`.
    Length,
    /// Count `index` of the section is zero, expected at least one.
    Empty,
    /// Float `index` is out of range. The float is not finite, larger than 1e9
    /// (1e6 in a correction), negative in a section of unsigned floats, or
    /// subnormal in half precision.
    Float,
    /// Element `index` is `found`, expected less than `expected`.
    Index,
    /// Element `index` is `found`, expected `expected` from the rest of the file.
    Mismatch,
    /// Element `index` breaks a rule of its section:
    ///
    /// - names: a name is not UTF-8 or out of place;
    /// - joints: a joint is not part of the tree, an inverse bind matrix is not rigid;
    /// - meshes: a normal, tangent or axis has a wrong length, weights do not sum to one, vertices
    ///   lie outside a rest box (`found` is the vertex), a range is not inside the mesh or ends
    ///   before it starts;
    /// - envelopes: a twist is too large, a fade does not start and then end;
    /// - shapes: deltas lie outside their shape's box (`found` is the delta), entries are out of
    ///   order or move no vertex of their block;
    /// - kernels: a first term is not 1;
    /// - priors: a factor's diagonal is not positive or too small for its column, the bounds of a
    ///   weight end before they start, a pair has one shape twice or excludes 0, β is 0;
    /// - views: a map does not give places and then numbers, an element has one point twice, a mask
    ///   has more bits than points, a texture is empty or larger than the format allows.
    Invalid,
    /// The file ends early: it has `found` bytes of the section, expected `expected`. Without a
    /// section both values are bytes of the file, `expected` is the least, and `index` is the place
    /// of the end: 0 the head, 1 the part table, 2 the section table, 3 the padding, 4 the blob.
    Truncated,
    /// Byte `index` of the space has the invalid value `found`.
    Space,
}

/// Converts a number to u32, saturating at the greatest value.
pub(crate) fn saturated(value: u64) -> u32 {
    u32::try_from(value).unwrap_or(u32::MAX)
}

/// Names the place in the file for an index of [`FileErrorKind::Truncated`] and
/// [`FileErrorKind::Malformed`].
fn place(index: u32) -> &'static str {
    let names = ["head", "part table", "section table", "padding", "blob"];
    names.get(index as usize).copied().unwrap_or("file")
}

/// Names the count at an index, of a section or of the file as a whole.
fn counted(section: Option<SectionKind>, index: u32) -> &'static str {
    let names: &[&str] = match section {
        None => &["file bytes", "parts", "sections"],
        Some(SectionKind::EnvelopeCounts) => &[
            "predictor",
            "joints",
            "proxies",
            "root",
            "groups",
            "floats of scratch",
            "stretches",
            "curves",
        ],
        Some(SectionKind::SkinCounts) => {
            &["vertices", "influences", "envelope", "ranges", "shapes", "entries", "deltas"]
        }
        Some(SectionKind::KernelCounts) => &[
            "inputs",
            "outputs",
            "features",
            "rows of the metric",
            "centres",
            "terms",
            "values",
            "rows of the variance",
        ],
        Some(SectionKind::PriorCounts) => &["skin", "shapes", "symmetry", "cancel pairs"],
        Some(SectionKind::ViewsCounts) => {
            &["points", "elements", "key views", "maps", "textures", "texels"]
        }
        Some(_) => &[],
    };
    names.get(index as usize).copied().unwrap_or("elements")
}

impl core::error::Error for FileError {}

/// Returns the feature of a kind of part or section with this number, if this build lacks the feature.
fn lacked(number: u32) -> Option<&'static str> {
    let number = u16::try_from(number).ok()?;
    if let Some(kind) = PartKind::from_number(number) {
        return (!EVALUATED.contains(&kind)).then(|| kind.name());
    }
    match SectionKind::from_number(number)? {
        SectionKind::StretchRanges | SectionKind::KeyStretches if !cfg!(feature = "stretch") => {
            Some("stretch")
        }
        SectionKind::CurveRanges if !cfg!(feature = "curves") => Some("curves"),
        _ => None,
    }
}

/// Whether a count is the number of a predictor whose helpers are bones, in a build without them.
fn is_bones(index: u32, found: u32) -> bool {
    !cfg!(feature = "trs") && index == 0 && matches!(found, 3 | 4)
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { kind, part, section, index, expected, found } = *self;
        let name = section.map_or("of an unknown kind", SectionKind::name);
        if let Some(part) = part {
            write!(f, "part {part}: ")?;
        }
        match kind {
            FileErrorKind::NotAModel => {
                write!(f, "not a model: it starts with {:?}", found.to_le_bytes())
            }
            FileErrorKind::Version => {
                write!(f, "format version: expected {expected}, found {found}")
            }
            FileErrorKind::Truncated => match section {
                Some(_) => write!(
                    f,
                    "the file ends early: section {name}: expected {expected} bytes, found {found}"
                ),
                None => write!(
                    f,
                    "the file ends early, in its {}: expected at least {expected} bytes, found {found}",
                    place(index)
                ),
            },
            FileErrorKind::Malformed => match index {
                3 => write!(
                    f,
                    "the blob: expected after zeros at a multiple of {expected} bytes, found at byte {found}"
                ),
                4 => write!(f, "the file: expected {expected} bytes, found {found}"),
                _ => write!(
                    f,
                    "the {}: expected rows of {expected} bytes, found {found} bytes",
                    place(index)
                ),
            },
            FileErrorKind::Space => write!(f, "byte {index} of the space: {found} is not valid"),
            FileErrorKind::Checksum => {
                write!(f, "damaged file: expected checksum {expected:08x}, found {found:08x}")
            }
            FileErrorKind::Limit => {
                write!(f, "{}: at most {expected} allowed, found {found}", counted(section, index))
            }
            FileErrorKind::Unsupported => match section {
                Some(SectionKind::EnvelopeCounts) if is_bones(index, found) => {
                    f.write_str("needs the feature `trs`, which this build lacks")
                }
                Some(_) => write!(f, "element {index} of {name}: unknown number {found}"),
                None if part.is_some() => match lacked(found) {
                    Some(name) => {
                        write!(f, "needs the feature `{name}`, which this build lacks")
                    }
                    None => write!(f, "unknown required kind, type or flags: {found}"),
                },
                None => write!(f, "needs unknown features {found:#x}"),
            },
            FileErrorKind::PartIndex => {
                write!(f, "section row {index} belongs to part {found} of {expected}")
            }
            FileErrorKind::Alignment => write!(
                f,
                "section row {index}, {name}: expected an offset that is a multiple of {expected}, found {found}"
            ),
            FileErrorKind::Overlap => write!(
                f,
                "section row {index}, {name}, starts inside another: expected an offset of at least {expected}, found \
                 {found}"
            ),
            FileErrorKind::Bounds => write!(
                f,
                "section row {index}, {name}, reaches beyond the blob: expected an end of at most {expected}, found \
                 {found}"
            ),
            FileErrorKind::Duplicate => write!(f, "section row {index}, {name}, repeats a kind"),
            FileErrorKind::Missing => write!(f, "section {name} is missing"),
            FileErrorKind::Unexpected => write!(f, "section {name} is not one of this part's"),
            FileErrorKind::Length => {
                write!(f, "section {name}: expected {expected} bytes, found {found}")
            }
            FileErrorKind::Empty => match section {
                Some(SectionKind::Groups) => write!(
                    f,
                    "group {index} lacks proxies, or has centres but no inputs or no rank"
                ),
                _ => write!(f, "{}: expected at least 1, found 0", counted(section, index)),
            },
            FileErrorKind::Float => write!(f, "float {index} of {name} is out of range"),
            FileErrorKind::Index => {
                write!(f, "index {index} of {name}: expected less than {expected}, found {found}")
            }
            FileErrorKind::Mismatch => match section {
                Some(SectionKind::Groups) => {
                    write!(f, "group {index}: expected at word {expected}, found at {found}")
                }
                Some(SectionKind::ShapeEntries) => {
                    write!(f, "entry {index}: expected at delta {expected}, found at {found}")
                }
                Some(SectionKind::ShapeSlopes) => write!(
                    f,
                    "section {name}: expected the deltas' element type {expected}, found {found}"
                ),
                Some(SectionKind::Maps) => {
                    write!(f, "map {index}: expected {expected} outputs, found {found}")
                }
                Some(SectionKind::Textures) => {
                    write!(f, "texture {index}: expected at texel {expected}, found at {found}")
                }
                _ => {
                    let what = counted(section, index);
                    let of = match section {
                        Some(SectionKind::KernelCounts) => "rows",
                        Some(SectionKind::SkinCounts) => "blocks",
                        Some(SectionKind::PriorCounts) => "skins",
                        Some(SectionKind::ViewsCounts) => "textures",
                        _ => "groups",
                    };
                    write!(f, "{what}: the {of} need {expected}, found {found}")
                }
            },
            FileErrorKind::Invalid => match section {
                Some(SectionKind::Names) => write!(f, "name {index} is not valid"),
                Some(SectionKind::Hierarchy) => write!(f, "joint {index} is not part of one tree"),
                Some(SectionKind::InverseBinds) => {
                    write!(f, "the inverse bind matrix of joint {index} is not rigid")
                }
                Some(SectionKind::RestNormals) => {
                    write!(f, "the normal of vertex {index} has a length other than 1 and 0")
                }
                Some(SectionKind::RestTangents) => write!(
                    f,
                    "the tangent of vertex {index} has a length other than 1, or no handedness"
                ),
                Some(SectionKind::InfluenceWeights) => {
                    write!(f, "the weights of vertex {index} do not sum to one")
                }
                Some(SectionKind::Keys) => {
                    write!(f, "a twist matrix of key {index} is too large")
                }
                Some(SectionKind::Groups) => {
                    write!(f, "group {index}: the fade does not start and end")
                }
                Some(SectionKind::RestBoxes) => write!(
                    f,
                    "rest box {index} does not hold vertex {found}, which its transform moves"
                ),
                Some(SectionKind::Ranges) => {
                    write!(f, "range {index} of vertices is not inside the mesh, or out of order")
                }
                Some(SectionKind::KernelRule) => f.write_str("the fade does not start and end"),
                Some(SectionKind::Inputs) => {
                    write!(f, "the axis of input {index} has a wrong length")
                }
                Some(SectionKind::Outputs) => {
                    write!(f, "the range or the neutral of output {index} does not fit its kind")
                }
                Some(SectionKind::Features) => {
                    write!(f, "the range of feature {index} ends before it starts")
                }
                Some(SectionKind::Terms) => f.write_str("the first term is not 1"),
                Some(SectionKind::Shapes) => {
                    write!(f, "the box of shape {index} does not hold 0, or not delta {found}")
                }
                Some(SectionKind::ShapeBlocks) => {
                    write!(f, "block {index} of vertices does not follow the one before it")
                }
                Some(SectionKind::ShapeEntries) => write!(
                    f,
                    "entry {index} moves no vertex, or one beyond the mesh, or its shape is out of order"
                ),
                Some(SectionKind::PriorFactor) => {
                    write!(f, "float {index} of {name} is too small for the diagonal of its column")
                }
                Some(SectionKind::WeightBounds) => {
                    write!(f, "the bounds of weight {index} end before they start")
                }
                Some(SectionKind::Symmetry) => {
                    write!(f, "pair {index} of {name} is of one shape, or its stiffness negative")
                }
                Some(SectionKind::CancelPairs) => {
                    write!(f, "pair {index} of {name} is of one shape, or of one that cannot be 0")
                }
                Some(SectionKind::PriorFit) => f.write_str("pins have no stiffness: beta is 0"),
                Some(SectionKind::Maps) => {
                    write!(f, "map {index} does not give places, then numbers")
                }
                Some(SectionKind::Elements) => {
                    write!(f, "element {index} has one point twice")
                }
                Some(SectionKind::ViewMasks) => {
                    write!(f, "key view {index} has mask bits behind its last point")
                }
                Some(SectionKind::Textures) => {
                    write!(f, "texture {index} is empty, or wider or higher than 65535 texels")
                }
                _ => write!(f, "element {index} of {name} is not valid"),
            },
        }
    }
}
