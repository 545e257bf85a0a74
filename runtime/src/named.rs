//! Enumerations whose variants have a number and a text.

/// Defines an enumeration, the list `ALL` of its variants in order, and a function that returns a variant's text.
///
/// Each variant has its number and its text. The comments of the list and of the function stand before their names.
macro_rules! named {
    (
        $(#[$meta:meta])*
        pub enum $enum:ident {
            $($(#[$doc:meta])* $variant:ident = $number:literal, $text:literal;)*
        }
        $(#[$all:meta])*
        $all_vis:vis ALL;
        $(#[$about:meta])*
        $function_vis:vis $function:ident;
    ) => {
        $(#[$meta])*
        pub enum $enum {
            $($(#[$doc])* $variant = $number,)*
        }

        impl $enum {
            $(#[$all])*
            $all_vis const ALL: [Self; [$($text),*].len()] = [$(Self::$variant),*];

            $(#[$about])*
            $function_vis const fn $function(self) -> &'static str {
                match self {
                    $(Self::$variant => $text,)*
                }
            }
        }
    };
}
pub(crate) use named;
