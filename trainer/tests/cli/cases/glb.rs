//! Parses a GLB and plays it by the glTF 2.0 specification only.

use crate::cli::common::Folder;
use nalgebra::{Matrix4, Quaternion, Translation3, UnitQuaternion, Vector3};
use serde_json::{Value, json};

/// JSON and binary chunk of a GLB.
pub(super) struct Glb {
    pub(super) json: Value,
    bytes: Vec<u8>,
}

/// Translation, rotation and scale of a node, and the weights of its morph targets.
struct Placed {
    translation: Vec<f64>,
    rotation: Vec<f64>,
    scale: Vec<f64>,
    weights: Vec<f64>,
}

impl Glb {
    pub(super) fn read(folder: &Folder, name: &str) -> Self {
        let bytes = folder.read(name);
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        let end = 20 + word(12);
        let json = serde_json::from_slice(&bytes[20..end]).unwrap();
        Self { json, bytes: bytes[end + 8..][..word(end)].to_vec() }
    }

    pub(super) fn write(&self, folder: &Folder, name: &str) {
        let mut json = self.json.clone();
        json["buffers"][0]["byteLength"] = json!(self.bytes.len());
        let mut json = json.to_string().into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut glb = b"glTF\x02\0\0\0".to_vec();
        glb.extend((28 + json.len() as u32 + self.bytes.len() as u32).to_le_bytes());
        for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &self.bytes)] {
            glb.extend((chunk.len() as u32).to_le_bytes());
            glb.extend(kind);
            glb.extend(chunk);
        }
        std::fs::write(folder.path(name), glb).unwrap();
    }

    /// Adds an accessor.
    pub(super) fn add(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8]) -> usize {
        let begin = self.bytes.len();
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let views = self.json["bufferViews"].as_array_mut().unwrap();
        views.push(json!({ "buffer": 0, "byteOffset": begin, "byteLength": bytes.len() }));
        let view = views.len() - 1;
        let accessors = self.json["accessors"].as_array_mut().unwrap();
        accessors.push(json!({
            "bufferView": view, "componentType": component, "type": kind, "count": count,
            "min": [0.0, 0.0, 0.0], "max": [0.0, 0.0, 0.0],
        }));
        accessors.len() - 1
    }

    /// Adds an accessor of floats.
    pub(super) fn floats(&mut self, kind: &str, width: usize, values: &[f32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.add(kind, 5126, values.len() / width, &bytes)
    }

    /// Adds an accessor of vertex indices.
    pub(super) fn numbers(&mut self, values: &[u16]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.add("SCALAR", 5123, values.len(), &bytes)
    }

    /// Reads an accessor of floats or integers, one element after another.
    pub(super) fn values(&self, accessor: &Value) -> Vec<f64> {
        let accessor = &self.json["accessors"][accessor.as_u64().unwrap() as usize];
        let width = match accessor["type"].as_str().unwrap() {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        let count = accessor["count"].as_u64().unwrap() as usize;
        let kind = accessor["componentType"].as_u64().unwrap();
        let mut all = match accessor.get("bufferView") {
            Some(_) => self.components(accessor, kind, width * count),
            None => vec![0.0; width * count],
        };
        let sparse = &accessor["sparse"];
        let few = sparse["count"].as_u64().unwrap_or(0) as usize;
        if few > 0 {
            let indices = &sparse["indices"];
            let of_indices = indices["componentType"].as_u64().unwrap();
            let indices = self.components(indices, of_indices, few);
            let values = self.components(&sparse["values"], kind, width * few);
            for (index, own) in indices.into_iter().zip(values.chunks(width)) {
                all[index as usize * width..][..width].copy_from_slice(own);
            }
        }
        all
    }

    fn components(&self, of: &Value, kind: u64, len: usize) -> Vec<f64> {
        let number = |of: &Value, name: &str| of[name].as_u64().unwrap_or(0) as usize;
        let view = &self.json["bufferViews"][number(of, "bufferView")];
        let begin = number(view, "byteOffset") + number(of, "byteOffset");
        let size = match kind {
            5121 => 1,
            5123 => 2,
            _ => 4,
        };
        let component = |bytes: &[u8]| match kind {
            5126 => f64::from(f32::from_le_bytes(bytes.try_into().unwrap())),
            _ => bytes.iter().rev().fold(0.0, |all, &byte| 256.0 * all + f64::from(byte)),
        };
        self.bytes[begin..][..size * len].chunks(size).map(component).collect()
    }

    /// Returns the key times of an animation's sampler.
    pub(super) fn times(&self, animation: usize, sampler: usize) -> Vec<f64> {
        self.values(&self.json["animations"][animation]["samplers"][sampler]["input"])
    }

    /// Returns the interpolation of each channel of an animation that moves the node, by path.
    pub(super) fn interpolations(&self, animation: usize, node: &str) -> Vec<(String, String)> {
        let animation = &self.json["animations"][animation];
        let of = |channel: &Value| {
            let at = channel["target"]["node"].as_u64()? as usize;
            let sampler = &animation["samplers"][channel["sampler"].as_u64()? as usize];
            let how = sampler["interpolation"].as_str().unwrap_or("LINEAR");
            (self.json["nodes"][at]["name"] == node)
                .then(|| (channel["target"]["path"].as_str().unwrap().to_owned(), how.to_owned()))
        };
        animation["channels"].as_array().unwrap().iter().filter_map(of).collect()
    }

    /// Returns the vertices of the skinned mesh whose node has this name, at a time of an
    /// animation; at rest for `None`.
    pub(super) fn posed(&self, mesh: &str, at: Option<(usize, f64)>) -> Vec<Vector3<f64>> {
        let nodes = self.json["nodes"].as_array().unwrap();
        let mut placed: Vec<Placed> = nodes.iter().map(|node| self.placed(node)).collect();
        if let Some((animation, time)) = at {
            self.play(&self.json["animations"][animation], time, &mut placed);
        }
        let worlds = worlds(nodes, &placed);
        let node = nodes.iter().position(|node| node["name"] == mesh && node["mesh"].is_u64());
        let node = node.unwrap();
        let skin = &self.json["skins"][nodes[node]["skin"].as_u64().unwrap() as usize];
        let binds = self.values(&skin["inverseBindMatrices"]);
        let joints =
            skin["joints"].as_array().unwrap().iter().map(|j| j.as_u64().unwrap() as usize);
        let palette: Vec<Matrix4<f64>> = joints
            .zip(binds.chunks(16))
            .map(|(joint, bind)| worlds[joint] * Matrix4::from_column_slice(bind))
            .collect();
        let mesh = &self.json["meshes"][nodes[node]["mesh"].as_u64().unwrap() as usize];
        let mut all = Vec::new();
        for primitive in mesh["primitives"].as_array().unwrap() {
            let mut positions = self.values(&primitive["attributes"]["POSITION"]);
            let targets = primitive["targets"].as_array().map_or(&[][..], Vec::as_slice);
            for (target, weight) in targets.iter().zip(&placed[node].weights) {
                let by = self.values(&target["POSITION"]);
                positions.iter_mut().zip(by).for_each(|(x, by)| *x += weight * by);
            }
            let [joints, weights] =
                ["JOINTS_0", "WEIGHTS_0"].map(|name| self.values(&primitive["attributes"][name]));
            for (v, x) in positions.chunks(3).enumerate() {
                let x = nalgebra::Point3::new(x[0], x[1], x[2]);
                let pairs = joints[4 * v..][..4].iter().zip(&weights[4 * v..][..4]);
                let moved =
                    pairs.map(|(&j, &w)| palette[j as usize].transform_point(&x).coords * w);
                all.push(moved.sum());
            }
        }
        all
    }

    fn placed(&self, node: &Value) -> Placed {
        let list = |value: &Value, rest: &[f64]| -> Vec<f64> {
            let own = value.as_array().map(|all| all.iter().map(|x| x.as_f64().unwrap()).collect());
            own.unwrap_or_else(|| rest.to_vec())
        };
        let mesh = node["mesh"].as_u64().map(|mesh| &self.json["meshes"][mesh as usize]);
        Placed {
            translation: list(&node["translation"], &[0.0; 3]),
            rotation: list(&node["rotation"], &[0.0, 0.0, 0.0, 1.0]),
            scale: list(&node["scale"], &[1.0; 3]),
            weights: list(
                &node["weights"],
                &list(mesh.map_or(&Value::Null, |m| &m["weights"]), &[]),
            ),
        }
    }

    fn play(&self, animation: &Value, time: f64, placed: &mut [Placed]) {
        for channel in animation["channels"].as_array().unwrap() {
            let Some(node) = channel["target"]["node"].as_u64() else { continue };
            let sampler = &animation["samplers"][channel["sampler"].as_u64().unwrap() as usize];
            let (times, values) = (self.values(&sampler["input"]), self.values(&sampler["output"]));
            let path = channel["target"]["path"].as_str().unwrap();
            let how = sampler["interpolation"].as_str().unwrap_or("LINEAR");
            let value = value(time, &times, &values, how, path == "rotation");
            let node = &mut placed[node as usize];
            match path {
                "translation" => node.translation = value,
                "rotation" => node.rotation = value,
                "scale" => node.scale = value,
                _ => node.weights = value,
            }
        }
    }
}

/// Interpolates by appendix C of the specification.
fn value(time: f64, times: &[f64], values: &[f64], how: &str, turns: bool) -> Vec<f64> {
    let per_key = values.len() / times.len();
    let width = if how == "CUBICSPLINE" { per_key / 3 } else { per_key };
    let key = |key: usize, part: usize| &values[key * per_key + part * width..][..width];
    let own = usize::from(how == "CUBICSPLINE");
    let after = times.partition_point(|&key| key <= time);
    if after == 0 || after == times.len() {
        return key(after.saturating_sub(1), own).to_vec();
    }
    let step = times[after] - times[after - 1];
    let t = (time - times[after - 1]) / step;
    let (a, b) = (key(after - 1, own), key(after, own));
    let quaternion =
        |q: &[f64]| UnitQuaternion::from_quaternion(Quaternion::new(q[3], q[0], q[1], q[2]));
    match how {
        "STEP" => a.to_vec(),
        "CUBICSPLINE" => {
            let (out, into) = (key(after - 1, 2), key(after, 0));
            let (t2, t3) = (t * t, t * t * t);
            let at = |i: usize| {
                (2.0 * t3 - 3.0 * t2 + 1.0) * a[i]
                    + step * (t3 - 2.0 * t2 + t) * out[i]
                    + (3.0 * t2 - 2.0 * t3) * b[i]
                    + step * (t3 - t2) * into[i]
            };
            (0..width).map(at).collect()
        }
        _ if turns => {
            let (a, b) = (quaternion(a), quaternion(b));
            a.try_slerp(&b, t, 1e-12).unwrap_or(a).coords.as_slice().to_vec()
        }
        _ => a.iter().zip(b).map(|(a, b)| a + t * (b - a)).collect(),
    }
}

fn worlds(nodes: &[Value], placed: &[Placed]) -> Vec<Matrix4<f64>> {
    let local = |placed: &Placed| {
        let Placed { translation: t, rotation: q, scale: s, .. } = placed;
        let turn = UnitQuaternion::from_quaternion(Quaternion::new(q[3], q[0], q[1], q[2]));
        Translation3::new(t[0], t[1], t[2]).to_homogeneous()
            * turn.to_homogeneous()
            * Matrix4::new_nonuniform_scaling(&Vector3::new(s[0], s[1], s[2]))
    };
    let children = |node: usize| nodes[node]["children"].as_array().into_iter().flatten();
    let children = |node| children(node).map(|child| child.as_u64().unwrap() as usize);
    let mut roots: Vec<usize> = (0..nodes.len()).collect();
    (0..nodes.len()).flat_map(children).for_each(|child| roots.retain(|&root| root != child));
    let mut worlds = vec![Matrix4::identity(); nodes.len()];
    let mut open: Vec<_> = roots.into_iter().map(|root| (root, Matrix4::identity())).collect();
    while let Some((node, parent)) = open.pop() {
        worlds[node] = parent * local(&placed[node]);
        open.extend(children(node).map(|child| (child, worlds[node])));
    }
    worlds
}
