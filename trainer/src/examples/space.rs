//! The space that examples are in, and how they are moved into another.

use super::mesh::Mesh;
use super::{Examples, Matrix3x4};
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use sinew_runtime::format::{Axis, Handedness, Space};

/// Metres that a unit of length may have, as in the file.
pub(super) const UNITS: std::ops::RangeInclusive<f32> = 1e-9..=1e9;

/// What is said of a space; what is not said stays as it is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpaceWish {
    /// Where a character's head is.
    pub up: Option<Axis>,
    /// Where a character looks.
    pub forward: Option<Axis>,
    /// The axes' handedness.
    pub handedness: Option<Handedness>,
    /// Metres of a unit of length.
    pub unit: Option<f32>,
}

/// A space that examples cannot be in, or cannot be moved into.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SpaceError {
    /// Two axes lie along one line.
    #[error(
        "up {} and forward {} lie along one line: give an up and a forward that are square to each \
         other",
        up.name(),
        forward.name()
    )]
    Parallel {
        /// Where a character's head is.
        up: Axis,
        /// Where it looks.
        forward: Axis,
    },
    /// A unit is no length.
    #[error("a unit of {metres} m: expected a length from 1e-9 to 1e9 m")]
    Unit {
        /// Its length.
        metres: f32,
    },
    /// Where an axis points is neither in the file nor said.
    #[error(
        "the file does not say which axis is {what}: say it with {flag} AXIS, as {flag} {like}"
    )]
    UnknownAxis {
        /// Up, or forward.
        what: &'static str,
        /// The option that says it.
        flag: &'static str,
        /// A value of it.
        like: &'static str,
    },
    /// The length of a unit is neither in the file nor said.
    #[error(
        "the file does not say how long its unit is: say it with --unit METRES, as --unit 0.01"
    )]
    UnknownUnit,
}

impl SpaceWish {
    /// Says what a space says.
    pub fn all_of(space: &Space) -> Self {
        let Space { up, forward, handedness, unit } = *space;
        Self { up, forward, handedness: Some(handedness), unit }
    }

    /// Whether nothing is said.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Says it of a space.
    ///
    /// # Errors
    /// [`SpaceError::Parallel`] and [`SpaceError::Unit`].
    pub fn of(&self, space: Space) -> Result<Space, SpaceError> {
        let (up, forward) = (self.up.or(space.up), self.forward.or(space.forward));
        if let (Some(up), Some(forward)) = (up, forward)
            && up.is_along(forward)
        {
            return Err(SpaceError::Parallel { up, forward });
        }
        if let Some(metres) = self.unit.filter(|unit| !UNITS.contains(unit)) {
            return Err(SpaceError::Unit { metres });
        }
        let handedness = self.handedness.unwrap_or(space.handedness);
        Ok(Space { up, forward, handedness, unit: self.unit.or(space.unit) })
    }
}

/// A change of axes and unit: `x' = scale axes x`, where the axes are those of the old space in
/// another order or sign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conversion {
    axes: Matrix3<f64>,
    scale: f64,
}

impl Conversion {
    /// Finds what leads from one space to what is asked for, and that space; no conversion where it is
    /// the same.
    ///
    /// # Errors
    /// Those of [`SpaceWish::of`]; [`SpaceError::UnknownAxis`] and [`SpaceError::UnknownUnit`] where
    /// axes or unit are asked for and not known of the space that it starts from.
    pub fn to(from: Space, wish: &SpaceWish) -> Result<(Space, Option<Self>), SpaceError> {
        let turns = wish.up.is_some()
            || wish.forward.is_some()
            || wish.handedness.is_some_and(|handedness| handedness != from.handedness);
        if turns {
            for (axis, what, flag, like) in
                [(from.up, "up", "--up", "y"), (from.forward, "forward", "--forward", "z")]
            {
                if axis.is_none() {
                    return Err(SpaceError::UnknownAxis { what, flag, like });
                }
            }
        }
        if wish.unit.is_some() && from.unit.is_none() {
            return Err(SpaceError::UnknownUnit);
        }
        let to = wish.of(from)?;
        Ok((to, Self::between(&from, &to)))
    }

    /// Finds what leads from one space to another, by what is known of both; `None` where they are
    /// the same as far as is known.
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

    /// Whether left and right change places.
    pub fn is_mirrored(&self) -> bool {
        self.axes.determinant() < 0.0
    }

    /// Returns the change of axes.
    pub fn axes(&self) -> Matrix3<f64> {
        self.axes
    }

    /// Returns the new units in an old one.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Converts a point.
    pub fn point(&self, x: [f64; 3]) -> [f64; 3] {
        (self.axes * Vector3::from(x) * self.scale).into()
    }

