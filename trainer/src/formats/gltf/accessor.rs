//! Arrays of a glTF file as numbers, whatever their component type.

use gltf::accessor::DataType;
use gltf::accessor::sparse::IndexType;

use super::file::Buffers;
use crate::formats::scene::SceneError;

/// Reads an accessor whose elements have `width` components: all components of all elements, in
/// order, integers scaled to [0, 1] or [-1, 1] where they are normalised.
///
/// # Errors
/// [`SceneError::Accessor`] if the elements have another width or lie outside of their buffer.
pub(super) fn numbers(
    accessor: &gltf::Accessor<'_>,
    buffers: &Buffers,
    width: usize,
) -> Result<Vec<f64>, SceneError> {
    let damaged = |reason| SceneError::Accessor { accessor: accessor.index(), reason };
    let found = accessor.dimensions().multiplicity();
    if found != width {
        return Err(damaged(format!("has {found} components an element, expected {width}")));
    }
    let outside = || damaged("reaches beyond its buffer".to_owned());
    let component = Component { kind: accessor.data_type(), normalized: accessor.normalized() };
    let read = |view: gltf::buffer::View<'_>, offset, count| {
        let elements = Elements { offset, count, bytes: width * component.bytes() };
        let elements = elements.of(&view, buffers)?;
        let numbers = elements.flat_map(|element| element.chunks_exact(component.bytes()));
        Some(numbers.map(|bytes| component.number(bytes)).collect::<Vec<f64>>())
    };
    let count = accessor.count();
    let mut all = match accessor.view() {
        Some(view) => read(view, accessor.offset(), count).ok_or_else(outside)?,
        // Nothing in the file bounds how many zeros it may stand for, so the sparse part must.
        None if accessor.sparse().is_none() || count > ZEROS_MAX => {
            return Err(damaged("has no buffer view".to_owned()));
        }
        None => vec![0.0; width * count],
    };
    let Some(sparse) = accessor.sparse() else { return Ok(all) };
    let values = read(sparse.values().view(), sparse.values().offset(), sparse.count())
        .ok_or_else(outside)?;
    let indices = sparse.indices();
    let kind = indices.index_type();
    let elements =
        Elements { offset: indices.offset(), count: sparse.count(), bytes: index_bytes(&kind) };
    let places = elements.of(&indices.view(), buffers).ok_or_else(outside)?;
    for (place, values) in places.zip(values.chunks_exact(width)) {
        let place = index(&kind, place);
        let element = all.chunks_exact_mut(width).nth(place).ok_or_else(outside)?;
        element.copy_from_slice(values);
    }
    Ok(all)
}

/// Most elements that a sparse accessor may leave at zero without data.
const ZEROS_MAX: usize = 10_000_000;

/// Elements in a buffer view.
struct Elements {
    offset: usize,
    count: usize,
    bytes: usize,
}

impl Elements {
    /// Gives the bytes of each element; none where they reach beyond the view or its buffer.
    fn of<'a>(
        &self,
        view: &gltf::buffer::View<'_>,
        buffers: &'a Buffers,
    ) -> Option<impl Iterator<Item = &'a [u8]> + use<'a>> {
        let bytes = self.bytes;
        let stride = view.stride().unwrap_or(bytes);
        if stride < bytes {
            return None;
        }
        let begin = view.offset();
        let view =
            buffers.get(view.buffer().index())?.get(begin..begin.checked_add(view.length())?)?;
        let span = match self.count.checked_sub(1) {
            Some(last) => last.checked_mul(stride)?.checked_add(bytes)?,
            None => 0,
        };
        let data = view.get(self.offset..self.offset.checked_add(span)?)?;
        Some(data.chunks(stride).map(move |element| &element[..bytes]))
    }
}

struct Component {
    kind: DataType,
    normalized: bool,
}

impl Component {
    fn bytes(&self) -> usize {
        self.kind.size()
    }

    fn number(&self, bytes: &[u8]) -> f64 {
        let (number, most) = match (self.kind, bytes) {
            (DataType::I8, &[a]) => (f64::from(a as i8), f64::from(i8::MAX)),
            (DataType::U8, &[a]) => (f64::from(a), f64::from(u8::MAX)),
            (DataType::I16, &[a, b]) => {
                (f64::from(i16::from_le_bytes([a, b])), f64::from(i16::MAX))
            }
            (DataType::U16, &[a, b]) => {
                (f64::from(u16::from_le_bytes([a, b])), f64::from(u16::MAX))
            }
            (DataType::U32, &[a, b, c, d]) => {
                (f64::from(u32::from_le_bytes([a, b, c, d])), f64::from(u32::MAX))
            }
            (_, &[a, b, c, d]) => return f64::from(f32::from_le_bytes([a, b, c, d])),
            _ => return f64::NAN,
        };
        if self.normalized { (number / most).max(-1.0) } else { number }
    }
}

fn index_bytes(kind: &IndexType) -> usize {
    match kind {
        IndexType::U8 => 1,
        IndexType::U16 => 2,
        IndexType::U32 => 4,
    }
}

fn index(kind: &IndexType, bytes: &[u8]) -> usize {
    bytes[..index_bytes(kind)].iter().rev().fold(0, |index, &byte| index << 8 | usize::from(byte))
}
