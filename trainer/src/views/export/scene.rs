//! A grid as binary glTF: the object as a flat mesh with its depth, a morph target a node, its pictures as textures.

use super::error::GridError;
use super::grid::{Grid, Node};
use super::sources::{ranking, source, triangles, uvs};
use crate::formats::gltf::write::{ArrayKind, Document, F32, Placed};
use crate::page::picture::Picture;
use crate::views::player::Player;
use serde_json::{Map, Value, json};
use sinew_runtime::Model;
use sinew_runtime::views::Views;

/// What the file says of itself.
const NOTE: &str = "An object of views: each morph target is what it is at the parameters of its name. The screen is one \
    unit high, its middle is the origin, y goes up and z to the viewer.";
/// What every material is: a picture, lit already.
const UNLIT: &str = "KHR_materials_unlit";

/// Writes a scene: at rest the object stands as at the node in the middle.
///
/// Each element is textured by one key view, as it is at rest; elements of one view are a primitive, in which vertex k is
/// point k. Quads are cut in two; elements that no key view shows are left out.
///
/// # Errors
/// [`GridError::Nothing`], and those of writing.
pub fn glb(model: &Model<Vec<u8>>, map: Option<&str>, grid: &Grid) -> Result<Vec<u8>, GridError> {
    let player = Player::new(model, map)?;
    let (views, screen) = (player.views(), player.size());
    let rest = grid.nodes.get(grid.nodes.len() / 2).ok_or(GridError::Nothing)?;
    let ranking = ranking(&rest.played);
    let mut by_view = vec![Vec::new(); views.view_len()];
    for element in player.elements() {
        if let Some(view) = source(views, &element, &ranking) {
            by_view[view].extend(triangles(&element));
        }
    }
    let has_depth = grid.nodes.iter().any(|node| node.played.points.iter().any(|p| p[2] != 0.0));
    let mut document = Document::new(NOTE);
    let (positions, targets) = shapes(&mut document, grid, rest, screen);
    let mut looks = Looks::default();
    let mut primitives = Vec::new();
    for (view, triangles) in by_view.iter().enumerate() {
        let Some(picture) = player.key_picture(view, 0).filter(|_| !triangles.is_empty()) else {
            continue;
        };
        let uvs = uvs(views, view, picture.size);
        let uvs = document.floats(ArrayKind::vertices(F32, "VEC2"), &uvs);
        primitives.push(json!({
            "attributes": { "POSITION": positions, "TEXCOORD_0": uvs },
            "indices": document.indices(triangles, views.point_len()),
            "mode": 4,
            "targets": targets,
            "material": looks.add(&mut document, views, view, &picture, has_depth)?,
        }));
    }
    if primitives.is_empty() {
        return Err(GridError::Nothing);
    }
    looks.state(&mut document.root);
    let names: Vec<&str> = grid.nodes.iter().map(|node| node.name.as_str()).collect();
    document.meshes.push(json!({
        "name": views.name(), "primitives": primitives, "weights": vec![0.0; names.len()],
        "extras": { "targetNames": names },
    }));
    let node = document.node(views.name().to_owned(), None, &Placed::AT_PARENT);
    document.nodes[node]["mesh"] = json!(document.meshes.len() - 1);
    Ok(document.finish()?)
}

/// Adds positions at rest and, of each node, what is to be added to them.
fn shapes(
    document: &mut Document,
    grid: &Grid,
    rest: &Node,
    [width, height]: [usize; 2],
) -> (usize, Vec<Value>) {
    let [width, height] = [width, height].map(|side| side as f32);
    let place = |[x, y, depth]: &[f32; 3]| {
        [(x - 0.5 * width) / height, (0.5 * height - y) / height, -depth / height]
    };
    let rest: Vec<[f32; 3]> = rest.played.points.iter().map(place).collect();
    let mut array = |rows: &[[f32; 3]]| {
        let at = document.floats(ArrayKind::vertices(F32, "VEC3"), rows);
        document.bound(at, rows);
        at
    };
    let positions = array(&rest);
    let target = |node: &Node| {
        let apart = |(point, rest): (&[f32; 3], &[f32; 3])| {
            let place = place(point);
            [0, 1, 2].map(|axis| place[axis] - rest[axis])
        };
        let rows: Vec<[f32; 3]> = node.played.points.iter().zip(&rest).map(apart).collect();
        json!({ "POSITION": array(&rows) })
    };
    (positions, grid.nodes.iter().map(target).collect())
}

/// Materials, and what they are made of, by the key views that they show.
#[derive(Default)]
struct Looks {
    materials: Vec<Value>,
    textures: Vec<Value>,
    images: Vec<Value>,
}

impl Looks {
    fn add(
        &mut self,
        document: &mut Document,
        views: &Views<'_>,
        view: usize,
        picture: &Picture,
        has_depth: bool,
    ) -> Result<usize, GridError> {
        let (name, number) = (views.view_name(view).unwrap_or_default(), self.materials.len());
        let bytes = document.view(picture.png()?);
        self.images.push(json!({ "name": name, "bufferView": bytes, "mimeType": "image/png" }));
        self.textures.push(json!({ "source": number, "sampler": 0 }));
        // What has no depth is drawn in its order, which materials keep that hide nothing.
        let alpha = if has_depth { "MASK" } else { "BLEND" };
        self.materials.push(json!({
            "name": name,
            "pbrMetallicRoughness": {
                "baseColorTexture": { "index": number }, "metallicFactor": 0.0,
            },
            "alphaMode": alpha,
            "doubleSided": true,
            "extensions": { UNLIT: {} },
        }));
        Ok(number)
    }

    fn state(self, root: &mut Map<String, Value>) {
        // Linear both ways, and no texel from beyond an edge.
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
