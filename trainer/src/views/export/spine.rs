//! Writes paths of parameters as Spine JSON, version 4.2. Each layer and key view is a slot, whose mesh is deformed at
//! each frame.
//!
//! The page "JSON export format" of esotericsoftware.com describes the format. y goes up, and the first slot is drawn
//! first. Numbers are interpolated linearly between keys, unless a key is stepped. Attachments and the draw order stay
//! until the next key.

use super::grid::{Grid, json_bytes};
use super::sheet::{Sheet, sheets};
use super::shown::Shown;
use crate::Error;
use crate::views::player::Player;
use serde_json::{Map, Value, json};
use sinew_runtime::Model;
use std::collections::HashMap;
use std::ops::Range;

/// Version of the format.
const VERSION: &str = "4.2.0";
const BONE: &str = "root";
const SKIN: &str = "default";
/// Parts of a pixel to which positions are rounded.
const ROUNDING: f64 = 1e4;

/// A skeleton and its pictures.
#[derive(Clone, Debug)]
pub struct Spine {
    /// The skeleton as JSON.
    pub json: Vec<u8>,
    /// Names of the pictures without their ending, and the PNG of each.
    pub pictures: Vec<(String, Vec<u8>)>,
    /// Names of layers whose clip masks are left out, because Spine clips by polygons.
    pub unclipped: Vec<String>,
}

/// Writes a skeleton with one bone, at the middle of the screen. The setup pose is the first frame.
///
/// - `folder`: folder of the pictures, beside the skeleton.
/// - `animations`: names and frames of the animations.
/// - `frame_time`: time between frames, seconds.
///
/// # Errors
/// The file has no such map; nothing is drawn at any node; or a picture cannot be encoded.
pub fn spine(
    model: &Model<Vec<u8>>,
    map: Option<&str>,
    folder: &str,
    animations: &[(String, Grid)],
    frame_time: f64,
) -> Result<Spine, Error> {
    let player = Player::new(model, map)?;
    let nodes: Vec<_> = animations.iter().flat_map(|(_, grid)| &grid.nodes).collect();
    let shown: Vec<Shown<'_>> =
        nodes.iter().map(|node| Shown::new(&player, &node.played)).collect();
    let mut ranges: Vec<Range<usize>> = Vec::new();
    for (_, grid) in animations {
        let start = ranges.last().map_or(0, |range| range.end);
        ranges.push(start..start + grid.nodes.len());
    }
    let beside = |node: usize| {
        let own = ranges.iter().zip(animations).find(|(range, _)| range.contains(&node));
        let Some((range, (_, grid))) = own else { return Vec::new() };
        grid.beside(node - range.start).into_iter().map(|at| range.start + at).collect()
    };
    let sheets = sheets(&player, &shown, beside)?;
    let names = unique(sheets.iter().map(|sheet| sheet.name.as_str()));
    let slots: Vec<Slot> =
        sheets.into_iter().zip(names).map(|(sheet, name)| Slot::new(sheet, name)).collect();
    let mut attachments = Map::new();
    let mut pictures = Vec::new();
    for slot in &slots {
        let name = &slot.name;
        attachments.insert(name.clone(), json!({ name: slot.mesh(&player, &shown[0]) }));
        pictures.push((name.clone(), slot.sheet.picture.png()?));
    }
    let mut moved = Map::new();
    for ((name, _), range) in animations.iter().zip(ranges) {
        let time = |node: usize| rounded((node - range.start) as f64 * frame_time);
        moved.insert(name.clone(), animation(&player, &slots, &shown, range.clone(), &time));
    }
    let [width, height] = player.size().map(|side| side as f64);
    let whole = json!({
        "skeleton": {
            "spine": VERSION, "x": -0.5 * width, "y": -0.5 * height, "width": width,
            "height": height, "images": format!("./{folder}/"),
        },
        "bones": [{ "name": BONE }],
        "slots": slots.iter().map(Slot::state).collect::<Vec<_>>(),
        "skins": [{ "name": SKIN, "attachments": attachments }],
        "animations": moved,
    });
    let views = player.views();
    let is_clipped = |layer: &usize| views.layer(*layer).is_some_and(|own| own.clip.is_some());
    let clipped = (0..views.layer_len()).filter(is_clipped);
    let unclipped = clipped.filter_map(|layer| views.layer_name(layer)).map(str::to_owned);
    Ok(Spine { json: json_bytes(&whole)?, pictures, unclipped: unclipped.collect() })
}

