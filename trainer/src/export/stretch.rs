//! Linear maps as a rotation, a stretch along three axes, and a rotation back. Scene nodes can hold these parts.

use super::skeleton::turned;
use nalgebra::{Matrix3, Vector3};

/// Cosine of the angle between two columns below which they count as orthogonal. If axes followed the rounding of
/// single precision, they would spin between keys.
const ORTHOGONAL: f64 = 1e-6;
/// Weight of a squared change of the factors, against a squared change of the rotation. The weight is so large that
/// factors change sign together only if both are small.
const FACTOR: f64 = 16.0;
/// Sweeps of Jacobi rotations; six are enough.
const SWEEPS: usize = 20;

/// A linear map as `turn · diag(scale) · axesᵀ`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stretch {
    /// A rotation.
    pub(super) turn: Matrix3<f64>,
    /// Factors along the axes; an odd number is negative if the map mirrors.
    pub(super) scale: Vector3<f64>,
    /// A rotation; its columns are the axes of the stretch.
    pub(super) axes: Matrix3<f64>,
}

impl Stretch {
    /// Interpolates two maps like nodes between two keys: rotations and factors change evenly.
    pub(super) fn between([from, to]: &[Matrix3<f64>; 2], part: f64) -> Matrix3<f64> {
        let a = Self::of(from, None);
        let b = Self::of(to, Some(&a));
        let turn = |a: &Matrix3<f64>, b: &Matrix3<f64>| {
            let (a, b) = (turned(a), turned(b));
            a.try_slerp(&b, part, 1e-12).unwrap_or(a).to_rotation_matrix().into_inner()
        };
        let scale = Matrix3::from_diagonal(&a.scale.lerp(&b.scale, part));
        turn(&a.turn, &b.turn) * scale * turn(&a.axes, &b.axes).transpose()
    }

    /// Splits a map. Its axes are as near as possible to those of the map before, so that the interpolation between two
    /// keys is near both.
    ///
    /// One-sided Jacobi rotations make the map's columns along the axes orthogonal. Each rotates by at most 45 degrees,
    /// so that an axis keeps its index. A mirroring map mirrors along its shortest axis, and later maps along the same
    /// axis.
    pub(super) fn of(map: &Matrix3<f64>, before: Option<&Self>) -> Self {
        let mut axes = before.map_or(Matrix3::identity(), |before| before.axes);
        let mut moved = map * axes;
        for _ in 0..SWEEPS {
            let mut turned = false;
            for (p, q) in [(0, 1), (0, 2), (1, 2)] {
                turned |= orthogonalise(&mut moved, &mut axes, p, q);
            }
            if !turned {
                break;
            }
        }
        let turn = rotation(&moved);
        let scale = Vector3::from_fn(|k, _| turn.column(k).dot(&moved.column(k)));
        // Two axes may change sign together with their factors: the map is the same.
        let signs = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
        signs
            .map(Vector3::from)
            .map(|signs| Self {
                turn: turn * Matrix3::from_diagonal(&signs),
                scale: scale.component_mul(&signs),
                axes,
            })
            .into_iter()
            .min_by(|a, b| a.change(before).total_cmp(&b.change(before)))
            .unwrap_or(Self { turn, scale, axes })
    }

    /// Measures the distance of rotation and factors from those before; without a map before, the distance of the
    /// factors from 1.
    fn change(&self, before: Option<&Self>) -> f64 {
        let turned = before.map_or(0.0, |before| (self.turn - before.turn).norm_squared());
        let factors = before.map_or(Vector3::repeat(1.0), |before| before.scale);
        turned + FACTOR * (self.scale - factors).norm_squared()
    }
}

/// Rotates the axes p and q in their plane until their images are orthogonal. Returns whether the images were not
/// orthogonal.
fn orthogonalise(moved: &mut Matrix3<f64>, axes: &mut Matrix3<f64>, p: usize, q: usize) -> bool {
    let (a, b) = (moved.column(p).norm_squared(), moved.column(q).norm_squared());
    let product = moved.column(p).dot(&moved.column(q));
    if product.abs() <= ORTHOGONAL * (a * b).sqrt() {
        return false;
    }
    let cotangent = (b - a) / (2.0 * product);
    let tangent = cotangent.signum() / (cotangent.abs() + cotangent.hypot(1.0));
    let cosine = 1.0 / tangent.hypot(1.0);
    let sine = tangent * cosine;
    for m in [moved, axes] {
        let (x, y) = (m.column(p).into_owned(), m.column(q).into_owned());
        m.set_column(p, &(x * cosine - y * sine));
        m.set_column(q, &(x * sine + y * cosine));
    }
    true
}

