//! Bounds contain every skinned vertex, and are not much larger than the skin.

use super::skin::{Skinned, whole_of};
use crate::backend::{Backend, Failure, part};
use crate::compare::Mismatch;
use crate::finding::Finding;
use crate::poses::Kind;
use crate::subject::Subject;
use crate::tolerance::{BOUNDS_AT_REST, BOUNDS_POSED};
use sinew_gpu::layout::SkinBatch;
use sinew_runtime::skin::Bounds;

/// Checks that every position is inside the bounds. Prints the largest ratio of the bounds'
/// diagonal to that of the skin's own box, at rest and in trained poses. Random models have no
/// ratio, because their transforms are unrelated to their vertices.
///
/// # Errors
/// The backend's error.
///
/// # Panics
/// If the bounds are too large.
pub fn body(backend: &dyn Backend, subject: &Subject<'_>) -> Result<Vec<Finding>, Failure> {
    let (skin, n) = (&subject.loaded.skin, subject.poses.len());
    let whole = whole_of(backend, subject)?;
    let positions = Skinned::gather(&whole.skin, &SkinBatch::new(skin), n).positions;
    let mut held = Finding::new("bounds");
    let (mut at_rest, mut posed) = (0.0_f64, 0.0_f64);
    for (i, pose) in subject.poses.iter().enumerate() {
        let positions = part(&positions, n, i).as_chunks().0;
        let bounds = skin.bounds(part(&whole.palettes, n, i), 0.0).expect("the palette is whole");
        let bounds = bounds.expect("there are vertices");
        holds(&mut held, &bounds, positions);
        let ratio = f64::from(length(&bounds) / length(&box_of(positions)));
        match pose.kind {
            _ if subject.name == "random" => {}
            Kind::Rest if !pose.moved => at_rest = at_rest.max(ratio),
            Kind::Rest | Kind::Trained | Kind::Single => posed = posed.max(ratio),
            _ => {}
        }
    }
    println!("bounds are {at_rest:.4} and {posed:.4} times as long as the skin's own box");
    assert!(at_rest <= BOUNDS_AT_REST, "at rest {at_rest} times as long as the skin's own");
    assert!(posed <= BOUNDS_POSED, "{posed} times as long as the skin's own");
    Ok(vec![held])
}

fn holds(held: &mut Finding, bounds: &Bounds, positions: &[[f32; 3]]) {
    for (vertex, &position) in positions.iter().enumerate() {
        let nearest = [0, 1, 2].map(|c| position[c].max(bounds.min[c]).min(bounds.max[c]));
        held.equal(&position, &nearest);
        if !bounds.contains(position) {
            held.mismatch.get_or_insert(Mismatch::Bits {
                index: 3 * vertex,
                expected: nearest[0],
                found: position[0],
            });
        }
    }
}

fn box_of(positions: &[[f32; 3]]) -> Bounds {
    let most = |pick: fn(f32, f32) -> f32| {
        [0, 1, 2].map(|c| positions.iter().map(|x| x[c]).reduce(pick).unwrap_or(f32::NAN))
    };
    Bounds { min: most(f32::min), max: most(f32::max) }
}

fn length(bounds: &Bounds) -> f32 {
    [0, 1, 2].map(|c| (bounds.max[c] - bounds.min[c]).powi(2)).iter().sum::<f32>().sqrt()
}
