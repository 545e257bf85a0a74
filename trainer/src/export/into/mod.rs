//! Puts a model and its clips into an artist's file.
//!
//! The model's meshes get joints and weights. The file's skeleton gets keys, and proxies as children of its joints.
//! Nothing else in the file changes.

mod find;
mod joints;

use std::collections::{BTreeSet, HashMap, HashSet};
use std::path::Path;

use nalgebra::Matrix4;
use serde_json::{Value, json};

use self::find::Found;
use self::joints::OwnJoints;
use super::chains::ChainNodes;
use super::play::Playback;
use super::skeleton::{rounded, wide};
use crate::Error;
use crate::envelope::levels::LevelReport;
use crate::formats::gltf::rigged::{RiggedFile, RiggedMesh};
use crate::formats::gltf::write::Document;
use crate::formats::scene::JointNames;

/// An artist's file that plays a model.
pub struct Grafted {
    /// Bytes of the file.
    pub glb: Vec<u8>,
    /// Names of the meshes that follow the model.
    pub meshes: Vec<String>,
    /// Joints that were added because the file lacked them.
    pub added_joints: Vec<String>,
    /// The added animations, one for each clip.
    pub animations: Vec<String>,
    /// Animations of the file that move the same joints, but no proxies.
    pub kept_animations: Vec<String>,
    /// Reports on the further meshes, in order.
    pub levels: Vec<LevelReport>,
}

/// Attributes of vertices, each with its array.
type Attributes = Vec<(String, Value)>;

/// Rows of an affine map.
type Rows = [[f32; 4]; 3];

/// Puts a model into an artist's GLB or glTF. Meshes with the model's vertices are found by position, joints are found
/// by name. The meshes then follow the file's own joints and proxies under these joints, and an animation is added for
/// each clip. Everything else stays.
#[derive(Clone, Copy)]
pub struct ExportInto<'a> {
    /// The model and its clips.
    pub playback: Playback<'a>,
    /// Conversion of the file's joint names to the model's.
    pub names: JointNames<'a>,
    /// The artist's file.
    pub file: &'a Path,
}

impl ExportInto<'_> {
    /// Writes the file.
    ///
    /// # Errors
    /// - The errors of [`Export::run`](crate::export::Export::run) about the model, clips and further meshes.
    /// - The file cannot be read, lacks the model's mesh, or cannot hold its motion; the error names the file.
    pub fn run(&self) -> Result<Grafted, Error> {
        let Self { playback, names, file: path } = *self;
        let Playback { examples, clips, levels, .. } = playback;
        let in_file = |error: Error| error.in_file(path);
        let file = RiggedFile::read(path).map_err(in_file)?;
        let (played, further) = playback.play()?;
        let known = joints::nodes(&file, &played.skeleton.names, &names).map_err(in_file)?;
        let root = known.get(played.skeleton.root()).copied().flatten();
        let found = Found::new(&file, root, &played.rest, examples.diagonal(), &played.poses)
            .map_err(in_file)?;

        let mut document = Document::of(file.tree.clone(), file.bytes.clone());
        // Without proxies, the file's animations move the whole character.
        let has_proxies = !played.centres.is_empty();
        let kept_animations = if has_proxies { moving(&document, &known) } else { Vec::new() };
        let joints =
            OwnJoints::new(&mut document, &file, &found, &played, &known).map_err(in_file)?;
        let proxies =
            ChainNodes::new(&mut document, &joints.carriers(), played.proxies().collect());
        let first_proxy = played.first_proxy();
        let (mut nodes, mut proxy_binds) = (Vec::new(), Vec::new());
        proxies.bind(&mut nodes, &mut proxy_binds);
        let nodes = [&joints.nodes[..first_proxy], &nodes].concat();
        // Maps from the model's rest mesh to each joint's space.
        let mut inverse_binds: Vec<_> =
            (0..first_proxy).map(|joint| joints.inverse_bind(joint)).collect();
        for (bind, &joint) in proxy_binds.iter().zip(&played.carriers) {
            inverse_binds.push(Matrix4::new_scaling(1.0 / joints.units[joint]) * wide(bind));
        }

        let graft =
            Graft { file: &file, found: &found, nodes: &nodes, inverse_binds: &inverse_binds };
        graft.release(&mut document);
        graft.skins(&mut document, joints.added.is_empty());
        graft.weights(&mut document, &played.influences);
        for mesh in graft.meshes().map(|(mesh, _)| mesh) {
            to_root(&mut document, &file, mesh);
        }
        if !levels.is_empty() {
            let rows = graft.rows(&Matrix4::identity());
            let matrices = document.matrices(&rows);
            document.skins.push(json!({ "joints": nodes, "inverseBindMatrices": matrices }));
            let skin = document.skins.len() - 1;
            further.add(&mut document, skin);
        }
        let mut animations = Vec::new();
        for ((clip, times), own) in clips.iter().zip(&played.times).zip(played.clips()) {
            let (mut tracks, worlds) =
                joints.tracks(&played.poses[own.clone()], times).map_err(in_file)?;
            tracks.extend(proxies.tracks(&played.palettes[own.clone()], &worlds));
            let name = free_name(&document, &clip.name);
            document.animation(&name, times, tracks);
            document.curves(&played.curve_names(), times, &played.curves[own]);
            animations.push(name);
        }
        Ok(Grafted {
            meshes: graft.meshes().map(|(mesh, _)| mesh.name.clone()).collect(),
            glb: document.finish()?,
            added_joints: joints.added,
            animations,
            kept_animations,
            levels: further.reports,
        })
    }
}

