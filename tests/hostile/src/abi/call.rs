//! One call: draws arguments, then compares the call's effects with the promises of the header.

use super::arena::{Arena, Descriptions, OBJECTS};
use arbitrary::{Result, Unstructured};
use sinew_capi::*;
use sinew_runtime::CallError;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::ptr::null_mut;
use std::sync::LazyLock;

/// Content of an error before a call.
const UNTOUCHED: sinew_error = sinew_error {
    status: sinew_status::NoStage,
    argument: sinew_argument::Features,
    part: 0xa3,
    section: 0xa4,
    index: 0xa5,
    expected: 0xa6,
    found: 0xa7,
};

/// Pointer to the error that a call is given.
#[derive(Clone, Copy, Debug, PartialEq)]
enum ErrorPointer {
    Null,
    Valid,
    /// An odd address.
    Misaligned,
}

/// A call whose arguments are being drawn.
pub(super) struct Call<'a, 'b> {
    pub(super) u: &'a mut Unstructured<'b>,
    pub(super) arena: &'a mut Arena,
    /// Two errors, so that an address between them is the caller's memory.
    errors: Box<[sinew_error; 2]>,
    error_pointer: ErrorPointer,
    /// Places that a successful call reads, and places that it writes. Places may overlap each
    /// other if `shared`.
    pub(super) read: Vec<Range<usize>>,
    pub(super) written: Vec<Range<usize>>,
    pub(super) shared: bool,
    /// Place of scratch that a call may write even if its result is not finite.
    pub(super) used: Option<Range<usize>>,
    /// Place of the next result.
    pub(super) next_result: usize,
    /// Known faults: the status and the argument that each fault must report.
    pub(super) faults: Vec<(sinew_status, sinew_argument)>,
    /// Whether the call may have a fault that is not in `faults`.
    pub(super) maybe_faulty: bool,
    /// Bytes that a faultless call writes to the place of its results, if they are known.
    expected: Vec<u8>,
    before: (Vec<u8>, Descriptions),
}

impl<'a, 'b> Call<'a, 'b> {
    /// Starts a call by drawing the pointer to the error.
    pub(super) fn new(u: &'a mut Unstructured<'b>, arena: &'a mut Arena) -> Result<Self> {
        let error_pointer = match u.int_in_range(0..=15)? {
            0 => ErrorPointer::Misaligned,
            1..=4 => ErrorPointer::Null,
            _ => ErrorPointer::Valid,
        };
        let next_result = arena.results.start;
        Ok(Self {
            u,
            arena,
            errors: Box::new([UNTOUCHED; 2]),
            error_pointer,
            read: Vec::new(),
            written: Vec::new(),
            shared: false,
            used: None,
            next_result,
            faults: Vec::new(),
            maybe_faulty: false,
            expected: Vec::new(),
            before: Default::default(),
        })
    }

    /// Records a fault.
    pub(super) fn fault(&mut self, status: sinew_status, argument: sinew_argument) {
        self.faults.push((status, argument));
    }

