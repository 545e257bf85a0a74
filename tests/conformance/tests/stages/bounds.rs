//! Bounds hold every skinned vertex, and are not much larger than the skin.

use crate::Subject;
use crate::skin::{palette_of, skin};
use conformance::backend::Backend;
use conformance::compare::Mismatch;
use conformance::poses::Kind;
use conformance::tolerance::{BOUNDS_AT_REST, BOUNDS_POSED};
use sinew_runtime::envelope::Bounds;

/// How many times longer than the skin's own box they are at most, at rest and in trained poses; 0
/// for random models, whose maps have nothing to do with their vertices.
pub(crate) fn body(backend: &impl Backend, subject: &Subject<'_>) -> Result<[f64; 2], Mismatch> {
    let envelope = &subject.envelope;
    let (mut at_rest, mut posed) = (0.0_f64, 0.0_f64);
    for pose in &subject.poses {
        let (palette, _) = palette_of(backend, envelope, &pose.maps);
        let bounds = envelope.bounds(&palette).expect("the palette has its length");
        let bounds = bounds.expect("there are vertices");
        let positions = skin(backend, envelope, &palette).positions;
        holds(&bounds, &positions)?;
        let ratio = f64::from(length(&bounds) / length(&box_of(&positions)));
        match pose.kind {
            _ if subject.name == "random" => {}
            Kind::Rest if !pose.moved => at_rest = at_rest.max(ratio),
            Kind::Rest | Kind::Trained | Kind::Single => posed = posed.max(ratio),
            _ => {}
        }
    }
    assert!(at_rest <= BOUNDS_AT_REST, "at rest {at_rest} times as long as the skin's own");
    assert!(posed <= BOUNDS_POSED, "{posed} times as long as the skin's own");
    Ok([at_rest, posed])
}

fn holds(bounds: &Bounds, positions: &[[f32; 3]]) -> Result<(), Mismatch> {
    for (vertex, &position) in positions.iter().enumerate() {
        for (c, found) in position.into_iter().enumerate() {
            let nearest = found.clamp(bounds.min[c], bounds.max[c]);
            if nearest != found || !bounds.contains(position) {
                let (index, expected) = (3 * vertex + c, f64::from(nearest));
                return Err(Mismatch::Beyond { index, expected, found, tolerance: 0.0 });
            }
        }
    }
    Ok(())
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