/// A file, and the palette for its meshes.
struct Graft<'a> {
    file: &'a RiggedFile,
    found: &'a Found,
    /// Nodes of the palette.
    nodes: &'a [usize],
    /// Map from the model's rest mesh to the space of each node.
    inverse_binds: &'a [Matrix4<f64>],
}

impl Graft<'_> {
    /// Lists the meshes that belong to the model, each with the model's vertices by primitive.
    fn meshes(&self) -> impl Iterator<Item = (&RiggedMesh, &Vec<Vec<usize>>)> {
        let all = self.file.meshes.iter().zip(&self.found.vertices);
        all.filter_map(|(mesh, vertices)| Some((mesh, vertices.as_ref()?)))
    }

    /// Removes the meshes' old joints and weights, and the skins that no mesh then uses.
    fn release(&self, document: &mut Document) {
        let mut arrays = Vec::new();
        for (mesh, _) in self.meshes() {
            for primitive in primitives(&mut document.meshes[mesh.mesh]) {
                let Some(Value::Object(attributes)) = primitive.get_mut("attributes") else {
                    continue;
                };
                attributes.retain(|name, array| {
                    let old = name.starts_with("JOINTS_") || name.starts_with("WEIGHTS_");
                    arrays.extend(array.as_u64().filter(|_| old));
                    !old
                });
            }
            document.nodes[mesh.node].as_object_mut().and_then(|node| node.remove("skin"));
        }
        for skin in self.meshes().filter_map(|(mesh, _)| mesh.skin) {
            if !document.nodes.iter().any(|node| node.get("skin") == Some(&json!(skin))) {
                let members = document.skins[skin].as_object_mut();
                let matrices = members.and_then(|skin| skin.remove("inverseBindMatrices"));
                arrays.extend(matrices.as_ref().and_then(Value::as_u64));
            }
        }
        document.free_unused(arrays.into_iter().map(|array| array as usize));
    }

    /// Connects the meshes to the palette. Meshes with the same bind share one skin, which replaces a skin that only
    /// they used.
    fn skins(&self, document: &mut Document, own_root: bool) {
        let mut made: Vec<(Matrix4<f64>, usize)> = Vec::new();
        for (mesh, _) in self.meshes() {
            let known = made.iter().find(|(bound, _)| *bound == mesh.to_bind);
            let skin = known.map(|(_, skin)| *skin).unwrap_or_else(|| {
                let rows = self.rows(&(self.found.to_model * mesh.to_bind));
                let matrices = document.matrices(&rows);
                let free = mesh.skin.filter(|&skin| {
                    document.nodes.iter().all(|node| node.get("skin") != Some(&json!(skin)))
                });
                let place = free.unwrap_or_else(|| {
                    document.skins.push(json!({}));
                    document.skins.len() - 1
                });
                let skin = &mut document.skins[place];
                skin["joints"] = json!(self.nodes);
                skin["inverseBindMatrices"] = json!(matrices);
                if !own_root {
                    skin.as_object_mut().and_then(|skin| skin.remove("skeleton"));
                }
                made.push((mesh.to_bind, place));
                place
            });
            document.nodes[mesh.node]["skin"] = json!(skin);
        }
    }

    /// Returns the inverse bind matrices of a mesh; `to_model` maps the mesh to the model's rest mesh.
    fn rows(&self, to_model: &Matrix4<f64>) -> Vec<Rows> {
        self.inverse_binds.iter().map(|bind| rounded(&(bind * to_model))).collect()
    }

    /// Gives the meshes' vertices the influences of the model's vertices.
    fn weights(&self, document: &mut Document, influences: &[Vec<(usize, f64)>]) {
        // Primitives with the same positions and the same model vertices share attributes.
        let mut made: HashMap<(Option<u64>, &[usize]), Attributes> = HashMap::new();
        let mut shown: HashMap<usize, &Vec<Vec<usize>>> = HashMap::new();
        for (mesh, vertices) in self.meshes() {
            let mut own = mesh.mesh;
            if *shown.entry(own).or_insert(vertices) != vertices {
                // Another node uses this mesh for other vertices of the model.
                let copy = document.meshes[own].clone();
                document.meshes.push(copy);
                own = document.meshes.len() - 1;
                document.nodes[mesh.node]["mesh"] = json!(own);
            }
            for (number, vertices) in vertices.iter().enumerate().filter(|(_, v)| !v.is_empty()) {
                let primitive = primitives(&mut document.meshes[own]).nth(number);
                let positions = primitive.and_then(|p| p["attributes"]["POSITION"].as_u64());
                let key = (positions, vertices.as_slice());
                let attributes = made.entry(key).or_insert_with(|| {
                    let own: Vec<_> = vertices.iter().map(|&v| influences[v].clone()).collect();
                    document.influences(&own, self.nodes.len())
                });
                for primitive in primitives(&mut document.meshes[own]).skip(number).take(1) {
                    for (name, array) in attributes.iter() {
                        primitive["attributes"][name] = array.clone();
                    }
                }
            }
        }
    }
}

