//! Writes glTF files: nodes, skins, animations and their arrays.

use crate::{Error, ErrorKind};
use serde_json::{Map, Value, json};

/// Component types of glTF.
pub(crate) const U8: u32 = 5121;
pub(crate) const U16: u32 = 5123;
pub(crate) const U32: u32 = 5125;
pub(crate) const F32: u32 = 5126;

/// Bytes of a GLB's header and of the headers of its two chunks.
const HEADS: usize = 12 + 8 + 8;

/// Names of the lists that a [`Document`] extends, in the order of its fields.
const LISTS: [&str; 6] = ["nodes", "meshes", "skins", "animations", "accessors", "bufferViews"];

/// A node of the document.
pub(crate) type NodeIndex = usize;
/// A skin of the document.
pub(crate) type SkinIndex = usize;
/// An array of the document.
pub(crate) type ArrayIndex = usize;

/// The tree of a glTF file with one scene and one buffer. It begins empty, or with a file whose other members stay as
/// they are.
pub(crate) struct Document {
    pub(crate) root: Map<String, Value>,
    pub(crate) nodes: Vec<Value>,
    pub(crate) meshes: Vec<Value>,
    pub(crate) skins: Vec<Value>,
    pub(crate) animations: Vec<Value>,
    pub(crate) accessors: Vec<Value>,
    pub(crate) views: Vec<Value>,
    /// Nodes of the default scene; `None` if the file has no scene.
    scene: Option<Vec<Value>>,
    /// Accessors and views that are no longer used; new ones take their indices.
    pub(crate) free: [Vec<usize>; 2],
    pub(crate) bytes: Vec<u8>,
}

/// Placement of a node relative to its parent: scale, then rotation, then translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Placed {
    /// Translation.
    pub(crate) translation: [f32; 3],
    /// Unit quaternion, xyzw.
    pub(crate) rotation: [f32; 4],
    /// Factors along the node's axes.
    pub(crate) scale: [f32; 3],
}

impl Placed {
    /// The identity.
    pub(crate) const AT_PARENT: Self =
        Self { translation: [0.0; 3], rotation: [0.0, 0.0, 0.0, 1.0], scale: [1.0; 3] };

    /// Writes the components that differ from the identity into a node's members.
    pub(crate) fn state(&self, node: &mut Value) {
        let Self { translation, rotation, scale } = *self;
        let rest = Self::AT_PARENT;
        for (name, differs, numbers) in [
            ("translation", translation != rest.translation, json!(translation)),
            ("rotation", rotation != rest.rotation, json!(rotation)),
            ("scale", scale != rest.scale, json!(scale)),
        ] {
            if differs {
                node[name] = numbers;
            }
        }
    }
}

/// The keys of one property of a node: one value a key time.
pub(crate) struct Track {
    /// The node.
    pub(crate) node: NodeIndex,
    /// The values.
    pub(crate) keys: ChannelKeys,
    /// Whether each value holds until the next key, rather than being interpolated linearly.
    pub(crate) holds: bool,
}

/// Lists the keys right before a jump: those one step of single precision before the next key.
pub(crate) fn before_jumps(times: &[f32]) -> impl Iterator<Item = usize> + '_ {
    (1..times.len()).filter(|&key| times[key - 1].next_up() == times[key]).map(|key| key - 1)
}

/// Values of one property.
pub(crate) enum ChannelKeys {
    /// Translations.
    Translation(Vec<[f32; 3]>),
    /// Unit quaternions, xyzw.
    Rotation(Vec<[f32; 4]>),
    /// Scales.
    Scale(Vec<[f32; 3]>),
    /// Weights of a mesh's morph targets; all weights of a key are adjacent.
    Weights(Vec<[f32; 1]>),
}

/// Type and use of an array.
pub(crate) struct ArrayKind {
    component: u32,
    element: &'static str,
    target: Option<u32>,
}

impl ArrayKind {
    /// A vertex attribute.
    pub(crate) const fn vertices(component: u32, element: &'static str) -> Self {
        Self { component, element, target: Some(34962) }
    }

    /// Floats that are not a vertex attribute.
    pub(crate) const fn floats(element: &'static str) -> Self {
        Self { component: F32, element, target: None }
    }
}

