//! Distance of a joint's map from a rigid map, its limits, and the kind of distortion.

use super::data::Matrix3x4;
use crate::numeric::affine::parts;
use nalgebra::Matrix3;
use std::fmt;

/// Largest deviation of a rigid map (METHOD §1.1): covers f32 rounding.
pub const RIGID: f64 = 1e-4;

/// Largest deviation of a rest pose that a fit repairs with the nearest rotation; beyond this limit the data is wrong.
pub(super) const REPAIRABLE: f64 = 1e-2;

/// Largest entry of a joint's strain that counts as rigid. The runtime's check of a pose allows twice as much.
pub(super) const STRETCHES: f64 = 1e-3;

/// Least determinant of a joint's map. The runtime takes a joint with a lesser one as hidden.
pub(super) const HIDDEN: f64 = 1e-3;

/// Kind of a matrix that is not a rotation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Distortion {
    /// A reflection.
    Mirrors,
    /// A uniform scale; the factor.
    Scales(f64),
    /// A scale along orthogonal axes; the factors, largest first.
    Stretches([f64; 3]),
    /// A scale of about 0, along one axis or more.
    Hides,
    /// A last row other than 0 0 0 1.
    Projects,
}

impl Distortion {
    /// Classifies the linear part of a map; factors are its singular values.
    pub(super) fn of(map: &Matrix3x4) -> Self {
        let (sigma, is_mirrored) = singular_values(map);
        let [most, middle, least] = sigma;
        if is_mirrored {
            Self::Mirrors
        } else if most - least <= 1e-3 * most {
            Self::Scales(middle)
        } else {
            Self::Stretches(sigma)
        }
    }
}

impl fmt::Display for Distortion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Mirrors => f.write_str(
                "is mirrored: apply the scale of the armature and of its parents (in Blender Ctrl+A) and export again",
            ),
            Self::Scales(factor) => write!(
                f,
                "is scaled by {factor:.4}: joints only turn and move; remove its scale keys, or apply the \
                 armature's scale, and export again"
            ),
            Self::Stretches([x, y, z]) => write!(
                f,
                "is scaled or sheared, by {x:.4}, {y:.4} and {z:.4}: joints only turn and move; remove its \
                 scale keys, and stretch in its constraints, and export again"
            ),
            Self::Hides => f.write_str(
                "is scaled to 0: leave the frames out in which it is hidden, or remove its scale keys",
            ),
            Self::Projects => f.write_str(
                "has a matrix whose last row is not 0 0 0 1: matrices are row by row, with the translation in \
                 the last column; is it transposed?",
            ),
        }
    }
}

/// Returns the fault of a posed joint's map, if it mirrors or is scaled to about 0.
pub(super) fn fault(map: &Matrix3x4) -> Option<Distortion> {
    let volume = parts(map).0.determinant();
    if volume < -HIDDEN {
        Some(Distortion::Mirrors)
    } else {
        (volume < HIDDEN).then_some(Distortion::Hides)
    }
}

/// Measures the distance of a map's linear part from the nearest rotation: the largest |σ - 1| over the singular
/// values. The smallest σ takes the sign of the determinant.
pub(super) fn deviation(map: &Matrix3x4) -> f64 {
    let ([most, middle, least], is_mirrored) = singular_values(map);
    let least = if is_mirrored { -least } else { least };
    [most, middle, least].into_iter().map(|sigma| (sigma - 1.0).abs()).fold(0.0, f64::max)
}

/// Returns the singular values of a map's linear part, largest first, and whether the map reflects.
fn singular_values(map: &Matrix3x4) -> ([f64; 3], bool) {
    let linear = Matrix3::from_fn(|row, column| map[row][column]);
    let sigma = linear.singular_values();
    ([sigma[0], sigma[1], sigma[2]], linear.determinant() < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn diagonal([x, y, z]: [f64; 3]) -> Matrix3x4 {
        [[x, 0.0, 0.0, 5.0], [0.0, y, 0.0, 0.0], [0.0, 0.0, z, 0.0]]
    }

    #[test]
    fn each_distortion_has_its_name() {
        assert_eq!(Distortion::of(&diagonal([-1.0, 1.0, 1.0])), Distortion::Mirrors);
        let scaled = Distortion::of(&diagonal([0.01; 3]));
        assert!(scaled.to_string().starts_with("is scaled by 0.0100: "), "{scaled}");
        let stretched = Distortion::of(&diagonal([1.0, 1.2, 0.9]));
        assert!(stretched.to_string().contains("1.2000, 1.0000 and 0.9000"), "{stretched}");
    }

    #[test]
    fn deviations_come_from_singular_values() {
        assert_eq!(deviation(&diagonal([1.0; 3])), 0.0);
        assert!((deviation(&diagonal([1.0, 1.2, 0.9])) - 0.2).abs() < 1e-12);
        assert!((deviation(&diagonal([-1.0, 1.0, 1.0])) - 2.0).abs() < 1e-12);
    }
}
