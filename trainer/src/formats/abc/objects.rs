//! The objects of an Alembic archive: transforms, and meshes under them.
//!
//! An object's group holds its properties, then its children, then their headers (`lib/Alembic/AbcCoreOgawa/OrData.cpp`
//! of the Alembic library).

use super::error::{AlembicError, damaged};
use super::header::{Cursor, Metadata};
use super::ogawa::{Archive, Group};
use super::property::Compound;

/// Version of the way in which objects are laid out.
const LAYOUT: [u8; 4] = [0; 4];
/// Bytes of the hashes behind the headers of children.
const HASH_BYTES: usize = 32;
/// Most objects above one another.
const DEPTH_MOST: usize = 256;

/// An object.
pub(super) struct Object<'a> {
    pub(super) name: String,
    /// The object above, which stands before it.
    pub(super) parent: Option<usize>,
    pub(super) schema: Schema,
    pub(super) properties: Compound<'a>,
}

/// What an object is.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Schema {
    Transform,
    /// Polygons, or what a subdivision surface begins with.
    Mesh,
    Other,
}

/// Lists the objects of an archive, each behind the one above it and in the order of the file.
///
/// # Errors
/// [`AlembicError::NotAlembic`] of another layout, [`AlembicError::Damaged`] and [`AlembicError::TooLarge`].
pub(super) fn list<'a>(
    archive: &'a Archive<'a>,
) -> Result<(Vec<Object<'a>>, Metadata), AlembicError> {
    let root = archive.root()?;
    let layout = root.data(0)?;
    if layout != LAYOUT {
        let reason = format!("its objects are laid out by version {layout:?}");
        return Err(AlembicError::NotAlembic { reason });
    }
    let metadata = Metadata::read(root.data(5)?)?;
    let mut objects: Vec<Object<'a>> = Vec::new();
    // Children that are still to be listed, the next at the end, with the object above and how deep they are.
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

/// An object that is to be listed.
struct Child<'a> {
    name: String,
    schema: Schema,
    group: Group<'a>,
    parent: Option<usize>,
    depth: usize,
}

fn push_children<'a>(
    group: Group<'a>,
    parent: Option<usize>,
    depth: usize,
    metadata: &Metadata,
    left: &mut Vec<Child<'a>>,
) -> Result<(), AlembicError> {
    let bytes = group.last_data()?;
    let Some(len) = bytes.len().checked_sub(HASH_BYTES).filter(|len| *len > 0) else {
        return Ok(());
    };
    if depth >= DEPTH_MOST {
        return Err(damaged(format!("its objects are more than {DEPTH_MOST} levels deep")));
    }
    group.archive().spend(bytes.len())?;
    let mut cursor = Cursor(&bytes[..len]);
    let begin = left.len();
    while !cursor.is_empty() {
        group.archive().spend(size_of::<(Child<'_>, Object<'_>)>())?;
        let name = cursor.text(4)?;
        let number = cursor.number(1)?;
        let schema = Schema::of(&metadata.of(number, &mut cursor, 4)?);
        let group = group.group(1 + left.len() - begin)?;
        left.push(Child { name, schema, group, parent, depth });
    }
    left[begin..].reverse();
    Ok(())
}

impl Schema {
    /// Tells what an object's text says that it is, among entries as `schema=AbcGeom_PolyMesh_v1;`.
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
