//! Views and cameras of pictures.

use crate::numeric::columns::ends;
use crate::space::{cross, direction};
use nalgebra::Vector3;
use sinew_runtime::format::{Axis, Handedness};

/// A direction to look from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Axis that points up in the picture.
    pub up: Axis,
    /// Handedness of model space; a left-handed space is not shown mirrored.
    pub handedness: Handedness,
    /// Degrees about the up axis, counter-clockwise seen from above. At 0, the first axis that is not up points to the
    /// right (for x up, y points to the left); for a negative up axis it points to the other side.
    pub azimuth: f64,
    /// Degrees above the horizon.
    pub elevation: f64,
}

/// Width and height, in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Resolution {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

/// A parallel projection.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    /// Right, up and toward the eye, unit vectors of model space.
    pub axes: [Vector3<f64>; 3],
    /// Point at the middle of the picture, along right and up.
    pub centre: [f64; 2],
    /// Pixels per unit of length.
    pub scale: f64,
    /// Size of the picture, in pixels.
    pub size: Resolution,
}

/// Share of a picture that is left empty at each side.
const MARGIN: f64 = 0.03;

impl View {
    /// Returns the unit vectors right, up and toward the eye, at azimuth and elevation 0.
    fn frame(&self) -> [Vector3<f64>; 3] {
        let right = match self.up {
            Axis::X => -Vector3::y(),
            Axis::MinusX => Vector3::y(),
            Axis::Y | Axis::Z => Vector3::x(),
            Axis::MinusY | Axis::MinusZ => -Vector3::x(),
        };
        let up = direction(self.up);
        [right, up, cross(&right, &up, self.handedness)]
    }

    /// Returns the unit vectors right, up and toward the eye.
    pub fn axes(&self) -> [Vector3<f64>; 3] {
        let [right, up, toward] = self.frame();
        let (sin, cos) = libm::sincos(self.azimuth.to_radians());
        let [right, toward] = [cos * right - sin * toward, cos * toward + sin * right];
        let (sin, cos) = libm::sincos(self.elevation.to_radians());
        [right, cos * up - sin * toward, cos * toward + sin * up]
    }

    /// Returns the view that sees `positions` as this view sees `rest`: rotated about the up axis with the character.
    pub fn following(&self, rest: &[[f64; 3]], positions: &[[f64; 3]]) -> Self {
        let [right, _, toward] = self.frame();
        let flat = |all: &[[f64; 3]]| -> Vec<[f64; 2]> {
            let along =
                |p: &[f64; 3]| [Vector3::from(*p).dot(&toward), Vector3::from(*p).dot(&right)];
            let points: Vec<[f64; 2]> = all.iter().map(along).collect();
            let mean = [0, 1].map(|axis| {
                points.iter().map(|p| p[axis]).sum::<f64>() / points.len().max(1) as f64
            });
            points.iter().map(|p| [p[0] - mean[0], p[1] - mean[1]]).collect()
        };
        let (mut sin, mut cos) = (0.0, 0.0);
        for (a, b) in flat(rest).iter().zip(flat(positions)) {
            cos += a[0] * b[0] + a[1] * b[1];
            sin += a[0] * b[1] - a[1] * b[0];
        }
        Self { azimuth: self.azimuth + libm::atan2(sin, cos).to_degrees(), ..*self }
    }
}

