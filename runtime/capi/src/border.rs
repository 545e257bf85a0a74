//! Checks the pointers of callers and turns them into references; no other module does.

use crate::argument::sinew_argument;
use crate::error::{sinew_error, sinew_status};
use core::cell::Cell;
use core::mem::{align_of, size_of};
use core::ptr;

/// Runs a call. On failure stores the error in `out_error` unless that is null.
///
/// # Safety
/// `out_error` is null, or points to an error that may be written.
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
                // SAFETY: the pointer is aligned and not null, and the caller allows writing. All references that
                // `body` made are gone.
                unsafe { out_error.write(error) };
            }
            error.status
        }
    }
}

/// Memory of the caller for `len` values. Address and extent have been checked; no reference to the memory exists yet.
pub(crate) struct Array<T> {
    at: *mut T,
    len: usize,
    argument: sinew_argument,
}

impl<T> Array<T> {
    /// Checks an array. An array of length 0 may be null.
    pub(crate) fn new(
        at: *const T,
        len: usize,
        argument: sinew_argument,
    ) -> Result<Self, sinew_error> {
        if len == 0 {
            return Ok(Self { at: ptr::dangling_mut(), len, argument });
        }
        let array = Self::pointer(at, argument)?;
        let bytes = len.checked_mul(size_of::<T>()).filter(|bytes| *bytes <= isize::MAX as usize);
        match bytes.and_then(|bytes| at.addr().checked_add(bytes)) {
            Some(_) => Ok(Self { len, ..array }),
            None => Err(sinew_error::new(sinew_status::TooLong, argument).values(0, len)),
        }
    }

    /// Checks an array that may be left out; `None` if the pointer is null and the length 0.
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

    /// Returns the array of a call that has none.
    pub(crate) fn none() -> Result<Self, sinew_error> {
        Self::new(ptr::null(), 0, sinew_argument::Call)
    }

    /// Checks a pointer to one value that may be null.
    pub(crate) fn optional(at: *const T, argument: sinew_argument) -> Result<Self, sinew_error> {
        Self::new(at, usize::from(!at.is_null()), argument)
    }

    /// Checks that the array has at least `least` elements.
    pub(crate) fn check_least(&self, least: usize) -> Result<(), sinew_error> {
        if self.len >= least {
            return Ok(());
        }
        Err(sinew_error::new(sinew_status::TooShort, self.argument).values(least, self.len))
    }

    /// Checks a pointer: not null, and aligned.
    fn pointer(at: *const T, argument: sinew_argument) -> Result<Self, sinew_error> {
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

    /// Returns the part of scratch of floats that holds whole values of another type, with their alignment.
    pub(crate) fn aligned<U>(self) -> Array<U> {
        let bytes = self.len * size_of::<T>();
        let skipped = self.at.addr().wrapping_neg() % align_of::<U>();
        // On firmware the values of scratch have no bytes.
        let len = bytes.saturating_sub(skipped).checked_div(size_of::<U>()).unwrap_or(0);
        Array { at: self.at.wrapping_byte_add(skipped).cast(), len, argument: self.argument }
    }

    /// Returns the array's place in memory.
    pub(crate) fn span(&self) -> Span {
        Span { start: self.at.addr(), bytes: self.len * size_of::<T>(), argument: self.argument }
    }

    /// Borrows the array to read it.
    ///
    /// # Safety
    /// For `'a` the caller keeps the elements readable and unchanged.
    pub(crate) unsafe fn read<'a>(self) -> &'a [T] {
        // SAFETY: not null, aligned, and of a length that fits; the rest is the caller's promise.
        unsafe { core::slice::from_raw_parts(self.at, self.len) }
    }

    /// Borrows the array to write to it.
    ///
    /// # Safety
    /// For `'a` only this reference uses the elements: [`check_disjoint`] has compared the array with all others of
    /// the call. All bit patterns are valid values of `T`.
    pub(crate) unsafe fn write<'a>(self) -> &'a mut [T] {
        // SAFETY: not null, aligned, and of a length that fits; the rest is the caller's promise.
        unsafe { core::slice::from_raw_parts_mut(self.at, self.len) }
    }

    /// Borrows the array to write to it, although other borrows may share its elements.
    ///
    /// # Safety
    /// For `'a` the elements are used only through cells and only on this thread: [`check_disjoint`] has compared the
    /// array with all memory that is read. All bit patterns are valid values of `T`.
    pub(crate) unsafe fn share<'a>(self) -> &'a [Cell<T>] {
        // SAFETY: not null, aligned, and of a length that fits. A cell has the layout of its content. The rest is the
        // caller's promise.
        unsafe { core::slice::from_raw_parts(self.at.cast(), self.len) }
    }

    /// Stores one value without reading the old content.
    ///
    /// # Safety
    /// The array has one element, which may be written. No reference to the element exists.
    pub(crate) unsafe fn store(self, value: T) {
        // SAFETY: not null and aligned; the rest is the caller's promise.
        unsafe { self.at.write(value) };
    }
}

/// Copies a structure of the caller, and returns its place in memory.
///
/// # Safety
/// `at` is null, or points to a value that may be read.
pub(crate) unsafe fn copied<T: Copy + 'static>(
    at: *const T,
    argument: sinew_argument,
) -> Result<(T, Span), sinew_error> {
    let one = Array::one(at, argument)?;
    let span = one.span();
    // SAFETY: the caller's promise is passed on; the value is copied immediately.
    let value = unsafe { one.read() }.first().copied();
    Ok((value.ok_or(sinew_error::new(sinew_status::Null, argument))?, span))
}

