//! Which key view an element has its texture from, as the runtime chooses.

use crate::page::camera::Resolution;
use crate::views::player::Played;
use sinew_runtime::views::{Element, Views};

/// Lists key views in the order in which elements are textured by them: the characteristic one, then by score.
pub(super) fn ranking(played: &Played) -> Vec<usize> {
    let mut out: Vec<usize> = (0..played.scores.len()).collect();
    out.sort_by(|&a, &b| played.scores[b].total_cmp(&played.scores[a]));
    out.sort_by_key(|&view| view != played.view);
    out
}

/// Returns the view of a ranking that an element has its texture from: the first that shows all of it.
pub(super) fn source(views: &Views<'_>, element: &Element, ranking: &[usize]) -> Option<usize> {
    let shows = |view: usize| {
        let mut points = element.vertices().iter();
        points.all(|&point| views.is_visible(view, point) == Some(true))
    };
    ranking.iter().copied().find(|&view| shows(view))
}

/// Whether an element is drawn.
pub(super) fn is_drawn(element: &Element, played: &Played) -> bool {
    let is_seen = |point: &usize| played.visibility.get(*point).is_some_and(|x| *x > 0.5);
    element.vertices().iter().all(is_seen)
}

/// Cuts an element into triangles.
pub(super) fn triangles(element: &Element) -> Vec<[usize; 3]> {
    match *element {
        Element::Triangle(points) => vec![points],
        Element::Quad([a, b, c, d]) => vec![[a, b, c], [a, c, d]],
    }
}

/// Lists where points are in a key view's picture, in shares of its width and height.
pub(super) fn uvs(views: &Views<'_>, view: usize, size: Resolution) -> Vec<[f32; 2]> {
    let sides = [size.width, size.height].map(|side| side as f32);
    let points = (0..views.point_len()).map(|point| views.reference(view, point));
    points.map(|place| [0, 1].map(|axis| place.unwrap_or_default()[axis] / sides[axis])).collect()
}
