//! The JSON file beside the arrays.

use crate::Error;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::io;
use std::path::Path;

/// Fields of the JSON: joints, clips, meshes and space; other fields are ignored.
#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct Sidecar {
    /// Names of joints, J.
    pub(super) bone_names: Option<Vec<String>>,
    /// Parents of joints, J; `null` or -1 is a root.
    pub(super) bone_parents: Option<Vec<Option<Parent>>>,
    /// Names of curves, C.
    pub(super) curve_names: Option<Vec<String>>,
    /// Rest origins in model space, by joint name.
    pub(super) joint_rest_positions: BTreeMap<String, [f64; 3]>,
    /// Names of clips, C.
    pub(super) clip_names: Option<Vec<String>>,
    /// First frames of clips, C.
    pub(super) clip_starts: Option<Vec<i64>>,
    /// Frames per second.
    pub(super) fps: Option<f64>,
    /// Names of meshes, M.
    pub(super) mesh_names: Option<Vec<String>>,
    /// First vertices of meshes, M.
    pub(super) mesh_starts: Option<Vec<i64>>,
    /// Up axis of the character.
    pub(super) up: Option<String>,
    /// Forward axis of the character.
    pub(super) forward: Option<String>,
    /// `right` or `left`.
    pub(super) handedness: Option<String>,
    /// Metres per unit of length.
    pub(super) unit: Option<f64>,
}

/// A parent as written in a file.
#[derive(Clone, Deserialize)]
#[serde(untagged)]
pub(super) enum Parent {
    /// Number of the joint; -1 for none.
    Number(i64),
    /// Name of the joint.
    Name(String),
}

impl Sidecar {
    /// Reads the JSON at `path`; all fields are empty if there is no file.
    pub(super) fn read(path: &Path) -> Result<Self, Error> {
        let text = match std::fs::read(path) {
            Ok(text) => text,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Self::default()),
            Err(error) => return Err(Error::read(error)),
        };
        serde_json::from_slice(&text).map_err(|error| {
            Error::damaged(format!("is not a description of examples: {error}")).caused_by(error)
        })
    }
}
