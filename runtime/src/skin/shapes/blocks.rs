//! Layout of shapes in a file: blocks of 64 vertices.
//!
//! A block has entries in ascending order of shapes. An entry has a delta for each vertex in its mask.

use super::super::counts::{BLOCK, RULES, place};
use super::super::view::Skin;
use crate::format::rule::Rule;
use crate::format::{Element, SectionKind};
use crate::linear::{Le, floats};
use crate::numeric::halves;
use core::ops::Range;

pub(super) const SHAPES: usize = Rule::place(&RULES, SectionKind::Shapes);
const STARTS: usize = Rule::place(&RULES, SectionKind::ShapeBlocks);
const ENTRIES: usize = Rule::place(&RULES, SectionKind::ShapeEntries);
const DELTAS: usize = Rule::place(&RULES, SectionKind::ShapeDeltas);
const SLOPES: usize = Rule::place(&RULES, SectionKind::ShapeSlopes);

/// Products in a batch before they are added to scattered vertices.
const ROOM: usize = 16;

/// Arrays of a skin's shapes.
#[derive(Clone, Copy)]
pub(super) struct Blocks<'a> {
    /// Row of each shape: step of the deltas, step of the slopes, least delta 3, greatest delta 3.
    pub(super) rows: &'a [[Le; 8]],
    pub(super) starts: &'a [Le],
    pub(super) entries: &'a [[Le; 4]],
    /// 3 numbers for each delta.
    pub(super) deltas: Numbers<'a>,
    /// 2 numbers for each delta.
    pub(super) slopes: Numbers<'a>,
}

/// Vertices of a block that a shape moves.
#[derive(Clone, Copy)]
pub(super) struct Entry {
    /// One bit for each vertex of the block.
    pub(super) mask: u64,
    pub(super) shape: usize,
    /// Index of the first delta, which belongs to the lowest bit.
    pub(super) start: usize,
}

/// Numbers of one element type. The reader multiplies them by a step.
#[derive(Clone, Copy)]
pub(super) struct Numbers<'a> {
    pub(super) element: Element,
    pub(super) bytes: &'a [u8],
}

impl<'a> Blocks<'a> {
    pub(super) fn of(skin: &Skin<'a>) -> Self {
        let part = &skin.0;
        let number = part.layout.counts[place::ELEMENT];
        let element = Element::ALL.get(number as usize).copied().unwrap_or(Element::F32);
        Self {
            rows: part.array(SHAPES),
            starts: part.bytes(STARTS).as_chunks().0,
            entries: part.array(ENTRIES),
            deltas: Numbers { element, bytes: part.bytes(DELTAS) },
            slopes: Numbers { element, bytes: part.bytes(SLOPES) },
        }
    }

    /// Lists the entries of a block, by ascending shape.
    pub(super) fn entries_of(&self, block: usize) -> impl Iterator<Item = Entry> + use<'a> {
        let start = |at: usize| self.starts.get(at).map(|le| u32::from_le_bytes(*le) as usize);
        let own = start(block).zip(start(block + 1));
        let own = own.and_then(|(start, end)| self.entries.get(start..end));
        own.unwrap_or_default().iter().map(Entry::read)
    }

    /// Returns the entry of a shape in a block; `None` if the shape moves no vertex of the block.
    pub(super) fn entry(&self, block: usize, shape: usize) -> Option<Entry> {
        self.entries_of(block).find(|entry| entry.shape == shape)
    }

    /// Returns the delta of a vertex of the entry's block; `None` if the entry does not move the vertex.
    pub(super) fn delta(&self, entry: Entry, vertex: usize) -> Option<[f32; 3]> {
        let [step, ..] = floats(self.rows.get(entry.shape)?);
        Some(self.deltas.read(entry.delta_of(vertex)?)?.map(|x| step * x))
    }

    /// Returns the slopes at a vertex of the entry's block; `None` if the entry does not move the vertex.
    pub(super) fn slopes(&self, entry: Entry, vertex: usize) -> Option<[f32; 2]> {
        let [_, step, ..] = floats(self.rows.get(entry.shape)?);
        Some(self.slopes.read(entry.delta_of(vertex)?)?.map(|x| step * x))
    }
}

impl Entry {
    pub(super) fn read(words: &[Le; 4]) -> Self {
        let [low, high, shape, start] = words.map(u32::from_le_bytes);
        let mask = u64::from(low) | u64::from(high) << 32;
        Self { mask, shape: shape as usize, start: start as usize }
    }

    /// Returns the index of the delta of a vertex of the block; `None` if the entry does not move the vertex.
    fn delta_of(self, vertex: usize) -> Option<usize> {
        let bit = 1 << (vertex % BLOCK);
        let before = (self.mask & (bit - 1)).count_ones() as usize;
        (self.mask & bit != 0).then_some(self.start + before)
    }

    /// Whether the moved vertices form runs of eight or more on average.
    const fn is_in_runs(self) -> bool {
        let run_len = (self.mask & !(self.mask << 1)).count_ones();
        8 * run_len <= self.mask.count_ones()
    }

