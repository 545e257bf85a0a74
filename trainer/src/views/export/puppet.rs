//! A grid of one or two parameters as an Inochi2D puppet: a part a key view, bent at the grid's nodes.
//!
//! Between nodes Inochi2D goes along lines. It knows no depth and draws parts one over the other: at each node that of
//! the characteristic view is the foremost, behind it the others by their scores, so that each element shows the view
//! that the runtime takes. Parts that no element is textured by at a node are not seen there.

use super::error::GridError;
use super::grid::{Grid, Side};
use super::inp::container;
use super::sources::{is_drawn, ranking, source, triangles, uvs};
use crate::page::camera::Resolution;
use crate::views::player::Player;
use serde_json::{Value, json};
use sinew_runtime::Model;
use sinew_runtime::views::{Element, Views};

/// Stands for nothing where Inochi2D has a number.
const NOTHING: u32 = u32::MAX;
/// Numbers of the root, of the parameter, and of the first part.
const ROOT: u32 = 1;
const PARAMETER: u32 = 2;
const FIRST_PART: u32 = 3;

/// Writes a puppet with one parameter, of one number or two.
///
/// A part's vertices are the control points where its picture has them, less the picture's middle, and vertex k is point
/// k; its mesh is bent so that they come to stand where the model has them at each node, less the screen's middle. Quads
/// are cut in two.
///
/// - `grid`: of `model`, of one or two sides.
///
/// # Errors
/// [`GridError::Nothing`], and those of writing.
pub fn puppet(
    model: &Model<Vec<u8>>,
    map: Option<&str>,
    grid: &Grid,
) -> Result<Vec<u8>, GridError> {
    let player = Player::new(model, map)?;
    let (views, screen) = (player.views(), player.size().map(|side| side as f32));
    let shown = Shown::new(&player, grid);
    let (mut parts, mut bindings, mut textures) = (Vec::new(), Vec::new(), Vec::new());
    for view in 0..views.view_len() {
        let own = shown.elements_of(view);
        let Some(picture) = player.key_picture(view, 0).filter(|_| !own.is_empty()) else {
            continue;
        };
        let uuid = FIRST_PART + parts.len() as u32;
        let part = Part { view, uuid, texture: textures.len(), size: picture.size };
        parts.push(part.node(views, &triangulated(&own)));
        bindings.extend(part.bindings(views, &shown, screen));
        textures.push(picture.png()?);
    }
    if parts.is_empty() {
        return Err(GridError::Nothing);
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

/// What is drawn at each node.
struct Shown<'a> {
    grid: &'a Grid,
    elements: Vec<Element>,
    /// By node: the key views' order.
    rankings: Vec<Vec<usize>>,
    /// By node and element: the view that it is textured by, where it is drawn.
    sources: Vec<Vec<Option<usize>>>,
}

impl<'a> Shown<'a> {
    fn new(player: &Player<'_>, grid: &'a Grid) -> Self {
        let (views, elements) = (player.views(), player.elements());
        let rankings: Vec<Vec<usize>> =
            grid.nodes.iter().map(|node| ranking(&node.played)).collect();
        let of = |(node, ranking): (&super::Node, &Vec<usize>)| {
            let own = |element: &Element| match is_drawn(element, &node.played) {
                true => source(views, element, ranking),
                false => None,
            };
            elements.iter().map(own).collect()
        };
        let sources = grid.nodes.iter().zip(&rankings).map(of).collect();
        Self { grid, elements, rankings, sources }
    }

    /// Lists the elements that are textured by a view at some node: the farthest first, as far as they are on average
    /// where they are, else in their order.
    fn elements_of(&self, view: usize) -> Vec<&Element> {
        let mut out = Vec::new();
        for (number, element) in self.elements.iter().enumerate() {
            let nodes = self.grid.nodes.iter().zip(&self.sources);
            let own = nodes.filter(|(_, sources)| sources[number] == Some(view));
            let depths: Vec<f32> = own
                .flat_map(|(node, _)| {
                    element.vertices().iter().map(|&point| node.played.points[point][2])
                })
                .collect();
            if !depths.is_empty() {
                out.push((depths.iter().sum::<f32>() / depths.len() as f32, element));
            }
        }
        out.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        out.into_iter().map(|(_, element)| element).collect()
    }

    /// Lists a number of each node, by the sides of the grid.
    fn by_sides<T: Into<Value>>(&self, of: impl Fn(usize) -> T) -> Value {
        let rows = self.grid.sides.get(1).map_or(1, |(side, _)| side.nodes);
        let all: Vec<Value> = (0..self.grid.nodes.len()).map(|node| of(node).into()).collect();
        all.chunks(rows).map(|row| Value::from(row.to_vec())).collect()
    }
}

/// A part in the making.
struct Part {
    view: usize,
    uuid: u32,
    texture: usize,
    size: Resolution,
}

impl Part {
    /// Returns where points are at rest.
    fn vertices(&self, views: &Views<'_>) -> Vec<[f32; 2]> {
        let middle = [self.size.width, self.size.height].map(|side| 0.5 * side as f32);
        let place = |point| views.reference(self.view, point).unwrap_or_default();
        let points = (0..views.point_len()).map(place);
        points.map(|place| [0, 1].map(|axis| place[axis] - middle[axis])).collect()
    }

    fn node(&self, views: &Views<'_>, indices: &[usize]) -> Value {
        json!({
            "uuid": self.uuid,
            "name": views.view_name(self.view).unwrap_or_default(),
            "type": "Part",
            "enabled": true,
            "zsort": 0.0,
            "transform": at_parent(),
            "lockToRoot": false,
            "mesh": {
                "verts": self.vertices(views).as_flattened(),
                "uvs": uvs(views, self.view, self.size).as_flattened(),
                "indices": indices,
                "origin": [0.0, 0.0],
            },
            "textures": [self.texture, NOTHING, NOTHING],
            "blend_mode": "Normal",
            "tint": [1.0, 1.0, 1.0],
            "screenTint": [0.0, 0.0, 0.0],
            "emissionStrength": 1.0,
            "mask_threshold": 0.5,
            "opacity": 1.0,
        })
    }

    /// Lists what the parameter does to it: its mesh along lines, and at the nearest node what it hides and whether it
    /// is seen.
    fn bindings(&self, views: &Views<'_>, shown: &Shown<'_>, screen: [f32; 2]) -> [Value; 3] {
        let rest = self.vertices(views);
        let bent = |node: usize| -> Vec<Value> {
            let points = shown.grid.nodes[node].played.points.iter().zip(&rest);
            let apart = |([x, y, _], rest): (&[f32; 3], &[f32; 2])| {
                [(*x, 0), (*y, 1)].map(|(at, axis)| {
                    f64::from(at) - 0.5 * f64::from(screen[axis]) - f64::from(rest[axis])
                })
            };
            points.map(|pair| json!(apart(pair))).collect()
        };
        let behind = |node: usize| {
            let place = shown.rankings[node].iter().position(|&view| view == self.view);
            place.unwrap_or_default() as f64
        };
        let opacity =
            |node: usize| f64::from(u8::from(shown.sources[node].contains(&Some(self.view))));
        let binding = |name: &str, mode: &str, values: Value| {
            json!({
                "node": self.uuid, "param_name": name, "values": values,
                "isSet": shown.by_sides(|_| true), "interpolate_mode": mode,
            })
        };
        [
            binding("deform", "Linear", shown.by_sides(bent)),
            binding("zSort", "Nearest", shown.by_sides(behind)),
            binding("opacity", "Nearest", shown.by_sides(opacity)),
        ]
    }
}

fn triangulated(elements: &[&Element]) -> Vec<usize> {
    elements.iter().flat_map(|element| triangles(element).concat()).collect()
}

fn at_parent() -> Value {
    json!({ "trans": [0.0, 0.0, 0.0], "rot": [0.0, 0.0, 0.0], "scale": [1.0, 1.0] })
}

/// States the parameter: where it begins is as near to 0 as it goes.
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
