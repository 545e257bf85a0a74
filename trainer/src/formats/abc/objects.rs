//! The objects of an Alembic archive and their properties.
//!
//! An object's group holds its properties, then its children, then the headers of the children
//! (`lib/Alembic/AbcCoreOgawa/OrData.cpp` of the Alembic library).
//!
//! A property is a typed value, sampled over time, or a compound of properties. The headers of a compound's properties
//! are the last child of its group. The header of an array or scalar states its type, its extent and which samples are
//! stored (`ReadPropertyHeaders` in `lib/Alembic/AbcCoreOgawa/ReadUtil.cpp` of the Alembic library). A sample is a key
//! of 16 bytes and the numbers.

use super::ogawa::{Archive, Cursor, Group, Metadata, damaged, not_alembic};
use crate::Error;

/// Version of the layout of objects.
const LAYOUT: [u8; 4] = [0; 4];
/// Bytes of the hashes behind the headers of children.
const HASH_BYTES: usize = 32;
/// Largest depth of nested objects.
const DEPTH_MOST: usize = 256;

/// Bytes of the key before a sample's numbers.
const KEY_BYTES: usize = 16;

/// An object.
pub(super) struct Object<'a> {
    pub(super) name: String,
    /// Index of the parent, which precedes the object.
    pub(super) parent: Option<usize>,
    pub(super) schema: Schema,
    pub(super) properties: Compound<'a>,
}

/// The kind of an object.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Schema {
    Transform,
    /// Polygons, or the control mesh of a subdivision surface.
    Mesh,
    Other,
}

/// Lists the objects of an archive in the order of the file, each after its parent.
///
/// # Errors
/// The objects have another layout, the file is damaged, or it exceeds the memory budget.
pub(super) fn list<'a>(archive: &'a Archive<'a>) -> Result<(Vec<Object<'a>>, Metadata), Error> {
    let root = archive.root()?;
    let layout = root.data(0)?;
    if layout != LAYOUT {
        return Err(not_alembic(format!("its objects are laid out by version {layout:?}")));
    }
    let metadata = Metadata::read(root.data(5)?)?;
    let mut objects: Vec<Object<'a>> = Vec::new();
    // Stack of the children still to list, with their parents and depths; the next child is last.
    let mut left = Vec::new();
    push_children(root.group(2)?, None, 0, &metadata, &mut left)?;
    while let Some(Child { name, schema, group, parent, depth }) = left.pop() {
        let properties = match group.len() {
            0 => group,
            _ => group.group(0)?,
        };
        let properties = Compound::read(properties, &metadata)?;
        let number = objects.len();
        objects.push(Object { name, parent, schema, properties });
        push_children(group, Some(number), depth + 1, &metadata, &mut left)?;
    }
    Ok((objects, metadata))
}

impl Schema {
    /// Reads the kind of an object from its metadata, which has entries as `schema=AbcGeom_PolyMesh_v1;`.
    fn of(metadata: &str) -> Self {
        let schema = metadata.split(';').find_map(|entry| entry.strip_prefix("schema="));
        let is = |name| schema.is_some_and(|schema| schema.starts_with(name));
        if is("AbcGeom_Xform_") {
            Self::Transform
        } else if is("AbcGeom_PolyMesh_") || is("AbcGeom_SubD_") {
            Self::Mesh
        } else {
            Self::Other
        }
    }
}

/// A compound: a group of properties.
pub(super) struct Compound<'a> {
    group: Group<'a>,
    headers: Vec<Header>,
}

/// A sampled property.
pub(super) struct Sampled<'a> {
    group: Group<'a>,
    layout: Layout,
}

/// Type and samples of a property.
#[derive(Clone, Copy)]
struct Layout {
    numbers: u32,
    extent: usize,
    /// Number of samples; a run of equal samples is stored once.
    len: usize,
    /// First sample that differs from sample 0, and last sample that differs from its predecessor; 0 and 0 for a
    /// constant.
    changed: [usize; 2],
    is_array: bool,
}

/// The number types that a property may be read as, with their codes in the file.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Numbers {
    /// A truth value, one byte.
    Bool = 0,
    /// One byte.
    U8 = 1,
    /// Four bytes.
    I32 = 6,
    /// Four bytes.
    F32 = 10,
    /// Eight bytes.
    F64 = 11,
}

impl<'a> Compound<'a> {
    /// Reads the headers of a compound's properties.
    ///
    /// # Errors
    /// The file is damaged, or exceeds the memory budget.
    pub(super) fn read(group: Group<'a>, metadata: &Metadata) -> Result<Self, Error> {
        let bytes = group.last_data()?;
        group.archive.spend(bytes.len())?;
        let mut cursor = Cursor(bytes);
        let mut headers = Vec::new();
        while !cursor.0.is_empty() {
            group.archive.spend(size_of::<Header>())?;
            headers.push(Header::read(&mut cursor, metadata)?);
        }
        Ok(Self { group, headers })
    }

    /// Returns the compound with a name; `None` if there is none.
    ///
    /// # Errors
    /// The file is damaged, or exceeds the memory budget.
    pub(super) fn compound(&self, name: &str, metadata: &Metadata) -> Result<Option<Self>, Error> {
        match self.find(name) {
            Some((place, None)) => Self::read(self.group.group(place)?, metadata).map(Some),
            _ => Ok(None),
        }
    }

