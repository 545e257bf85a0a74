//! Sheets: pictures with a mesh, as tools for 2-D rigs use them. Each layer and key view has a sheet.
//!
//! A layer without depth blends its key views by their shares. The tools have no depth, so a single view textures an
//! element with depth. The view with the highest score is in front. Views behind show the elements that the front view
//! does not show.
//!
//! The tools blend a picture over the pictures below. Two pictures at an opacity of 0.5 would let a quarter of the
//! background through. So the lowest picture stays opaque, and the pictures above fade.

use super::grid::nothing_drawn;
use super::shown::{Shown, descending, elements, name, numbered, texel, triangles, uvs};
use crate::Error;
use crate::page::picture::Picture;
use crate::views::player::Player;
use sinew_runtime::views::{Element, Views};

/// A picture of a layer in a key view, with its mesh and its opacity and order at each node.
pub(super) struct Sheet {
    /// Index of the layer.
    pub(super) layer: usize,
    /// Index of the key view.
    view: usize,
    /// Name of the key view, after the name of the layer if there are several layers.
    pub(super) name: String,
    /// Picture with straight alpha.
    pub(super) picture: Picture,
    /// Indices of the vertices in the object.
    pub(super) vertices: Vec<usize>,
    /// Triangles as positions in `vertices`, the hindmost first.
    pub(super) triangles: Vec<[usize; 3]>,
    /// Opacity at each node.
    pub(super) opacities: Vec<f64>,
    /// Number of sheets behind at each node.
    pub(super) behind: Vec<usize>,
    /// Whether the opacity jumps between nodes.
    pub(super) is_switched: bool,
}

impl Sheet {
    /// Returns the positions of the vertices in the picture, pixels.
    pub(super) fn texels(&self, views: &Views<'_>) -> Vec<[f32; 2]> {
        self.vertices.iter().map(|&vertex| texel(views, self.view, vertex)).collect()
    }

    /// Returns the positions of the vertices in shares of the picture's width and height.
    pub(super) fn uvs(&self, views: &Views<'_>) -> Vec<[f32; 2]> {
        uvs(views, self.view, &self.vertices, self.picture.size)
    }

    /// Returns the positions of the vertices on the screen, relative to the middle, pixels.
    pub(super) fn places(&self, shown: &Shown<'_>, screen: [usize; 2]) -> Vec<[f64; 2]> {
        let middle = screen.map(|side| 0.5 * side as f64);
        let place = |&vertex: &usize| [0, 1].map(|axis| shown.places[vertex][axis] - middle[axis]);
        self.vertices.iter().map(place).collect()
    }
}

