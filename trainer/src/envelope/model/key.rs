//! Keys: a key predicts the gradient of a patch of the skin from the rotations of one or two joints (METHOD §1.4,
//! §1.5).

use crate::numeric::affine::Strain;
use crate::numeric::so3;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3, Vector6};

/// A key predictor: `D = Q_p exp(A θ_b) [exp(A' θ_c)] (I + sym(H [θ_b; θ_p] + G E_b))`.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// Joint b that the key follows; p is the parent of b.
    pub joint: usize,
    /// A = u W.
    pub twist: Matrix3<f64>,
    /// Residual joint c, and A' = u' W'.
    pub residual: Option<(usize, Matrix3<f64>)>,
    /// `[H G]`: rows xx, xy, xz, yy, yz, zz.
    pub shear: Shear,
}

/// Movement of a key's joint b and of its parent p: `[θ_b; θ_p; E_b]`. Angles are in radians; θ_p = 0 without a parent.
pub type Movement = SVector<f64, 12>;

/// Linear map from a [`Movement`] to the entries xx, xy, xz, yy, yz, zz of a stretch.
pub type Shear = SMatrix<f64, 6, 12>;

/// Factors whose product is a key's gradient.
pub struct Factors {
    /// Q_p, I for the root.
    pub parent: Matrix3<f64>,
    /// A θ_b, radians.
    pub twist: Vector3<f64>,
    /// A' θ_c, radians.
    pub residual: Option<Vector3<f64>>,
    /// Stretch S.
    pub stretch: Matrix3<f64>,
}

impl Key {
    /// Evaluates the factors of the key's gradient.
    ///
    /// - `parent`: Q_p, I for the root.
    /// - `angle`: θ of a joint, radians.
    /// - `above`: parent of b; `None` for the root, which uses θ_p = 0.
    /// - `strain`: E_b.
    pub fn factors<'a>(
        &self,
        parent: Matrix3<f64>,
        angle: impl Fn(usize) -> &'a Vector3<f64>,
        above: Option<usize>,
        strain: &Strain,
    ) -> Factors {
        let own = angle(self.joint);
        let over = above.map_or(Vector3::zeros(), |p| *angle(p));
        Factors {
            parent,
            twist: self.twist * own,
            residual: self.residual.map(|(joint, twist)| twist * angle(joint)),
            stretch: stretch(&self.shear, &movement(own, &over, strain)),
        }
    }
}

impl Factors {
    /// Multiplies the factors.
    pub fn gradient(&self) -> Matrix3<f64> {
        let turn = self.parent * so3::exp(&self.twist);
        let turn = self.residual.map_or(turn, |angles| turn * so3::exp(&angles));
        turn * self.stretch
    }
}

/// Joins the movement of a joint b and its parent p.
pub fn movement(own: &Vector3<f64>, above: &Vector3<f64>, strain: &Strain) -> Movement {
    Movement::from_iterator(own.iter().chain(above).chain(strain).copied())
}

/// Returns S = I + sym([H G] [θ_b; θ_p; E_b]).
pub fn stretch(shear: &Shear, movement: &Movement) -> Matrix3<f64> {
    Matrix3::identity() + symmetric(&(shear * movement))
}

/// Returns `[xx xy xz; xy yy yz; xz yz zz]`.
pub fn symmetric(s: &Vector6<f64>) -> Matrix3<f64> {
    let [xx, xy, xz, yy, yz, zz] = (*s).into();
    Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
}

/// Converts a value of the file to f64; NaN if the value is missing.
pub(super) fn wide(value: Option<f32>) -> f64 {
    value.map_or(f64::NAN, f64::from)
}
