//! The border: pointers of the caller are checked here, and become references only here.

use crate::argument::sinew_argument;
use crate::error::{sinew_error, sinew_status};
use core::cell::Cell;
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
    argument: sinew_argument,
}

impl<T> Array<T> {
    /// Checks an array; a null pointer is one without elements.
    pub(crate) fn new(
        at: *const T,
        len: usize,
        argument: sinew_argument,
    ) -> Result<Self, sinew_error> {
        if len == 0 {
            return Ok(Self { at: ptr::dangling_mut(), len, argument });
        }
        let array = Self::some(at, argument)?;
        let bytes = len.checked_mul(size_of::<T>()).filter(|bytes| *bytes <= isize::MAX as usize);
        match bytes.and_then(|bytes| at.addr().checked_add(bytes)) {
            Some(_) => Ok(Self { len, ..array }),
            None => Err(sinew_error::new(sinew_status::TooLong, argument).values(0, len)),
        }
    }

    /// Checks an array that may be left out: a null pointer, and no length.
    pub(crate) fn given(
        at: *const T,
        len: usize,
        argument: sinew_argument,
    ) -> Result<Option<Self>, sinew_error> {
        let is_given = !at.is_null() || len > 0;
        is_given.then(|| Self::new(at, len, argument)).transpose()
    }

    /// Checks a pointer to one value.
    pub(crate) fn one(at: *const T, argument: sinew_argument) -> Result<Self, sinew_error> {
        Self::new(at, 1, argument)
    }

    /// Checks a pointer to one value that may be null.
    pub(crate) fn optional(at: *const T, argument: sinew_argument) -> Result<Self, sinew_error> {
        Self::new(at, usize::from(!at.is_null()), argument)
    }

    /// Checks that an array is long enough.
    pub(crate) fn check_least(&self, least: usize) -> Result<(), sinew_error> {
        if self.len >= least {
            return Ok(());
        }
        Err(sinew_error::new(sinew_status::TooShort, self.argument).values(least, self.len))
    }

    fn some(at: *const T, argument: sinew_argument) -> Result<Self, sinew_error> {
        if at.is_null() {
            return Err(sinew_error::new(sinew_status::Null, argument));
        }
        if !at.is_aligned() {
            let align = align_of::<T>();
            let error = sinew_error::new(sinew_status::Misaligned, argument);
            return Err(error.values(align, at.addr() % align));
        }
        Ok(Self { at: at.cast_mut(), len: 1, argument })
    }

    /// Returns where it lies.
    pub(crate) fn span(&self) -> Span {
        Span { start: self.at.addr(), bytes: self.len * size_of::<T>(), argument: self.argument }
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

    /// Refers to the array to write to it beside others that refer to the same elements.
    ///
    /// # Safety
    /// For `'a` the elements are used through references to cells alone, on this thread alone ([`apart`]
    /// has compared it with all that is read), and T has no value that is not allowed.
    pub(crate) unsafe fn share<'a>(self) -> &'a [Cell<T>] {
        // SAFETY: not null, aligned, and of a length that fits, and a cell is laid out as what it
        // holds; the rest is the caller's promise.
        unsafe { core::slice::from_raw_parts(self.at.cast(), self.len) }
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

/// Copies a structure of the caller's; returns also where it lies.
///
/// # Safety
/// `at` is null, or points to a value that may be read.
pub(crate) unsafe fn copied<T: Copy + 'static>(
    at: *const T,
    argument: sinew_argument,
) -> Result<(T, Span), sinew_error> {
    let one = Array::one(at, argument)?;
    let span = one.span();
    // SAFETY: the caller's promise is passed on; what is referred to is copied at once.
    let value = unsafe { one.read() }.first().copied();
    Ok((value.ok_or(sinew_error::new(sinew_status::Null, argument))?, span))
}

/// Where an argument lies in memory.
#[derive(Clone, Copy)]
pub(crate) struct Span {
    start: usize,
    bytes: usize,
    argument: sinew_argument,
}

impl Span {
    /// That of what was left out.
    pub(crate) const NOWHERE: Self = Self { start: 0, bytes: 0, argument: sinew_argument::Call };

    /// Returns where bytes lie that were checked before.
    pub(crate) fn of(bytes: &[u8], argument: sinew_argument) -> Self {
        Self { start: bytes.as_ptr().addr(), bytes: bytes.len(), argument }
    }

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
            return Err(sinew_error::new(sinew_status::Overlap, span.argument));
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
}

impl<T> Loaded<T> {
    /// Marks a value as an object.
    pub(crate) const fn new<O: Object<Value = T>>(value: T) -> Self {
        Self { tag: O::TAG, value }
    }
}

/// What a handle points to: a [`Loaded`] under the name that it has in C.
pub(crate) trait Object: Sized {
    /// What is loaded.
    type Value: 'static;
    /// Marks memory that holds such an object.
    const TAG: u32;
    /// The handle's name as an argument.
    const ARGUMENT: sinew_argument;

    /// Returns its only field.
    fn loaded(&self) -> &Loaded<Self::Value>;
}

/// Returns what a handle's object holds, and where the object lies.
///
/// # Safety
/// `at` is null, or points to memory as large as the object, which for `'a` stays as it is.
pub(crate) unsafe fn object<'a, T: Object + 'a>(
    at: *const T,
) -> Result<(&'a T::Value, Span), sinew_error> {
    const { assert!(size_of::<T>() == size_of::<Loaded<T::Value>>()) };
    let object = Array::one(at, T::ARGUMENT)?;
    let span = object.span();
    // SAFETY: aligned, not null, and the tag is an object's first four bytes.
    let tag = unsafe { at.cast::<u32>().read() };
    let not_loaded = sinew_error::new(sinew_status::NotLoaded, T::ARGUMENT);
    if tag != T::TAG {
        return Err(not_loaded);
    }
    // SAFETY: aligned, not null, and its tag says that it was written by this library.
    let loaded = unsafe { object.read() }.first().ok_or(not_loaded)?.loaded();
    Ok((&loaded.value, span))
}

/// Checks memory that is to hold an object.
pub(crate) fn place<T: Object>(
    memory: *mut core::ffi::c_void,
    memory_bytes: usize,
) -> Result<Array<T>, sinew_error> {
    let place = Array::one(memory.cast_const().cast::<T>(), sinew_argument::Memory)?;
    if memory_bytes < size_of::<T>() {
        return Err(sinew_error::new(sinew_status::TooShort, sinew_argument::Memory)
            .values(size_of::<T>(), memory_bytes));
    }
    Ok(place)
}
