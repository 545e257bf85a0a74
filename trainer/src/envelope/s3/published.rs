//! S3 to the letter, in place of what this crate does otherwise.
//!
//! | S3 | as published | otherwise |
//! |---|---|---|
//! | §1.2, W and u | coordinate descent from `u = Σ\|θ\|\|ρ\| / Σ\|θ\|²`, u ≥ 0 ([`rotation`](super::rotation)) | the closed form over both signs |
//! | §1.3, H | least squares with a free bias, `vec(S) = H [θ_b1; θ_b2; 1]`, by which the rest pose is not exact ([`scale_shear`](super::scale_shear), [`bias`](super::bias)) | a ridge, and no bias |
//! | §2.2, F | the vertices on which LBS errs less than a threshold: here | a fraction by cross-validation |
//! | Eq. 2 and 5 | vertices of F stay on their LBS positions: they follow the joints, which stand after the proxies in the palette | F follows proxies that anchors pull to LBS |
//! | Eq. 6 | `c1 = a⁻¹ b1`, `c2 = a⁻¹ b2` | anchors by cross-validation, and the refinement |
//! | §3.1, α and T | both fitted anew after every merge ([`merging`](super::merging)) | after the last |
//!
//! Eq. 4 has all vertices follow proxies. But a (Eq. 6) has no equation for what proxies do to F: were F to follow what
//! free vertices alone decide, the whole mesh would err by 6 and 9 % (METHOD §1.7).
//!
//! What S3 leaves open is as otherwise: the normal as a third edge of small weight where keys are fitted, a vertex's few
//! influences, u of at most 4, the branch of ρ at π. Slips of its equations are corrected (METHOD §1.7).

use super::proxies::Proxies;
use super::reduce::Anchors;
use super::settings::Setting;
use crate::envelope::lbs::blend::Weights;

/// S3 has no anchors, and a is singular where a proxy moves vertices of F alone, a part of the mesh has none, a patch is
/// flat, or two proxies have their vertices in one proportion. This one is so weak that it decides what is open and no
/// more.
const ANCHORS: Anchors = Anchors { near_rigid: 0.0, patch: 1e-6 };

/// Gives F, as the fraction of the vertices that LBS errs on least: those on which it errs less than over all, RMS. S3 has
/// a threshold of that error but no number; any length would be none of F on one set and all of it on another.
///
/// - `lbs_errors`: squared, summed over the poses.
pub fn setting(lbs_errors: &[f64]) -> Setting {
    let count = lbs_errors.len().max(1) as f64;
    let mean = lbs_errors.iter().sum::<f64>() / count;
    let within = lbs_errors.iter().filter(|error| **error <= mean).count();
    Setting { near_rigid_fraction: within as f64 / count, anchors: ANCHORS }
}

/// Gives weights on P proxies and then J joints: on the proxies, of the vertices of F on the joints.
pub fn fixed_on_joints(proxies: &Proxies, joints: &Weights, fixed: &[bool]) -> Weights {
    let first = proxies.len();
    let lists = fixed.iter().enumerate().map(|(vertex, fixed)| match fixed {
        true => joints.of(vertex).map(|(joint, w)| (first + joint, w)).collect(),
        false => proxies.weights.of(vertex).collect(),
    });
    Weights::from_lists(proxies.weights.most().max(joints.most()), lists)
}

#[cfg(test)]
mod tests {
    use super::super::settings::near_rigid;
    use super::*;

    #[test]
    fn vertices_that_lbs_errs_on_less_than_over_all_are_near_rigid() {
        let fixed = |errors: &[f64]| near_rigid(errors, setting(errors).near_rigid_fraction);
        assert_eq!(fixed(&[9.0, 1.0, 3.0, 4.0, 0.0]), [false, true, true, false, true]);
        assert_eq!(fixed(&[2.0, 2.0]), [true, true]);
        assert_eq!(fixed(&[]), [false; 0]);
    }
}
