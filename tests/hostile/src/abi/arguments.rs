//! The arguments of a call: mostly as they should be, else with a fault that a library can see, or
//! anywhere in the arena.

use super::call::Call;
use crate::recipe;
use arbitrary::Result;
use sinew_capi::{sinew_envelope, sinew_model};
use std::ffi::c_void;
use std::ops::Range;
use std::ptr::{null, null_mut};

/// Numbers at which something ends.
const NUMBERS: [usize; 8] =
    [0, 1, 2, 0xffff, u32::MAX as usize, isize::MAX as usize, usize::MAX - 1, usize::MAX];

/// Bytes between results: more than any element has.
pub(super) const RESULTS_APART: usize = 64;

impl Call<'_, '_> {
    /// Draws a number that should be below another.
    pub(super) fn number(&mut self, below: usize) -> Result<usize> {
        let number = match self.u.int_in_range(0..=7)? {
            0 => *self.u.choose(&NUMBERS)?,
            1 => self.u.arbitrary()?,
            2 => below,
            _ => self.u.choose_index(below.max(1))?,
        };
        self.faultless &= number < below;
        Ok(number)
    }

    /// Draws the start and the end of a range of vertices, and how many it has if there are so many.
    pub(super) fn vertices(&mut self) -> Result<(usize, usize, usize)> {
        let vertex_len = self.arena.frame.vertex_len;
        if self.one_in(2)? {
            return Ok((0, vertex_len, vertex_len));
        }
        let (start, end) = (self.number(vertex_len + 1)?, self.number(vertex_len + 1)?);
        self.faultless &= start <= end;
        Ok((start, end, end.saturating_sub(start).min(vertex_len)))
    }

    /// Draws any number; whether it is one of those that are right is not known.
    pub(super) fn any(&mut self) -> Result<u32> {
        self.faultless = false;
        let small: bool = self.u.arbitrary()?;
        if small { self.u.int_in_range(0..=31) } else { self.u.arbitrary() }
    }

    /// Draws the handle of a model.
    pub(super) fn model(&mut self) -> Result<*const sinew_model> {
        self.faultless &= self.arena.blob().is_some();
        self.handle(self.arena.model.clone(), self.arena.envelope.clone())
    }

    /// Draws the handle of an envelope.
    pub(super) fn envelope(&mut self) -> Result<*const sinew_envelope> {
        self.faultless &= self.arena.info().is_some();
        self.handle(self.arena.envelope.clone(), self.arena.model.clone())
    }

    /// Draws where a handle points: to its object, to one of another kind, to what was never loaded,
    /// beside it, or nowhere.
    fn handle<T>(&mut self, own: Range<usize>, other: Range<usize>) -> Result<*const T> {
        self.read.extend([own.clone(), self.arena.file.clone()]);
        let drawn = self.u.int_in_range(0..=31)?;
        self.faultless &= drawn > 3;
        let place = match drawn {
            0 => return Ok(null()),
            1 => other.start,
            2 => self.arena.results.start,
            3 => own.start + self.u.int_in_range(1..=7)?,
            _ => own.start,
        };
        Ok(self.arena.at::<T>(place).cast_const())
    }

    /// Draws an array that is read, of a length that must be the place's.
    pub(super) fn input<T>(&mut self, place: Range<usize>) -> Result<(*const T, usize)> {
        let right = place.len() / size_of::<T>();
        let (at, len) = self.input_any(place)?;
        self.must_fail |= len != right;
        Ok((at, len))
    }

    /// Draws an array that is read, of any length.
    pub(super) fn input_any<T>(&mut self, place: Range<usize>) -> Result<(*const T, usize)> {
        let (at, len) = self.array::<T>(place)?;
        self.read.extend(self.arena.place(at, len));
        Ok((at.cast_const(), len))
    }

    /// Draws one value that is read.
    pub(super) fn input_one<T>(&mut self, place: usize) -> Result<*const T> {
        let at = self.one::<T>(place)?;
        self.read.extend(self.arena.place(at, 1));
        Ok(at.cast_const())
    }

    /// Draws one value that is read where it stands: no other bytes will do for it.
    pub(super) fn input_fixed<T>(&mut self, place: usize) -> Result<*const T> {
        self.read.push(place..place + size_of::<T>());
        let drawn = self.u.int_in_range(0..=31)?;
        self.faultless &= drawn > 1;
        Ok(match drawn {
            0 => null(),
            1 => self.arena.at(place + self.u.int_in_range(1..=7)?),
            _ => self.arena.at(place),
        })
    }

    /// Draws an array for `len` results, which must not be shorter.
    pub(super) fn output<T>(&mut self, len: usize) -> Result<(*mut T, usize)> {
        let (at, found) = self.output_any(len)?;
        self.must_fail |= found < len;
        Ok((at, found))
    }

