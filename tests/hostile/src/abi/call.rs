//! One call: its arguments are drawn, then what it did is held to what the header promises.

use super::arena::Arena;
use super::header::promises;
use arbitrary::{Result, Unstructured};
use sinew_capi::*;
use std::ops::Range;
use std::ptr::null_mut;

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
    pub(super) u: &'a mut Unstructured<'b>,
    pub(super) arena: &'a mut Arena,
    /// Two of them, so that an address between is the caller's memory.
    errors: Box<[sinew_error; 2]>,
    error_goes: ErrorGoes,
    /// Places that a successful call reads, and those that it writes to.
    pub(super) read: Vec<Range<usize>>,
    pub(super) written: Vec<Range<usize>>,
    /// Where the next result belongs.
    pub(super) next_result: usize,
    /// Whether every argument so far is as it should be.
    pub(super) faultless: bool,
    /// Whether an argument is one that must be refused.
    pub(super) must_fail: bool,
    /// What a faultless call writes to its results' place, as far as that is known.
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
            must_fail: false,
            expected: Vec::new(),
            before: Before::default(),
        })
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
        assert!(!done || !self.must_fail, "{function} accepts a wrong length, or a wrong model");
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
        assert!(done || !self.faultless, "{function} refused a faultless call: {status:?}");
        let results = self.arena.results.start - start;
        let found = &content[results..results + self.expected.len()];
        assert!(found == self.expected, "{function} gives other bits than the runtime");
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
