//! Parts of a model, for example envelopes and skins: opens them, views them, and runs calls on them. Calls refuse a
//! part after its model has loaded another file.

use crate::argument::sinew_argument;
use crate::border::{self, Array, Loaded, Object, Span};
use crate::error::{sinew_error, sinew_status};
use crate::model::{self, sinew_model};
use core::ffi::{c_char, c_void};
use sinew_runtime::{CallError, Model};

/// Content of a part's memory: the layout that opening found in the file, and the model's handle.
pub(crate) struct Opened<L> {
    layout: L,
    model: *const sinew_model,
}

/// An object that is a part of a model.
pub(crate) trait Part: Object<Value = Opened<Self::Layout>> {
    /// The runtime's description of where the part is in the file.
    type Layout: 'static;
    /// The runtime's type that evaluates the part, borrowed from the file's bytes.
    type View<'a>;

    /// Wraps loaded content in the structure that C knows.
    fn wrap(loaded: Loaded<Self::Value>) -> Self;

    /// Finds the `index`-th part with this name, or the `index`-th of all parts if `name` is `None`.
    fn find(model: &Model<&[u8]>, name: Option<&str>, index: usize) -> Option<Self::Layout>;

    /// Views the part; `None` if the bytes are those of another file.
    fn view<'a>(layout: &Self::Layout, file: &'a [u8]) -> Option<Self::View<'a>>;
}

/// Implements [`Object`] and [`Part`] for an opaque structure of the header.
///
/// The structure's only field is [`Loaded`]. The macro takes the layout and the view of the runtime, the method of
/// [`Model`] that lists the parts, the tag of the memory, the argument that errors name, and the constant that limits
/// the size in words.
macro_rules! part {
    (
        $object:ident: $layout:ident to $view:ident, of Model::$list:ident,
        tag $tag:literal, argument $argument:ident, within $words:ident
    ) => {
        impl $crate::border::Object for $object {
            type Value = $crate::part::Opened<$layout>;
            const TAG: u32 = u32::from_le_bytes(*$tag);
            const ARGUMENT: $crate::argument::sinew_argument =
                $crate::argument::sinew_argument::$argument;

            fn loaded(&self) -> &$crate::border::Loaded<Self::Value> {
                &self.0
            }
        }

        impl $crate::part::Part for $object {
            type Layout = $layout;
            type View<'a> = $view<'a>;

            fn wrap(loaded: $crate::border::Loaded<Self::Value>) -> Self {
                Self(loaded)
            }

            fn find(
                model: &sinew_runtime::Model<&[u8]>,
                name: Option<&str>,
                index: usize,
            ) -> Option<$layout> {
                let matches = |part: &$view<'_>| name.is_none_or(|name| part.name() == name);
                model.$list().filter(matches).nth(index).map(|part| part.layout())
            }

            fn view<'a>(layout: &$layout, file: &'a [u8]) -> Option<$view<'a>> {
                layout.open(file)
            }
        }

        const _: () = {
            assert!(size_of::<$object>() <= $words * size_of::<usize>());
            assert!(align_of::<$object>() <= align_of::<usize>());
        };
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
    /// Opens the part in the caller's memory and stores its handle.
    ///
    /// # Safety
    /// The model's handle is null or points to memory as large as a model. The caller may read the name. The memory,
    /// `out_part` and `out_error` may be written.
    pub(crate) unsafe fn open<T: Part>(
        &self,
        out_part: *mut *const T,
        out_error: *mut sinew_error,
    ) -> sinew_status {
        let Self { model, name, name_len, index, memory, memory_bytes } = *self;
        let body = || {
            // SAFETY: the caller's promise is passed on.
            let (loaded, [handle, file]) = unsafe { model::loaded(model) }?;
            let text = Array::new(name.cast::<u8>(), name_len, sinew_argument::Name)?;
            let place = border::place::<T>(memory, memory_bytes)?;
            let out = Array::one(out_part, sinew_argument::Result)?;
            border::check_disjoint(&[place.span(), out.span()], &[handle, file, text.span()])?;
            let layout = if name.is_null() {
                T::find(loaded, None, index)
            } else {
                // SAFETY: lent by the caller. No part has a name that is not UTF-8.
                let text = core::str::from_utf8(unsafe { text.read() });
                text.ok().and_then(|text| T::find(loaded, Some(text), index))
            };
            let layout = layout.ok_or(sinew_error::new(sinew_status::NotFound, T::ARGUMENT))?;
            let object = T::wrap(Loaded::new::<T>(Opened { layout, model }));
            // SAFETY: the memory is large enough, aligned, lent by the caller, and overlaps nothing that is read.
            unsafe { place.store(object) };
            // SAFETY: one element, which the caller allows to be written.
            unsafe { out.store(memory.cast_const().cast()) };
            Ok(())
        };
        // SAFETY: the caller's promise is passed on.
        unsafe { border::call(out_error, body) }
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
    let view = T::view(&part.layout, model.as_bytes());
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
    pub(crate) unsafe fn run<'a, T: Part + 'a>(
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
        ) -> Result<(), CallError>,
    ) -> sinew_status {
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