    /// Draws an array for exactly `len` results.
    pub(super) fn output_exact<T>(&mut self, len: usize) -> Result<(*mut T, usize)> {
        let (at, found) = self.output_any(len)?;
        self.must_fail |= found != len;
        Ok((at, found))
    }

    /// Draws an array for about as many results.
    pub(super) fn output_any<T>(&mut self, len: usize) -> Result<(*mut T, usize)> {
        let place = self.result_place(len * size_of::<T>());
        let (at, len) = self.array::<T>(place)?;
        self.written.extend(self.arena.place(at, len));
        Ok((at, len))
    }

    /// Draws where one result goes.
    pub(super) fn output_one<T>(&mut self) -> Result<*mut T> {
        let place = self.result_place(size_of::<T>());
        let at = self.one::<T>(place.start)?;
        self.written.extend(self.arena.place(at, 1));
        Ok(at)
    }

    /// Draws memory for an object.
    pub(super) fn memory(&mut self, object_bytes: usize) -> Result<(*mut c_void, usize)> {
        let place = self.result_place(object_bytes);
        let (at, bytes) = self.array::<u8>(place)?;
        self.must_fail |= bytes < object_bytes;
        self.written.extend(self.arena.place(at, object_bytes.min(bytes)));
        Ok((at.cast(), bytes))
    }

    /// Takes the next room for results, some way behind the last: one result too many is no overlap.
    fn result_place(&mut self, bytes: usize) -> Range<usize> {
        let start = self.next_result;
        self.next_result = (start + bytes).next_multiple_of(align_of::<u128>()) + RESULTS_APART;
        assert!(start + bytes <= self.arena.results.end);
        start..start + bytes
    }

    /// Draws a pointer and a length: as they should be, or with a fault that a library can see, or
    /// anywhere else in the arena.
    fn array<T>(&mut self, place: Range<usize>) -> Result<(*mut T, usize)> {
        let (size, end) = (size_of::<T>(), self.arena.len());
        let len = place.len() / size;
        let drawn = self.u.int_in_range(0..=31)?;
        self.faultless &= drawn > 6;
        let (start, len) = match drawn {
            0 => return Ok((null_mut(), len)),
            1 => {
                let start = self.u.int_in_range(0..=end)?;
                (start, self.u.int_in_range(0..=(end - start) / size)?)
            }
            2 => (self.u.int_in_range(0..=end - place.len())?, len),
            3 => (self.beside(place.len())?, len),
            4 => (place.start, self.u.int_in_range(0..=len)?),
            5 => (place.start, (isize::MAX as usize / size + 1).max(self.u.arbitrary()?)),
            6 => (place.start, (len + 1).min((end - place.start) / size)),
            _ => (place.start, len),
        };
        Ok((self.arena.at(start), len))
    }

    /// Draws a pointer to one value.
    fn one<T>(&mut self, place: usize) -> Result<*mut T> {
        let drawn = self.u.int_in_range(0..=31)?;
        self.faultless &= drawn > 3;
        let most = self.arena.len() - size_of::<T>();
        let place = match drawn {
            0 => return Ok(null_mut()),
            1 => self.u.int_in_range(0..=most)?,
            2 => self.beside(size_of::<T>())?,
            3 => (place + self.u.int_in_range(1..=7)?).min(most),
            _ => place,
        };
        Ok(self.arena.at(place))
    }

    /// Draws where some bytes touch an argument drawn before, or overlap it by a few bytes.
    fn beside(&mut self, bytes: usize) -> Result<usize> {
        let others = self.read.iter().chain(&self.written).cloned().collect::<Vec<_>>();
        let other = others.get(self.u.choose_index(others.len().max(1))?).cloned();
        let other = other.unwrap_or_else(|| self.arena.file.clone());
        let overlap = 4 * self.u.int_in_range(0..=2)?;
        let before: bool = self.u.arbitrary()?;
        let start = if before {
            (other.start + overlap).checked_sub(bytes)
        } else {
            other.end.checked_sub(overlap)
        };
        Ok(start.unwrap_or_default().min(self.arena.len() - bytes))
    }

    /// Puts something else into one of a place's floats, or not.
    pub(super) fn spoil(&mut self, place: Range<usize>) -> Result<()> {
        if self.one_in(4)? && !place.is_empty() {
            let at = place.start + 4 * self.u.choose_index(place.len() / 4)?;
            self.arena.write(at, &recipe::float(self.u)?.to_ne_bytes());
            self.faultless = false;
        }
        Ok(())
    }

    /// Whether something that happens in one of so many calls does.
    pub(super) fn one_in(&mut self, calls: u8) -> Result<bool> {
        Ok(self.u.int_in_range(1..=calls)? == 1)
    }
}
