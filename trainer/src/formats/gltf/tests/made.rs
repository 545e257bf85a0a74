//! Builds a glTF scene for tests: two joints along x, a triangle that follows both, a morph target, and a clip in which
//! the second joint turns.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use std::path::PathBuf;

/// A glTF file under construction.
pub(super) struct Made {
    pub(super) json: Value,
    pub(super) bytes: Vec<u8>,
}

/// A quarter turn about z, as a quaternion.
pub(super) const QUARTER: [f32; 4] =
    [0.0, 0.0, std::f32::consts::FRAC_1_SQRT_2, std::f32::consts::FRAC_1_SQRT_2];
pub(super) const NO_TURN: [f32; 4] = [0.0, 0.0, 0.0, 1.0];

impl Made {
    pub(super) fn scene() -> Self {
        let mut made = Self {
            json: json!({
                "asset": { "version": "2.0" },
                "accessors": [], "bufferViews": [],
                "scene": 0, "scenes": [{ "nodes": [0, 1] }],
                "nodes": [
                    { "name": "body", "mesh": 0, "skin": 0 },
                    { "name": "upper", "children": [2] },
                    { "name": "lower", "translation": [2.0, 0.0, 0.0] },
                ],
            }),
            bytes: Vec::new(),
        };
        let positions = made.floats(&[[1.0, 0.0, 0.0], [3.0, 0.0, 0.0], [2.0, 1.0, 0.0]]);
        let raised = made.floats(&[[0.0; 3], [0.0, 0.0, 1.0], [0.0; 3]]);
        let joints = made.bytes(&[[0, 1, 0, 0]; 3]);
        let weights =
            made.floats(&[[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.5, 0.5, 0.0, 0.0]]);
        made.json["meshes"] = json!([{ "primitives": [{
            "attributes": { "POSITION": positions, "JOINTS_0": joints, "WEIGHTS_0": weights },
            "targets": [{ "POSITION": raised }],
        }], "weights": [0.0] }]);
        let inverses = made.floats(&[moved_by(0.0), moved_by(-2.0)]);
        made.json["skins"] = json!([{ "joints": [1, 2], "inverseBindMatrices": inverses }]);
        let times = made.floats(&[[0.0], [0.5], [1.0]]);
        let turns = made.floats(&[NO_TURN, QUARTER, NO_TURN]);
        made.json["animations"] = json!([{
            "name": "bend",
            "samplers": [{ "input": times, "output": turns }],
            "channels": [{ "sampler": 0, "target": { "node": 2, "path": "rotation" } }],
        }]);
        made
    }

    /// Adds an accessor of floats.
    pub(super) fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = values.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
        self.accessor(&bytes, 5126, N, values.len())
    }

    /// Adds an accessor of bytes.
    pub(super) fn bytes<const N: usize>(&mut self, values: &[[u8; N]]) -> usize {
        self.accessor(values.as_flattened(), 5121, N, values.len())
    }

    fn accessor(&mut self, bytes: &[u8], component: u32, width: usize, count: usize) -> usize {
        let kind = match width {
            1 => "SCALAR",
            2 => "VEC2",
            3 => "VEC3",
            4 => "VEC4",
            _ => "MAT4",
        };
        let views = self.json["bufferViews"].as_array_mut().unwrap();
        let view = views.len();
        views.push(
            json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() }),
        );
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let accessors = self.json["accessors"].as_array_mut().unwrap();
        accessors.push(json!({
            "bufferView": view, "componentType": component, "type": kind, "count": count,
            "min": [0.0, 0.0, 0.0], "max": [0.0, 0.0, 0.0],
        }));
        accessors.len() - 1
    }

    /// Adds a clip of one channel.
    pub(super) fn clip(
        &mut self,
        name: &str,
        target: Value,
        input: usize,
        output: usize,
        how: &str,
    ) {
        self.json["animations"].as_array_mut().unwrap().push(json!({
            "name": name,
            "samplers": [{ "input": input, "output": output, "interpolation": how }],
            "channels": [{ "sampler": 0, "target": target }],
        }));
    }

    /// Writes the file and returns its path.
    pub(super) fn write(&self, test: &str) -> PathBuf {
        let mut json = self.json.clone();
        if json.get("buffers").is_none() {
            let data = STANDARD.encode(&self.bytes);
            let uri = format!("data:application/octet-stream;base64,{data}");
            json["buffers"] = json!([{ "byteLength": self.bytes.len(), "uri": uri }]);
        }
        let folder = std::env::temp_dir().join(format!("sinew-gltf-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join(format!("{test}.gltf"));
        std::fs::write(&path, serde_json::to_vec(&json).unwrap()).unwrap();
        path
    }
}

/// A translation along x, by columns.
pub(super) fn moved_by(x: f32) -> [f32; 16] {
    [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, x, 0.0, 0.0, 1.0]
}
