//! Why a file is refused.

use super::SectionKind;
use core::fmt;

/// Why a file was refused, and where; FORMAT.md lists the checks in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileError {
    /// What is wrong.
    pub kind: FileErrorKind,
    /// The part, a row of the part table; `None` for the file as a whole.
    pub part: Option<u16>,
    /// The section, or that of a row of the section table where it is known; `None` for the message and its tables.
    pub section: Option<SectionKind>,
    /// Which element: of the section, in what its table counts, or of a table, in rows.
    pub index: u32,
    /// What should be there, or the most or the least that may; `u32::MAX` also stands for more.
    pub expected: u32,
    /// What is there; `u32::MAX` also stands for more.
    pub found: u32,
}

/// What can be wrong with a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum FileErrorKind {
    /// The first four bytes, `found`, are not those of a model.
    NotAModel,
    /// Written in version `found`; this reader knows `expected`.
    Version,
    /// The message contradicts itself, at the place `index`. 1 or 2: the part or the section table has `found` bytes,
    /// expected rows of `expected` bytes. 3: the blob stands at byte `found`, expected a
    /// multiple of `expected` after zeros. 4: the file has
    /// `found` bytes, expected `expected`, the end of the blob.
    Malformed,
    /// The file was changed after it was written: it states checksum `expected`, and has `found`.
    Checksum,
    /// More of something than the caller's [`crate::Limits`] or the format allow. Without a section
    /// `index` 0 is bytes of the file, 1 parts, 2 sections; else it is a count of the section.
    Limit,
    /// `found` is nothing that this reader knows: feature bits; flags or the kind of a part or of a
    /// section; an element type, a predictor, a kernel, a reserved number that is not 0.
    Unsupported,
    /// Row `index` of the section table names part `found` of `expected`.
    PartIndex,
    /// Row `index` of the section table starts at byte `found` of the blob, expected a multiple of `expected`.
    Alignment,
    /// Row `index` of the section table starts at byte `found` of the blob; the one before it ends at `expected`.
    Overlap,
    /// Row `index` of the section table ends at byte `found` of the blob, which has `expected`.
    Bounds,
    /// Row `index` of the section table repeats a kind of its part.
    Duplicate,
    /// The part lacks the section.
    Missing,
    /// The section is not one that the part, as its counts describe it, has.
    Unexpected,
    /// The section should have `expected` bytes.
    Length,
    /// A count that must be at least one is zero: `index` of the section.
    Empty,
    /// Float `index` is not finite, or larger than [`super::MAGNITUDE_MAX`], or in a correction than
    /// [`super::CORRECTION_MAX`]; or negative where it may not be; or of half precision and subnormal.
    Float,
    /// Element `index` should be less than `expected`.
    Index,
    /// Element `index` should be `expected`, which follows from the rest of the file.
    Mismatch,
    /// Element `index` breaks a rule of its section: a name is not UTF-8 or out of place, a joint not
    /// of the tree, an inverse bind matrix not rigid, a normal, tangent or axis not of its length, a
    /// twist too large, weights do not sum to one, a fade does not start and then end, vertices lie
    /// outside a rest box (`found` is the vertex), a range is not inside the mesh, or ends before it
    /// starts, a first term is not 1, deltas lie outside their shape's box (`found` is the delta), entries of
    /// shapes are out of order or move no vertex of their block, a factor's diagonal is not positive or too small for
    /// its column, weights have a bound that ends before it starts, a pair is of one shape or cannot be 0, β is 0, a map
    /// does not give places and then numbers, an element has one point twice, a mask has more bits than there are
    /// points, a texture is empty or larger than the format allows.
    Invalid,
    /// The file ends early: it has `found` bytes of the section, expected `expected`. Without a section both are bytes of
    /// the file, `expected` the least, and `index` is the place of its end: 0 the head, 1 the part table, 2 the section
    /// table, 3 the padding, 4 the blob.
    Truncated,
    /// Byte `index` of the space is `found`, which no space has.
    Space,
}

/// Returns a number, or the most that an error holds.
pub(crate) fn saturated(value: u64) -> u32 {
    u32::try_from(value).unwrap_or(u32::MAX)
}

/// Names what an index of [`FileErrorKind::Truncated`] and [`FileErrorKind::Malformed`] stands for.
fn place(index: u32) -> &'static str {
    let names = ["head", "part table", "section table", "padding", "blob"];
    names.get(index as usize).copied().unwrap_or("file")
}

/// Names what an index counts where a section, or the file as a whole, has counts.
fn counted(section: Option<SectionKind>, index: u32) -> &'static str {
    let names: &[&str] = match section {
        None => &["file bytes", "parts", "sections"],
        Some(SectionKind::EnvelopeCounts) => {
            &["predictor", "joints", "proxies", "root", "groups", "floats of scratch"]
        }
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
            FileErrorKind::Space => write!(f, "byte {index} of the space: {found} is not one"),
            FileErrorKind::Checksum => {
                write!(f, "damaged file: expected checksum {expected:08x}, found {found:08x}")
            }
            FileErrorKind::Limit => {
                write!(f, "{}: at most {expected} allowed, found {found}", counted(section, index))
            }
            FileErrorKind::Unsupported => match section {
                Some(_) => write!(f, "element {index} of {name}: unknown number {found}"),
                None if part.is_some() => {
                    write!(f, "unknown required kind, type or flags: {found}")
                }
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
                    write!(f, "the axis of input {index} has a length other than it must have")
                }
                Some(SectionKind::Outputs) => {
                    write!(f, "the range or the neutral of output {index} is not one of its kind")
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
                    write!(f, "key view {index} shows points that there are not")
                }
                Some(SectionKind::Textures) => {
                    write!(f, "texture {index} is empty, or wider or higher than 65535 texels")
                }
                _ => write!(f, "element {index} of {name} is not valid"),
            },
        }
    }
}
