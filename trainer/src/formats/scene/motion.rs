//! The motion of a skeleton, whatever it moves.

use super::clip::Clip;
use super::error::SceneError;
use super::names::{JointNames, mismatch};
use crate::formats::warning::FormatWarning;
use nalgebra::Matrix4;
use sinew_runtime::format::Space;

/// How joints move, sampled: what the readers of scenes return of animations without a mesh.
pub(crate) struct Motion {
    /// Axes and unit of the scene.
    pub(crate) space: Space,
    /// The joints of the character that are there.
    pub(crate) joints: MotionJoints,
    /// World frame of each where nothing is animated.
    pub(crate) rest: Vec<Matrix4<f64>>,
    /// Frame in which a skin of the file binds each; none where the file has no skin.
    pub(crate) binds: Option<Vec<Matrix4<f64>>>,
    /// World frame of each in each frame, frame-major.
    pub(crate) frames: Vec<Matrix4<f64>>,
    /// The clips that the frames come from.
    pub(crate) clips: Vec<Clip>,
    /// What was left out.
    pub(crate) warnings: Vec<FormatWarning>,
}

/// Which nodes of a file are joints of a character.
pub(crate) struct MotionJoints {
    /// The nodes.
    pub(crate) nodes: Vec<usize>,
    /// The joint of the character that each is.
    pub(crate) of: Vec<usize>,
    /// What keeps the names of other nodes from matching, and the option that mends it.
    pub(crate) mismatch: Option<String>,
}

impl MotionJoints {
    /// Finds the joints of a character among nodes, each with its name; of several of one name the first.
    ///
    /// # Errors
    /// [`SceneError::OtherJoints`] where there is none.
    pub(in crate::formats) fn find<'a>(
        candidates: impl Iterator<Item = (usize, &'a str)>,
        character: &[String],
        names: &JointNames<'_>,
    ) -> Result<Self, SceneError> {
        let candidates: Vec<(usize, String)> =
            candidates.map(|(node, name)| (node, names.renamed(name, character))).collect();
        let node = |name: &String| {
            let found = candidates.iter().find(|(_, own)| own == name);
            found.map(|&(node, _)| node)
        };
        let (of, nodes): (Vec<usize>, Vec<usize>) = character
            .iter()
            .enumerate()
            .filter_map(|(joint, name)| Some((joint, node(name)?)))
            .unzip();
        let found: Vec<String> = candidates.iter().map(|(_, name)| name.clone()).collect();
        let mismatch = mismatch(character, &found);
        if nodes.is_empty() {
            let joints = character.to_vec();
            return Err(SceneError::OtherJoints { joints, mismatch });
        }
        Ok(Self { nodes, of, mismatch })
    }
}

/// Gives the frame in which a joint is bound; of one that no skin names, where it stands against the nearest above that
/// one does.
///
/// - `upwards`: the joint and the nodes above it.
/// - `binds`, `at_rest`: of all nodes, as skins bind them and where nothing is animated.
pub(in crate::formats) fn bound(
    upwards: impl Iterator<Item = usize> + Clone,
    binds: &[Option<Matrix4<f64>>],
    at_rest: &[Matrix4<f64>],
) -> Option<Matrix4<f64>> {
    let joint = upwards.clone().next()?;
    let any = binds.iter().position(Option::is_some);
    let known = { upwards }.find(|&node| binds[node].is_some()).or(any)?;
    if known == joint {
        return binds[joint];
    }
    Some(binds[known]? * at_rest[known].try_inverse()? * at_rest[joint])
}
