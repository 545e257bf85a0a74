//! Parts of a model, for example envelopes and skins: opens them, views them, and runs calls on them. Calls refuse a
//! part after its model has loaded another file.

use crate::argument::sinew_argument;
use crate::border::{self, Array, Loaded, Object, Span};
use crate::error::{sinew_error, sinew_status};
use crate::model::{self, sinew_model};
use core::ffi::{c_char, c_void};
use core::mem::{align_of, size_of};
use sinew_runtime::{CallError, Model, ModelPart, PartLayout};

/// Length of a `uintptr_t` array that can hold a part of any kind on every target:
/// `uintptr_t memory[SINEW_PART_WORDS]`.
pub const SINEW_PART_WORDS: usize = 48;

/// Content of a part's memory: the layout that opening found in the file, and the model's handle.
pub(crate) struct Opened {
    layout: PartLayout,
    model: *const sinew_model,
}

const _: () = {
    assert!(size_of::<Loaded<Opened>>() <= SINEW_PART_WORDS * size_of::<usize>());
    assert!(align_of::<Loaded<Opened>>() <= align_of::<usize>());
};

/// An object that is a part of a model.
pub(crate) trait Part: Object<Value = Opened> {
    /// The runtime's type that evaluates the part, borrowed from the file's bytes.
    type View<'a>: ModelPart<'a>;

    /// Wraps loaded content in the structure that C knows.
    fn wrap(loaded: Loaded<Opened>) -> Self;
}

/// Implements [`Object`] and [`Part`] for an opaque structure of the header, whose only field is [`Loaded`].
///
/// The macro takes the view of the runtime, the tag of the memory, and the argument that errors name.
macro_rules! part {
    ($object:ident: $view:ident, tag $tag:literal, argument $argument:ident) => {
        impl $crate::border::Object for $object {
            type Value = $crate::part::Opened;
            const TAG: u32 = u32::from_le_bytes(*$tag);
            const ARGUMENT: $crate::argument::sinew_argument =
                $crate::argument::sinew_argument::$argument;

            fn loaded(&self) -> &$crate::border::Loaded<Self::Value> {
                &self.0
            }
        }

        impl $crate::part::Part for $object {
            type View<'a> = $view<'a>;

            fn wrap(loaded: $crate::border::Loaded<$crate::part::Opened>) -> Self {
                Self(loaded)
            }
        }
    };
}
pub(crate) use part;

/// Arguments of a call that opens a part: `index` counts the parts with this name, or all parts if the name is null.
pub(crate) struct Opening {
    pub(crate) model: *const sinew_model,
    pub(crate) name: *const c_char,
    pub(crate) name_len: usize,
    pub(crate) index: usize,
    pub(crate) memory: *mut c_void,
    pub(crate) memory_bytes: usize,
}

impl Opening {
    /// Opens the part in the caller's memory.
    ///
    /// # Safety
    /// The model's handle is null or points to memory as large as a model. The caller may read the name. The memory
    /// may be written.
    pub(crate) unsafe fn open<T: Part>(&self) -> Result<(), sinew_error> {
        let Self { model, name, name_len, index, memory, memory_bytes } = *self;
        // SAFETY: the caller's promise is passed on.
        let (loaded, [handle, file]) = unsafe { model::loaded(model) }?;
        let text = Array::new(name.cast::<u8>(), name_len, sinew_argument::Name)?;
        let place = border::place::<T>(memory, memory_bytes)?;
        border::check_disjoint(&[place.span()], &[handle, file, text.span()])?;
        // SAFETY: lent by the caller. No part has a name that is not UTF-8.
        let text = core::str::from_utf8(unsafe { text.read() });
        let matches = |part: &T::View<'_>| name.is_null() || text == Ok(part.name());
        let found = loaded.all::<T::View<'_>>().filter(matches).nth(index);
        let found = found.ok_or(sinew_error::new(sinew_status::NotFound, T::ARGUMENT))?;
        let object = T::wrap(Loaded::new::<T>(Opened { layout: found.layout(), model }));
        // SAFETY: the memory is large enough, aligned, lent by the caller, and overlaps nothing that is read.
        unsafe { place.store(object) };
        Ok(())
    }
}

/// A part's view, its model, and the memory that a call with both reads.
pub(crate) type InModel<'a, T> = (<T as Part>::View<'a>, &'a Model<&'static [u8]>, [Span; 3]);

/// Views a part in its model's file. Also returns the memory that a call reads: the part's object, the model's object
/// and the file.
///
/// # Safety
/// `at` is null, or points to memory as large as the object. That memory, and the model's memory if the part is open,
/// stay unchanged for `'a`.
pub(crate) unsafe fn view<'a, T: Part + 'a>(
    at: *const T,
) -> Result<(T::View<'a>, [Span; 3]), sinew_error> {
    // SAFETY: the caller's promise is passed on.
    unsafe { view_in(at) }.map(|(view, _, reads)| (view, reads))
}

