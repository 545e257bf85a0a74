//! Pins: arguments, constraints of a solve, and results.

use crate::face::baked::Shaped;
use anyhow::{Context, bail};
use nalgebra::{Matrix2, Matrix2x3, Vector2, Vector3};
use sinew_runtime::prior::Pin;

/// Projection of a position (x, y, z, 1) to a screen, two rows of four.
pub(super) type Projection = [[f64; 4]; 2];

/// Vertex, its target position, and its stiffness.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PinArgument {
    vertex: u32,
    /// Three coordinates, or two on a screen; `None` for a free coordinate.
    at: Vec<Option<f64>>,
    stiffness: f32,
}

/// Pin with its projection.
pub(super) struct Placed {
    pub(super) pin: Pin,
    projection: Option<Projection>,
    at: Vec<Option<f64>>,
}

/// Result of a pin.
pub(super) struct Followed {
    pub(super) vertex: usize,
    /// Whether every coordinate is free: the pin has no effect.
    pub(super) is_free: bool,
    /// Position, in the coordinates of the argument.
    pub(super) at: Vec<f64>,
    /// Target, in the coordinates of the argument.
    pub(super) target: Vec<f64>,
    /// Position and target in space.
    pub(super) places: ([f64; 3], [f64; 3]),
}

impl PinArgument {
    /// Makes a pin.
    ///
    /// - `vertex_len`: number of vertices of the face.
    /// - `projection`: returns the projection of pins on a screen.
    ///
    /// # Errors
    /// The face has no such vertex, or there is no projection.
    pub(super) fn place(
        &self,
        vertex_len: usize,
        projection: impl FnOnce() -> anyhow::Result<Projection>,
    ) -> anyhow::Result<Placed> {
        let Self { vertex, ref at, stiffness } = *self;
        if vertex as usize >= vertex_len {
            bail!("--pin {vertex}: expected a vertex from 0 to {}", vertex_len - 1);
        }
        let projection = if at.len() == 2 { Some(projection()?) } else { None };
        let keep = [0, 1, 2].map(|axis| at.get(axis).is_some_and(Option::is_some));
        let number = |axis: usize| at.get(axis).copied().flatten().unwrap_or_default();
        let pin = match &projection {
            None => Pin::new(vertex, [0, 1, 2].map(|axis| number(axis) as f32)),
            // Scaled to units of length, so that pins on the screen are as stiff as pins in space.
            Some(rows) => {
                let units = rows.map(|[x, y, z, _]| Vector3::new(x, y, z).norm());
                let row = |axis: usize| rows[axis].map(|x| (x / units[axis]) as f32);
                let target = [0, 1].map(|axis| (number(axis) / units[axis]) as f32);
                Pin::on_screen(vertex, [row(0), row(1)], target)
            }
        };
        let pin = pin.masked(keep).with_stiffness(stiffness);
        Ok(Placed { pin, projection, at: at.clone() })
    }
}

impl Placed {
    /// Makes a pin that holds a vertex in place.
    pub(super) fn hold(vertex: u32, place: [f64; 3]) -> Self {
        let pin = Pin::new(vertex, place.map(|x| x as f32));
        Self { pin, projection: None, at: place.map(Some).to_vec() }
    }

    /// Returns the result of the pin in a solved face.
    ///
    /// # Errors
    /// The face has no such vertex.
    pub(super) fn follow(&self, shaped: &Shaped) -> anyhow::Result<Followed> {
        let vertex = self.pin.vertex as usize;
        let place = *shaped.positions.get(vertex).context("the face has no such vertex")?;
        let at = match &self.projection {
            None => place.to_vec(),
            Some(rows) => rows.map(|row| projected(row, place)).to_vec(),
        };
        // The target of a free coordinate is its position.
        let target: Vec<f64> =
            self.at.iter().zip(&at).map(|(target, at)| target.unwrap_or(*at)).collect();
        let to = match (&self.projection, target.as_slice()) {
            (None, &[x, y, z]) => [x, y, z],
            (Some(rows), &[x, y]) => moved(*rows, place, [x - at[0], y - at[1]]),
            _ => place,
        };
        let is_free = self.at.iter().all(Option::is_none);
        Ok(Followed { vertex, is_free, at, target, places: (place, to) })
    }
}

impl Followed {
    /// Returns the distance between position and target.
    pub(super) fn missed(&self) -> f64 {
        self.at.iter().zip(&self.target).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    }
}

fn projected([a, b, c, d]: [f64; 4], [x, y, z]: [f64; 3]) -> f64 {
    a * x + b * y + c * z + d
}

