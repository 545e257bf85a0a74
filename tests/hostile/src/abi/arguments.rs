//! Draws the arguments of a call. Most arguments are correct. Others have a fault that a library
//! can detect, or lie anywhere in the arena.

use super::arena::{Since, result_after};
use super::call::Call;
use crate::recipe;
use arbitrary::Result;
use sinew_capi::*;
use std::ffi::c_void;
use std::ops::Range;
use std::ptr::{null, null_mut};

use sinew_argument as Argument;
use sinew_status as Status;

/// Boundary values of counts.
const NUMBERS: [usize; 8] =
    [0, 1, 2, 0xffff, u32::MAX as usize, isize::MAX as usize, usize::MAX - 1, usize::MAX];

/// Constraint on the length of an array.
#[derive(Clone, Copy)]
enum Must {
    Be(usize),
    HoldAtLeast(usize),
    BeAny,
}

impl Call<'_, '_> {
    /// Draws a number that should be less than `below`.
    pub(super) fn number(&mut self, below: usize, argument: Argument) -> Result<usize> {
        let number = match self.u.int_in_range(0..=7)? {
            0 => *self.u.choose(&NUMBERS)?,
            1 => self.u.arbitrary()?,
            2 => below,
            _ => self.u.choose_index(below.max(1))?,
        };
        self.fault_if(number >= below, Status::OutOfRange, argument);
        Ok(number)
    }

    /// Draws the start and the end of a range of vertices. Also returns the length of the range,
    /// at most `vertex_len`.
    pub(super) fn vertices(&mut self, vertex_len: usize) -> Result<(usize, usize, usize)> {
        if self.one_in(2)? {
            return Ok((0, vertex_len, vertex_len));
        }
        let mut end = || self.number(vertex_len.saturating_add(1), Argument::Vertices);
        let (start, end) = (end()?, end()?);
        self.fault_if(start > end, Status::OutOfRange, Argument::Vertices);
        Ok((start, end, end.saturating_sub(start).min(vertex_len)))
    }

    /// Draws any number; the call may or may not accept the number.
    pub(super) fn any(&mut self) -> Result<u32> {
        self.maybe_faulty = true;
        let small: bool = self.u.arbitrary()?;
        if small { self.u.int_in_range(0..=31) } else { self.u.arbitrary() }
    }

    /// Draws the handle of a model.
    pub(super) fn model(&mut self) -> Result<*const sinew_model> {
        let is_loaded = self.arena.frame.refusal.is_none() && self.arena.since != Since::Emptied;
        let fault = (!is_loaded).then_some((Status::NotLoaded, Argument::Model));
        let places = [self.arena.model.clone(), self.arena.envelope.clone()];
        self.handle(places, fault, Argument::Model)
    }

    /// Draws the handle of an envelope.
    pub(super) fn envelope(&mut self) -> Result<*const sinew_envelope> {
        let fault = self.part_fault(self.arena.frame.has_envelope, Argument::Envelope);
        let places = [self.arena.envelope.clone(), self.arena.skin.clone()];
        self.handle(places, fault, Argument::Envelope)
    }

    /// Draws the handle of a kernel.
    pub(super) fn kernel(&mut self) -> Result<*const sinew_kernel> {
        let fault = self.part_fault(self.arena.frame.has_kernel, Argument::Kernel);
        let places = [self.arena.kernel.clone(), self.arena.envelope.clone()];
        self.handle(places, fault, Argument::Kernel)
    }

    /// Draws the handle of a prior.
    pub(super) fn prior(&mut self) -> Result<*const sinew_prior> {
        let fault = self.part_fault(self.arena.frame.prior.is_some(), Argument::Prior);
        let places = [self.arena.prior.clone(), self.arena.kernel.clone()];
        self.handle(places, fault, Argument::Prior)
    }

    /// Draws the handle of views.
    pub(super) fn views(&mut self) -> Result<*const sinew_views> {
        let fault = self.part_fault(self.arena.frame.views.is_some(), Argument::Views);
        let places = [self.arena.views.clone(), self.arena.prior.clone()];
        self.handle(places, fault, Argument::Views)
    }

    /// Draws the handle of a filter.
    pub(super) fn filter(&mut self) -> Result<*const sinew_filter> {
        let fault = self.part_fault(self.arena.frame.filter.is_some(), Argument::Filter);
        let places = [self.arena.filter.clone(), self.arena.views.clone()];
        self.handle(places, fault, Argument::Filter)
    }

