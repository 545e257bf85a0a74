//! Pictures with a mesh, as tools of 2-D rigs have them: one a layer and key view.
//!
//! A layer without depth is a blend of its key views by their shares. Such tools have no depth, so an element with depth is
//! textured by one view. The view of the highest score is in front. Views behind it show the elements that it does not.

use super::fade::{opacities, order};
use super::shown::{Shown, elements, name, numbered, texel, triangles, uvs};
use crate::page::picture::Picture;
use crate::views::player::Player;
use sinew_runtime::views::{Element, Views};

/// A layer's picture in a key view, and what becomes of it.
pub(super) struct Sheet {
    /// Its layer.
    pub(super) layer: usize,
    /// Its key view.
    view: usize,
    /// Its name: that of its key view, after that of its layer if there are several.
    pub(super) name: String,
    /// Its picture, of straight alpha.
    pub(super) picture: Picture,
    /// Numbers of its vertices.
    pub(super) vertices: Vec<usize>,
    /// Triangles by places in that list, the hindmost first.
    pub(super) triangles: Vec<[usize; 3]>,
    /// By node, how opaque it is.
    pub(super) opacities: Vec<f64>,
    /// By node, how many sheets are behind it.
    pub(super) behind: Vec<usize>,
    /// Whether its opacity jumps from node to node.
    pub(super) is_switched: bool,
}

impl Sheet {
    /// Returns where its vertices are in its picture, in pixels.
    pub(super) fn texels(&self, views: &Views<'_>) -> Vec<[f32; 2]> {
        self.vertices.iter().map(|&vertex| texel(views, self.view, vertex)).collect()
    }

    /// Returns the same in shares of its picture's width and height.
    pub(super) fn uvs(&self, views: &Views<'_>) -> Vec<[f32; 2]> {
        uvs(views, self.view, &self.vertices, self.picture.size)
    }

    /// Returns where its vertices are on the screen, from its middle.
    pub(super) fn places(&self, shown: &Shown<'_>, screen: [usize; 2]) -> Vec<[f64; 2]> {
        let middle = screen.map(|side| 0.5 * side as f64);
        let place = |&vertex: &usize| [0, 1].map(|axis| shown.places[vertex][axis] - middle[axis]);
        self.vertices.iter().map(place).collect()
    }
}