impl Camera {
    /// Fits all positions into a picture of the given width. The height follows from the positions' extent, clamped
    /// between 0.5 and 1.4 widths.
    pub fn fit<'a>(
        view: &View,
        positions: impl IntoIterator<Item = &'a [f64; 3]>,
        width: usize,
    ) -> Self {
        let axes = view.axes();
        let positions = positions.into_iter().map(|position| Vector3::from(*position));
        let seen = positions.map(|x| [axes[0].dot(&x), axes[1].dot(&x)]).collect::<Vec<_>>();
        let sides = [0, 1].map(|axis| ends(seen.iter().map(|x| &x[axis])));
        let extent = sides.map(|[low, high]| (high - low).max(f64::MIN_POSITIVE));
        let room = 1.0 - 2.0 * MARGIN;
        let aspect = (extent[1] / extent[0]).clamp(0.5, 1.4);
        let height = (aspect * width as f64).round() as usize;
        let scale = room * (width as f64 / extent[0]).min(height as f64 / extent[1]);
        let centre = sides.map(|[low, high]| 0.5 * (low + high));
        Self { axes, centre, scale, size: Resolution { width, height } }
    }

    /// Looks at a point and the surroundings within `radius`.
    pub fn around(view: &View, point: &[f64; 3], radius: f64, size: Resolution) -> Self {
        let axes = view.axes();
        let centre = [0, 1].map(|axis| axes[axis].dot(&Vector3::from(*point)));
        let scale = 0.5 * size.width.min(size.height) as f64 / radius;
        Self { axes, centre, scale, size }
    }

    /// Returns the camera of the picture scaled by a factor.
    pub fn resized(&self, factor: f64) -> Self {
        let pixels = |count: usize| (count as f64 * factor).round().max(1.0) as usize;
        let Resolution { width, height } = self.size;
        let size = Resolution { width: pixels(width), height: pixels(height) };
        Self { scale: self.scale * size.width as f64 / width as f64, size, ..*self }
    }

    /// Returns a position's pixel, counted from the upper left, and its distance toward the eye.
    pub fn project(&self, position: &[f64; 3]) -> [f64; 3] {
        let [right, up, toward] = self.axes.map(|axis| axis.dot(&Vector3::from(*position)));
        let Resolution { width, height } = self.size;
        [
            0.5 * width as f64 + self.scale * (right - self.centre[0]),
            0.5 * height as f64 - self.scale * (up - self.centre[1]),
            toward,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRONT: View =
        View { up: Axis::Y, handedness: Handedness::Right, azimuth: 0.0, elevation: 0.0 };

    fn close(a: Vector3<f64>, b: Vector3<f64>) -> bool {
        (a - b).norm() < 1e-12
    }

    #[test]
    fn axes_are_right_handed_and_turn_as_documented() {
        let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
        for (up, expected) in [(Axis::X, [-y, x, z]), (Axis::Y, [x, y, z]), (Axis::Z, [x, z, -y])] {
            assert_eq!(View { up, ..FRONT }.axes(), expected);
        }
        // From the right of a character that looks along z: z points to the left.
        let [right, up, toward] = View { azimuth: 90.0, ..FRONT }.axes();
        assert!(close(right, -z) && close(up, y) && close(toward, x));
        let [right, up, toward] = View { elevation: 90.0, ..FRONT }.axes();
        assert!(close(right, x) && close(up, -z) && close(toward, y));
    }

    #[test]
    fn a_left_handed_space_is_shown_as_its_mirror_image_is() {
        let positions = [[0.5, 2.0, -1.0], [-1.5, 0.25, 3.0]];
        let view = View { azimuth: 35.0, elevation: 20.0, ..FRONT };
        let other = View { handedness: Handedness::Left, ..view };
        // Mirrors z. Up stays, so right stays too.
        let mirrored = positions.map(|[x, y, z]| [x, y, -z]);
        let seen = |view: &View, all: &[[f64; 3]; 2]| {
            let camera = Camera::fit(view, all, 100);
            all.map(|position| camera.project(&position))
        };
        for (a, b) in seen(&view, &positions).iter().zip(seen(&other, &mirrored)) {
            assert!((Vector3::from(*a) - Vector3::from(b)).norm() < 1e-9, "{a:?} {b:?}");
        }
        for up in Axis::ALL {
            let [right, above, toward] = View { up, ..FRONT }.axes();
            assert!(close(right.cross(&above), toward) && close(above, direction(up)));
        }
    }

    #[test]
    fn a_fitted_picture_holds_every_position_and_touches_its_margins() {
        let positions = [[0.0, 0.0, 0.0], [2.0, 3.0, -1.0], [1.0, -4.0, 9.0], [-3.0, 1.0, 2.0]];
        let view = View { up: Axis::Z, azimuth: 30.0, elevation: 20.0, ..FRONT };
        let camera = Camera::fit(&view, &positions, 200);
        let seen = positions.map(|position| camera.project(&position));
        let Resolution { width, height } = camera.size;
        let ends = |axis: usize, len: usize| {
            let along = seen.map(|pixel| pixel[axis] / len as f64);
            let low = along.iter().copied().fold(f64::INFINITY, f64::min);
            (low, along.iter().copied().fold(0.0, f64::max))
        };
        let [(left, right), (top, foot)] = [ends(0, width), ends(1, height)];
        assert!(left.min(top) > MARGIN - 1e-9 && right.max(foot) < 1.0 - MARGIN + 1e-9);
        assert!((left.min(top) - MARGIN).abs() < 1e-9, "{left} {top}");
        assert!((left + right - 1.0).abs() < 1e-9 && (top + foot - 1.0).abs() < 1e-9);
        let twice = camera.resized(2.0).project(&positions[1]);
        assert!((twice[0] - 2.0 * seen[1][0]).abs() < 1e-9);
    }

    #[test]
    fn the_view_turns_with_the_character() {
        let rest: Vec<[f64; 3]> = (0..20)
            .map(|k| [f64::from(k).sin(), f64::from(k).cos() * 0.3, f64::from(k * k).sin()])
            .collect();
        for (up, axis) in [(Axis::Y, Vector3::y_axis()), (Axis::Z, Vector3::z_axis())] {
            let turn = nalgebra::Rotation3::from_axis_angle(&axis, 40_f64.to_radians());
            let moved: Vec<[f64; 3]> = rest
                .iter()
                .map(|p| (turn * Vector3::from(*p) + Vector3::new(5.0, -2.0, 1.0)).into())
                .collect();
            let view = View { up, azimuth: 10.0, elevation: 5.0, ..FRONT };
            let following = view.following(&rest, &moved);
            assert!((following.azimuth - 50.0).abs() < 1e-9, "{following:?}");
            // Both pictures agree up to an offset.
            let [rest, moved] = [(&view, &rest), (&following, &moved)].map(|(view, p)| {
                let camera = Camera::fit(view, p, 100);
                p.iter().map(|p| camera.project(p)).collect::<Vec<_>>()
            });
            for (a, b) in rest.iter().zip(&moved) {
                assert!((a[0] - b[0]).abs() < 1e-9 && (a[1] - b[1]).abs() < 1e-9);
            }
        }
    }
}