    /// Draws the handle of a skin.
    pub(super) fn skin(&mut self) -> Result<*const sinew_skin> {
        let fault = self.part_fault(self.arena.frame.has_skin, Argument::Skin);
        let places = [self.arena.skin.clone(), self.arena.model.clone()];
        self.handle(places, fault, Argument::Skin)
    }

    /// Returns the fault of a part's handle, if there is one.
    fn part_fault(&mut self, is_there: bool, own: Argument) -> Option<(Status, Argument)> {
        match self.arena.since {
            _ if !is_there => Some((Status::NotLoaded, own)),
            Since::Nothing => None,
            Since::Reloaded => Some((Status::Stale, own)),
            Since::Emptied => Some((Status::NotLoaded, Argument::Model)),
        }
    }

    /// Draws a handle: to its object, to an object of another kind, to memory that was never
    /// loaded, next to the object, or null.
    fn handle<T>(
        &mut self,
        [own, other]: [Range<usize>; 2],
        fault: Option<(Status, Argument)>,
        argument: Argument,
    ) -> Result<*const T> {
        self.read.extend([own.clone(), self.arena.model.clone(), self.arena.held()]);
        let (place, fault) = match self.u.int_in_range(0..=31)? {
            0 => (None, Some((Status::Null, argument))),
            1 => (Some(other.start), Some((Status::NotLoaded, argument))),
            2 => (Some(self.arena.results.start), Some((Status::NotLoaded, argument))),
            3 => {
                let beside = own.start + self.u.int_in_range(1..=7)?;
                (Some(beside), Some((Status::Misaligned, argument)))
            }
            _ => (Some(own.start), fault),
        };
        self.faults.extend(fault);
        Ok(place.map_or(null(), |place| self.arena.at::<T>(place).cast_const()))
    }

    /// Draws an input array whose length must be correct.
    pub(super) fn input<T>(
        &mut self,
        place: Range<usize>,
        right: usize,
        argument: Argument,
    ) -> Result<(*const T, usize)> {
        let (at, len) = self.array::<T>(place, Must::Be(right), argument)?;
        self.read.extend(self.arena.place(at, len));
        Ok((at.cast_const(), len))
    }

    /// Draws an input array of any length.
    pub(super) fn input_any<T>(
        &mut self,
        place: Range<usize>,
        argument: Argument,
    ) -> Result<(*const T, usize)> {
        let (at, len) = self.array::<T>(place, Must::BeAny, argument)?;
        self.read.extend(self.arena.place(at, len));
        Ok((at.cast_const(), len))
    }

    /// Draws a pointer to one input value.
    pub(super) fn input_one<T>(&mut self, place: usize, argument: Argument) -> Result<*const T> {
        let at = self.one::<T>(place, argument)?;
        self.read.extend(self.arena.place(at, 1));
        Ok(at.cast_const())
    }

    /// Draws a pointer to one input value at its place: other bytes would not be a valid value.
    pub(super) fn input_fixed<T>(&mut self, place: usize, argument: Argument) -> Result<*const T> {
        self.read.push(place..place + size_of::<T>());
        Ok(match self.u.int_in_range(0..=31)? {
            0 => {
                self.fault(Status::Null, argument);
                null()
            }
            1 => {
                self.fault(Status::Misaligned, argument);
                self.arena.at(place + self.u.int_in_range(1..=align_of::<T>().max(2) - 1)?)
            }
            _ => self.arena.at(place),
        })
    }

    /// Draws an array for `len` results, which must not be shorter.
    pub(super) fn output<T>(&mut self, len: usize, argument: Argument) -> Result<(*mut T, usize)> {
        self.output_least(len, len, argument)
    }

    /// Draws an array for at least `least` results, with room for `len`.
    pub(super) fn output_least<T>(
        &mut self,
        len: usize,
        least: usize,
        argument: Argument,
    ) -> Result<(*mut T, usize)> {
        self.output_of(len, Must::HoldAtLeast(least), argument)
    }

    /// Draws an array for exactly `right` results, with room for `len`.
    pub(super) fn output_exact<T>(
        &mut self,
        len: usize,
        right: usize,
        argument: Argument,
    ) -> Result<(*mut T, usize)> {
        self.output_of(len, Must::Be(right), argument)
    }

    /// Draws an array for about `len` results.
    pub(super) fn output_any<T>(
        &mut self,
        len: usize,
        argument: Argument,
    ) -> Result<(*mut T, usize)> {
        self.output_of(len, Must::BeAny, argument)
    }

