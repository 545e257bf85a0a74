//! The border: pointers of the caller are checked here, and become references only here.

use crate::{sinew_error, sinew_status, sinew_subject};
use core::mem::{align_of, size_of};
use core::ptr;

/// Runs a call; on an error writes the error, if the caller wants it, and nothing else.
///
/// # Safety
/// `out_error` is null, or what it points to may be written.
pub(crate) unsafe fn call(
    out_error: *mut sinew_error,
    body: impl FnOnce() -> Result<(), sinew_error>,
) -> sinew_status {
    if !out_error.is_aligned() {
        return sinew_status::Misaligned;
    }
    match body() {
        Ok(()) => sinew_status::Ok,
        Err(error) => {
            if !out_error.is_null() {
                // SAFETY: it is aligned and not null, and the caller lets it be written; every
                // reference that `body` made is gone.
                unsafe { out_error.write(error) };
            }
            error.status
        }
    }
}

/// Memory of the caller for `len` values: its address and extent have been checked, and nothing
/// refers to it yet.
pub(crate) struct Array<T> {
    at: *mut T,
    len: usize,
    subject: sinew_subject,
}

impl<T> Array<T> {
    /// Checks an array; a null pointer is one without elements.
    pub(crate) fn new(
        at: *const T,
        len: usize,
        subject: sinew_subject,
    ) -> Result<Self, sinew_error> {
        if len == 0 {
            return Ok(Self { at: ptr::dangling_mut(), len, subject });
        }
        let array = Self::some(at, subject)?;
        let bytes = len.checked_mul(size_of::<T>()).filter(|bytes| *bytes <= isize::MAX as usize);
        match bytes.and_then(|bytes| at.addr().checked_add(bytes)) {
            Some(_) => Ok(Self { len, ..array }),
            None => Err(sinew_error::new(sinew_status::TooLong, subject).found(len as u64)),
        }
    }

    /// Checks a pointer to one value.
    pub(crate) fn one(at: *const T, subject: sinew_subject) -> Result<Self, sinew_error> {
        Self::new(at, 1, subject)
    }

    /// Checks a pointer to one value that may be null.
    pub(crate) fn optional(at: *const T, subject: sinew_subject) -> Result<Self, sinew_error> {
        Self::new(at, usize::from(!at.is_null()), subject)
    }

    /// Checks the length of an array that must be exact.
    pub(crate) fn check_len(&self, expected: usize) -> Result<(), sinew_error> {
        if self.len == expected {
            return Ok(());
        }
        Err(self.error(sinew_status::Length, expected))
    }

    /// Checks that an array is long enough.
    pub(crate) fn check_least(&self, least: usize) -> Result<(), sinew_error> {
        if self.len >= least {
            return Ok(());
        }
        Err(self.error(sinew_status::TooShort, least))
    }

    fn error(&self, status: sinew_status, expected: usize) -> sinew_error {
        sinew_error::new(status, self.subject).expected(expected as u64).found(self.len as u64)
    }

    fn some(at: *const T, subject: sinew_subject) -> Result<Self, sinew_error> {
        if at.is_null() {
            return Err(sinew_error::new(sinew_status::Null, subject));
        }
        if !at.is_aligned() {
            let align = align_of::<T>();
            return Err(sinew_error::new(sinew_status::Misaligned, subject)
                .expected(align as u64)
                .found((at.addr() % align) as u64));
        }
        Ok(Self { at: at.cast_mut(), len: 1, subject })
    }

    /// Returns where it lies.
    pub(crate) fn span(&self) -> Span {
        let bytes = if self.len == 0 { 0 } else { self.len * size_of::<T>() };
        Span { start: self.at.addr(), bytes, subject: self.subject }
    }

    /// Refers to the array.
    ///
    /// # Safety
    /// For `'a` the caller keeps its elements readable and unchanged.
    pub(crate) unsafe fn read<'a>(self) -> &'a [T] {
        // SAFETY: not null, aligned, and of a length that fits; the rest is the caller's promise.
        unsafe { core::slice::from_raw_parts(self.at, self.len) }
    }