/// A sheet with the common name of its slot, attachment and picture.
struct Slot {
    sheet: Sheet,
    name: String,
    /// Number of vertices along the border, which come first.
    hull_len: usize,
}

impl Slot {
    fn new(mut sheet: Sheet, name: String) -> Self {
        let hull = hull(&sheet.triangles);
        let inner = (0..sheet.vertices.len()).filter(|at| !hull.contains(at));
        let order: Vec<usize> = hull.iter().copied().chain(inner).collect();
        let mut places = vec![0; order.len()];
        order.iter().enumerate().for_each(|(place, &at)| places[at] = place);
        sheet.vertices = order.iter().map(|&at| sheet.vertices[at]).collect();
        let placed = sheet.triangles.iter().map(|corners| corners.map(|at| places[at]));
        sheet.triangles = placed.collect();
        Self { sheet, name, hull_len: hull.len() }
    }

    /// Makes the slot in the setup pose.
    fn state(&self) -> Value {
        let mut out = json!({ "name": self.name, "bone": BONE, "color": self.colour(0) });
        if self.sheet.opacities[0] > 0.0 {
            out["attachment"] = json!(self.name);
        }
        out
    }

    fn mesh(&self, player: &Player<'_>, rest: &Shown<'_>) -> Value {
        let size = self.sheet.picture.size;
        json!({
            "type": "mesh",
            "uvs": self.sheet.uvs(player.views()).as_flattened(),
            "triangles": self.sheet.triangles.as_flattened(),
            "vertices": self.places(player, rest).as_flattened(),
            "hull": self.hull_len,
            "width": size.width,
            "height": size.height,
        })
    }

    /// Returns the positions of the vertices, y up.
    fn places(&self, player: &Player<'_>, shown: &Shown<'_>) -> Vec<[f64; 2]> {
        let places = self.sheet.places(shown, player.size());
        places.into_iter().map(|[x, y]| [rounded(x), rounded(-y)]).collect()
    }

    fn colour(&self, node: usize) -> String {
        let alpha = (255.0 * self.sheet.opacities[node]).round();
        format!("ffffff{:02x}", alpha as u8)
    }
}

/// Makes an animation.
fn animation(
    player: &Player<'_>,
    slots: &[Slot],
    shown: &[Shown<'_>],
    range: Range<usize>,
    time: &impl Fn(usize) -> f64,
) -> Value {
    let (mut of_slots, mut of_meshes) = (Map::new(), Map::new());
    for slot in slots {
        let opacities = &slot.sheet.opacities;
        // The attachment of a frame stays until the next frame.
        let is_seen = |node: usize| {
            let last = if slot.sheet.is_switched { node } else { (node + 1).min(range.end - 1) };
            opacities[node..=last].iter().any(|opacity| *opacity > 0.0)
        };
        let name = |node: usize| is_seen(node).then_some(&slot.name);
        let attachment =
            changes(range.clone(), name, |node, name| json!({ "time": time(node), "name": name }));
        let mut timelines = json!({ "attachment": attachment });
        let is_shown = |node: usize| {
            let before = node.saturating_sub(1).max(range.start);
            is_seen(node) || is_seen(before)
        };
        if range.clone().any(is_shown) {
            let rest = slot.places(player, &shown[0]);
            let (mut bent, mut faded) = (Vec::new(), Vec::new());
            for node in range.clone().filter(|&node| is_shown(node)) {
                let places = slot.places(player, &shown[node]);
                let apart = places.as_flattened().iter().zip(rest.as_flattened());
                let apart: Vec<f64> = apart.map(|(place, rest)| rounded(place - rest)).collect();
                bent.push(json!({ "time": time(node), "vertices": apart }));
                let mut key = json!({ "time": time(node), "color": slot.colour(node) });
                if slot.sheet.is_switched {
                    key["curve"] = json!("stepped");
                }
                faded.push(key);
            }
            timelines["rgba"] = json!(faded);
            of_meshes.insert(slot.name.clone(), json!({ &slot.name: { "deform": bent } }));
        }
        of_slots.insert(slot.name.clone(), timelines);
    }
    let offsets = |node: usize| -> Vec<Value> {
        let apart = |(place, slot): (usize, &Slot)| {
            let offset = slot.sheet.behind[node] as i64 - place as i64;
            (offset != 0).then(|| json!({ "slot": slot.name, "offset": offset }))
        };
        slots.iter().enumerate().filter_map(apart).collect()
    };
    let order = changes(range.clone(), offsets, |node, offsets| match offsets[..] {
        [] => json!({ "time": time(node) }),
        _ => json!({ "time": time(node), "offsets": offsets }),
    });
    json!({ "slots": of_slots, "attachments": { SKIN: of_meshes }, "drawOrder": order })
}

/// Lists keys at the first frame and at each change of the value.
fn changes<T: PartialEq>(
    range: Range<usize>,
    value: impl Fn(usize) -> T,
    key: impl Fn(usize, &T) -> Value,
) -> Vec<Value> {
    let mut last = None;
    let mut out = Vec::new();
    for node in range {
        let own = value(node);
        if last.as_ref() != Some(&own) {
            out.push(key(node, &own));
            last = Some(own);
        }
    }
    out
}

/// Makes distinct file names of letters and digits. All other characters become hyphens.
fn unique<'a>(names: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut out: Vec<String> = Vec::new();
    for name in names {
        let kept = |c: char| if c.is_alphanumeric() || c == '_' { c } else { '-' };
        let plain: String = name.chars().map(kept).collect();
        let plain = if plain.is_empty() { "slot".to_owned() } else { plain };
        let numbered = (2..).map(|number| format!("{plain}-{number}"));
        let mut all = std::iter::once(plain.clone()).chain(numbered);
        // Some file systems ignore case.
        let is_free = |name: &String| !out.iter().any(|own| own.eq_ignore_ascii_case(name));
        out.extend(all.find(is_free));
    }
    out
}

