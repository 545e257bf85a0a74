//! Writes a grid as binary glTF: layers are flat meshes, nodes are morph targets, and pictures are textures.

use super::grid::{Grid, nothing_drawn};
use super::shown::{Shown, descending, elements, name, numbered, triangles, uvs};
use crate::Error;
use crate::formats::gltf::write::{ArrayKind, Document, F32, Placed};
use crate::page::picture::Picture;
use crate::views::player::Player;
use serde_json::{Map, Value, json};
use sinew_runtime::Model;
use std::collections::BTreeMap;

/// Description inside the file.
const NOTE: &str = "An object of views: each morph target is what it is at the parameters of its name. The screen is one \
    unit high, its middle is the origin, y goes up and z to the viewer.";
/// Extension of every material: a picture without lighting.
const UNLIT: &str = "KHR_materials_unlit";
/// Distance from each layer to the next one behind, in heights of the screen.
const STEP: f64 = 1e-3;

/// Writes a scene. The middle node is the rest shape.
///
/// The key view with the largest share at rest textures a layer. With depth a key view is chosen for each element.
/// Elements of one layer and view form a primitive. Layers without depth are stacked by small steps, in their order at
/// rest. Quads are split in two. Layers that are hidden at rest are left out.
///
/// # Errors
/// The file has no such map; nothing is drawn at any node; a picture cannot be encoded; or the scene is too large.
pub fn glb(model: &Model<Vec<u8>>, map: Option<&str>, grid: &Grid) -> Result<Vec<u8>, Error> {
    let player = Player::new(model, map)?;
    let views = player.views();
    let shown: Vec<Shown<'_>> =
        grid.nodes.iter().map(|node| Shown::new(&player, &node.played)).collect();
    let rest = shown.get(shown.len() / 2).ok_or_else(nothing_drawn)?;
    let mut document = Document::new(NOTE);
    let mut looks = Looks::default();
    let mut primitives = Vec::new();
    for (step, layer) in rest.layers().into_iter().enumerate() {
        let opacity = rest.opacity(layer);
        let Some(has_depth) = views.layer(layer).map(|layer| layer.has_depth) else { continue };
        let by_view = textured(&player, rest, layer, has_depth);
        if by_view.is_empty() || opacity <= 0.0 {
            continue;
        }
        let all: Vec<[usize; 3]> = by_view.values().flatten().copied().collect();
        let (vertices, all) = numbered(&all);
        let mut left = all.as_slice();
        let before = if has_depth { 0.0 } else { STEP * step as f64 };
        let (positions, targets) =
            shapes(&mut document, &shown, rest, &vertices, player.size(), before);
        for (view, own) in by_view {
            let (triangles, others) = left.split_at(own.len());
            left = others;
            let Some(picture) = player.key_picture(view, layer) else { continue };
            let uvs = uvs(views, view, &vertices, picture.size);
            let uvs = document.floats(ArrayKind::vertices(F32, "VEC2"), &uvs);
            let name = name(views, layer, view);
            primitives.push(json!({
                "attributes": { "POSITION": positions, "TEXCOORD_0": uvs },
                "indices": document.indices(triangles, vertices.len()),
                "mode": 4,
                "targets": targets,
                "material": looks.add(&mut document, &name, &picture, opacity, has_depth)?,
            }));
        }
    }
    if primitives.is_empty() {
        return Err(nothing_drawn());
    }
    looks.state(&mut document.root);
    let names: Vec<&str> = grid.nodes.iter().map(|node| node.name.as_str()).collect();
    document.meshes.push(json!({
        "name": views.name(), "primitives": primitives, "weights": vec![0.0; names.len()],
        "extras": { "targetNames": names },
    }));
    let node = document.node(views.name().to_owned(), None, &Placed::AT_PARENT);
    document.nodes[node]["mesh"] = json!(document.meshes.len() - 1);
    document.finish()
}