impl Document {
    /// Begins an empty document whose asset carries a note.
    pub(crate) fn new(note: &str) -> Self {
        let generator = format!("sinew {}", env!("CARGO_PKG_VERSION"));
        let asset = json!({ "version": "2.0", "generator": generator, "extras": { "note": note } });
        let scenes = json!([{ "nodes": [] }]);
        let root = [("asset", asset), ("scene", json!(0)), ("scenes", scenes)];
        Self::of(root.map(|(name, value)| (name.to_owned(), value)).into_iter().collect(), vec![])
    }

    /// Begins with a file's JSON and the bytes of its single buffer.
    pub(crate) fn of(mut root: Map<String, Value>, bytes: Vec<u8>) -> Self {
        let [nodes, meshes, skins, animations, accessors, views] =
            LISTS.map(|name| take_list(&mut root, name));
        let scene = shown_scene(&mut root);
        let scene = scene.map(|scene| match scene.get_mut("nodes").map(Value::take) {
            Some(Value::Array(nodes)) => nodes,
            _ => Vec::new(),
        });
        let free = Default::default();
        Self { root, nodes, meshes, skins, animations, accessors, views, scene, free, bytes }
    }

    /// Adds a node under a parent, or to the scene.
    pub(crate) fn node(
        &mut self,
        name: String,
        parent: Option<NodeIndex>,
        placed: &Placed,
    ) -> NodeIndex {
        let mut node = json!({ "name": name });
        placed.state(&mut node);
        let node = push(&mut self.nodes, node);
        match parent {
            None => self.show(node),
            Some(parent) => match self.nodes[parent].get_mut("children") {
                Some(Value::Array(children)) => children.push(json!(node)),
                _ => self.nodes[parent]["children"] = json!([node]),
            },
        }
        node
    }

    /// Adds a node to the scene.
    pub(crate) fn show(&mut self, node: NodeIndex) {
        if let Some(scene) = &mut self.scene {
            scene.push(json!(node));
        }
    }

    /// Adds a skin of joints under a common root, with inverse bind matrices (3 x 4, by rows).
    pub(crate) fn skin(
        &mut self,
        root: NodeIndex,
        joints: &[NodeIndex],
        inverse_binds: &[[[f32; 4]; 3]],
    ) -> SkinIndex {
        let matrices = self.matrices(inverse_binds);
        let skin = json!({ "joints": joints, "inverseBindMatrices": matrices, "skeleton": root });
        push(&mut self.skins, skin)
    }

    /// Adds an animation with keys at ascending times, in seconds.
    ///
    /// Between keys, values are interpolated linearly, and rotations along the shorter arc. Tracks that hold their
    /// values have no keys right before jumps.
    pub(crate) fn animation(&mut self, name: &str, times: &[f32], tracks: Vec<Track>) {
        let len = times.len();
        let times: Vec<[f32; 1]> = times.iter().map(|&time| [time]).collect();
        let jumps: Vec<usize> = before_jumps(times.as_flattened()).collect();
        let input = self.key_times(&times);
        let mut input_of_steps = None;
        let (mut channels, mut samplers) = (Vec::new(), Vec::new());
        for Track { node, keys, holds } in tracks {
            let (input, interpolation, dropped) = match holds {
                false => (input, "LINEAR", &[][..]),
                true => {
                    let kept = || without(times.clone(), &jumps, len);
                    let input = *input_of_steps.get_or_insert_with(|| self.key_times(&kept()));
                    (input, "STEP", &jumps[..])
                }
            };
            let (path, output) = match keys {
                ChannelKeys::Translation(keys) => {
                    ("translation", self.keys("VEC3", keys, dropped, len))
                }
                ChannelKeys::Rotation(keys) => ("rotation", self.keys("VEC4", keys, dropped, len)),
                ChannelKeys::Scale(keys) => ("scale", self.keys("VEC3", keys, dropped, len)),
                ChannelKeys::Weights(keys) => ("weights", self.keys("SCALAR", keys, dropped, len)),
            };
            let sampler =
                json!({ "input": input, "interpolation": interpolation, "output": output });
            let sampler = push(&mut samplers, sampler);
            let target = json!({ "node": node, "path": path });
            channels.push(json!({ "sampler": sampler, "target": target }));
        }
        self.animations.push(json!({ "name": name, "channels": channels, "samplers": samplers }));
    }

