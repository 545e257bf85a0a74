//! Writes a grid of one or two parameters as an Inochi2D puppet. Each layer and key view is a part, which is deformed
//! at the nodes of the grid.
//!
//! Inochi2D interpolates linearly between nodes. The part with the largest `zSort` is the hindmost. If a layer clips
//! another, its parts mask the other's parts by the alpha of their pictures. Inochi2D ignores the opacity and the masks
//! of a mask.

use super::grid::{Grid, Side, json_bytes};
use super::sheet::{Sheet, sheets};
use super::shown::Shown;
use crate::Error;
use crate::views::player::Player;
use serde_json::{Value, json};
use sinew_runtime::Model;
use sinew_runtime::views::Views;

/// Inochi2D's number for "none".
const NOTHING: u32 = u32::MAX;
/// Identifiers of the root, of the parameter, and of the first part.
const ROOT: u32 = 1;
const PARAMETER: u32 = 2;
const FIRST_PART: u32 = 3;

/// Writes a puppet with one parameter, of one or two numbers.
///
/// The vertices of a part lie at their places in its picture, relative to the middle of the picture. At each node the
/// mesh is deformed to the places in the model, relative to the middle of the screen. Quads are split in two.
///
/// - `grid`: grid of `model`, with one or two sides.
///
/// # Errors
/// The file has no such map; nothing is drawn at any node; a picture cannot be encoded; or a section is too large.
pub fn puppet(model: &Model<Vec<u8>>, map: Option<&str>, grid: &Grid) -> Result<Vec<u8>, Error> {
    let player = Player::new(model, map)?;
    let views = player.views();
    let shown: Vec<Shown<'_>> =
        grid.nodes.iter().map(|node| Shown::new(&player, &node.played)).collect();
    let sheets = sheets(&player, &shown, |node| grid.beside(node))?;
    let (mut parts, mut bindings, mut textures) = (Vec::new(), Vec::new(), Vec::new());
    for (number, sheet) in sheets.iter().enumerate() {
        parts.push(part(views, &sheets, number));
        let places: Vec<_> = shown.iter().map(|own| sheet.places(own, player.size())).collect();
        bindings.extend(bindings_of(grid, views, &sheets, number, &places));
        textures.push(sheet.picture.png()?);
    }
    let root = json!({
        "uuid": ROOT, "name": views.name(), "type": "Node", "enabled": true, "zsort": 0.0,
        "transform": at_parent(), "lockToRoot": false, "children": parts,
    });
    let whole = json!({
        "meta": {
            "name": views.name(), "version": "1.0-alpha",
            "rigger": format!("sinew {}", env!("CARGO_PKG_VERSION")),
            "artist": null, "copyright": null, "licenseURL": null, "contact": null, "reference": null,
            "thumbnailId": NOTHING, "preservePixels": false,
        },
        "physics": { "pixelsPerMeter": 1000.0, "gravity": 9.8 },
        "nodes": root,
        "param": [parameter(&grid.sides, bindings)],
        "automation": [],
        "animations": {},
        "groups": [],
    });
    container(&whole, &textures)
}

/// Returns the identifier of the part of a sheet.
fn uuid(number: usize) -> u32 {
    FIRST_PART + number as u32
}

/// Returns the positions of a sheet's vertices at rest.
fn rest(views: &Views<'_>, sheet: &Sheet) -> Vec<[f32; 2]> {
    let middle =
        [sheet.picture.size.width, sheet.picture.size.height].map(|side| 0.5 * side as f32);
    let from_middle = |place: [f32; 2]| [place[0] - middle[0], place[1] - middle[1]];
    sheet.texels(views).into_iter().map(from_middle).collect()
}

fn part(views: &Views<'_>, sheets: &[Sheet], number: usize) -> Value {
    let sheet = &sheets[number];
    let clip = views.layer(sheet.layer).and_then(|layer| layer.clip);
    let masks = sheets.iter().enumerate().filter(|(_, other)| Some(other.layer) == clip);
    let masks: Vec<Value> =
        masks.map(|(other, _)| json!({ "source": uuid(other), "mode": "Mask" })).collect();
    json!({
        "uuid": uuid(number),
        "name": sheet.name,
        "type": "Part",
        "enabled": true,
        "zsort": 0.0,
        "transform": at_parent(),
        "lockToRoot": false,
        "mesh": {
            "verts": rest(views, sheet).as_flattened(),
            "uvs": sheet.uvs(views).as_flattened(),
            "indices": sheet.triangles.as_flattened(),
            "origin": [0.0, 0.0],
        },
        "textures": [number, NOTHING, NOTHING],
        "blend_mode": "Normal",
        "tint": [1.0, 1.0, 1.0],
        "screenTint": [0.0, 0.0, 0.0],
        "emissionStrength": 1.0,
        "masks": masks,
        "mask_threshold": 0.5,
        "opacity": 1.0,
    })
}