/// Moves a position by the shortest way that moves its projection by `by`.
fn moved(rows: Projection, place: [f64; 3], by: [f64; 2]) -> [f64; 3] {
    let [[a, b, c, _], [d, e, f, _]] = rows;
    let rows = Matrix2x3::new(a, b, c, d, e, f);
    let inverse = Matrix2::from(rows * rows.transpose()).try_inverse().unwrap_or_default();
    let by = rows.transpose() * inverse * Vector2::from(by);
    [place[0] + by.x, place[1] + by.y, place[2] + by.z]
}

/// Parses a vertex, its target and its stiffness.
pub(super) fn pin(text: &str) -> Result<PinArgument, String> {
    let expected = || {
        "expected VERTEX=X,Y,Z, or VERTEX=X,Y on the screen, with _ for a free coordinate; and *STIFFNESS, above 0, \
         for a pin that counts more or less than others"
            .to_owned()
    };
    let (vertex, place) = text.split_once('=').ok_or_else(expected)?;
    let vertex = vertex.trim().parse().map_err(|_| expected())?;
    let (place, stiffness) = place.split_once('*').unwrap_or((place, "1"));
    let stiffness = stiffness.trim().parse().ok();
    let stiffness = stiffness.filter(|x: &f32| x.is_finite() && *x > 0.0).ok_or_else(expected)?;
    let number = |word: &str| match word.trim() {
        "_" => Ok(None),
        word => match word.parse::<f64>() {
            Ok(x) if (x as f32).is_finite() => Ok(Some(x)),
            _ => Err(expected()),
        },
    };
    let at = place.split(',').map(number).collect::<Result<Vec<_>, _>>()?;
    if !(2..=3).contains(&at.len()) {
        return Err(expected());
    }
    Ok(PinArgument { vertex, at, stiffness })
}

/// Parses a projection.
pub(super) fn projection(text: &str) -> Result<Projection, String> {
    let expected = || {
        "expected eight numbers, two rows of four; the first three of a row are not all 0"
            .to_owned()
    };
    let numbers = text.split(',').map(|word| word.trim().parse::<f64>());
    let numbers = numbers.collect::<Result<Vec<_>, _>>().map_err(|_| expected())?;
    let (&[first, second], []) = numbers.as_chunks::<4>() else { return Err(expected()) };
    let is_sound = |[x, y, z, w]: [f64; 4]| {
        let len = Vector3::new(x, y, z).norm();
        len > 0.0 && (len as f32).is_finite() && ((w / len) as f32).is_finite()
    };
    let rows = [first, second];
    if rows.into_iter().all(is_sound) { Ok(rows) } else { Err(expected()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pins_have_two_or_three_coordinates_and_a_stiffness() {
        let made = |vertex, at: &[Option<f64>], stiffness| {
            Ok(PinArgument { vertex, at: at.to_vec(), stiffness })
        };
        assert_eq!(pin("7=1,_,-3"), made(7, &[Some(1.0), None, Some(-3.0)], 1.0));
        assert_eq!(pin("7=1,2,3*0.25"), made(7, &[Some(1.0), Some(2.0), Some(3.0)], 0.25));
        assert_eq!(pin("0=5,_*2"), made(0, &[Some(5.0), None], 2.0));
        for text in ["7", "x=1,2,3", "7=1", "7=1,2,3,4", "7=1,2,inf", "7=1,2,3*0", "7=1,2,3*x"] {
            assert!(pin(text).is_err(), "{text}");
        }
    }

    #[test]
    fn a_projection_is_two_rows_with_a_direction() {
        assert_eq!(
            projection("1,0,0,5, 0,-2,0,3"),
            Ok([[1.0, 0.0, 0.0, 5.0], [0.0, -2.0, 0.0, 3.0]])
        );
        for text in ["1,0,0,5,0,-2,0", "0,0,0,5,0,1,0,0", "1,0,0,nan,0,1,0,0", "1,0,0,0,0,1,0,x"] {
            assert!(projection(text).is_err(), "{text}");
        }
    }

    #[test]
    fn a_move_on_the_screen_has_the_length_asked_for() {
        let rows = [[3.0, 0.0, 4.0, 1.0], [0.0, -2.0, 0.5, 0.0]];
        let place = [0.5, 1.0, -2.0];
        let found = moved(rows, place, [10.0, -1.0]);
        for (row, by) in rows.into_iter().zip([10.0, -1.0]) {
            assert!((projected(row, found) - projected(row, place) - by).abs() < 1e-12);
        }
    }
}
