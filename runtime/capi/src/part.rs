//! Envelopes, skins, kernels and their like as parts of a model: how they are opened, and refused once the model holds
//! another file.

use crate::argument::sinew_argument;
use crate::border::{self, Array, Loaded, Object, Span};
use crate::error::sinew_error;
use crate::model::{self, sinew_model};
use crate::status::sinew_status;
use core::ffi::{c_char, c_void};
use sinew_runtime::Model;

/// What the memory of a part holds: what loading found of it, and the handle of its model.
pub(crate) struct Opened<L> {
    layout: L,
    model: *const sinew_model,
}

/// An object that is a part of a model.
pub(crate) trait Part: Object<Value = Opened<Self::Layout>> {
    /// What loading found of it.
    type Layout: 'static;
    /// What evaluates it, in the file's bytes.
    type View<'a>;

    /// Gives an object its name in C.
    fn named(loaded: Loaded<Self::Value>) -> Self;

    /// Finds the `index`-th part of a name, or of any.
    fn find(model: &Model<&[u8]>, name: Option<&str>, index: usize) -> Option<Self::Layout>;

    /// Views it; `None` if the bytes are another file's.
    fn view<'a>(layout: &Self::Layout, file: &'a [u8]) -> Option<Self::View<'a>>;
}

/// Makes a structure of the header, whose field is what is loaded, a part: of which layout and view, listed by which
/// of a model's methods; the tag of its memory, what an error about it names, and the words that it must fit in.
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

            fn named(loaded: $crate::border::Loaded<Self::Value>) -> Self {
                Self(loaded)
            }

            fn find(
                model: &sinew_runtime::Model<&[u8]>,
                name: Option<&str>,
                index: usize,
            ) -> Option<$layout> {
                let is_it = |part: &$view<'_>| name.is_none_or(|name| part.name() == name);
                model.$list().filter(is_it).nth(index).map(|part| part.layout())
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

/// Which part is wanted: the `index`-th of those of a name, or of all if the name is null.
pub(crate) struct Wanted {
    pub(crate) name: *const c_char,
    pub(crate) name_len: usize,
    pub(crate) index: usize,
}

/// Opens a part of a model in the caller's memory.
///
/// # Safety
/// The handle is null or points to memory as large as a model; the name is the caller's to be read, and
/// the memory and where the handle goes are the caller's to be written.
pub(crate) unsafe fn open<T: Part>(
    model: *const sinew_model,
    wanted: &Wanted,
    memory: *mut c_void,
    memory_bytes: usize,
    out_part: *mut *const T,
) -> Result<(), sinew_error> {
    // SAFETY: the caller's promise is passed on.
    let (loaded, [handle, file]) = unsafe { model::loaded(model) }?;
    let name = Array::new(wanted.name.cast::<u8>(), wanted.name_len, sinew_argument::Name)?;
    let place = border::place::<T>(memory, memory_bytes)?;
    let out = Array::one(out_part, sinew_argument::Result)?;
    border::apart(&[place.span(), out.span()], &[handle, file, name.span()])?;
    let layout = if wanted.name.is_null() {
        T::find(loaded, None, wanted.index)
    } else {
        // SAFETY: lent by the caller. What is no text is the name of nothing.
        let name = core::str::from_utf8(unsafe { name.read() });
        name.ok().and_then(|name| T::find(loaded, Some(name), wanted.index))
    };
    let layout = layout.ok_or(sinew_error::new(sinew_status::NotFound, T::ARGUMENT))?;
    let object = T::named(Loaded::new::<T>(Opened { layout, model }));
    // SAFETY: memory large enough, aligned, apart from all that is read, and lent by the caller.
    unsafe { place.store(object) };
    // SAFETY: one element, which the caller lets be written.
    unsafe { out.store(memory.cast_const().cast()) };
    Ok(())
}

/// A view, its model, and what a call with both reads.
pub(crate) type InModel<'a, T> = (<T as Part>::View<'a>, &'a Model<&'static [u8]>, [Span; 3]);

/// Views a part in its model's file; returns also what a call with it reads: the part's object, the
/// model's, and the file.
///
/// # Safety
/// `at` is null, or points to memory as large as the object, which for `'a` stays as it is; and if it
/// is open, so does its model's memory.
pub(crate) unsafe fn view<'a, T: Part + 'a>(
    at: *const T,
) -> Result<(T::View<'a>, [Span; 3]), sinew_error> {
    // SAFETY: the caller's promise is passed on.
    unsafe { view_in(at) }.map(|(view, _, reads)| (view, reads))
}

/// Views a part as [`view`] does; returns also the model that it is of.
///
/// # Safety
/// As of [`view`].
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
