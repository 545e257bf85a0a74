//! What `sinew inspect` says of priors.

use crate::cli::described::Described;
use crate::cli::printable;
use serde_json::{Value, json};
use sinew_runtime::format::PartKind;
use sinew_runtime::{Model, Prior};

/// Describes the priors of a file.
pub(in crate::cli) fn describe(model: &Model<Vec<u8>>) -> Vec<Described> {
    let described = |prior: Prior<'_>| Described {
        part: prior.part(),
        kind: PartKind::Prior,
        name: prior.name().to_owned(),
        text: as_text(&prior),
        json: as_json(&prior),
    };
    model.priors().map(described).collect()
}

fn as_text(prior: &Prior<'_>) -> String {
    let (counts, fit) = (prior.counts(), prior.fit());
    let learned = match fit.frames > 0.0 {
        true => format!("from {} frames", fit.frames),
        false => "from no take".to_owned(),
    };
    format!(
        "prior \"{}\" of part {}: {} shapes, learned {learned}; pins hold to {:.3e}; {} mirrored pairs, {} \
         cancelling; {} bytes of scratch for 8 pins\n",
        printable(prior.name()),
        counts.skin,
        counts.shape_len,
        f64::from(fit.beta).sqrt(),
        counts.symmetry_len,
        counts.cancel_len,
        8 * counts.pin_scratch_len(24),
    )
}

fn as_json(prior: &Prior<'_>) -> Value {
    let (counts, fit) = (prior.counts(), prior.fit());
    json!({
        "part": prior.part(),
        "name": prior.name(),
        "skin": counts.skin,
        "shapes": counts.shape_len,
        "frames": fit.frames,
        "tolerance": f64::from(fit.beta).sqrt(),
        "error": fit.error,
        "slider_error": fit.slider_error,
        "mirrored_pairs": counts.symmetry_len,
        "cancelling_pairs": counts.cancel_len,
        "scratch_bytes_for_8_pins": 8 * counts.pin_scratch_len(24),
    })
}
