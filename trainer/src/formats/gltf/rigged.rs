//! glTF files that are kept whole to be extended, and the appearance of their meshes.

use super::file::{self, Buffers, Parsed, is_surface, triangles};
use super::meshes::{default_weights, has_surface, shaped};
use super::skins::Skins;
use super::write::{push, take_list};
use crate::Error;
use crate::formats::appearance::{Appearance, Image, image_kind, missing_image};
use crate::formats::scene::faults;
use ::gltf::{Document, Semantic};
use nalgebra::Matrix4;
use serde_json::{Map, Value, json};
use std::path::Path;

/// Extensions that compress vertices, so that only readers of the extension see them.
const COMPRESSIONS: [&str; 3] =
    ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"];

/// A glTF file kept whole, with the places of its meshes and joints.
#[derive(Clone, Debug)]
pub(crate) struct RiggedFile {
    /// All members of the JSON; external files are embedded.
    pub(crate) tree: Map<String, Value>,
    /// Bytes of the single buffer.
    pub(crate) bytes: Vec<u8>,
    /// Names of the nodes; made up for nodes without a name, and unique for joints.
    pub(crate) names: Vec<String>,
    /// Parent of each node.
    pub(crate) parents: Vec<Option<usize>>,
    /// Nodes, parents before children.
    pub(crate) order: Vec<usize>,
    /// Transform of each node without animation.
    pub(crate) locals: Vec<Matrix4<f64>>,
    /// Bind frame of each node that is a joint, in the common bind space.
    pub(crate) binds: Vec<Option<Matrix4<f64>>>,
    /// Meshes of the character: all with a skin, or all meshes if none has a skin.
    pub(crate) meshes: Vec<RiggedMesh>,
}

/// A mesh and the node that shows it.
#[derive(Clone, Debug)]
pub(crate) struct RiggedMesh {
    /// Index of the node.
    pub(crate) node: usize,
    /// Index of the mesh.
    pub(crate) mesh: usize,
    /// Name of the node, or else of the mesh.
    pub(crate) name: String,
    /// Index of the skin.
    pub(crate) skin: Option<usize>,
    /// Transform from the mesh to the space in which joints are bound; without joints, to the space of the first mesh.
    pub(crate) to_bind: Matrix4<f64>,
    /// Positions of each primitive, with morph targets at their default weights.
    pub(crate) positions: Vec<Vec<[f64; 3]>>,
    /// Whether each primitive consists of triangles, rather than points or lines.
    pub(crate) surfaces: Vec<bool>,
}

impl RiggedFile {
    /// Reads a file, its buffers and its images.
    ///
    /// # Errors
    /// The file cannot be read, a part is damaged, or meshes are compressed.
    pub(crate) fn read(path: &Path) -> Result<Self, Error> {
        let bytes = file::read(path)?;
        let parsed = file::parse(&bytes, path)?;
        let Parsed { document, buffers, nodes, .. } = &parsed;
        let compressed = |name: &&str| document.extensions_used().any(|used| used == *name);
        if let Some(name) = COMPRESSIONS.iter().find(|name| compressed(name)) {
            return Err(file::unread_extension(name));
        }
        if nodes.is_empty() {
            return Err(faults::empty());
        }
        let (meshes, skins) = meshes(&parsed)?;
        let mut file = Self {
            tree: file::tree(&bytes)?,
            bytes: Vec::new(),
            names: nodes.tree.unique_names(|node| skins.joints.contains(&node)).0,
            parents: nodes.tree.parents.clone(),
            order: nodes.order.clone(),
            locals: nodes.locals.iter().map(|local| local.matrix()).collect(),
            binds: skins.binds_of_nodes(nodes),
            meshes,
        };
        file.join_buffers(document, buffers);
        file.embed_images(path)?;
        Ok(file)
    }

