//! Structures whose numbers have one type.

/// Implements the conversion between a structure and its section, which has the fields in their order.
macro_rules! flat {
    ($type:ident of $section:literal, $to:ident, $from:ident: [$number:ty; $len:literal] { $($field:ident),* }) => {
        impl $type {
            #[doc = concat!("Bytes of section `", $section, "`.")]
            #[cfg_attr(feature = "internals", visibility::make(pub))]
            pub(crate) const BYTES: usize = 4 * $len;

            #[doc = concat!("Lists the ", stringify!($to), " in the order of the file.")]
            #[cfg_attr(feature = "internals", visibility::make(pub))]
            pub(crate) const fn $to(&self) -> [$number; $len] {
                [$(self.$field),*]
            }

            #[doc = concat!("Makes the structure from ", stringify!($to), " in the order of the file.")]
            #[cfg_attr(feature = "internals", visibility::make(pub))]
            pub(crate) const fn $from([$($field),*]: [$number; $len]) -> Self {
                Self { $($field),* }
            }
        }
    };
}
pub(crate) use flat;