    /// Returns the sampled property with a name; `None` if it is missing, has another type or extent, or has no sample.
    ///
    /// - `extent`: numbers in each element; 0 accepts any extent.
    ///
    /// # Errors
    /// The file does not have the property's group.
    pub(super) fn sampled(
        &self,
        name: &str,
        numbers: Numbers,
        extent: usize,
    ) -> Result<Option<Sampled<'a>>, Error> {
        let Some((place, Some(layout))) = self.find(name) else { return Ok(None) };
        if layout.numbers != numbers as u32 || (extent != 0 && layout.extent != extent) {
            return Ok(None);
        }
        let group = self.group.group(place)?;
        Ok((layout.len > 0).then_some(Sampled { group, layout }))
    }

    /// Subtracts bytes from the archive's memory budget.
    ///
    /// # Errors
    /// [`ErrorKind::Limit`](crate::ErrorKind::Limit): the budget is spent.
    pub(super) fn spend(&self, bytes: usize) -> Result<(), Error> {
        self.group.archive.spend(bytes)
    }

    /// Returns the place of a property, and its layout unless it is a compound.
    fn find(&self, name: &str) -> Option<(usize, Option<Layout>)> {
        let place = self.headers.iter().position(|header| header.name == name)?;
        Some((place, self.headers[place].layout))
    }
}

impl<'a> Sampled<'a> {
    /// Counts the samples.
    pub(super) fn len(&self) -> usize {
        self.layout.len
    }

    /// Returns the bytes of the numbers of sample `index`; a constant property has one sample for every index.
    ///
    /// # Errors
    /// The sample is missing or cut off.
    pub(super) fn sample(&self, index: usize) -> Result<&'a [u8], Error> {
        self.stored(self.place(index))
    }

    /// Returns the bytes of the numbers of a stored sample.
    ///
    /// # Errors
    /// The sample is missing or cut off.
    pub(super) fn stored(&self, place: usize) -> Result<&'a [u8], Error> {
        // Arrays store their dimensions behind each sample.
        let bytes = self.group.data(if self.layout.is_array { 2 * place } else { place })?;
        match bytes.split_at_checked(KEY_BYTES) {
            Some((_, numbers)) => Ok(numbers),
            None if bytes.is_empty() => Ok(&[]),
            None => Err(damaged("a sample is shorter than its key")),
        }
    }

    /// Returns the place at which sample `index` is stored.
    pub(super) fn place(&self, index: usize) -> usize {
        let [first, last] = self.layout.changed;
        match index {
            _ if last == 0 || index < first => 0,
            _ => index.min(last) - first + 1,
        }
    }

    /// Returns the first sample that is stored at a place.
    pub(super) fn frame(&self, place: usize) -> usize {
        if place == 0 { 0 } else { self.layout.changed[0] + place - 1 }
    }

    /// Counts the stored samples.
    pub(super) fn stored_len(&self) -> usize {
        self.place(self.len() - 1) + 1
    }

    /// Returns whether all samples are equal.
    pub(super) fn is_constant(&self) -> bool {
        self.stored_len() == 1
    }
}

/// An object still to be listed.
struct Child<'a> {
    name: String,
    schema: Schema,
    group: Group<'a>,
    parent: Option<usize>,
    depth: usize,
}

/// Pushes the children of a group onto the stack, the first child last.
fn push_children<'a>(
    group: Group<'a>,
    parent: Option<usize>,
    depth: usize,
    metadata: &Metadata,
    left: &mut Vec<Child<'a>>,
) -> Result<(), Error> {
    let bytes = group.last_data()?;
    let Some(len) = bytes.len().checked_sub(HASH_BYTES).filter(|len| *len > 0) else {
        return Ok(());
    };
    if depth >= DEPTH_MOST {
        return Err(damaged(format!("its objects are more than {DEPTH_MOST} levels deep")));
    }
    group.archive.spend(bytes.len())?;
    let mut cursor = Cursor(&bytes[..len]);
    let begin = left.len();
    while !cursor.0.is_empty() {
        group.archive.spend(size_of::<(Child<'_>, Object<'_>)>())?;
        let name = cursor.text(4)?;
        let number = cursor.number(1)?;
        let schema = Schema::of(&metadata.of(number, &mut cursor, 4)?);
        let group = group.group(1 + left.len() - begin)?;
        left.push(Child { name, schema, group, parent, depth });
    }
    left[begin..].reverse();
    Ok(())
}

struct Header {
    name: String,
    /// `None` for a compound.
    layout: Option<Layout>,
}

impl Header {
    fn read(cursor: &mut Cursor<'_>, metadata: &Metadata) -> Result<Self, Error> {
        let info = cursor.number(4)? as u32;
        let bytes = match info >> 2 & 3 {
            0 => 1,
            1 => 2,
            2 => 4,
            _ => return Err(damaged("a property has counts of no size")),
        };
        let layout = match info & 3 {
            0 => None,
            kind => {
                let len = cursor.number(bytes)?;
                let changed = if info & 0x200 != 0 {
                    [cursor.number(bytes)?, cursor.number(bytes)?]
                } else if info & 0x800 != 0 {
                    [0, 0]
                } else {
                    [1, len.saturating_sub(1)]
                };
                if info & 0x100 != 0 {
                    // Index of the time sampling, which is not used.
                    cursor.number(bytes)?;
                }
                let [first, last] = changed;
                if last != 0 && (first == 0 || first > last || last >= len) {
                    return Err(damaged("a property changes before or behind its samples"));
                }
                let (numbers, extent) = (info >> 4 & 0xf, (info >> 12 & 0xff) as usize);
                Some(Layout { numbers, extent, len, changed, is_array: kind != 1 })
            }
        };
        let name = cursor.text(bytes)?;
        metadata.of((info >> 20 & 0xff) as usize, cursor, bytes)?;
        Ok(Self { name, layout })
    }
}