    /// Writes curves into the extras of the last animation: C names, the key times, and C values a key. Without curves
    /// there are no extras.
    pub(crate) fn curves(&mut self, names: &[&str], times: &[f32], keys: &[Vec<f64>]) {
        let Some(animation) = self.animations.last_mut().filter(|_| !names.is_empty()) else {
            return;
        };
        let times: Vec<Value> = times.iter().map(|&time| short(time)).collect();
        let row = |key: &Vec<f64>| key.iter().map(|&value| short(value as f32)).collect();
        let values: Vec<Value> = keys.iter().map(row).collect();
        let curves = json!({ "names": names, "times": times, "values": values });
        animation["extras"] = json!({ "curves": curves });
    }

    /// Adds the values of a channel, without those of the `dropped` keys.
    fn keys<const N: usize>(
        &mut self,
        element: &'static str,
        rows: Vec<[f32; N]>,
        dropped: &[usize],
        key_len: usize,
    ) -> ArrayIndex {
        self.floats(ArrayKind::floats(element), &without(rows, dropped, key_len))
    }

    /// Adds key times, with their bounds.
    fn key_times(&mut self, times: &[[f32; 1]]) -> ArrayIndex {
        let input = self.floats(ArrayKind::floats("SCALAR"), times);
        self.bound(input, times);
        input
    }

    /// Returns the bytes of the file.
    ///
    /// # Errors
    /// The file would be larger than binary glTF allows, or its JSON cannot be written.
    pub(crate) fn finish(mut self) -> Result<Vec<u8>, Error> {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let scene = shown_scene(&mut self.root).zip(self.scene);
        if let Some((scene, nodes)) = scene.filter(|(_, nodes)| !nodes.is_empty()) {
            scene["nodes"] = Value::Array(nodes);
        }
        let lists =
            [self.nodes, self.meshes, self.skins, self.animations, self.accessors, self.views];
        for (name, items) in LISTS.into_iter().zip(lists) {
            if !items.is_empty() {
                self.root.insert(name.to_owned(), Value::Array(items));
            }
        }
        let first = self.root.get_mut("buffers").and_then(|buffers| buffers.get_mut(0));
        let mut buffer = first.map_or(json!({}), Value::take);
        buffer["byteLength"] = json!(self.bytes.len());
        self.root.insert("buffers".to_owned(), json!([buffer]));
        let unwritten = |error: serde_json::Error| {
            let message = format!("cannot be put together: {error}");
            Error::new(ErrorKind::Write, message).caused_by(error)
        };
        let mut json = serde_json::to_vec(&self.root).map_err(unwritten)?;
        json.resize(json.len().next_multiple_of(4), b' ');
        let bytes = HEADS + json.len() + self.bytes.len();
        let too_large = |_| {
            Error::limit(format!(
                "the file takes {bytes} bytes, and binary glTF holds 4 GiB: export fewer frames"
            ))
        };
        let length = u32::try_from(bytes).map_err(too_large)?;
        let mut glb = Vec::with_capacity(bytes);
        glb.extend(b"glTF");
        glb.extend([2, length].map(u32::to_le_bytes).as_flattened());
        for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &self.bytes)] {
            glb.extend((chunk.len() as u32).to_le_bytes());
            glb.extend(kind);
            glb.extend(chunk);
        }
        Ok(glb)
    }

    /// Adds the vertex indices of triangles.
    pub(crate) fn indices(&mut self, triangles: &[[usize; 3]], vertex_len: usize) -> ArrayIndex {
        let corners = triangles.as_flattened();
        // The largest index of a type stays unused, because some engines restart a strip there.
        let (component, len) =
            if vertex_len <= usize::from(u16::MAX) { (U16, 2) } else { (U32, 4) };
        let bytes =
            corners.iter().flat_map(|&vertex| (vertex as u32).to_le_bytes().into_iter().take(len));
        let kind = ArrayKind { component, element: "SCALAR", target: Some(34963) };
        self.array(kind, corners.len(), bytes.collect())
    }

    /// Adds matrices (3 x 4, by rows).
    pub(crate) fn matrices(&mut self, matrices: &[[[f32; 4]; 3]]) -> ArrayIndex {
        let columns = |m: &[[f32; 4]; 3]| -> [f32; 16] {
            std::array::from_fn(|at| match (at % 4, at / 4) {
                (3, 3) => 1.0,
                (3, _) => 0.0,
                (row, column) => m[row][column],
            })
        };
        let matrices: Vec<[f32; 16]> = matrices.iter().map(columns).collect();
        self.floats(ArrayKind::floats("MAT4"), &matrices)
    }

    /// Adds rows of floats.
    pub(crate) fn floats<const N: usize>(
        &mut self,
        kind: ArrayKind,
        rows: &[[f32; N]],
    ) -> ArrayIndex {
        let bytes = rows.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
        self.array(kind, rows.len(), bytes)
    }

    /// Adds an array in a separate view, aligned to four bytes.
    pub(crate) fn array(&mut self, kind: ArrayKind, len: usize, bytes: Vec<u8>) -> ArrayIndex {
        let ArrayKind { component, element, target } = kind;
        let view = self.view(bytes);
        if let Some(target) = target {
            self.views[view]["target"] = json!(target);
        }
        let accessor = json!({
            "bufferView": view, "componentType": component, "count": len, "type": element,
        });
        put(&mut self.accessors, &mut self.free[0], accessor)
    }

    /// Adds bytes, aligned to four, and returns their view.
    pub(crate) fn view(&mut self, bytes: Vec<u8>) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let begin = self.bytes.len();
        let view = json!({ "buffer": 0, "byteOffset": begin, "byteLength": bytes.len() });
        self.bytes.extend(bytes);
        put(&mut self.views, &mut self.free[1], view)
    }

    /// Writes an array's bounds, which glTF requires for positions and key times.
    pub(crate) fn bound<const N: usize>(&mut self, array: ArrayIndex, rows: &[[f32; N]]) {
        let bound = |choose: fn(f32, f32) -> f32, from: f32| -> Value {
            let all = |axis: usize| rows.iter().map(|row| row[axis]).fold(from, choose);
            (0..N).map(all).collect()
        };
        self.accessors[array]["min"] = bound(f32::min, f32::INFINITY);
        self.accessors[array]["max"] = bound(f32::max, f32::NEG_INFINITY);
    }
}