fn rounded(x: f64) -> f64 {
    (x * ROUNDING).round() / ROUNDING
}

/// Lists the vertices along the longest border of triangles, each once. Empty without a border.
fn hull(triangles: &[[usize; 3]]) -> Vec<usize> {
    let edges = |[a, b, c]: [usize; 3]| [[a, b], [b, c], [c, a]];
    let mut counts: HashMap<[usize; 2], usize> = HashMap::new();
    for [a, b] in triangles.iter().copied().flat_map(edges) {
        *counts.entry([a.min(b), a.max(b)]).or_default() += 1;
    }
    let mut border: Vec<[usize; 2]> =
        counts.into_iter().filter(|(_, count)| *count == 1).map(|(edge, _)| edge).collect();
    // The order of a hash map is random.
    border.sort_unstable();
    let mut loops = Vec::new();
    while let Some([start, next]) = border.pop() {
        let mut way = vec![start];
        let mut at = next;
        while at != start {
            way.push(at);
            let Some(found) = border.iter().position(|edge| edge.contains(&at)) else { break };
            let [a, b] = border.swap_remove(found);
            at = if a == at { b } else { a };
            // Two borders may meet at a vertex. The loop between is a separate border.
            if let Some(first) = way.iter().position(|&vertex| vertex == at).filter(|&at| at > 0) {
                loops.push(way.split_off(first));
            }
        }
        loops.push(way);
    }
    // The first of equal loops wins.
    loops.into_iter().rev().max_by_key(Vec::len).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_pictures_stay_in_their_folder_and_differ() {
        let names = ["hair back", "../hair back", "Hair-back", "", ""];
        let expected = ["hair-back", "---hair-back", "Hair-back-2", "slot", "slot-2"];
        assert_eq!(unique(names.into_iter()), expected);
    }

    /// Rotates a loop so that its smallest vertex comes first, and the smaller of its neighbours second.
    fn turned(way: Vec<usize>) -> Vec<usize> {
        let mut way = way;
        let least = (0..way.len()).min_by_key(|&at| way[at]).unwrap_or(0);
        way.rotate_left(least);
        if way.len() > 2 && way[way.len() - 1] < way[1] {
            way[1..].reverse();
        }
        way
    }

    #[test]
    fn the_border_goes_round_once() {
        assert_eq!(turned(hull(&[[0, 1, 2], [0, 2, 3]])), [0, 1, 2, 3]);
        // Mixed orientations, and a vertex in the middle.
        let fan = [[0, 1, 4], [4, 1, 2], [2, 3, 4], [4, 0, 3]];
        assert_eq!(turned(hull(&fan)), [0, 1, 2, 3]);
        assert_eq!(hull(&[]), [0; 0]);
    }

    #[test]
    fn the_longer_border_of_two_pieces_wins_even_if_they_touch() {
        let apart = [[0, 1, 2], [3, 4, 5], [3, 5, 6]];
        assert_eq!(turned(hull(&apart)), [3, 4, 5, 6]);
        let touching = [[0, 1, 2], [2, 3, 4], [2, 4, 5]];
        assert_eq!(turned(hull(&touching)), [2, 3, 4, 5]);
    }
}
