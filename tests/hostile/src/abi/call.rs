//! One call: its arguments are drawn, then what it did is held to what the header promises.

use super::arena::{Arena, OBJECTS, Told};
use super::header::promises;
use arbitrary::{Result, Unstructured};
use sinew_capi::*;
use sinew_runtime::CallError;
use std::ops::Range;
use std::ptr::null_mut;

/// What an error holds before a call.
const UNTOUCHED: sinew_error = sinew_error {
    status: sinew_status::NoStage,
    argument: sinew_argument::Features,
    part: 0xa3,
    section: 0xa4,
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
    /// Places that a successful call reads, and those that it writes to, which may meet each other
    /// where they are shared.
    pub(super) read: Vec<Range<usize>>,
    pub(super) written: Vec<Range<usize>>,
    pub(super) shared: bool,
    /// A place of scratch, which a call that finds its result not finite has used.
    pub(super) used: Option<Range<usize>>,
    /// Where the next result belongs.
    pub(super) next_result: usize,
    /// What is wrong for sure, and what each fault must be called.
    pub(super) faults: Vec<(sinew_status, sinew_argument)>,
    /// Whether something may be wrong besides.
    pub(super) vague: bool,
    /// What a faultless call writes to its results' place, as far as that is known.
    expected: Vec<u8>,
    before: (Vec<u8>, Told),
}

impl<'a, 'b> Call<'a, 'b> {
    /// Begins with the place of the error.
    pub(super) fn new(u: &'a mut Unstructured<'b>, arena: &'a mut Arena) -> Result<Self> {
        let error_goes = match u.int_in_range(0..=15)? {
            0 => ErrorGoes::Astray,
            1..=4 => ErrorGoes::Nowhere,
            _ => ErrorGoes::Here,
        };
        let next_result = arena.results.start;
        Ok(Self {
            u,
            arena,
            errors: Box::new([UNTOUCHED; 2]),
            error_goes,
            read: Vec::new(),
            written: Vec::new(),
            shared: false,
            used: None,
            next_result,
            faults: Vec::new(),
            vague: false,
            expected: Vec::new(),
            before: Default::default(),
        })
    }

    /// Remembers what is wrong.
    pub(super) fn fault(&mut self, status: sinew_status, argument: sinew_argument) {
        self.faults.push((status, argument));
    }

    /// Remembers what is wrong, if it is.
    pub(super) fn fault_if(
        &mut self,
        is_wrong: bool,
        status: sinew_status,
        argument: sinew_argument,
    ) {
        if is_wrong {
            self.fault(status, argument);
        }
    }

    fn faultless(&self) -> bool {
        self.faults.is_empty() && !self.vague && self.error_goes != ErrorGoes::Astray
    }

    /// Remembers what the runtime makes of arguments that are where they should be: why it refuses them, or what it
    /// gives, which is returned; of others nothing.
    pub(super) fn by_runtime(
        &mut self,
        run: impl FnOnce(&Arena) -> std::result::Result<Vec<u8>, CallError>,
    ) -> Vec<u8> {
        if self.vague {
            return Vec::new();
        }
        run(self.arena).unwrap_or_else(|refusal| {
            let refusal = sinew_error::from(refusal);
            self.fault(refusal.status, refusal.argument);
            Vec::new()
        })
    }

    /// Ends the arguments: what the memory holds now is what the call must not touch. Returns where
    /// the error goes.
    ///
    /// `expected` is what a faultless call writes to its results' place.
    pub(super) fn ready(&mut self, expected: impl FnOnce(&Arena) -> Vec<u8>) -> *mut sinew_error {
        if self.faultless() {
            self.expected = expected(self.arena);
        }
        let told = self.arena.told([true; OBJECTS]);
        self.before = (self.arena.content().1.to_vec(), told);
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
        self.check_error(function, status);
        let used = self.used.take().filter(|_| status == sinew_status::NonFinite);
        let written = match used {
            _ if done => std::mem::take(&mut self.written),
            used => used.into_iter().collect(),
        };
        for (i, place) in written.iter().enumerate() {
            let others = if self.shared { &[] } else { &written[i + 1..] };
            let apart = !self.read.iter().chain(others).any(|other| meets(place, other));
            assert!(apart, "{function} accepts that {place:?} is to be written to");
        }
        let (start, content) = self.arena.content();
        let results = self.arena.results.start - start;
        let found = &content[results..results + self.expected.len()];
        assert!(found == self.expected, "{function} gives other bits than the runtime");
        // What may be written is put back unread, for an object or a structure has padding.
        let (right, told) = std::mem::take(&mut self.before);
        for place in &written {
            let (from, to) = (place.start.max(start), place.end.max(start));
            self.arena.write(from, &right[from - start..to - start]);
        }
        let (_, content) = self.arena.content();
        if right != content {
            let at = right.iter().zip(content).position(|(right, found)| right != found);
            panic!("{function}, {status:?}, has written to byte {at:?} behind the objects");
        }
        // An object that the call does not read may be written to: it is one no more, and is not asked.
        let spared = |place| !written.iter().any(|written| meets(written, place));
        let kept = self.arena.objects().map(spared);
        let found = self.arena.told(kept);
        assert!(
            kept != [true; OBJECTS] || found == told,
            "{function} changed an object: {found:?}"
        );
    }

    /// Holds the status, and what was told of it, to what is known of the arguments.
    fn check_error(&self, function: &str, status: sinew_status) {
        let done = status == sinew_status::Ok;
        let told = !done && self.error_goes == ErrorGoes::Here;
        let [error, other] = *self.errors;
        let misplaced = other != UNTOUCHED || (error != UNTOUCHED) != told;
        assert!(!misplaced, "{function} returned {status:?} and told {:?}", self.errors);
        assert!(!told || error.status == status, "{function}: {error:?}");
        if self.error_goes == ErrorGoes::Astray {
            assert_eq!(status, sinew_status::Misaligned, "{function} writes an error astray");
            return;
        }
        let faults = &self.faults;
        assert!(!done || faults.is_empty(), "{function} accepts {faults:?}");
        assert!(done || !self.faultless(), "{function} refused a faultless call: {status:?}");
        let is_one = faults
            .iter()
            .any(|(fault, argument)| *fault == status && (!told || *argument == error.argument));
        assert!(
            done || self.vague || is_one,
            "{function} returned {status:?}, {error:?}, for {faults:?}"
        );
    }
}

/// Whether two places have a byte in common.
fn meets(a: &Range<usize>, b: &Range<usize>) -> bool {
    a.start.max(b.start) < a.end.min(b.end)
}
