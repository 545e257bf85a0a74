//! Enumerations whose variants have a number and a text.

/// Defines an enumeration, the list `ALL` of its variants in order, and a function that returns a variant's text.
///
/// Each variant has its number, its text and, after `if`, the feature without which it does not exist. The comments
/// of the list and of the function stand before their names.
macro_rules! named {
    (
        $(#[$meta:meta])*
        pub enum $enum:ident {
            $($(#[$doc:meta])* $variant:ident = $number:literal, $text:literal $(if $feature:literal)?;)*
        }
        $(#[$all:meta])*
        ALL;
        $(#[$about:meta])*
        $function:ident;
    ) => {
        $(#[$meta])*
        pub enum $enum {
            $($(#[$doc])* $(#[cfg(feature = $feature)])? $variant = $number,)*
        }

        impl $enum {
            // The array of texts has one entry for each variant that exists with the features.
            $(#[$all])*
            pub const ALL: [Self; [$($(#[cfg(feature = $feature)])? $text),*].len()] =
                [$($(#[cfg(feature = $feature)])? Self::$variant),*];

            $(#[$about])*
            pub const fn $function(self) -> &'static str {
                match self {
                    $($(#[cfg(feature = $feature)])? Self::$variant => $text,)*
                }
            }
        }
    };
}
pub(crate) use named;
