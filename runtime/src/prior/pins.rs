//! Pins: targets for single vertices, and lists of pins.

use crate::error::{Argument, CallError, CallErrorKind};
use crate::linear::Matrix3x4;
use crate::skin::Skin;
use core::cmp::Ordering;
use heapless::Vec;

/// Target of a vertex, constrained in up to three directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pin {
    /// The vertex of the skin.
    pub vertex: u32,
    /// Rows that map the posed position x to a number: `row · (x, 1)`. A row whose first three
    /// numbers are 0 has no effect.
    pub rows: [[f32; 4]; 3],
    /// Target number of each row.
    pub target: [f32; 3],
    /// Weight against other pins and the prior; 1 is the prior's own tolerance.
    pub stiffness: f32,
}

impl Pin {
    /// Makes a pin of a full position, with stiffness 1.
    ///
    /// - `target`: in model space. The vertex's current place holds the vertex there:
    ///   [`crate::Skin::place`].
    pub const fn new(vertex: u32, target: [f32; 3]) -> Self {
        let rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        Self { vertex, rows, target, stiffness: 1.0 }
    }

    /// Makes a pin of a place on a screen, with stiffness 1.
    ///
    /// - `projection`: from a position to the screen, in units of the screen.
    /// - `target`: on the screen, without perspective division. For a camera with perspective give
    ///   rows `p_i - target_i p_w` and targets of 0.
    pub const fn on_screen(vertex: u32, projection: [[f32; 4]; 2], target: [f32; 2]) -> Self {
        let ([a, b], [x, y]) = (projection, target);
        Self { vertex, rows: [a, b, [0.0; 4]], target: [x, y, 0.0], stiffness: 1.0 }
    }

    /// Removes the rows of coordinates that stay free.
    pub const fn masked(mut self, keep: [bool; 3]) -> Self {
        let mut row = 0;
        while row < 3 {
            if !keep[row] {
                self.rows[row] = [0.0; 4];
            }
            row += 1;
        }
        self
    }

    /// Sets the stiffness.
    pub const fn with_stiffness(self, stiffness: f32) -> Self {
        Self { stiffness, ..self }
    }

    /// Lists the rows with an effect, each with its target.
    pub(super) fn active_rows(&self) -> impl Iterator<Item = ([f32; 4], f32)> {
        let all = self.rows.into_iter().zip(self.target);
        all.filter(|([x, y, z, _], _)| [*x, *y, *z] != [0.0; 3])
    }

    /// Orders pins, so that their rows have one order for any order of adding.
    fn order(&self, other: &Self) -> Ordering {
        let floats = |pin: &Self| {
            let [a, b, c] = pin.rows;
            let ([x, y, z], s) = (pin.target, pin.stiffness);
            [a, b, c, [s, x, y, z]]
        };
        let (own, others) = (floats(self), floats(other));
        let pairs = own.as_flattened().iter().zip(others.as_flattened());
        let by_floats = pairs.map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne());
        self.vertex.cmp(&other.vertex).then(by_floats.unwrap_or(Ordering::Equal))
    }
}

/// A list of at most N pins, in an order independent of the order of adding.
///
/// Several pins of one vertex act as one pin at the stiffness-weighted mean of their targets, by
/// least squares.
#[derive(Clone, Debug, Default)]
pub struct Pins<const N: usize>(Vec<Pin, N>);

/// The pins of a [`Pins`] list of any capacity.
#[derive(Clone, Copy, Debug)]
pub struct PinList<'a>(&'a [Pin]);

impl<const N: usize> Pins<N> {
    /// Makes an empty list.
    pub const fn new() -> Self {
        Self(Vec::new())
    }

    /// Adds a pin.
    ///
    /// # Errors
    /// - [`CallErrorKind::OutOfRange`]: the list is full, or the stiffness is negative; `expected`
    ///   is N in the first case and 0 in the second.
    /// - [`CallErrorKind::NonFinite`]: a number of the pin is not finite; the index is the pin's
    ///   vertex.
    pub fn add(&mut self, pin: Pin) -> Result<(), CallError> {
        let error = |kind| CallError::new(kind, Argument::Pins).at(pin.vertex as usize);
        let rows = pin.rows.as_flattened().iter();
        if !rows.chain(&pin.target).chain([&pin.stiffness]).all(|x| x.is_finite()) {
            return Err(error(CallErrorKind::NonFinite));
        }
        if pin.stiffness < 0.0 {
            return Err(error(CallErrorKind::OutOfRange));
        }
        let mut last = pin;
        if self.0.is_full() {
            return Err(error(CallErrorKind::OutOfRange).values(N, N + 1));
        }
        // Later pins move up by one place.
        for other in &mut self.0 {
            if other.order(&last).is_gt() {
                core::mem::swap(other, &mut last);
            }
        }
        self.0.push(last).map_err(|_| error(CallErrorKind::OutOfRange))
    }

    /// Removes all pins.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Returns the pins for a job.
    pub fn list(&self) -> PinList<'_> {
        PinList(&self.0)
    }
}

impl<'a> PinList<'a> {
    /// Lists the pins in order.
    pub fn iter(&self) -> core::slice::Iter<'a, Pin> {
        self.0.iter()
    }

    /// Counts the rows with an effect: the scalars of a solve.
    pub fn scalar_len(&self) -> usize {
        self.0.iter().map(|pin| pin.active_rows().count()).sum()
    }
}