    /// Records a fault if `is_wrong`.
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
        self.faults.is_empty()
            && !self.maybe_faulty
            && self.error_pointer != ErrorPointer::Misaligned
    }

    /// Runs the runtime on the drawn arguments. Returns the result, or records the refusal as a
    /// fault. Does nothing if the arguments may have an unknown fault.
    pub(super) fn by_runtime(
        &mut self,
        run: impl FnOnce(&Arena) -> std::result::Result<Vec<u8>, CallError>,
    ) -> Vec<u8> {
        if self.maybe_faulty {
            return Vec::new();
        }
        run(self.arena).unwrap_or_else(|refusal| {
            let refusal = sinew_error::from(refusal);
            self.fault(refusal.status, refusal.argument);
            Vec::new()
        })
    }

    /// Ends the arguments and saves the memory that the call must not change. Returns the pointer
    /// to the error.
    ///
    /// `expected` computes the bytes that a faultless call writes to the place of its results.
    pub(super) fn ready(&mut self, expected: impl FnOnce(&Arena) -> Vec<u8>) -> *mut sinew_error {
        if self.faultless() {
            self.expected = expected(self.arena);
        }
        let descriptions = self.arena.descriptions([true; OBJECTS]);
        self.before = (self.arena.content().1.to_vec(), descriptions);
        let error = self.errors.as_mut_ptr();
        match self.error_pointer {
            ErrorPointer::Null => null_mut(),
            ErrorPointer::Valid => error,
            ErrorPointer::Misaligned => error.wrapping_byte_add(1),
        }
    }

    /// Compares the effects of a function with the promises.
    ///
    /// # Panics
    /// If a promise is broken.
    pub(super) fn check(&mut self, function: &str, status: sinew_status) {
        let done = status == sinew_status::Ok;
        assert!(
            done || promises()[function].contains(&(status as i32)),
            "{function} returned {status:?}, which its comment does not list"
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
        // Restored without being read, because objects and structures have padding.
        let (right, descriptions) = std::mem::take(&mut self.before);
        for place in &written {
            let (from, to) = (place.start.max(start), place.end.max(start));
            self.arena.write(from, &right[from - start..to - start]);
        }
        let (_, content) = self.arena.content();
        if right != content {
            let at = right.iter().zip(content).position(|(right, found)| right != found);
            panic!("{function}, {status:?}, has written to byte {at:?} behind the objects");
        }
        // A call may overwrite an object that it does not read. The object is then invalid and must
        // not be described.
        let is_unchanged = |place| !written.iter().any(|written| meets(written, place));
        let kept = self.arena.objects().map(is_unchanged);
        let found = self.arena.descriptions(kept);
        assert!(
            kept != [true; OBJECTS] || found == descriptions,
            "{function} changed an object: {found:?}"
        );
    }

    /// Compares the status and the error with the known faults.
    fn check_error(&self, function: &str, status: sinew_status) {
        let done = status == sinew_status::Ok;
        let reported = !done && self.error_pointer == ErrorPointer::Valid;
        let [error, other] = *self.errors;
        let misplaced = other != UNTOUCHED || (error != UNTOUCHED) != reported;
        assert!(!misplaced, "{function} returned {status:?} and reported {:?}", self.errors);
        assert!(!reported || error.status == status, "{function}: {error:?}");
        if self.error_pointer == ErrorPointer::Misaligned {
            assert_eq!(status, sinew_status::Misaligned, "{function} writes an error astray");
            return;
        }
        let faults = &self.faults;
        assert!(!done || faults.is_empty(), "{function} accepts {faults:?}");
        assert!(done || !self.faultless(), "{function} refused a faultless call: {status:?}");
        let is_one = faults.iter().any(|(fault, argument)| {
            *fault == status && (!reported || *argument == error.argument)
        });
        assert!(
            done || self.maybe_faulty || is_one,
            "{function} returned {status:?}, {error:?}, for {faults:?}"
        );
    }
}

/// Returns whether two places share a byte.
fn meets(a: &Range<usize>, b: &Range<usize>) -> bool {
    a.start.max(b.start) < a.end.min(b.end)
}

const HEADER: &str = include_str!("../../../../runtime/capi/include/sinew.h");

/// First status that describes a fault of a file.
const FIRST_OF_FILES: i32 = 100;

/// Lists the statuses other than 0 that each function may return, by the name of the function. The
/// sentence "Returns ..." of its comment lists them.
pub fn promises() -> &'static BTreeMap<&'static str, BTreeSet<i32>> {
    static PROMISES: LazyLock<BTreeMap<&str, BTreeSet<i32>>> = LazyLock::new(|| {
        let numbers = numbers();
        let (functions, _) = HEADER.split_once("}  // extern").unwrap_or_default();
        let declarations = functions.split(";\n").filter_map(|text| {
            let (comment, declaration) = text.split_once("\nsinew_status ")?;
            let (name, _) = declaration.split_once('(')?;
            let (_, listed) = comment.rsplit_once("Returns ")?;
            let named = listed.split('`').skip(1).step_by(2).map(|status| numbers[status]);
            let of_files = numbers.values().copied().filter(|number| {
                *number >= FIRST_OF_FILES && listed.contains("every status from 100 on")
            });
            Some((name, named.chain(of_files).collect()))
        });
        declarations.collect()
    });
    &PROMISES
}

/// Reads the enumeration of statuses: numbers by the names that comments use.
fn numbers() -> BTreeMap<&'static str, i32> {
    let lines = HEADER.lines().filter_map(|line| line.trim().strip_prefix("SINEW_STATUS_"));
    lines
        .filter_map(|line| line.strip_suffix(',')?.split_once(" = "))
        .filter_map(|(name, number)| Some((name, number.parse().ok()?)))
        .collect()
}