    /// Lists the moved vertices as runs: the range of the vertices in the block, and the index of the first delta.
    #[inline(always)]
    fn runs(self) -> impl Iterator<Item = (Range<usize>, usize)> {
        let (mut mask, mut at, mut delta) = (self.mask, 0, self.start);
        core::iter::from_fn(move || {
            if mask == 0 {
                return None;
            }
            let skipped = mask.trailing_zeros();
            mask >>= skipped;
            let len = mask.trailing_ones();
            mask = mask.checked_shr(len).unwrap_or_default();
            let start = at + skipped as usize;
            at = start + len as usize;
            let first = delta;
            delta += len as usize;
            Some((start..at, first))
        })
    }
}

impl Numbers<'_> {
    /// Reads an array of N numbers.
    pub(super) fn read<const N: usize>(&self, index: usize) -> Option<[f32; N]> {
        let mut out = [0.0; N];
        self.add(1.0, index, core::slice::from_mut(&mut out))?;
        Some(out)
    }

    /// Adds `weight` times the numbers of an entry to the sums of a block, N numbers for each moved vertex.
    ///
    /// `None` only if the bytes of the file have changed since loading.
    #[inline(always)]
    pub(super) fn add_entry<const N: usize>(
        &self,
        weight: f32,
        entry: Entry,
        sums: &mut [[f32; N]; BLOCK],
    ) -> Option<()> {
        if entry.is_in_runs() {
            for (run, first) in entry.runs() {
                self.add(weight, first, sums.get_mut(run)?)?;
            }
            return Some(());
        }
        let (mut mask, mut first) = (entry.mask, entry.start);
        while mask != 0 {
            // Computes a batch of products, then adds each product to its vertex.
            let mut room = [[0.0; N]; ROOM];
            let products = room.get_mut(..ROOM.min(mask.count_ones() as usize))?;
            self.add(weight, first, products)?;
            first += products.len();
            for product in products {
                let sum = sums.get_mut(mask.trailing_zeros() as usize)?;
                sum.iter_mut().zip(product).for_each(|(sum, product)| *sum += *product);
                mask &= mask.wrapping_sub(1);
            }
        }
        Some(())
    }

    /// Adds `weight` times arrays of N numbers to `sums`, from array `first` on.
    #[inline(always)]
    fn add<const N: usize>(&self, weight: f32, first: usize, sums: &mut [[f32; N]]) -> Option<()> {
        self.add_numbers(weight, first.checked_mul(N)?, sums.as_flattened_mut())
    }

    /// Adds `weight` times numbers to `sums`, from number `first` on.
    #[cfg_attr(not(target_os = "none"), inline(always))]
    #[cfg_attr(target_os = "none", inline(never))]
    fn add_numbers(&self, weight: f32, first: usize, sums: &mut [f32]) -> Option<()> {
        let each = self.element.bytes();
        let bytes = self.bytes.get(first.checked_mul(each)?..)?.get(..sums.len() * each)?;
        match self.element {
            Element::F16 => add_each(sums, weight, bytes.as_chunks().0, |le| {
                let [low, _] = halves(u32::from(u16::from_le_bytes(le)));
                low
            }),
            Element::I8 => {
                add_each(sums, weight, bytes.as_chunks().0, |le| f32::from(i8::from_le_bytes(le)));
            }
            _ => add_each(sums, weight, bytes.as_chunks().0, f32::from_le_bytes),
        }
        Some(())
    }
}

#[inline(always)]
fn add_each<const B: usize>(
    sums: &mut [f32],
    weight: f32,
    numbers: &[[u8; B]],
    read: impl Fn([u8; B]) -> f32,
) {
    for (sum, le) in sums.iter_mut().zip(numbers) {
        *sum += weight * read(*le);
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    fn runs(mask: u64) -> Vec<(Range<usize>, usize)> {
        Entry { mask, shape: 0, start: 5 }.runs().collect()
    }

    #[test]
    fn runs_list_the_set_bits_in_order() {
        assert_eq!(runs(0), []);
        assert_eq!(runs(u64::MAX), [(0..64, 5)]);
        assert_eq!(runs(1), [(0..1, 5)]);
        assert_eq!(runs(1 << 63), [(63..64, 5)]);
        assert_eq!(runs(0b0110_1110), [(1..4, 5), (5..7, 8)]);
        assert_eq!(runs(!1), [(1..64, 5)]);
    }

    #[test]
    fn the_index_of_a_delta_counts_the_lower_bits() {
        for mask in [1, u64::MAX, 0b0110_1110, 1 << 63, !1, 0x8421_0842_1084_2108] {
            let entry = Entry { mask, shape: 0, start: 5 };
            let mut next = 5;
            for vertex in 0..BLOCK {
                let is_moved = mask >> vertex & 1 == 1;
                assert_eq!(entry.delta_of(vertex), is_moved.then_some(next));
                next += usize::from(is_moved);
            }
        }
    }

    #[test]
    fn numbers_of_each_type_are_read() {
        let read = |element, bytes: &[u8]| Numbers { element, bytes }.read::<2>(1);
        assert_eq!(read(Element::I8, &[1, 2, 0x80, 127]), Some([-128.0, 127.0]));
        assert_eq!(
            read(Element::F16, &[9, 9, 9, 9, 0, 0xbc, 0x00, 0x04]),
            Some([-1.0, 1.0 / 16384.0])
        );
        let floats = [7.0, 7.0, -1.5, 3e-9f32].map(f32::to_le_bytes);
        assert_eq!(read(Element::F32, floats.as_flattened()), Some([-1.5, 3e-9]));
        assert_eq!(read(Element::I8, &[1, 2, 3]), None);
    }
}