/// A vertex as a function of the weights: `x = offset + sum z_s (image of delta s)`.
pub(super) struct Vertex {
    /// Rows of the vertex's blended transform.
    transform: [[f64; 4]; 3],
    rest: [f64; 3],
}

impl Skin<'_> {
    /// Returns the place of a vertex for given shape weights and palette; `None` if the vertex is
    /// not in the mesh.
    ///
    /// - `palette`: [`Skin::palette_len`] transforms.
    /// - `weights`: [`Skin::shape_len`] weights z; missing weights count as 0.
    pub fn place(&self, vertex: u32, palette: &[Matrix3x4], weights: &[f32]) -> Option<[f32; 3]> {
        let moving = Vertex::new(self, palette, vertex)?;
        let mut x = moving.rest;
        for (shape, delta) in self.deltas_of(vertex as usize) {
            let weight = weights.get(shape).copied().unwrap_or_default();
            x.iter_mut().zip(delta).for_each(|(x, u)| *x += f64::from(weight) * f64::from(u));
        }
        let [a, b, c] = x;
        Some(moving.transform.map(|[x, y, z, w]| (x * a + y * b + z * c + w) as f32))
    }
}

impl Vertex {
    pub(super) fn new(skin: &Skin<'_>, palette: &[Matrix3x4], vertex: u32) -> Option<Self> {
        let rest = skin.rest_position(vertex as usize)?.map(f64::from);
        let transform = skin.blended(palette, vertex as usize)?.map(|row| row.map(f64::from));
        Some(Self { transform, rest })
    }

    /// Applies a pin's row to the vertex. Returns the row's number at rest, and the coefficients
    /// that turn a delta into a change of the number.
    pub(super) fn apply_row(&self, row: [f32; 4]) -> (f64, [f64; 3]) {
        let [a, b, c, d] = row.map(f64::from);
        let [x, y, z] = self.transform;
        let along = |i: usize| a * at(x, i) + b * at(y, i) + c * at(z, i);
        let own = [along(0), along(1), along(2)];
        let [u, v, w] = own;
        let [r, s, t] = self.rest;
        (u * r + v * s + w * t + along(3) + d, own)
    }
}

fn at(row: [f64; 4], i: usize) -> f64 {
    row.get(i).copied().unwrap_or_default()
}

/// Returns the error of a pin with an infinite row.
pub(super) fn not_finite(pin: usize) -> CallError {
    CallError::new(CallErrorKind::NonFinite, Argument::Pins).at(pin)
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    #[test]
    fn the_order_of_adding_is_irrelevant() {
        let all = [
            Pin::new(7, [1.0, 2.0, 3.0]),
            Pin::new(2, [1.0, 2.0, 3.0]),
            Pin::new(7, [0.0, 2.0, 3.0]),
            Pin::new(7, [1.0, 2.0, 3.0]).with_stiffness(0.5),
            Pin::new(7, [1.0, 2.0, 3.0]).masked([true, false, true]),
        ];
        let list = |order: [usize; 5]| -> Vec<Pin> {
            let mut pins = Pins::<5>::new();
            order.iter().for_each(|at| pins.add(all[*at]).unwrap());
            pins.list().iter().copied().collect()
        };
        let first = list([0, 1, 2, 3, 4]);
        for order in [[4, 3, 2, 1, 0], [2, 0, 4, 1, 3], [3, 4, 0, 2, 1]] {
            assert_eq!(list(order), first);
        }
        assert_eq!(first.iter().map(|pin| pin.vertex).collect::<Vec<_>>(), [2, 7, 7, 7, 7]);
    }

    #[test]
    fn only_rows_with_an_effect_count() {
        let mut pins = Pins::<3>::new();
        pins.add(Pin::new(0, [0.0; 3])).unwrap();
        pins.add(Pin::new(1, [0.0; 3]).masked([false, true, false])).unwrap();
        pins.add(Pin::on_screen(2, [[1.0, 0.0, 0.0, 5.0], [0.0, 0.0, 0.0, 1.0]], [0.0; 2]))
            .unwrap();
        assert_eq!(pins.list().scalar_len(), 3 + 1 + 1);
    }

    #[test]
    fn an_invalid_pin_is_refused_and_not_added() {
        let mut pins = Pins::<1>::new();
        let refused = |pin, pins: &mut Pins<1>| {
            let error = pins.add(pin).unwrap_err();
            (error.kind, error.argument, error.index, error.expected)
        };
        let nan = CallErrorKind::NonFinite;
        let range = CallErrorKind::OutOfRange;
        assert_eq!(
            refused(Pin::new(3, [0.0, f32::NAN, 0.0]), &mut pins),
            (nan, Argument::Pins, 3, 0)
        );
        let stiff = Pin::new(3, [0.0; 3]);
        for (stiffness, kind) in [(f32::INFINITY, nan), (-1.0, range)] {
            let found = refused(stiff.with_stiffness(stiffness), &mut pins);
            assert_eq!(found, (kind, Argument::Pins, 3, 0));
        }
        assert_eq!(pins.list().iter().len(), 0);
        pins.add(stiff).unwrap();
        assert_eq!(refused(Pin::new(4, [0.0; 3]), &mut pins), (range, Argument::Pins, 4, 1));
        pins.clear();
        pins.add(stiff).unwrap();
    }
}