    /// Converts a direction.
    pub fn direction(&self, x: [f64; 3]) -> [f64; 3] {
        (self.axes * Vector3::from(x)).into()
    }

    /// Converts a transform: `S B S⁻¹`, S the change of axes and unit.
    pub fn transform(&self, b: &Matrix3x4) -> Matrix3x4 {
        let linear = Matrix3::from_fn(|row, column| b[row][column]);
        let linear = self.axes * linear * self.axes.transpose();
        let offset = self.point(b.map(|row| row[3]));
        std::array::from_fn(|r| [linear[(r, 0)], linear[(r, 1)], linear[(r, 2)], offset[r]])
    }

    /// Converts triangles: those of a mirrored mesh are turned over, so that normals stay outward.
    pub fn triangles(&self, triangles: &mut [[usize; 3]]) {
        if self.is_mirrored() {
            triangles.iter_mut().for_each(|[_, b, c]| std::mem::swap(b, c));
        }
    }

    /// Converts a mesh; texture coordinates stay.
    pub fn mesh(&self, mesh: &mut Mesh) {
        mesh.positions.iter_mut().for_each(|x| *x = self.point(*x));
        self.triangles(&mut mesh.triangles);
    }
}

impl Examples {
    /// Moves the examples into a space by what leads there; texture coordinates stay.
    pub fn convert(&mut self, conversion: &Conversion, space: Space) {
        self.rest.iter_mut().for_each(|x| *x = conversion.point(*x));
        self.vertices.par_iter_mut().for_each(|x| *x = conversion.point(*x));
        self.skeleton.rest.iter_mut().for_each(|frame| *frame = conversion.transform(frame));
        self.transforms.par_iter_mut().for_each(|b| *b = conversion.transform(b));
        conversion.triangles(&mut self.triangles);
        self.space = space;
    }

    /// Moves the examples into the space of a model, as far as both are known: where they are equal or
    /// nothing is known, nothing changes. Returns what was done, for meshes that come with them.
    pub fn convert_to(&mut self, space: &Space) -> Option<Conversion> {
        let conversion = Conversion::between(&self.space, space)?;
        self.convert(&conversion, *space);
        Some(conversion)
    }
}

/// Returns the directions of up, forward and the character's left; `None` where one is not known.
fn frame(space: &Space) -> Option<Matrix3<f64>> {
    let (up, forward) = (direction(space.up?), direction(space.forward?));
    let left = up.cross(&forward);
    let left = match space.handedness {
        Handedness::Right => left,
        Handedness::Left => -left,
    };
    Some(Matrix3::from_columns(&[up, forward, left]))
}

/// Returns the unit vector of a direction.
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

/// Finds the direction of a unit vector along an axis.
pub(super) fn axis(vector: &Vector3<f64>) -> Option<Axis> {
    Axis::ALL.into_iter().find(|&axis| (direction(axis) - vector).norm() < 1e-9)
}

/// Widens a unit to the decimal number that was meant: 0.01, not what single precision makes of it.
fn metres(unit: f32) -> f64 {
    unit.to_string().parse().unwrap_or(f64::from(unit))
}

#[cfg(test)]
mod tests {
    use super::super::testing::triangle;
    use super::*;

    const GLTF: Space = Space::GLTF;
    const UNREAL: Space = Space::UNREAL;
    const UNITY: Space = Space::UNITY;

    fn wish(space: Space) -> SpaceWish {
        SpaceWish::all_of(&space)
    }

    #[test]
    fn gltf_s_axes_become_those_of_engines() {
        let to = |space| Conversion::between(&GLTF, &space).unwrap();
        // glTF: x to the character's left, y up, z forward. Unity: x to its right. Unreal: x forward,
        // y to its right, z up, centimetres.
        assert_eq!(to(UNITY).point([1.0, 2.0, 3.0]), [-1.0, 2.0, 3.0]);
        assert_eq!(to(UNREAL).point([1.0, 2.0, 3.0]), [300.0, -100.0, 200.0]);
        let blender = Space { up: Some(Axis::Z), forward: Some(Axis::MinusY), ..GLTF };
        assert_eq!(to(blender).point([1.0, 2.0, 3.0]), [1.0, -3.0, 2.0]);
        assert!(to(UNITY).is_mirrored() && to(UNREAL).is_mirrored() && !to(blender).is_mirrored());
        assert_eq!(Conversion::to(GLTF, &wish(UNREAL)), Ok((UNREAL, Some(to(UNREAL)))));
    }