    /// Returns the world transform of every node without animation.
    pub(crate) fn worlds(&self) -> Vec<Matrix4<f64>> {
        let mut worlds = self.locals.clone();
        for &node in &self.order {
            if let Some(parent) = self.parents[node] {
                worlds[node] = worlds[parent] * self.locals[node];
            }
        }
        worlds
    }

    fn items(&mut self, list: &str) -> impl Iterator<Item = &mut Value> {
        self.tree.get_mut(list).and_then(Value::as_array_mut).into_iter().flatten()
    }

    /// Joins all buffers into one; the bytes of the first buffer keep their offsets.
    fn join_buffers(&mut self, document: &Document, buffers: &Buffers) {
        let mut begins = Vec::new();
        for (buffer, bytes) in document.buffers().zip(buffers) {
            self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
            begins.push(self.bytes.len());
            self.bytes.extend(&bytes[..buffer.length()]);
        }
        for view in self.items("bufferViews") {
            let buffer = view["buffer"].as_u64().unwrap_or(0) as usize;
            let begin = begins.get(buffer).copied().unwrap_or(0);
            if begin > 0 {
                let offset = view.get("byteOffset").and_then(Value::as_u64).unwrap_or(0) as usize;
                view["byteOffset"] = json!(begin + offset);
            }
            view["buffer"] = json!(0);
        }
        for buffer in self.items("buffers") {
            buffer.as_object_mut().and_then(|buffer| buffer.remove("uri"));
        }
    }

    /// Embeds the images of external files.
    fn embed_images(&mut self, path: &Path) -> Result<(), Error> {
        let uri = |image: &mut Value| {
            let uri = image.get("uri").and_then(Value::as_str);
            uri.filter(|uri| !uri.starts_with("data:")).map(str::to_owned)
        };
        let uris: Vec<Option<String>> = self.items("images").map(uri).collect();
        for (image, uri) in uris.into_iter().enumerate() {
            let Some(uri) = uri else { continue };
            let damaged = |reason: String| Error::damaged(format!("image {image}: {reason}"));
            let bytes = file::resource(&uri, path).map_err(damaged)?;
            let kind = image_kind(&bytes)
                .ok_or_else(|| damaged(format!("{uri} is no PNG, JPEG, WebP or KTX2 file")))?;
            self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
            let view =
                json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
            self.bytes.extend(bytes);
            let views = self.tree.entry("bufferViews").or_insert_with(|| json!([]));
            let number = views.as_array_mut().map_or(0, |views| push(views, view));
            if let Some(Value::Object(image)) = self.items("images").nth(image) {
                image.remove("uri");
                image.insert("bufferView".to_owned(), json!(number));
                image.insert("mimeType".to_owned(), json!(kind));
            }
        }
        Ok(())
    }
}

/// Lists the meshes of a character, with the nodes that show them: all with a skin, or all meshes if none has a skin.
pub(super) fn shown_meshes(file: &Parsed) -> Vec<(::gltf::Mesh<'_>, ::gltf::Node<'_>)> {
    let all = file.document.nodes().filter(|node| file.nodes.shown[node.index()]);
    let mut all: Vec<_> = all
        .filter_map(|node| Some((node.mesh()?, node)))
        .filter(|(mesh, _)| has_surface(mesh))
        .collect();
    if all.iter().any(|(_, node)| node.skin().is_some()) {
        all.retain(|(_, node)| node.skin().is_some());
    }
    all
}