/// Returns a number with no more digits than single precision needs.
fn short(number: f32) -> Value {
    json!(number.to_string().parse::<f64>().unwrap_or(f64::from(number)))
}

/// Removes the rows of the given keys; `rows` has equally many rows for each of `key_len` keys.
fn without<const N: usize>(rows: Vec<[f32; N]>, keys: &[usize], key_len: usize) -> Vec<[f32; N]> {
    let width = (rows.len() / key_len.max(1)).max(1);
    let kept = rows.chunks(width).enumerate().filter(|(key, _)| keys.binary_search(key).is_err());
    kept.flat_map(|(_, rows)| rows).copied().collect()
}

/// Removes a list from the members of an object; empty if there is none.
pub(super) fn take_list(members: &mut Map<String, Value>, name: &str) -> Vec<Value> {
    match members.remove(name) {
        Some(Value::Array(items)) => items,
        _ => Vec::new(),
    }
}

/// Returns the default scene of a file.
fn shown_scene(root: &mut Map<String, Value>) -> Option<&mut Value> {
    let shown = root.get("scene").and_then(Value::as_u64).unwrap_or(0) as usize;
    root.get_mut("scenes")?.get_mut(shown)
}

/// Adds an item to a list and returns its index.
pub(super) fn push(items: &mut Vec<Value>, item: Value) -> usize {
    items.push(item);
    items.len() - 1
}

/// Stores an item at a free index, or else at the end.
fn put(items: &mut Vec<Value>, free: &mut Vec<usize>, item: Value) -> usize {
    match free.pop() {
        None => push(items, item),
        Some(place) => {
            items[place] = item;
            place
        }
    }
}