    /// Refers to the array to write to it.
    ///
    /// # Safety
    /// For `'a` the elements are used through this reference alone ([`apart`] has compared it with
    /// all others of the call), and T has no value that is not allowed.
    pub(crate) unsafe fn write<'a>(self) -> &'a mut [T] {
        // SAFETY: not null, aligned, and of a length that fits; the rest is the caller's promise.
        unsafe { core::slice::from_raw_parts_mut(self.at, self.len) }
    }

    /// Stores one value, without reading what was there.
    ///
    /// # Safety
    /// It has one element, which may be written and which no reference is left to.
    pub(crate) unsafe fn store(self, value: T) {
        // SAFETY: not null and aligned; the rest is the caller's promise.
        unsafe { self.at.write(value) };
    }
}

/// Where an argument lies in memory.
#[derive(Clone, Copy)]
pub(crate) struct Span {
    start: usize,
    bytes: usize,
    subject: sinew_subject,
}

impl Span {
    /// Whether the two have a byte in common.
    fn meets(&self, other: &Self) -> bool {
        let (a, b) = (self.start, other.start);
        if a <= b {
            b - a < self.bytes && other.bytes > 0
        } else {
            a - b < other.bytes && self.bytes > 0
        }
    }
}

/// Checks that nothing written overlaps anything else of the call.
pub(crate) fn apart(mut written: &[Span], read: &[Span]) -> Result<(), sinew_error> {
    while let Some((span, others)) = written.split_first() {
        if others.iter().chain(read).any(|other| span.meets(other)) {
            return Err(sinew_error::new(sinew_status::Overlap, span.subject));
        }
        written = others;
    }
    Ok(())
}

/// What lies in the caller's memory once something is loaded. The tag comes first whatever the kind:
/// reading it stays within the smallest object, and memory that is used again has the new kind's.
#[repr(C)]
pub(crate) struct Loaded<T> {
    tag: u32,
    value: T,
    file: Span,
}

impl<T> Loaded<T> {
    /// Marks a value, which borrows from the file, as an object.
    pub(crate) fn new<O: Object<Value = T>>(value: T, file: Span) -> Self {
        Self { tag: O::TAG, value, file }
    }
}

/// What a handle points to: a [`Loaded`] under the name that it has in C.
pub(crate) trait Object: Sized {
    /// What is loaded.
    type Value: 'static;
    /// Marks memory that holds such an object.
    const TAG: u32;
    /// The handle's name as an argument.
    const SUBJECT: sinew_subject;

    /// Returns its only field.
    fn loaded(&self) -> &Loaded<Self::Value>;
}

/// Returns what a handle's object holds, and what a call with it reads: the object and the file.
///
/// # Safety
/// `at` is null, or points to memory as large as the object, which for `'a` stays as it is.
pub(crate) unsafe fn object<'a, T: Object + 'a>(
    at: *const T,
) -> Result<(&'a T::Value, [Span; 2]), sinew_error> {
    const { assert!(size_of::<T>() == size_of::<Loaded<T::Value>>()) };
    let object = Array::one(at, T::SUBJECT)?;
    let handle = object.span();
    // SAFETY: aligned, not null, and the tag is an object's first four bytes.
    let tag = unsafe { at.cast::<u32>().read() };
    let not_loaded = sinew_error::new(sinew_status::NotLoaded, T::SUBJECT);
    if tag != T::TAG {
        return Err(not_loaded);
    }
    // SAFETY: aligned, not null, and its tag says that it was written by this library.
    let loaded = unsafe { object.read() }.first().ok_or(not_loaded)?.loaded();
    Ok((&loaded.value, [handle, loaded.file]))
}

/// Checks memory that is to hold an object.
pub(crate) fn place<T: Object>(
    memory: *mut core::ffi::c_void,
    memory_bytes: usize,
) -> Result<Array<T>, sinew_error> {
    let place = Array::one(memory.cast_const().cast::<T>(), sinew_subject::Memory)?;
    if memory_bytes < size_of::<T>() {
        return Err(sinew_error::new(sinew_status::TooShort, sinew_subject::Memory)
            .expected(size_of::<T>() as u64)
            .found(memory_bytes as u64));
    }
    Ok(place)
}