fn primitives(mesh: &mut Value) -> impl Iterator<Item = &mut Value> {
    mesh.get_mut("primitives").and_then(Value::as_array_mut).into_iter().flatten()
}

/// Moves a mesh's node to the root of the scene, as glTF recommends for skinned meshes, whose node transforms are
/// ignored. A node with children stays.
fn to_root(document: &mut Document, file: &RiggedFile, mesh: &RiggedMesh) {
    let node = mesh.node;
    if document.nodes[node].get("children").is_some() {
        return;
    }
    if let Some(parent) = file.parents[node] {
        let parent = &mut document.nodes[parent];
        let children = parent.get_mut("children").and_then(Value::as_array_mut);
        let left = children.map(|children| {
            children.retain(|child| *child != json!(node));
            children.len()
        });
        if left == Some(0) {
            parent.as_object_mut().and_then(|parent| parent.remove("children"));
        }
        document.show(node);
    }
    for name in ["matrix", "translation", "rotation", "scale"] {
        document.nodes[node].as_object_mut().and_then(|node| node.remove(name));
    }
}

/// Lists the names of the animations that move joints.
fn moving(document: &Document, joints: &[Option<usize>]) -> Vec<String> {
    let moves = |animation: &Value| {
        list(animation, "channels").any(|channel| {
            let node = channel["target"]["node"].as_u64().map(|node| node as usize);
            node.is_some() && joints.contains(&node)
        })
    };
    let name = |(number, animation): (usize, &Value)| match animation["name"].as_str() {
        Some(name) => name.to_owned(),
        None => format!("animation {number}"),
    };
    let all = document.animations.iter().enumerate();
    all.filter(|(_, animation)| moves(animation)).map(name).collect()
}

/// Returns the clip's name, or a similar name that no animation of the file has.
fn free_name(document: &Document, name: &str) -> String {
    let taken = |name: &str| document.animations.iter().any(|a| a["name"].as_str() == Some(name));
    let further = (2..).map(|number| format!("{name} (sinew {number})"));
    let names = [name.to_owned(), format!("{name} (sinew)")].into_iter().chain(further);
    names.into_iter().find(|name| !taken(name)).unwrap_or_default()
}

impl Document {
    /// Frees arrays that nothing uses, and views that only these arrays used, for new content. Their bytes stay.
    fn free_unused(&mut self, arrays: impl IntoIterator<Item = usize>) {
        let primitives = self.meshes.iter().flat_map(|mesh| list(mesh, "primitives"));
        let in_primitives = primitives.flat_map(|primitive| {
            let targets = list(primitive, "targets").flat_map(members);
            let attributes = primitive.get("attributes").into_iter().flat_map(members);
            attributes.chain(targets).chain(primitive.get("indices"))
        });
        let in_skins = self.skins.iter().filter_map(|skin| skin.get("inverseBindMatrices"));
        let samplers = self.animations.iter().flat_map(|animation| list(animation, "samplers"));
        let in_samplers =
            samplers.flat_map(|sampler| [sampler.get("input"), sampler.get("output")]).flatten();
        let used = in_primitives.chain(in_skins).chain(in_samplers).filter_map(Value::as_u64);
        let used: HashSet<usize> = used.map(|array| array as usize).collect();
        let arrays: BTreeSet<usize> =
            arrays.into_iter().filter(|array| !used.contains(array)).collect();
        let views = |array: &Value| -> Vec<usize> {
            let sparse = array.get("sparse");
            let parts = ["indices", "values"].map(|part| sparse.and_then(|s| s.get(part)));
            let all = parts.into_iter().flatten().chain([array]);
            let views = all.filter_map(|part| Some(part.get("bufferView")?.as_u64()? as usize));
            views.collect()
        };
        let mut free: BTreeSet<usize> =
            arrays.iter().flat_map(|&array| views(&self.accessors[array])).collect();
        let kept = (0..self.accessors.len()).filter(|array| !arrays.contains(array));
        kept.flat_map(|array| views(&self.accessors[array])).for_each(|view| {
            free.remove(&view);
        });
        // Free indices are taken from the end: the lowest first.
        self.free = [arrays, free].map(|indices| indices.into_iter().rev().collect());
    }
}

fn list<'a>(value: &'a Value, name: &str) -> impl Iterator<Item = &'a Value> {
    value.get(name).and_then(Value::as_array).into_iter().flatten()
}

fn members(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_object().into_iter().flat_map(|members| members.values())
}