    #[test]
    fn a_transform_moves_a_converted_point_as_it_moved_the_point() {
        let quarter = [[0.0, -1.0, 0.0, 1.0], [1.0, 0.0, 0.0, 2.0], [0.0, 0.0, 1.0, 3.0]];
        let moved =
            |b: &Matrix3x4, x: [f64; 3]| b.map(|[a, b, c, d]| a * x[0] + b * x[1] + c * x[2] + d);
        let x = [0.5, -2.0, 4.0];
        for space in [UNITY, UNREAL] {
            let to = Conversion::between(&GLTF, &space).unwrap();
            let b = to.transform(&quarter);
            assert_eq!(moved(&b, to.point(x)), to.point(moved(&quarter, x)));
        }
        // A quarter turn about glTF's z, forward, from left to up is one about Unreal's x.
        let to = Conversion::between(&GLTF, &UNREAL).unwrap();
        let expected = [[1.0, 0.0, 0.0, 300.0], [0.0, 0.0, 1.0, -100.0], [0.0, -1.0, 0.0, 200.0]];
        assert_eq!(to.transform(&quarter), expected);
    }

    #[test]
    fn there_and_back_again_is_the_same() {
        let mut examples = triangle(2);
        examples.uv = Some(vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
        examples.vertices[4] = [0.5, -0.25, 0.125];
        examples.transforms[3][0][3] = 0.75;
        examples.space = GLTF;
        let before = examples.clone();
        for space in [UNITY, UNREAL] {
            let there = examples.convert_to(&space).unwrap();
            assert!(examples.space == space && there.is_mirrored());
            assert_eq!(examples.triangles, [[0, 2, 1]]);
            examples.validate().unwrap();
            // Normals and tangents go with the surface; a mirrored cross product turns the handedness.
            assert_eq!(
                examples.rest_normals(),
                before.rest_normals().iter().map(|n| there.direction(*n)).collect::<Vec<_>>()
            );
            let tangents = before.rest_tangents().unwrap().into_iter().map(|[x, y, z, hand]| {
                let [x, y, z] = there.direction([x, y, z]);
                [x, y, z, -hand]
            });
            assert_eq!(examples.rest_tangents().unwrap(), tangents.collect::<Vec<_>>());
            examples.convert_to(&GLTF).unwrap();
            assert_eq!(examples.rest, before.rest);
            assert_eq!(examples.vertices, before.vertices);
            assert_eq!(examples.transforms, before.transforms);
            assert_eq!(examples.skeleton.rest, before.skeleton.rest);
            assert_eq!(examples.triangles, before.triangles);
        }
        assert_eq!(examples.convert_to(&GLTF), None);
    }

    #[test]
    fn what_is_not_known_is_not_guessed() {
        let unknown = Space::default();
        assert_eq!(Conversion::between(&unknown, &UNREAL), None);
        assert_eq!(Conversion::between(&UNREAL, &unknown), None);
        let up_alone = Space { up: Some(Axis::Z), ..unknown };
        let to = |from, wish| Conversion::to(from, &wish).map(|(space, _)| space);
        let left = SpaceWish { handedness: Some(Handedness::Left), ..SpaceWish::default() };
        let error = |from, wish| to(from, wish).unwrap_err().to_string();
        assert!(error(unknown, wish(UNREAL)).contains("--up AXIS"));
        assert!(error(unknown, left).contains("--up AXIS"));
        assert!(error(up_alone, wish(UNREAL)).contains("--forward AXIS"));
        let no_unit = Space { unit: None, ..GLTF };
        assert!(error(no_unit, wish(UNREAL)).contains("--unit METRES"));
        // What is not asked for needs no knowledge.
        let right = SpaceWish { handedness: Some(Handedness::Right), ..SpaceWish::default() };
        assert_eq!(to(unknown, right), Ok(unknown));
        assert_eq!(to(GLTF, left), Ok(UNITY));
    }

    #[test]
    fn spaces_that_cannot_be_are_refused() {
        for (up, forward) in [(Axis::Z, Axis::Z), (Axis::Z, Axis::MinusZ), (Axis::MinusY, Axis::Y)]
        {
            let wish = SpaceWish { up: Some(up), forward: Some(forward), ..SpaceWish::default() };
            assert_eq!(wish.of(GLTF), Err(SpaceError::Parallel { up, forward }));
        }
        // What is said and what the file says may not agree.
        let wish = SpaceWish { up: Some(Axis::Z), ..SpaceWish::default() };
        assert!(matches!(wish.of(GLTF), Err(SpaceError::Parallel { .. })));
        for metres in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-10] {
            let wish = SpaceWish { unit: Some(metres), ..SpaceWish::default() };
            assert!(matches!(wish.of(GLTF), Err(SpaceError::Unit { .. })), "{metres}");
        }
    }
}
