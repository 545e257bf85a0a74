//! Axes, handedness and unit of a space: requests for them, and the conversion from one space to another. Tools disagree
//! about them: y or z up, x to the left or to the right.

use crate::Error;
use nalgebra::{Matrix3, Vector3};
use sinew_runtime::format::{Axis, Handedness, Space};
use std::fmt;
use std::str::FromStr;

/// Allowed lengths of a unit, in metres, as in the file.
pub(crate) const UNITS: std::ops::RangeInclusive<f32> = 1e-9..=1e9;

/// Likely ratios between the units of two files: powers of ten and inches, 1 first.
pub(crate) const SCALES: [f64; 11] =
    [1.0, 0.01, 100.0, 0.1, 10.0, 0.001, 1000.0, 0.0254, 1.0 / 0.0254, 2.54, 1.0 / 2.54];

/// A request for a space; `None` keeps the present value.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpaceRequest {
    /// Direction of a character's head.
    pub up: Option<Axis>,
    /// Direction in which a character looks.
    pub forward: Option<Axis>,
    /// Handedness of the axes.
    pub handedness: Option<Handedness>,
    /// Length of a unit, in metres.
    pub unit: Option<f32>,
}

impl SpaceRequest {
    /// Requests everything that a space states.
    pub fn all_of(space: &Space) -> Self {
        let Space { up, forward, handedness, unit } = *space;
        Self { up, forward, handedness: Some(handedness), unit }
    }

    /// Whether the request asks for nothing.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Applies the request to a space.
    ///
    /// # Errors
    /// Up and forward lie along one line, or the unit is not a length.
    pub fn of(&self, space: Space) -> Result<Space, Error> {
        let (up, forward) = (self.up.or(space.up), self.forward.or(space.forward));
        if let (Some(up), Some(forward)) = (up, forward)
            && up.is_along(forward)
        {
            return Err(Error::value(format!(
                "up {} and forward {} lie along one line: give an up and a forward that are square \
                 to each other",
                up.name(),
                forward.name()
            )));
        }
        if let Some(metres) = self.unit.filter(|unit| !UNITS.contains(unit)) {
            return Err(Error::value(format!(
                "a unit of {metres} m: expected a length from 1e-9 to 1e9 m"
            )));
        }
        let handedness = self.handedness.unwrap_or(space.handedness);
        Ok(Space { up, forward, handedness, unit: self.unit.or(space.unit) })
    }
}

/// A change of axes and unit: `x' = scale axes x`. The matrix permutes the old axes and may flip their signs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conversion {
    /// Change of axes: a signed permutation.
    pub axes: Matrix3<f64>,
    /// New units in an old unit.
    pub scale: f64,
}

impl Conversion {
    /// Returns the requested space and the conversion to it; no conversion if nothing changes.
    ///
    /// # Errors
    /// - Those of [`SpaceRequest::of`].
    /// - [`ErrorKind::Missing`](crate::ErrorKind::Missing): the request changes axes or unit, and the starting space
    ///   does not say its own.
    pub fn to(from: Space, request: &SpaceRequest) -> Result<(Space, Option<Self>), Error> {
        let turns = request.up.is_some()
            || request.forward.is_some()
            || request.handedness.is_some_and(|handedness| handedness != from.handedness);
        if turns {
            for (axis, what, flag, like) in
                [(from.up, "up", "--up", "y"), (from.forward, "forward", "--forward", "z")]
            {
                if axis.is_none() {
                    return Err(Error::missing(format!(
                        "the file does not say which axis is {what}: say it with {flag} AXIS, as \
                         {flag} {like}"
                    )));
                }
            }
        }
        if request.unit.is_some() && from.unit.is_none() {
            return Err(Error::missing(
                "the file does not say how long its unit is: say it with --unit METRES, as --unit \
                 0.01",
            ));
        }
        let to = request.of(from)?;
        Ok((to, Self::between(&from, &to)))
    }

    /// Returns the conversion between two spaces; `None` if they agree in every axis and unit that both state.
    pub fn between(from: &Space, to: &Space) -> Option<Self> {
        let axes = match (frame(from), frame(to)) {
            (Some(from), Some(to)) => to * from.transpose(),
            _ => Matrix3::identity(),
        };
        let scale = match (from.unit, to.unit) {
            (Some(from), Some(to)) if from != to => metres(from) / metres(to),
            _ => 1.0,
        };
        let conversion = Self { axes, scale };
        (conversion != Self { axes: Matrix3::identity(), scale: 1.0 }).then_some(conversion)
    }

