//! Depths of points that are vertices of a mesh.

use super::data::View;
use super::error::SetError;
use nalgebra::{DMatrix, Matrix2x4, RowVector4, Vector3};

/// Finds the affine projection of K positions that comes nearest to a view's known points: rows of x and y,
/// the last column their offset.
///
/// # Errors
/// [`SetError::Triangulation`]: the known points do not determine it.
fn project(view: &View, positions: &[[f64; 3]], named: &str) -> Result<Matrix2x4<f64>, SetError> {
    let known: Vec<(usize, [f64; 2])> =
        view.points.iter().enumerate().filter_map(|(k, point)| Some((k, (*point)?))).collect();
    let row = |(k, _): &(usize, [f64; 2])| {
        let [x, y, z] = positions[*k];
        RowVector4::new(x, y, z, 1.0)
    };
    let a = DMatrix::from_fn(known.len(), 4, |i, c| row(&known[i])[c]);
    let b = DMatrix::from_fn(known.len(), 2, |i, c| known[i].1[c]);
    let svd = a.svd(true, true);
    let undetermined = || SetError::Triangulation {
        view: named.to_owned(),
        what: "they do not determine a projection of the mesh".to_owned(),
    };
    if svd.rank(1e-9 * svd.singular_values.max()) < 4 {
        return Err(undetermined());
    }
    let found = svd.solve(&b, 0.0).map_err(|_| undetermined())?;
    Ok(Matrix2x4::from_fn(|r, c| found[(c, r)]))
}

/// Computes depths of K positions in a view, in its pixels, growing away from the viewer: along what is
/// orthogonal to x and y of the affine projection that comes nearest to its points.
///
/// # Errors
/// That of [`project`].
pub(super) fn depths(
    view: &View,
    positions: &[[f64; 3]],
    named: &str,
) -> Result<Vec<f64>, SetError> {
    let projection = project(view, positions, named)?;
    let [x, y] = [0, 1].map(|r| Vector3::from_fn(|c, _| projection[(r, c)]));
    // Right x down points away; its length is that of a pixel's square.
    let away = x.cross(&y) / (x.norm() * y.norm()).sqrt();
    Ok(positions.iter().map(|p| away.dot(&Vector3::from(*p))).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depth_is_what_a_view_from_the_front_does_not_show() {
        let positions =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 2.0], [0.0, 1.0, -1.0], [1.0, 1.0, 0.5], [0.3, 0.9, 3.0]];
        // The viewer is where z is large; y points up there, and down in pixels.
        let points = positions.map(|[x, y, _]| Some([10.0 * x + 3.0, 50.0 - 10.0 * y]));
        let view = View {
            values: Default::default(),
            points: points.to_vec(),
            visible: vec![true; 5],
            depths: Vec::new(),
            image: None,
            layers: Vec::new(),
        };
        let found = depths(&view, &positions, "view 0").unwrap();
        for ([_, _, z], depth) in positions.iter().zip(found) {
            assert!((depth + 10.0 * z).abs() < 1e-9, "{z} {depth}");
        }
        let flat = positions.map(|[x, y, _]| [x, y, 0.0]);
        assert!(depths(&view, &flat, "view 0").is_err());
    }
}