    fn output_of<T>(
        &mut self,
        len: usize,
        must: Must,
        argument: Argument,
    ) -> Result<(*mut T, usize)> {
        let place = self.result_place(len * size_of::<T>());
        let over =
            if self.one_in(16)? { self.over_inputs(place.len(), align_of::<T>())? } else { None };
        let (at, len) = match over {
            Some(place) => {
                self.fault(Status::Overlap, argument);
                self.check_len(len, must, argument);
                (self.arena.at(place), len)
            }
            None => self.array::<T>(place, must, argument)?,
        };
        self.written.extend(self.arena.place(at, len));
        Ok((at, len))
    }

    /// Draws the pointer to one result.
    pub(super) fn output_one<T>(&mut self, argument: Argument) -> Result<*mut T> {
        let place = self.result_place(size_of::<T>());
        let over =
            if self.one_in(16)? { self.over_inputs(place.len(), align_of::<T>())? } else { None };
        let at = match over {
            Some(place) => {
                self.fault(Status::Overlap, argument);
                self.arena.at(place)
            }
            None => self.one::<T>(place.start, argument)?,
        };
        self.written.extend(self.arena.place(at, 1));
        Ok(at)
    }

    /// Draws memory for an object.
    pub(super) fn memory(&mut self, object_bytes: usize) -> Result<(*mut c_void, usize)> {
        let argument = Argument::Memory;
        let place = self.result_place(object_bytes);
        let (at, bytes) = match self.u.int_in_range(0..=31)? {
            0 => {
                self.fault(Status::Null, argument);
                return Ok((null_mut(), object_bytes));
            }
            1 => {
                self.maybe_faulty = true;
                (self.u.int_in_range(0..=self.arena.len() - object_bytes)?, object_bytes)
            }
            2 => (self.beside(object_bytes)?, object_bytes),
            3 => {
                self.fault(Status::Misaligned, argument);
                (place.start + self.u.int_in_range(1..=7)?, object_bytes)
            }
            4 => (place.start, self.u.int_in_range(0..=object_bytes)?),
            5 => (place.start, usize::MAX),
            6 => match self.over_inputs(object_bytes, align_of::<usize>())? {
                Some(place) => {
                    self.fault(Status::Overlap, argument);
                    (place, object_bytes)
                }
                None => (place.start, object_bytes),
            },
            _ => (place.start, object_bytes),
        };
        self.fault_if(bytes < object_bytes, Status::TooShort, argument);
        self.written.push(at..at + object_bytes.min(bytes));
        Ok((self.arena.at(at), bytes))
    }

    /// Draws an array of the caller's rest mesh. One length counts for three arrays, and every
    /// float is read.
    pub(super) fn rest_array(
        &mut self,
        place: usize,
        len: usize,
        argument: Argument,
    ) -> Result<*const f32> {
        let at = match self.u.int_in_range(0..=31)? {
            0 => return Ok(null()),
            1 if len > 0 => {
                self.fault(Status::Misaligned, argument);
                self.arena.at(place + self.u.int_in_range(1..=3)?)
            }
            2 => {
                let place = self.beside(4 * len)?;
                self.arena.at(place)
            }
            _ => self.arena.at::<f32>(place),
        };
        self.read.extend(self.arena.place(at, len));
        Ok(at.cast_const())
    }

    /// Draws an output of a job within its room: at its place with a length that may be below
    /// `least`, or at another place. A wrong stride is reported first.
    pub(super) fn output_at(
        &mut self,
        place: Range<usize>,
        len: usize,
        least: usize,
        is_wrong: bool,
        argument: Argument,
    ) -> Result<(*mut f32, usize)> {
        // An output may start in an input and end after it.
        let end = self.arena.len();
        let over = if self.one_in(16)? { self.over(place.len(), 4, end)? } else { None };
        let (at, len) = match over {
            Some(place) => {
                self.fault(Status::Overlap, argument);
                (self.arena.at(place), len)
            }
            None => self.array::<f32>(place, Must::BeAny, argument)?,
        };
        self.fault_if(
            len < least && !is_wrong && !(at.is_null() && len == 0),
            Status::TooShort,
            argument,
        );
        self.written.extend(self.arena.place(at, len));
        Ok((at, len))
    }

    /// Reserves room for results, with a gap after the last results: one result too many does not
    /// overlap them.
    pub(super) fn result_place(&mut self, bytes: usize) -> Range<usize> {
        let start = self.next_result;
        self.next_result = result_after(start + bytes);
        assert!(start + bytes <= self.arena.results.end);
        start..start + bytes
    }