/// Makes the sheets of all layers, in the order of the file. The sheets of a layer start with the lowest.
///
/// - `beside`: lists the nodes that a tool reaches from a node.
///
/// # Errors
/// [`ErrorKind::Missing`](crate::ErrorKind::Missing): nothing is drawn at any node.
pub(super) fn sheets(
    player: &Player<'_>,
    shown: &[Shown<'_>],
    beside: impl Fn(usize) -> Vec<usize>,
) -> Result<Vec<Sheet>, Error> {
    let views = player.views();
    let mut out = Vec::new();
    for number in 0..views.layer_len() {
        let Some(layer) = views.layer(number) else { continue };
        out.extend(match layer.has_depth {
            true => switched(player, shown, number),
            false => faded(player, shown, number, &beside),
        });
    }
    // A layer is invisible if its clipping layer has no sheet.
    let layers: Vec<usize> = out.iter().map(|sheet| sheet.layer).collect();
    out.retain(|sheet| views.clips(sheet.layer).all(|clip| layers.contains(&clip)));
    stack(&mut out, shown);
    if out.is_empty() { Err(nothing_drawn()) } else { Ok(out) }
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
        let drawn = |view: usize| is_seen && views.view_texture(view, layer).is_some();
        let all = shown.shares(layer).into_iter().enumerate();
        all.map(|(view, share)| if drawn(view) { share } else { 0.0 }).collect()
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
        // Elements with their mean depth over the nodes where the view textures them.
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

/// Makes a sheet of elements. `None` if the key view has no picture of the layer.
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

/// Counts the sheets behind each sheet, at each node.
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

/// Remaining opacity below which the lower pictures are hidden.
const HIDDEN: f64 = 1e-6;

/// Lists the key views with a share at some node, the lowest first. The lowest has the largest share in all nodes.
///
/// - `shares`: shares of the N views, by node.
fn order(shares: &[Vec<f64>]) -> Vec<usize> {
    let len = shares.first().map_or(0, Vec::len);
    let whole = |view: usize| shares.iter().map(|own| own[view]).sum();
    let whole: Vec<f64> = (0..len).map(whole).collect();
    descending(&whole).into_iter().filter(|&view| whole[view] > 0.0).collect()
}

/// Returns the opacities of pictures at a node. Opaque pictures then mix by their shares.
///
/// A fully covered picture stays opaque if it has a share at a neighbouring node. Tools interpolate linearly between
/// nodes, so the background stays hidden between them.
///
/// - `order`: views, the lowest first.
/// - `shares`: shares of the N views, with a sum of at most 1.
/// - `opacity`: opacity of all pictures together.
/// - `counts_beside`: whether a view has a share at a neighbouring node.
fn opacities(
    order: &[usize],
    shares: &[f64],
    opacity: f64,
    counts_beside: impl Fn(usize) -> bool,
) -> Vec<f64> {
    let mut left = 1.0;
    let mut out: Vec<f64> = Vec::new();
    for &view in order.iter().rev() {
        let own = opacity * shares[view];
        out.push(match left > HIDDEN {
            true => (own / left).clamp(0.0, 1.0),
            false => f64::from(u8::from(counts_beside(view))),
        });
        left -= own;
    }
    out.reverse();
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Visible share of each opaque picture, and of the background.
    fn seen(opacities: &[f64]) -> Vec<f64> {
        let mut left = 1.0;
        let mut out: Vec<f64> = Vec::new();
        for opacity in opacities.iter().rev() {
            out.push(left * opacity);
            left *= 1.0 - opacity;
        }
        out.reverse();
        out.push(left);
        out
    }

    #[test]
    fn opaque_pictures_mix_by_their_shares() {
        for opacity in [1.0, 0.5, 0.0] {
            for shares in [[0.5, 0.5, 0.0], [0.2, 0.3, 0.5], [0.0, 0.0, 1.0], [0.1, 0.0, 0.2]] {
                let found = seen(&opacities(&[2, 0, 1], &shares, opacity, |_| true));
                let expected = [2, 0, 1].map(|view| opacity * shares[view]);
                let apart = found.iter().zip(expected).map(|(a, b)| (a - b).abs());
                assert!(apart.fold(0.0, f64::max) < 1e-12, "{shares:?} {opacity}: {found:?}");
            }
        }
    }

    #[test]
    fn nothing_is_seen_through_halfway_between_nodes() {
        // Along a line of three nodes the first view blends into the second, and the second into the third.
        let nodes = [vec![1.0, 0.0, 0.0], vec![0.0, 1.0, 0.0], vec![0.0, 0.0, 1.0]];
        let order = order(&nodes);
        let at = |node: usize| {
            let beside = |view: usize| {
                let nodes = &nodes[node.saturating_sub(1)..nodes.len().min(node + 2)];
                nodes.iter().any(|shares| shares[view] > 0.0)
            };
            opacities(&order, &nodes[node], 1.0, beside)
        };
        for pair in [[0, 1], [1, 2]] {
            let [from, to] = pair.map(at);
            for share in [0.0, 0.3, 0.5, 1.0] {
                let own: Vec<f64> =
                    from.iter().zip(&to).map(|(a, b)| a + share * (b - a)).collect();
                assert_eq!(seen(&own).last(), Some(&0.0), "{pair:?} {share}: {own:?}");
            }
        }
    }

    #[test]
    fn the_view_with_the_largest_share_is_lowest_and_views_without_share_are_dropped() {
        assert_eq!(order(&[vec![0.1, 0.0, 0.9], vec![0.3, 0.0, 0.7]]), [2, 0]);
        assert_eq!(order(&[]), [0; 0]);
    }
}