/// Makes the sheets of all layers, in the order of the file. Sheets of a layer come from the undermost on.
///
/// - `beside`: lists the nodes that a tool goes to from a node.
pub(super) fn sheets(
    player: &Player<'_>,
    shown: &[Shown<'_>],
    beside: impl Fn(usize) -> Vec<usize>,
) -> Vec<Sheet> {
    let views = player.views();
    let mut out = Vec::new();
    for number in 0..views.layer_len() {
        let Some(layer) = views.layer(number) else { continue };
        out.extend(match layer.has_depth {
            true => switched(player, shown, number),
            false => faded(player, shown, number, &beside),
        });
    }
    // Without what clips it nothing of a layer is seen.
    let layers: Vec<usize> = out.iter().map(|sheet| sheet.layer).collect();
    out.retain(|sheet| views.clips(sheet.layer).all(|clip| layers.contains(&clip)));
    stack(&mut out, shown);
    out
}

/// Makes the sheets of a layer whose key views fade into each other.
fn faded(
    player: &Player<'_>,
    shown: &[Shown<'_>],
    layer: usize,
    beside: impl Fn(usize) -> Vec<usize>,
) -> Vec<Sheet> {
    let views = player.views();
    let shares = |shown: &Shown<'_>| {
        let is_seen = shown.opacity(layer) > 0.0;
        let mut out = shown.shares(layer);
        for (view, share) in out.iter_mut().enumerate() {
            if !is_seen || views.view_texture(view, layer).is_none() {
                *share = 0.0;
            }
        }
        out
    };
    let shares: Vec<Vec<f64>> = shown.iter().map(shares).collect();
    let elements: Vec<Element> = elements(views, layer).map(|(_, element)| element).collect();
    let order = order(&shares);
    let at = |node: usize| {
        let counts = |view: usize| beside(node).iter().any(|&other| shares[other][view] > 0.0);
        opacities(&order, &shares[node], shown[node].opacity(layer), counts)
    };
    let by_node: Vec<Vec<f64>> = (0..shown.len()).map(at).collect();
    let sheet = |(place, &view): (usize, &usize)| {
        let opacities = by_node.iter().map(|own| own[place]).collect();
        of_elements(player, layer, view, &elements, opacities)
    };
    order.iter().enumerate().filter_map(sheet).collect()
}

/// Makes the sheets of a layer whose elements hide each other by depth.
fn switched(player: &Player<'_>, shown: &[Shown<'_>], layer: usize) -> Vec<Sheet> {
    let views = player.views();
    let elements: Vec<Element> = elements(views, layer).map(|(_, element)| element).collect();
    let sources = |shown: &Shown<'_>| -> Vec<Option<usize>> {
        let ranking = shown.ranking();
        let source = |element: &Element| {
            shown.texture(layer, element, &ranking).filter(|_| shown.is_seen(element))
        };
        elements.iter().map(source).collect()
    };
    let sources: Vec<Vec<Option<usize>>> = shown.iter().map(sources).collect();
    let of_view = |view: usize| {
        // Elements with their mean depth at the nodes where the view textures them.
        let mut own = Vec::new();
        for (number, element) in elements.iter().enumerate() {
            let nodes = shown.iter().zip(&sources).filter(|(_, all)| all[number] == Some(view));
            let vertices = element.vertices();
            let depths =
                nodes.flat_map(|(shown, _)| vertices.iter().map(|&at| shown.places[at][2]));
            let depths: Vec<f64> = depths.collect();
            if !depths.is_empty() {
                own.push((depths.iter().sum::<f64>() / depths.len() as f64, *element));
            }
        }
        own.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        let own: Vec<Element> = own.into_iter().map(|(_, element)| element).collect();
        let seen = |(shown, all): (&Shown<'_>, &Vec<Option<usize>>)| {
            if all.contains(&Some(view)) { shown.opacity(layer) } else { 0.0 }
        };
        let opacities = shown.iter().zip(&sources).map(seen).collect();
        of_elements(player, layer, view, &own, opacities).filter(|_| !own.is_empty())
    };
    (0..views.view_len()).filter_map(of_view).collect()
}

/// Makes a sheet of elements.
fn of_elements(
    player: &Player<'_>,
    layer: usize,
    view: usize,
    elements: &[Element],
    opacities: Vec<f64>,
) -> Option<Sheet> {
    let views = player.views();
    let picture = player.key_picture(view, layer)?;
    let triangles: Vec<[usize; 3]> = elements.iter().flat_map(triangles).collect();
    let (vertices, triangles) = numbered(&triangles);
    let name = name(views, layer, view);
    let is_switched = views.layer(layer).is_some_and(|layer| layer.has_depth);
    let behind = Vec::new();
    Some(Sheet { layer, view, name, picture, vertices, triangles, opacities, behind, is_switched })
}

/// Counts at each node the sheets behind each.
fn stack(sheets: &mut [Sheet], shown: &[Shown<'_>]) {
    for shown in shown {
        let (layers, ranking) = (shown.layers(), shown.ranking());
        let key = |(number, sheet): (usize, &Sheet)| {
            let layer = layers.iter().position(|&layer| layer == sheet.layer);
            let lower = ranking.iter().rev().position(|&view| view == sheet.view);
            (layer, lower.filter(|_| sheet.is_switched), number)
        };
        let mut keys: Vec<_> = sheets.iter().enumerate().map(key).collect();
        keys.sort_unstable();
        for (behind, (.., number)) in keys.into_iter().enumerate() {
            sheets[number].behind.push(behind);
        }
    }
}
