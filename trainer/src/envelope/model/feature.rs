//! Features of a pose, the inputs of kernel maps (METHOD §1.9, §1.10), and their order in a file.

use serde::Serialize;
use sinew_runtime::envelope::STRAIN_LEN;

/// Feature of a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Feature {
    /// Entry 4 r + c of a joint's `[half rotation | gap]`.
    Joint {
        /// Number of the joint.
        joint: usize,
        /// Entry, 0 to 11.
        entry: usize,
    },
    /// Entry of a joint's strain: xx, xy, xz, yy, yz, zz.
    Strain {
        /// Number of the joint.
        joint: usize,
        /// Entry, 0 to 5.
        entry: usize,
    },
    /// Value of a curve.
    Curve(usize),
}

impl Feature {
    /// Whether the feature is a length, which changes with the unit.
    pub fn is_length(self) -> bool {
        matches!(self, Self::Joint { entry, .. } if entry % 4 == 3)
    }
}

/// Order of the features in a file: 12 for each joint, then 6 for each joint if joints stretch, then the curves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FeatureOrder {
    /// Number of joints, J.
    pub joint_len: usize,
    /// Whether a joint stretches.
    pub stretches: bool,
}

impl FeatureOrder {
    /// Returns the index of a feature.
    pub fn index(self, feature: Feature) -> usize {
        let strains = if self.stretches { STRAIN_LEN * self.joint_len } else { 0 };
        match feature {
            Feature::Joint { joint, entry } => 12 * joint + entry,
            Feature::Strain { joint, entry } => 12 * self.joint_len + STRAIN_LEN * joint + entry,
            Feature::Curve(curve) => 12 * self.joint_len + strains + curve,
        }
    }

    /// Returns the feature with an index.
    pub fn feature(self, index: usize) -> Feature {
        let Some(rest) = index.checked_sub(12 * self.joint_len) else {
            return Feature::Joint { joint: index / 12, entry: index % 12 };
        };
        let strains = if self.stretches { STRAIN_LEN * self.joint_len } else { 0 };
        match rest.checked_sub(strains) {
            Some(curve) => Feature::Curve(curve),
            None => Feature::Strain { joint: rest / STRAIN_LEN, entry: rest % STRAIN_LEN },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_index_names_its_feature() {
        for stretches in [false, true] {
            let order = FeatureOrder { joint_len: 3, stretches };
            let features: Vec<_> = (0..60).map(|index| order.feature(index)).collect();
            assert!(features.iter().enumerate().all(|(at, feature)| order.index(*feature) == at));
            assert_eq!(features[15], Feature::Joint { joint: 1, entry: 3 });
            let first = Feature::Strain { joint: 0, entry: 0 };
            assert_eq!(features[36], if stretches { first } else { Feature::Curve(0) });
            assert!(features.contains(&Feature::Curve(5)));
        }
    }
}
