//! The description in JSON beside the arrays.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::examples::ExamplesError;
use crate::formats::FormatError;

/// What the JSON says of joints, clips, meshes and space; everything else in it is left alone.
#[derive(Default, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct Sidecar {
    /// J names.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) bone_names: Option<Vec<String>>,
    /// J parents; `null` or -1 is a root.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) bone_parents: Option<Vec<Option<Parent>>>,
    /// Model-space rest origins by name.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub(super) joint_rest_positions: BTreeMap<String, [f64; 3]>,
    /// C names of clips.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) clip_names: Option<Vec<String>>,
    /// C first frames of clips.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) clip_starts: Option<Vec<i64>>,
    /// Frames a second.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) fps: Option<f64>,
    /// M names of meshes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) mesh_names: Option<Vec<String>>,
    /// M first vertices of meshes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) mesh_starts: Option<Vec<i64>>,
    /// The axis along which the character stands.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) up: Option<String>,
    /// The axis along which it looks.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) forward: Option<String>,
    /// `right` or `left`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) handedness: Option<String>,
    /// Metres of a unit of length.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) unit: Option<f64>,
}

/// A parent as files write it.
#[derive(Clone, Serialize, Deserialize)]
#[serde(untagged)]
pub(super) enum Parent {
    /// By place in the list of joints; -1 is none.
    Number(i64),
    /// By name.
    Name(String),
}

impl Sidecar {
    /// Reads the JSON at `path`; without a file, nothing is described.
    pub(super) fn read(path: &Path) -> Result<Self, ExamplesError> {
        let text = match std::fs::read(path) {
            Ok(text) => text,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Self::default()),
            Err(error) => return Err(FormatError::Read(error).into()),
        };
        serde_json::from_slice(&text)
            .map_err(|error| ExamplesError::Json { reason: error.to_string() })
    }
}
