//! One call: its arguments are drawn, then what it did is held to what the header promises.

use super::arena::Arena;
use super::header::promises;
use crate::recipe;
use arbitrary::{Result, Unstructured};
use sinew_capi::*;
use std::ffi::c_void;
use std::ops::Range;
use std::ptr::{null, null_mut};

/// Numbers at which something ends.
const NUMBERS: [usize; 8] =
    [0, 1, 2, 0xffff, u32::MAX as usize, isize::MAX as usize, usize::MAX - 1, usize::MAX];

/// What an error holds before a call.
const UNTOUCHED: sinew_error = sinew_error {
    status: sinew_status::NoStage,
    subject: sinew_subject::SectionKeys,
    index: 0xa5,
    expected: 0xa6,
    found: 0xa7,
};

/// Where the error goes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum ErrorGoes {
    Nowhere,
    Here,
    /// To an odd address.
    Astray,
}

/// A call in the making.
pub(super) struct Call<'a, 'b> {
    u: &'a mut Unstructured<'b>,
    pub(super) arena: &'a mut Arena,
    /// Two of them, so that an address between is the caller's memory.
    errors: Box<[sinew_error; 2]>,
    error_goes: ErrorGoes,
    /// Places that a successful call reads, and those that it writes to.
    read: Vec<Range<usize>>,
    written: Vec<Range<usize>>,
    /// Where the next result belongs.
    next_result: usize,
    /// Whether every argument so far is as it should be.
    faultless: bool,
    /// Whether the length of an array is one that must be refused.
    wrong_length: bool,
    /// What a faultless call writes to its results' place.
    expected: Vec<u8>,
    before: Before,
}

/// What the arena held and its objects told.
#[derive(Default)]
struct Before {
    content: Vec<u8>,
    blob: Option<(*const u8, usize)>,
    info: Option<sinew_envelope_info>,
}

impl<'a, 'b> Call<'a, 'b> {
    /// Begins with the place of the error.
    pub(super) fn new(u: &'a mut Unstructured<'b>, arena: &'a mut Arena) -> Result<Self> {
        let error_goes = match u.int_in_range(0..=15)? {
            0 => ErrorGoes::Astray,
            1..=4 => ErrorGoes::Nowhere,
            _ => ErrorGoes::Here,
        };
        let (next_result, faultless) = (arena.results.start, error_goes != ErrorGoes::Astray);
        let errors = Box::new([UNTOUCHED; 2]);
        Ok(Self {
            u,
            arena,
            errors,
            error_goes,
            read: Vec::new(),
            written: Vec::new(),
            next_result,
            faultless,
            wrong_length: false,
            expected: Vec::new(),
            before: Before::default(),
        })
    }