/// Reads the appearance of the meshes that [`read`](super::read) reads.
///
/// # Errors
/// The file cannot be read, or a part is damaged.
pub(in crate::formats) fn read_appearance(path: &Path) -> Result<Appearance, Error> {
    let bytes = file::read(path)?;
    let parsed = file::parse(&bytes, path)?;
    let Parsed { document, buffers, .. } = &parsed;
    let mut tree = file::tree(&bytes)?;
    let meshes = shown_meshes(&parsed);
    let primitives = meshes.iter().flat_map(|(mesh, _)| mesh.primitives());
    let mut of_triangles = Vec::new();
    for primitive in primitives.filter(is_surface) {
        let positions = primitive.get(&Semantic::Positions);
        let vertex_len = positions.map_or(0, |positions| positions.count());
        let place = || "the meshes".to_owned();
        let count = triangles(&primitive, buffers, vertex_len, place)?.len();
        of_triangles.extend(std::iter::repeat_n(primitive.material().index(), count));
    }
    let mut list = |name: &str| take_list(&mut tree, name);
    let mut appearance = Appearance {
        mesh: match meshes.as_slice() {
            [(mesh, node)] => node.name().or(mesh.name()).map(str::to_owned),
            _ => None,
        },
        of_triangles,
        materials: list("materials"),
        textures: list("textures"),
        samplers: list("samplers"),
        ..Appearance::default()
    };
    let mut images = Vec::new();
    for (number, members) in list("images").into_iter().enumerate() {
        let Value::Object(members) = members else { continue };
        let name = ["name", "uri"].iter().find_map(|name| members.get(*name)?.as_str());
        let name = name.filter(|name| !name.starts_with("data:")).map(str::to_owned);
        let uri = members.get("uri").and_then(Value::as_str);
        let looked_for = uri.and_then(|uri| file::beside(uri, path).ok());
        let found = picture(members, document, buffers, path);
        if found.is_none() {
            let name = name.unwrap_or_else(|| format!("image {number}"));
            appearance.missing.push(missing_image(&name, looked_for.as_slice()));
        }
        images.push(found);
    }
    appearance.set_images(images);
    let required = list("extensionsRequired");
    let used = appearance.extensions();
    let required = required.into_iter().filter_map(|name| name.as_str().map(str::to_owned));
    appearance.required = required.filter(|name| used.contains(name)).collect();
    Ok(appearance)
}

/// Reads the meshes of a character and their joints.
fn meshes(file: &Parsed) -> Result<(Vec<RiggedMesh>, Skins), Error> {
    let nodes = &file.nodes;
    let worlds = nodes.worlds(&nodes.locals);
    let mut skins = Skins::default();
    let mut meshes: Vec<RiggedMesh> = Vec::new();
    for (mesh, node) in shown_meshes(file) {
        let name = nodes.tree.names[node.index()].clone();
        let name = node.name().or(mesh.name()).map_or(name, str::to_owned);
        let skin = node.skin().map(|skin| skin.index());
        let to_bind = match node.skin() {
            Some(skin) => skins.join(&skin, file, &name)?.shift,
            None => meshes
                .first()
                .and_then(|first| worlds[first.node].try_inverse())
                .map_or_else(Matrix4::identity, |back| back * worlds[node.index()]),
        };
        let weights = default_weights(&node, &mesh);
        let place = || format!("mesh {name}");
        let positions = mesh
            .primitives()
            .map(|primitive| shaped(&primitive, Semantic::Positions, &weights, file, place));
        let positions = positions.collect::<Result<_, Error>>()?;
        let surfaces = mesh.primitives().map(|primitive| is_surface(&primitive)).collect();
        let (node, mesh) = (node.index(), mesh.index());
        meshes.push(RiggedMesh { node, mesh, name, skin, to_bind, positions, surfaces });
    }
    Ok((meshes, skins))
}

/// Returns an image with its bytes; `None` if they cannot be read or are no known kind of image.
fn picture(
    mut members: Map<String, Value>,
    document: &Document,
    buffers: &Buffers,
    path: &Path,
) -> Option<Image> {
    members.remove("mimeType");
    let bytes = match (members.remove("bufferView"), members.remove("uri")) {
        (Some(view), _) => {
            let view = document.views().nth(view.as_u64()? as usize)?;
            let buffer = buffers.get(view.buffer().index())?;
            let end = view.offset().checked_add(view.length())?;
            buffer.get(view.offset()..end)?.to_vec()
        }
        (None, uri) => file::resource(uri?.as_str()?, path).ok()?,
    };
    image_kind(&bytes)?;
    Some(Image { members, bytes })
}