/// Lists the bindings of a part. The mesh is deformed linearly between nodes. The place in the stack is that of the
/// nearest node.
///
/// - `places`: positions of the part's vertices, by node.
fn bindings_of(
    grid: &Grid,
    views: &Views<'_>,
    sheets: &[Sheet],
    number: usize,
    places: &[Vec<[f64; 2]>],
) -> [Value; 3] {
    let sheet = &sheets[number];
    let rest = rest(views, sheet);
    let bent = |node: usize| -> Vec<Value> {
        let apart = |(place, rest): (&[f64; 2], &[f32; 2])| {
            [0, 1].map(|axis| place[axis] - f64::from(rest[axis]))
        };
        places[node].iter().zip(&rest).map(|pair| json!(apart(pair))).collect()
    };
    let binding = |name: &str, mode: &str, values: Value| {
        json!({
            "node": uuid(number), "param_name": name, "values": values,
            "isSet": by_sides(grid, |_| true), "interpolate_mode": mode,
        })
    };
    let before = |node: usize| (sheets.len() - 1 - sheet.behind[node]) as f64;
    let mode = if sheet.is_switched { "Nearest" } else { "Linear" };
    [
        binding("deform", "Linear", by_sides(grid, bent)),
        binding("zSort", "Nearest", by_sides(grid, before)),
        binding("opacity", mode, by_sides(grid, |node| sheet.opacities[node])),
    ]
}

/// Lists a value of each node, by the sides of the grid.
fn by_sides<T: Into<Value>>(grid: &Grid, of: impl Fn(usize) -> T) -> Value {
    let rows = grid.sides.get(1).map_or(1, |(side, _)| side.nodes);
    let all: Vec<Value> = (0..grid.nodes.len()).map(|node| of(node).into()).collect();
    all.chunks(rows).map(|row| Value::from(row.to_vec())).collect()
}

fn at_parent() -> Value {
    json!({ "trans": [0.0, 0.0, 0.0], "rot": [0.0, 0.0, 0.0], "scale": [1.0, 1.0] })
}

/// Makes the parameter. Its default is the value nearest to 0.
fn parameter(sides: &[(Side, [f64; 2])], bindings: Vec<Value>) -> Value {
    let ends = |end: usize, beyond: f64| -> [f64; 2] {
        [0, 1].map(|side| sides.get(side).map_or(beyond, |(_, range)| range[end]))
    };
    let default = [0, 1]
        .map(|side| sides.get(side).map_or(0.0, |(_, [low, high])| 0.0f64.clamp(*low, *high)));
    let points = [0, 1].map(|side| {
        let nodes = sides.get(side).map_or(1, |(side, _)| side.nodes);
        let last = nodes.saturating_sub(1).max(1) as f64;
        (0..nodes).map(|node| node as f64 / last).collect::<Vec<f64>>()
    });
    let names: Vec<&str> = sides.iter().map(|(side, _)| side.name.as_str()).collect();
    json!({
        "uuid": PARAMETER, "name": names.join(", "), "is_vec2": sides.len() == 2,
        "min": ends(0, 0.0), "max": ends(1, 1.0), "defaults": default,
        "axis_points": points, "merge_mode": "Additive", "bindings": bindings,
    })
}

const MAGIC: &[u8; 8] = b"TRNSRTS\0";
const TEXTURES: &[u8; 8] = b"TEX_SECT";
/// Encoding of a texture: PNG.
const PNG: u8 = 0;

/// Writes a puppet and its PNG textures in the container of Inochi2D: JSON, then textures. Lengths are big-endian.
///
/// # Errors
/// The JSON cannot be written, or a section is larger than 4 GiB.
fn container(puppet: &Value, textures: &[Vec<u8>]) -> Result<Vec<u8>, Error> {
    let json = json_bytes(puppet)?;
    let mut out = Vec::new();
    out.extend(MAGIC);
    out.extend(length(json.len())?);
    out.extend(json);
    out.extend(TEXTURES);
    out.extend(length(textures.len())?);
    for texture in textures {
        out.extend(length(texture.len())?);
        out.push(PNG);
        out.extend(texture);
    }
    Ok(out)
}

fn length(len: usize) -> Result<[u8; 4], Error> {
    let text = || format!("the file takes {len} bytes in one section, and INP holds 4 GiB");
    u32::try_from(len).map(u32::to_be_bytes).map_err(|_| Error::limit(text()))
}