/// Views a part as [`view`] does, and also returns its model.
///
/// # Safety
/// As for [`view`].
pub(crate) unsafe fn view_in<'a, T: Part + 'a>(
    at: *const T,
) -> Result<InModel<'a, T>, sinew_error> {
    // SAFETY: the caller's promise is passed on.
    let (part, own) = unsafe { border::object(at) }?;
    // SAFETY: the caller's promise is passed on.
    let (model, [handle, file]) = unsafe { model::loaded(part.model) }?;
    let view = part.layout.open(model.as_bytes());
    let view = view.ok_or(sinew_error::new(sinew_status::Stale, T::ARGUMENT))?;
    Ok((view, model, [own, handle, file]))
}

/// Runs a call that describes a part: stores in `out` the value that `answer` computes from the view.
///
/// # Safety
/// As for [`view`]; `out` and `out_error` may be written.
pub(crate) unsafe fn describe<'a, T: Part + 'a, V>(
    at: *const T,
    out: *mut V,
    out_error: *mut sinew_error,
    answer: impl FnOnce(&T::View<'a>) -> Result<V, sinew_error>,
) -> sinew_status {
    let inputs = (Array::<u8>::none(), Array::<u8>::none());
    // SAFETY: the caller's promise is passed on.
    unsafe { compute(at, inputs, out, out_error, |view, _, _| answer(view)) }
}

/// An array, or the error about it. Errors about the part are reported before this error.
pub(crate) type Checked<T> = Result<Array<T>, sinew_error>;

/// Runs a call that stores in `out` the value that `answer` computes from the view and two arrays.
///
/// # Safety
/// As for [`view`]; the arrays may be read, `out` and `out_error` may be written.
pub(crate) unsafe fn compute<'a, T: Part + 'a, I, J, V>(
    at: *const T,
    inputs: (Checked<I>, Checked<J>),
    out: *mut V,
    out_error: *mut sinew_error,
    answer: impl FnOnce(&T::View<'a>, &[I], &[J]) -> Result<V, sinew_error>,
) -> sinew_status {
    let body = || {
        // SAFETY: the caller's promise is passed on.
        let (view, [own, model, file]) = unsafe { view(at) }?;
        let (first, second) = (inputs.0?, inputs.1?);
        let out = Array::one(out, sinew_argument::Result)?;
        let reads = [own, model, file, first.span(), second.span()];
        border::check_disjoint(&[out.span()], &reads)?;
        // SAFETY: lent by the caller; written memory overlaps none of it.
        let value = unsafe { answer(&view, first.read(), second.read()) }?;
        // SAFETY: one element, which the caller allows to be written.
        unsafe { out.store(value) };
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Arguments of a call that evaluates a part. Arrays that the call does not have are empty.
pub(crate) struct Evaluation<I, O> {
    pub(crate) input: Checked<I>,
    pub(crate) curves: Checked<f32>,
    pub(crate) scratch: Checked<f32>,
    pub(crate) output: Checked<O>,
    pub(crate) confidences: Checked<f32>,
}

impl<I, O> Evaluation<I, O> {
    /// Runs the call: checks handle and arrays, then evaluates the part by a function of the runtime. The function
    /// takes the arrays in the order of the fields.
    ///
    /// # Safety
    /// As for [`view`]; the input and the curves may be read, all other arrays and `out_error` may be written.
    pub(crate) unsafe fn run<'a, T: Part + 'a, E>(
        self,
        at: *const T,
        out_error: *mut sinew_error,
        evaluate: impl FnOnce(
            &T::View<'a>,
            &[I],
            &[f32],
            &mut [f32],
            &mut [O],
            &mut [f32],
        ) -> Result<(), E>,
    ) -> sinew_status
    where
        sinew_error: From<E>,
    {
        let body = || {
            // SAFETY: the caller's promise is passed on.
            let (view, [own, model, file]) = unsafe { view(at) }?;
            let (input, curves, scratch) = (self.input?, self.curves?, self.scratch?);
            let (output, confidences) = (self.output?, self.confidences?);
            let written = [scratch.span(), output.span(), confidences.span()];
            border::check_disjoint(&written, &[own, model, file, input.span(), curves.span()])?;
            // SAFETY: lent by the caller; written memory overlaps nothing else.
            let (input, curves) = unsafe { (input.read(), curves.read()) };
            // SAFETY: as above.
            let (scratch, output) = unsafe { (scratch.write(), output.write()) };
            // SAFETY: as above.
            let confidences = unsafe { confidences.write() };
            Ok(evaluate(&view, input, curves, scratch, output, confidences)?)
        };
        // SAFETY: the caller's promise is passed on.
        unsafe { border::call(out_error, body) }
    }

    /// Runs the call as [`Evaluation::run`] does. The function returns one confidence, which is stored.
    ///
    /// # Safety
    /// As for [`Evaluation::run`].
    pub(crate) unsafe fn run_one<'a, T: Part + 'a>(
        self,
        at: *const T,
        out_error: *mut sinew_error,
        evaluate: impl FnOnce(
            &T::View<'a>,
            &[I],
            &[f32],
            &mut [f32],
            &mut [O],
        ) -> Result<f32, CallError>,
    ) -> sinew_status {
        // SAFETY: the caller's promise is passed on.
        unsafe {
            self.run(at, out_error, |view, input, curves, scratch, output, confidences| {
                evaluate(view, input, curves, scratch, output).map(|found| confidences.fill(found))
            })
        }
    }
}