    /// Draws a pointer and a length: correct, with a fault that a library can detect, or anywhere
    /// else in the arena.
    fn array<T>(
        &mut self,
        place: Range<usize>,
        must: Must,
        argument: Argument,
    ) -> Result<(*mut T, usize)> {
        let (size, end) = (size_of::<T>(), self.arena.len());
        let len = place.len() / size;
        let drawn = self.u.int_in_range(0..=31)?;
        self.maybe_faulty |= matches!(drawn, 1..=3);
        let (start, len) = match drawn {
            0 => {
                self.fault_if(len > 0, Status::Null, argument);
                self.check_len(len, must, argument);
                return Ok((null_mut(), len));
            }
            1 => {
                let start = self.u.int_in_range(0..=end)?;
                (start, self.u.int_in_range(0..=(end - start) / size)?)
            }
            2 => (self.u.int_in_range(0..=end - place.len())?, len),
            3 => (self.beside(place.len())?, len),
            4 => (place.start, self.u.int_in_range(0..=len)?),
            5 => {
                // A length that no array can have is reported before a length that is wrong for
                // this array.
                self.fault(Status::TooLong, argument);
                return Ok((
                    self.arena.at(place.start),
                    (isize::MAX as usize / size + 1).max(self.u.arbitrary()?),
                ));
            }
            6 => {
                self.maybe_faulty = true;
                (place.start, (len + 1).min((end - place.start) / size))
            }
            7 if align_of::<T>() > 1 && len > 0 => {
                self.fault(Status::Misaligned, argument);
                (place.start + self.u.int_in_range(1..=align_of::<T>() - 1)?, len)
            }
            _ => (place.start, len),
        };
        self.check_len(len, must, argument);
        // If any length is allowed, a shorter array is a different valid array.
        self.maybe_faulty |= drawn == 4 && matches!(must, Must::BeAny);
        Ok((self.arena.at(start), len))
    }

    fn check_len(&mut self, len: usize, must: Must, argument: Argument) {
        match must {
            Must::Be(right) => self.fault_if(len != right, Status::Length, argument),
            Must::HoldAtLeast(least) => {
                self.fault_if(len < least, Status::TooShort, argument);
            }
            Must::BeAny => {}
        }
    }

    /// Draws a pointer to one value.
    fn one<T>(&mut self, place: usize, argument: Argument) -> Result<*mut T> {
        let most = self.arena.len() - size_of::<T>();
        let place = match self.u.int_in_range(0..=31)? {
            0 => {
                self.fault(Status::Null, argument);
                return Ok(null_mut());
            }
            1 => {
                self.maybe_faulty = true;
                self.u.int_in_range(0..=most)?
            }
            2 => self.beside(size_of::<T>())?,
            3 if align_of::<T>() > 1 => {
                self.fault(Status::Misaligned, argument);
                place + self.u.int_in_range(1..=align_of::<T>() - 1)?
            }
            _ => place,
        };
        Ok(self.arena.at(place))
    }

    /// Draws a place that touches an argument drawn before, or overlaps it by a few bytes.
    fn beside(&mut self, bytes: usize) -> Result<usize> {
        self.maybe_faulty = true;
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

    /// Draws a place that overlaps an input and no output.
    fn over_inputs(&mut self, bytes: usize, align: usize) -> Result<Option<usize>> {
        self.over(bytes, align, self.arena.results.start)
    }

    /// Draws a place that overlaps an input and ends before `end`.
    fn over(&mut self, bytes: usize, align: usize, end: usize) -> Result<Option<usize>> {
        let read = self.read.get(self.u.choose_index(self.read.len().max(1))?).cloned();
        Ok(read
            .filter(|read| !read.is_empty() && bytes > 0 && read.start + bytes <= end)
            .filter(|read| read.start.is_multiple_of(align))
            .map(|read| read.start))
    }

    /// Overwrites one float of a place in some calls.
    pub(super) fn spoil(&mut self, place: Range<usize>) -> Result<()> {
        if self.one_in(4)? && !place.is_empty() {
            let at = place.start + 4 * self.u.choose_index(place.len() / 4)?;
            self.arena.write(at, &recipe::float(self.u)?.to_ne_bytes());
            self.maybe_faulty = true;
        }
        Ok(())
    }

    /// Returns true in one of `calls` calls on average.
    pub(super) fn one_in(&mut self, calls: u8) -> Result<bool> {
        Ok(self.u.int_in_range(1..=calls)? == 1)
    }
}