/// Place of an argument in memory.
#[derive(Clone, Copy)]
pub(crate) struct Span {
    start: usize,
    bytes: usize,
    argument: sinew_argument,
}

impl Span {
    /// Place of an argument that was left out.
    pub(crate) const EMPTY: Self = Self { start: 0, bytes: 0, argument: sinew_argument::Call };

    /// Returns the place of bytes that were checked before.
    pub(crate) fn of(bytes: &[u8], argument: sinew_argument) -> Self {
        Self { start: bytes.as_ptr().addr(), bytes: bytes.len(), argument }
    }

    /// Whether the two places have a byte in common.
    fn overlaps(&self, other: &Self) -> bool {
        let (a, b) = (self.start, other.start);
        if a <= b {
            b - a < self.bytes && other.bytes > 0
        } else {
            a - b < other.bytes && self.bytes > 0
        }
    }
}

/// Checks that written memory overlaps no other memory of the call.
///
/// # Errors
/// `OVERLAP`, with the argument that is written.
pub(crate) fn check_disjoint(mut written: &[Span], read: &[Span]) -> Result<(), sinew_error> {
    while let Some((span, others)) = written.split_first() {
        if others.iter().chain(read).any(|other| span.overlaps(other)) {
            return Err(sinew_error::new(sinew_status::Overlap, span.argument));
        }
        written = others;
    }
    Ok(())
}

/// Content of the caller's memory after loading or opening. Every kind of object starts with its tag. Reading the tag
/// therefore stays inside the smallest object, and reused memory has the tag of the new kind.
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

/// Target of a handle: a structure of the header that wraps a [`Loaded`].
pub(crate) trait Object: Sized {
    /// The loaded value.
    type Value: 'static;
    /// Tag of memory that holds this kind of object.
    const TAG: u32;
    /// Argument that errors about the handle name.
    const ARGUMENT: sinew_argument;

    /// Returns the structure's only field.
    fn loaded(&self) -> &Loaded<Self::Value>;
}

/// Returns the value that a handle points to, and the object's place in memory.
///
/// # Safety
/// `at` is null, or points to memory as large as the object, which stays unchanged for `'a`.
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
    // SAFETY: aligned, not null, and the tag shows that this library wrote the object.
    let loaded = unsafe { object.read() }.first().ok_or(not_loaded)?.loaded();
    Ok((&loaded.value, span))
}

/// Checks memory for a new object: aligned, and `memory_bytes` bytes are enough.
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