    /// Says that the call is one that must be refused.
    pub(super) fn fault(&mut self) {
        self.faultless = false;
    }

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
        self.handle(self.arena.model.clone(), self.arena.envelope.clone())
    }

    /// Draws the handle of an envelope.
    pub(super) fn envelope(&mut self) -> Result<*const sinew_envelope> {
        self.handle(self.arena.envelope.clone(), self.arena.model.clone())
    }

    /// Draws where a handle points: to its object, to one of another kind, to what was never loaded,
    /// beside it, or nowhere.
    fn handle<T>(&mut self, own: Range<usize>, other: Range<usize>) -> Result<*const T> {
        self.read.extend([own.clone(), self.arena.file.clone()]);
        let blank = self.arena.results.clone();
        let drawn = self.u.int_in_range(0..=31)?;
        self.faultless &= drawn > 3;
        let place = match drawn {
            0 => return Ok(null()),
            1 => other.start,
            2 if own.len() <= blank.len() => blank.start,
            3 => own.start + self.u.int_in_range(1..=7)?,
            _ => own.start,
        };
        Ok(self.arena.at::<T>(place).cast_const())
    }

    /// Draws an array that is read, of a length that must be the place's.
    pub(super) fn input<T>(&mut self, place: Range<usize>) -> Result<(*const T, usize)> {
        let right = place.len() / size_of::<T>();
        let (at, len) = self.input_any(place)?;
        self.wrong_length |= len != right;
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
        self.wrong_length |= found < len;
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
        self.wrong_length |= bytes < object_bytes;
        self.written.extend(self.arena.place(at, object_bytes.min(bytes)));
        Ok((at.cast(), bytes))
    }

    /// Takes the next room for results.
    fn result_place(&mut self, bytes: usize) -> Range<usize> {
        let start = self.next_result;
        self.next_result = (start + bytes).next_multiple_of(align_of::<u128>());
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

    /// Ends the arguments: what the memory holds now is what the call must not touch. Returns where
    /// the error goes.
    ///
    /// `expected` is what a faultless call writes to its results' place.
    pub(super) fn ready(&mut self, expected: impl FnOnce(&Arena) -> Vec<u8>) -> *mut sinew_error {
        if self.faultless {
            self.expected = expected(self.arena);
        }
        let (blob, info) = (self.arena.blob(), self.arena.info());
        self.before = Before { content: self.arena.content().1.to_vec(), blob, info };
        let error = self.errors.as_mut_ptr();
        match self.error_goes {
            ErrorGoes::Nowhere => null_mut(),
            ErrorGoes::Here => error,
            ErrorGoes::Astray => error.wrapping_byte_add(1),
        }
    }

    /// Holds what a function did to the promises.
    ///
    /// # Panics
    /// Where one is broken.
    pub(super) fn check(&mut self, function: &str, status: sinew_status) {
        let done = status == sinew_status::Ok;
        assert!(
            done || promises()[function].contains(&(status as i32)),
            "{function} returned {status:?}, of which its comment says nothing"
        );
        let told = !done && self.error_goes == ErrorGoes::Here;
        let misplaced = self.errors[1] != UNTOUCHED || (self.errors[0] != UNTOUCHED) != told;
        assert!(!misplaced, "{function} returned {status:?} and told {:?}", self.errors);
        assert!(!told || self.errors[0].status == status, "{function}: {:?}", self.errors[0]);
        assert!(!done || !self.wrong_length, "{function} accepts a wrong length");
        let written = if done { &*self.written } else { &[] };
        for (i, place) in written.iter().enumerate() {
            let apart = !self.read.iter().chain(&written[i + 1..]).any(|other| meets(place, other));
            assert!(apart, "{function} accepts that {place:?} is to be written to");
        }
        let (start, content) = self.arena.content();
        let mut right = std::mem::take(&mut self.before.content);
        for place in written {
            let behind_objects = place.start.max(start) - start..place.end.max(start) - start;
            right[behind_objects.clone()].copy_from_slice(&content[behind_objects]);
        }
        if right != content {
            let at = right.iter().zip(content).position(|(right, found)| right != found);
            panic!("{function}, {status:?}, has written to byte {at:?} behind the objects");
        }
        if self.faultless && !self.expected.is_empty() {
            let results = self.arena.results.start - start;
            let found = &content[results..results + self.expected.len()];
            assert!(done, "{function} refused a faultless call: {status:?}");
            assert!(found == self.expected, "{function} gives other bits than the runtime");
        }
        // An object that the call does not read may be written to, and is one no more.
        let lost = |object| written.iter().any(|place| meets(place, object));
        let [model, envelope] = [lost(&self.arena.model), lost(&self.arena.envelope)];
        assert!(model || self.arena.blob() == self.before.blob, "{function} changed the model");
        assert!(
            envelope || self.arena.info() == self.before.info,
            "{function} changed the envelope"
        );
    }
}

/// Whether two places have a byte in common.
fn meets(a: &Range<usize>, b: &Range<usize>) -> bool {
    a.start.max(b.start) < a.end.min(b.end)
}
