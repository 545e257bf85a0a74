//! The tolerance of stage palette.

use super::inexact::{Inexact, Transform, magnitudes, product};
use faer::Mat;
use nalgebra::{Matrix3, SMatrix};
use sinew_trainer::envelope::model::{EnvelopeModel, Reconstruction};
use sinew_trainer::envelope::oracle::stack;
use sinew_trainer::numeric::affine::linear;
use sinew_trainer::regression::arithmetic::gamma;

/// Bounds the palette: `t = c1 d + c2 q`, sums of 3P + 4J products; then `B_r t`, three products
/// and one term.
pub fn palette(
    oracle: &EnvelopeModel,
    root: &Inexact<Transform>,
    relative: &Inexact<Transform>,
    gradients: &Inexact<Matrix3<f64>>,
) -> Inexact<Transform> {
    let Some(Reconstruction { c1, c2, .. }) = &oracle.reconstruction else {
        return Inexact::exact(Vec::new());
    };
    let terms = c1.ncols() + c2.ncols();
    let unmoved = oracle.palette(&Transform::identity(), &relative.value, &gradients.value);
    let errors = stacked_error(c1, gradients, terms) + stacked_error(c2, relative, terms);
    let error = unmoved.iter().enumerate().map(|(l, transform)| {
        let error = Transform::from_fn(|r, c| errors[(4 * l + c, r)]);
        composed((&root.value[0], &root.error[0]), (transform, &error))
    });
    let value = oracle.palette(&root.value[0], &relative.value, &gradients.value);
    Inexact { error: error.collect(), value }
}

/// Bounds c x for a stack x of blocks: `|c| E + γₙ |c| (|x| + E)`.
fn stacked_error<const C: usize>(
    coefficients: &Mat<f64>,
    blocks: &Inexact<SMatrix<f64, 3, C>>,
    terms: usize,
) -> Mat<f64> {
    let weigh = |(value, error): (&SMatrix<f64, 3, C>, &SMatrix<f64, 3, C>)| {
        value.abs() * gamma(terms) + error * (1.0 + gamma(terms))
    };
    let blocks: Vec<_> = blocks.value.iter().zip(&blocks.error).map(weigh).collect();
    magnitudes(coefficients) * stack(&blocks)
}

/// Bounds the composition of a transform `a` after a transform `b`.
fn composed(a: (&Transform, &Transform), b: (&Transform, &Transform)) -> Transform {
    let mut error = product((&linear(a.0), &linear(a.1)), b, 4);
    let last = (a.0.column(3).abs() + a.1.column(3)) * gamma(4) + a.1.column(3);
    error.column_mut(3).axpy(1.0, &last, 1.0);
    error
}
