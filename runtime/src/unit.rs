//! Processors without vector units compute with one float at a time.

use crate::lanes::{Lanes, Unit};

/// The vector units of the processor: none.
#[derive(Clone, Copy)]
pub(crate) struct Level;

pub(crate) fn level() -> Level {
    Level
}

/// Computes an expression with the units of a level.
macro_rules! by_unit {
    ($level:expr, $unit:ident => $result:expr) => {{
        let $unit: $crate::unit::Level = $level;
        $result
    }};
}
pub(crate) use by_unit;

impl Unit for Level {
    type Real = f32;

    #[inline]
    fn read(self, le: &[[u8; 4]; 8]) -> Lanes<Self> {
        le.map(f32::from_le_bytes)
    }

    #[inline(always)]
    fn load(self, floats: &[f32; 8]) -> Lanes<Self> {
        *floats
    }

    #[inline(always)]
    fn floats(self, lanes: Lanes<Self>) -> [f32; 8] {
        lanes
    }
}