/// Returns the rotation whose columns point along nearly orthogonal columns. The longest is exact. The shortest is
/// right-handed, so it points against its column if the map mirrors.
fn rotation(columns: &Matrix3<f64>) -> Matrix3<f64> {
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| columns.column(b).norm().total_cmp(&columns.column(a).norm()));
    let [long, middle, short] = order;
    let first = columns.column(long).try_normalize(0.0).unwrap_or(Vector3::ith(long, 1.0));
    let across = columns.column(middle) - first * first.dot(&columns.column(middle));
    let least = 1e-12 * columns.column(long).norm();
    let second = across
        .try_normalize(least)
        .unwrap_or_else(|| first.cross(&Vector3::ith(first.iamin(), 1.0)).normalize());
    let right_handed = (middle + 3 - long) % 3 == 1;
    let third = first.cross(&second) * if right_handed { 1.0 } else { -1.0 };
    let mut rotation = Matrix3::zeros();
    rotation.set_column(long, &first);
    rotation.set_column(middle, &second);
    rotation.set_column(short, &third);
    rotation
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::so3::{exp, polar};
    use rand::{RngExt, SeedableRng};

    fn whole(s: &Stretch) -> Matrix3<f64> {
        s.turn * Matrix3::from_diagonal(&s.scale) * s.axes.transpose()
    }

    fn is_rotation(m: &Matrix3<f64>) -> bool {
        (m.transpose() * m - Matrix3::identity()).amax() < 1e-12 && m.determinant() > 0.0
    }

    #[test]
    fn any_map_is_reproduced_even_if_it_mirrors_or_collapses() {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let mut before: Option<Stretch> = None;
        for round in 0..500 {
            let mut map = Matrix3::from_fn(|_, _| random.random_range(-2.0..2.0));
            let plane = map.column(0) + map.column(1);
            match round % 5 {
                1 => map.set_column(2, &plane),
                2 => map = map.column(0) * map.row(0),
                3 => map = exp(&map.column(0).into_owned()),
                _ => {}
            }
            if round == 499 {
                map = Matrix3::zeros();
            }
            let found = Stretch::of(&map, before.as_ref());
            assert!((whole(&found) - map).amax() < 1e-5, "{round}: {map}");
            assert!(is_rotation(&found.turn) && is_rotation(&found.axes), "{round}");
            before = Some(found);
        }
    }

    #[test]
    fn the_axes_of_a_rotation_are_the_identity() {
        let turn = exp(&Vector3::new(0.4, -1.3, 0.8));
        let noise = Matrix3::from_fn(|r, c| 1e-7 * (r as f64 - c as f64));
        let found = Stretch::of(&(turn + noise), None);
        assert_eq!(found.axes, Matrix3::identity());
        assert!((found.turn - turn).amax() < 1e-6);
        assert!((found.scale - Vector3::repeat(1.0)).amax() < 1e-6);
    }

    #[test]
    fn the_turn_back_and_the_turn_compose_to_the_polar_rotation() {
        let stretch = Matrix3::new(1.3, 0.2, 0.0, 0.2, 0.8, -0.1, 0.0, -0.1, 1.1);
        let map = exp(&Vector3::new(1.0, 0.2, -0.5)) * stretch;
        let found = Stretch::of(&map, None);
        let (rotation, _) = polar(&map).unwrap();
        assert!((found.turn * found.axes.transpose() - rotation).amax() < 1e-5);
    }

    #[test]
    fn axes_are_continuous_where_two_factors_cross() {
        let mut before: Option<Stretch> = None;
        for key in 0..200 {
            let t = f64::from(key) / 100.0 - 1.0;
            let tilt = exp(&Vector3::new(0.0, 0.0, 0.3 + 0.2 * t));
            let factors = Matrix3::from_diagonal(&Vector3::new(1.0 + 0.3 * t, 1.0 - 0.3 * t, 0.9));
            let map = exp(&Vector3::new(t, 0.5, 0.0)) * tilt * factors * tilt.transpose();
            before = Some(near(&Stretch::of(&map, before.as_ref()), before.as_ref(), key));
        }
    }

    fn near(found: &Stretch, before: Option<&Stretch>, key: i32) -> Stretch {
        if let Some(before) = before {
            assert!((found.axes - before.axes).amax() < 0.02, "{key}");
            assert!((found.turn - before.turn).amax() < 0.02, "{key}");
            assert!((found.scale - before.scale).amax() < 0.02, "{key}");
        }
        *found
    }

    #[test]
    fn a_mirroring_map_is_continuous_while_another_axis_becomes_the_shortest() {
        let mut before: Option<Stretch> = None;
        for key in 0..200 {
            let t = f64::from(key) / 100.0 - 1.0;
            let tilt = exp(&Vector3::new(0.3, 0.2, 0.1 * t));
            let factors = Vector3::new(1.0, 0.45 - 0.1 * t, -0.45 - 0.1 * t);
            let map = tilt * Matrix3::from_diagonal(&factors) * tilt.transpose();
            let found = near(&Stretch::of(&map, before.as_ref()), before.as_ref(), key);
            assert_eq!(found.scale.iter().filter(|&&s| s < 0.0).count(), 1, "{key}");
            before = Some(found);
        }
    }

    #[test]
    fn a_map_that_rotates_by_a_half_turn_keeps_positive_factors() {
        let first = Stretch::of(&Matrix3::from_diagonal(&Vector3::new(1.0, 0.7, 0.6)), None);
        let over = exp(&Vector3::new(3.1, 0.0, 0.0));
        let found = Stretch::of(&(over * whole(&first)), Some(&first));
        assert!(found.scale.iter().all(|&s| s > 0.0), "{}", found.scale);
    }
}