/// Lists the triangles of a layer by the key view that textures them. Triangles are indices of vertices.
fn textured(
    player: &Player<'_>,
    rest: &Shown<'_>,
    layer: usize,
    has_depth: bool,
) -> BTreeMap<usize, Vec<[usize; 3]>> {
    let views = player.views();
    let ranking = if has_depth { rest.ranking() } else { descending(&rest.shares(layer)) };
    let mut pictured = ranking.iter().filter(|&&view| views.view_texture(view, layer).is_some());
    let most = pictured.next().copied();
    let mut out: BTreeMap<usize, Vec<[usize; 3]>> = BTreeMap::new();
    for (_, element) in elements(views, layer) {
        let view = if has_depth { rest.texture(layer, &element, &ranking) } else { most };
        if let Some(view) = view {
            out.entry(view).or_default().extend(triangles(&element));
        }
    }
    out
}

/// Adds the positions at rest, and the offsets of each node.
///
/// - `vertices`: indices of the vertices.
/// - `before`: offset towards the viewer, in heights of the screen.
fn shapes(
    document: &mut Document,
    shown: &[Shown<'_>],
    rest: &Shown<'_>,
    vertices: &[usize],
    [width, height]: [usize; 2],
    before: f64,
) -> (usize, Vec<Value>) {
    let [width, height] = [width, height].map(|side| side as f64);
    let placed = |shown: &Shown<'_>| -> Vec<[f64; 3]> {
        let place = |&vertex: &usize| {
            let [x, y, depth] = shown.places[vertex];
            [(x - 0.5 * width) / height, (0.5 * height - y) / height, before - depth / height]
        };
        vertices.iter().map(place).collect()
    };
    let mut array = |rows: Vec<[f64; 3]>| {
        let rows: Vec<[f32; 3]> = rows.into_iter().map(|row| row.map(|x| x as f32)).collect();
        let at = document.floats(ArrayKind::vertices(F32, "VEC3"), &rows);
        document.bound(at, &rows);
        at
    };
    let rest = placed(rest);
    let positions = array(rest.clone());
    let target = |shown: &Shown<'_>| {
        let apart = |(place, rest): (&[f64; 3], &[f64; 3])| [0, 1, 2].map(|k| place[k] - rest[k]);
        let rows = placed(shown).iter().zip(&rest).map(apart).collect();
        json!({ "POSITION": array(rows) })
    };
    (positions, shown.iter().map(target).collect())
}

/// Materials, their textures and images.
#[derive(Default)]
struct Looks {
    materials: Vec<Value>,
    textures: Vec<Value>,
    images: Vec<Value>,
}

impl Looks {
    /// Adds the picture of a layer in a key view.
    fn add(
        &mut self,
        document: &mut Document,
        name: &str,
        picture: &Picture,
        opacity: f64,
        has_depth: bool,
    ) -> Result<usize, Error> {
        let number = self.materials.len();
        let bytes = document.view(picture.png()?);
        self.images.push(json!({ "name": name, "bufferView": bytes, "mimeType": "image/png" }));
        self.textures.push(json!({ "source": number, "sampler": 0 }));
        // BLEND materials keep the drawing order of layers without depth, since they hide nothing.
        let alpha = if has_depth { "MASK" } else { "BLEND" };
        self.materials.push(json!({
            "name": name,
            "pbrMetallicRoughness": {
                "baseColorFactor": [1.0, 1.0, 1.0, opacity],
                "baseColorTexture": { "index": number }, "metallicFactor": 0.0,
            },
            "alphaMode": alpha,
            "doubleSided": true,
            "extensions": { UNLIT: {} },
        }));
        Ok(number)
    }

    fn state(self, root: &mut Map<String, Value>) {
        // Linear filters, and clamping at the edges.
        let sampler =
            json!({ "magFilter": 9729, "minFilter": 9729, "wrapS": 33071, "wrapT": 33071 });
        for (name, items) in [
            ("materials", self.materials),
            ("textures", self.textures),
            ("images", self.images),
            ("samplers", vec![sampler]),
            ("extensionsUsed", vec![json!(UNLIT)]),
        ] {
            root.insert(name.to_owned(), Value::Array(items));
        }
    }
}