    /// Whether the conversion swaps left and right.
    pub fn is_mirrored(&self) -> bool {
        self.axes.determinant() < 0.0
    }

    /// Converts a point.
    pub fn point(&self, x: [f64; 3]) -> [f64; 3] {
        (self.axes * Vector3::from(x) * self.scale).into()
    }

    /// Converts a direction.
    pub fn direction(&self, x: [f64; 3]) -> [f64; 3] {
        (self.axes * Vector3::from(x)).into()
    }

    /// Converts a 3x4 transform: `S B S⁻¹`, with S the change of axes and unit.
    pub fn transform(&self, b: &[[f64; 4]; 3]) -> [[f64; 4]; 3] {
        let linear = Matrix3::from_fn(|row, column| b[row][column]);
        let linear = self.axes * linear * self.axes.transpose();
        let offset = self.point(b.map(|row| row[3]));
        std::array::from_fn(|r| [linear[(r, 0)], linear[(r, 1)], linear[(r, 2)], offset[r]])
    }

    /// Converts triangles. Those of a mirrored mesh change their winding, so that normals stay outward.
    pub fn triangles(&self, triangles: &mut [[usize; 3]]) {
        if self.is_mirrored() {
            triangles.iter_mut().for_each(|[_, b, c]| std::mem::swap(b, c));
        }
    }
}

impl FromStr for Conversion {
    type Err = &'static str;

    /// Parses the form of [`Display`](fmt::Display), as in `(x, -z, y) x 0.01`; brackets and commas are optional.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let expected = "expected where x, y and z come from, and a scale, as \"(x, -z, y) x 0.01\"";
        let words = text.split(|c: char| c.is_whitespace() || "(),".contains(c));
        let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
        let (own, scale) = words.split_at_checked(3).ok_or(expected)?;
        let scale = match &*scale.concat() {
            "" => 1.0,
            scale => scale.strip_prefix('x').unwrap_or(scale).parse().map_err(|_| expected)?,
        };
        let named = |word: &&str| Axis::ALL.into_iter().find(|axis| axis.name() == *word);
        let rows: Vec<_> = own.iter().filter_map(named).map(direction).collect();
        let [x, y, z] = rows[..] else { return Err(expected) };
        let axes = Matrix3::from_columns(&[x, y, z]).transpose();
        let is_sound = axes.determinant().abs() > 0.5 && f64::is_normal(scale) && scale > 0.0;
        is_sound.then_some(Self { axes, scale }).ok_or(expected)
    }
}

impl serde::Serialize for Conversion {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl fmt::Display for Conversion {
    /// Writes the old axis that each new axis comes from, as in `(x, -z, y) x 0.01`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&axis_names(&self.axes))?;
        if self.scale == 1.0 { Ok(()) } else { write!(f, " x {}", self.scale) }
    }
}

/// Widens a unit to the decimal number its author wrote: exactly 0.01, rather than the nearest `f32`.
fn metres(unit: f32) -> f64 {
    unit.to_string().parse().unwrap_or(f64::from(unit))
}

/// Lists the 24 rotations that map axes to axes, the identity first.
pub(crate) fn rotations() -> impl Iterator<Item = Matrix3<f64>> {
    const ORDERS: [[usize; 3]; 6] =
        [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
    let signed = ORDERS.into_iter().flat_map(|order| (0..8).map(move |signs| (order, signs)));
    let matrices = signed.map(|(order, signs)| {
        Matrix3::from_fn(|row, column| match order[row] == column {
            false => 0.0,
            true if signs >> row & 1 == 1 => -1.0,
            true => 1.0,
        })
    });
    matrices.filter(|turn| turn.determinant() > 0.0)
}

/// Names the old axes that become x, y and z, as in `(x, -z, y)`.
pub(crate) fn axis_names(turn: &Matrix3<f64>) -> String {
    let name = |row: usize| {
        let axis = turn.row(row).transpose().iamax();
        let sign = if turn[(row, axis)] < 0.0 { "-" } else { "" };
        format!("{sign}{}", ["x", "y", "z"][axis])
    };
    format!("({}, {}, {})", name(0), name(1), name(2))
}

/// Returns the unit vector of an axis.
pub(crate) fn direction(axis: Axis) -> Vector3<f64> {
    match axis {
        Axis::X => Vector3::x(),
        Axis::MinusX => -Vector3::x(),
        Axis::Y => Vector3::y(),
        Axis::MinusY => -Vector3::y(),
        Axis::Z => Vector3::z(),
        Axis::MinusZ => -Vector3::z(),
    }
}

/// Returns the axis that a unit vector lies along; `None` if the vector lies along no axis.
pub(crate) fn axis(vector: &Vector3<f64>) -> Option<Axis> {
    Axis::ALL.into_iter().find(|&axis| (direction(axis) - vector).norm() < 1e-9)
}

/// Returns the directions of up, forward and the character's left; `None` if the space does not state them.
fn frame(space: &Space) -> Option<Matrix3<f64>> {
    let (up, forward) = (direction(space.up?), direction(space.forward?));
    Some(Matrix3::from_columns(&[up, forward, cross(&up, &forward, space.handedness)]))
}

/// Returns the cross product of two directions; by the left-hand rule in a left-handed space.
pub(crate) fn cross(a: &Vector3<f64>, b: &Vector3<f64>, handedness: Handedness) -> Vector3<f64> {
    match handedness {
        Handedness::Right => a.cross(b),
        Handedness::Left => -a.cross(b),
    }
}

/// Returns the length of a unit in millimetres; `None` if the unit is not known.
pub fn millimetres(space: &Space) -> Option<f64> {
    space.unit.map(|unit| 1000.0 * metres(unit))
}

/// Formats a length in millimetres, without the unit: to the micrometre, or with an exponent from a kilometre on.
pub fn written(millimetres: f64) -> String {
    if millimetres < 1e6 { format!("{millimetres:.3}") } else { format!("{millimetres:.2e}") }
}

/// Formats ` (1.234 mm)` to stand behind a percentage of the diagonal; empty if the diagonal is not known.
pub fn beside(percent: f64, diagonal_mm: Option<f64>) -> String {
    let length = diagonal_mm.map(|diagonal| written(percent / 100.0 * diagonal));
    length.map_or(String::new(), |length| format!(" ({length} mm)"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_is_the_decimal_number_that_was_meant() {
        let of = |unit| millimetres(&Space { unit, ..Space::default() });
        assert_eq!([of(Some(1.0)), of(Some(0.01)), of(None)], [Some(1000.0), Some(10.0), None]);
    }

    #[test]
    fn a_length_takes_few_digits() {
        assert_eq!(
            [0.0, 0.01234, 999_999.0, 1e30].map(written),
            ["0.000", "0.012", "999999.000", "1.00e30"]
        );
        assert_eq!(beside(0.5, Some(2000.0)), " (10.000 mm)");
        assert_eq!(beside(0.5, None), "");
    }

    const GLTF: Space = Space::GLTF;
    const UNREAL: Space = Space::UNREAL;
    const UNITY: Space = Space::UNITY;

    fn request(space: Space) -> SpaceRequest {
        SpaceRequest::all_of(&space)
    }

    #[test]
    fn contradictory_spaces_are_refused() {
        for (up, forward) in [(Axis::Z, Axis::Z), (Axis::Z, Axis::MinusZ), (Axis::MinusY, Axis::Y)]
        {
            let request =
                SpaceRequest { up: Some(up), forward: Some(forward), ..SpaceRequest::default() };
            let expected = format!(
                "up {} and forward {} lie along one line: give an up and a forward that are \
                 square to each other",
                up.name(),
                forward.name()
            );
            assert_eq!(request.of(GLTF).unwrap_err().message(), expected);
        }
        // The request and the file may contradict each other.
        let request = SpaceRequest { up: Some(Axis::Z), ..SpaceRequest::default() };
        let error = request.of(GLTF).unwrap_err();
        assert!(error.message().contains("lie along one line"), "{error}");
        for metres in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-10] {
            let request = SpaceRequest { unit: Some(metres), ..SpaceRequest::default() };
            let error = request.of(GLTF).unwrap_err();
            assert!(error.message().contains("expected a length from 1e-9 to 1e9 m"), "{error}");
        }
    }

    #[test]
    fn gltf_s_axes_become_those_of_engines() {
        let to = |space| Conversion::between(&GLTF, &space).unwrap();
        // glTF: x to the character's left, y up, z forward. Unity: x to its right. Unreal: x forward, y to its right, z
        // up, centimetres.
        assert_eq!(to(UNITY).point([1.0, 2.0, 3.0]), [-1.0, 2.0, 3.0]);
        assert_eq!(to(UNREAL).point([1.0, 2.0, 3.0]), [300.0, -100.0, 200.0]);
        let blender = Space { up: Some(Axis::Z), forward: Some(Axis::MinusY), ..GLTF };
        assert_eq!(to(blender).point([1.0, 2.0, 3.0]), [1.0, -3.0, 2.0]);
        assert!(to(UNITY).is_mirrored() && to(UNREAL).is_mirrored() && !to(blender).is_mirrored());
        let found = Conversion::to(GLTF, &request(UNREAL)).unwrap();
        assert_eq!(found, (UNREAL, Some(to(UNREAL))));
    }

    #[test]
    fn a_conversion_is_read_with_and_without_spaces_and_punctuation() {
        let expected = "(x, -z, y) x 0.01".parse::<Conversion>().unwrap();
        assert_eq!(expected.point([1.0, 2.0, 3.0]), [0.01, -0.03, 0.02]);
        for text in [
            "(x,-z,y)x0.01",
            "(x,-z,y) x0.01",
            "( x , -z , y )x 0.01",
            "x -z y 0.01",
            "x,-z,y,x,1e-2",
        ] {
            assert_eq!(text.parse(), Ok(expected), "{text}");
        }
        for text in ["(x,-z,y)", "(x,-z,y)x1", "x -z y"] {
            assert_eq!(text.parse::<Conversion>().unwrap().scale, 1.0, "{text}");
        }
        for text in ["", "(x,y)", "(x,x,z)", "(x,y,z) x", "(x,y,z) x 0", "(x,y,z) 1 2 x", "(x,y,w)"]
        {
            assert!(text.parse::<Conversion>().is_err(), "{text}");
        }
    }

    #[test]
    fn a_transform_moves_a_converted_point_as_it_moved_the_point() {
        let quarter = [[0.0, -1.0, 0.0, 1.0], [1.0, 0.0, 0.0, 2.0], [0.0, 0.0, 1.0, 3.0]];
        let moved = |b: &[[f64; 4]; 3], x: [f64; 3]| {
            b.map(|[a, b, c, d]| a * x[0] + b * x[1] + c * x[2] + d)
        };
        let x = [0.5, -2.0, 4.0];
        for space in [UNITY, UNREAL] {
            let to = Conversion::between(&GLTF, &space).unwrap();
            let b = to.transform(&quarter);
            assert_eq!(moved(&b, to.point(x)), to.point(moved(&quarter, x)));
        }
        // A quarter turn about glTF's z (forward), from left to up, is a quarter turn about Unreal's x.
        let to = Conversion::between(&GLTF, &UNREAL).unwrap();
        let expected = [[1.0, 0.0, 0.0, 300.0], [0.0, 0.0, 1.0, -100.0], [0.0, -1.0, 0.0, 200.0]];
        assert_eq!(to.transform(&quarter), expected);
    }

    #[test]
    fn unknown_axes_and_units_are_not_guessed() {
        let unknown = Space::default();
        assert_eq!(Conversion::between(&unknown, &UNREAL), None);
        assert_eq!(Conversion::between(&UNREAL, &unknown), None);
        let up_alone = Space { up: Some(Axis::Z), ..unknown };
        let to = |from, request| Conversion::to(from, &request).map(|(space, _)| space);
        let left = SpaceRequest { handedness: Some(Handedness::Left), ..SpaceRequest::default() };
        let error = |from, request| to(from, request).unwrap_err().to_string();
        assert!(error(unknown, request(UNREAL)).contains("--up AXIS"));
        assert!(error(unknown, left).contains("--up AXIS"));
        assert!(error(up_alone, request(UNREAL)).contains("--forward AXIS"));
        let no_unit = Space { unit: None, ..GLTF };
        assert!(error(no_unit, request(UNREAL)).contains("--unit METRES"));
        // A request without axes or unit works from an unknown space.
        let right = SpaceRequest { handedness: Some(Handedness::Right), ..SpaceRequest::default() };
        assert_eq!(to(unknown, right).unwrap(), unknown);
        assert_eq!(to(GLTF, left).unwrap(), UNITY);
    }

    #[test]
    fn there_are_24_rotations_with_24_names() {
        let mut all: Vec<String> = rotations().map(|turn| axis_names(&turn)).collect();
        assert_eq!(all[0], "(x, y, z)");
        all.sort();
        all.dedup();
        assert_eq!(all.len(), 24);
    }
}
