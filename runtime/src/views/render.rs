//! Drawing of a picture from points (METHOD §6.5, §6.9).

use super::blend::{Blend, SOURCES_MAX};
use super::frame::Frame;
use super::raster::{Corner, Screen, Source, blend_group, multiply_mask, quad, triangle};
use super::view::{Element, Layer, Views};
use crate::error::{Argument, CallError};
use crate::numeric::{greater, lesser, smoothstep, sqrt};

/// Draws an object into the caller's picture.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(not(feature = "internals"), non_exhaustive)]
pub struct RenderJob<'a> {
    /// The object.
    pub views: Views<'a>,
    /// K points, as in [`super::Frame`].
    pub points: &'a [[f32; 3]],
    /// K visibilities. An element with partly visible points is drawn from key views that show the
    /// element to the same degree.
    pub visibility: &'a [f32],
    /// N scores of the key views, for their shares.
    pub scores: &'a [f32],
    /// Opacity and order of L layers.
    pub layers: &'a [[f32; 2]],
    /// Width of the picture in pixels.
    pub width: usize,
}

/// Scratch memory of a [`RenderJob`], of any content.
#[derive(Debug)]
#[cfg_attr(not(feature = "internals"), non_exhaustive)]
pub struct RenderScratch<'o> {
    /// V places of vertices.
    pub vertices: &'o mut [[f32; 3]],
    /// E + L numbers, for sorting.
    pub order: &'o mut [u16],
    /// One float per pixel if a layer has depth ([`Views::has_depth`]).
    pub depths: &'o mut [f32],
    /// One colour per pixel if a layer is clipped or a group ([`Views::has_groups`]).
    pub group: &'o mut [[u8; 4]],
    /// One byte per pixel if a layer is clipped ([`Views::has_clips`]).
    pub clips: &'o mut [u8],
}

/// Result of a [`RenderJob`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(not(feature = "internals"), non_exhaustive)]
pub struct Drawn {
    /// Number of elements drawn.
    pub element_len: usize,
    /// Number of drawn elements that are flipped against their texture or folded, with all points
    /// visible.
    pub flipped_len: usize,
}

impl<'o> RenderScratch<'o> {
    /// Collects scratch for an object without depth, groups and clips. Set the other fields for these.
    pub const fn new(vertices: &'o mut [[f32; 3]], order: &'o mut [u16]) -> Self {
        Self { vertices, order, depths: &mut [], group: &mut [], clips: &mut [] }
    }
}

impl<'a> RenderJob<'a> {
    /// Makes the job of a frame.
    ///
    /// - `width`: width of the picture in pixels.
    pub const fn new(views: Views<'a>, frame: &'a Frame<'_>, width: usize) -> Self {
        let Frame { points, visibility, scores, layers } = frame;
        Self { views, points, visibility, scores, layers, width }
    }

    /// Draws the layers over the picture, in ascending order. Layers of equal order are drawn as in
    /// the file.
    ///
    /// A group or a clipped layer is drawn into its own buffer first. In other layers, overlapping
    /// translucent elements show the elements below.
    ///
    /// Points more than 2^20 pixels out are drawn at this distance.
    ///
    /// - `out`: RGBA8 pixels in sRGB with premultiplied alpha, row by row from the top. Textures
    ///   are sampled and blended in sRGB encoding.
    ///
    /// # Errors
    /// - [`crate::CallErrorKind::Length`]: `points`, `visibility`, `scores`, `layers`, or a scratch array
    ///   has another length; or `out` does not hold whole rows.
    /// - [`crate::CallErrorKind::TooShort`]: a scratch array with one value per pixel is too short.
    /// - [`crate::CallErrorKind::NonFinite`]: a point is not finite.
    pub fn run(&self, scratch: RenderScratch<'_>, out: &mut [[u8; 4]]) -> Result<Drawn, CallError> {
        self.check(&scratch, out)?;
        let RenderScratch { vertices, order, depths, group, clips } = scratch;
        for (number, vertex) in vertices.iter_mut().enumerate() {
            *vertex = self.views.vertex(number).map_or([0.0; 3], |vertex| vertex.at(self.points));
        }
        let picture = Picture { job: self, vertices };
        let group = group.get_mut(..out.len()).unwrap_or_default();
        let clips = clips.get_mut(..out.len()).unwrap_or_default();
        let (layers, elements) = order.split_at_mut(self.views.layer_len().min(order.len()));
        layers.iter_mut().zip(0..).for_each(|(out, layer)| *out = layer);
        sort(layers, |layer| self.layer_numbers(layer.into())[1]);
        let mut drawn = Drawn::default();
        let mut clipped = None;
        for number in layers.iter().map(|layer| usize::from(*layer)) {
            let [opacity, _] = self.layer_numbers(number);
            let Some(layer) = self.views.layer(number).filter(|_| opacity > 0.0) else { continue };
            if layer.clip.is_some() && layer.clip != clipped {
                picture.clip(number, group, clips);
                clipped = layer.clip;
            }
            let is_group = layer.clip.is_some() || layer.is_group;
            let order = elements.get_mut(layer.first..layer.end).unwrap_or_default();
            order.iter_mut().zip(layer.first as u16..).for_each(|(out, element)| *out = element);
            if layer.has_depth {
                depths.fill(f32::INFINITY);
                // Far elements first, then by number.
                sort(order, |element| -picture.mean_depth(element.into()));
            }
            if is_group {
                group.fill([0; 4]);
            }
            let (pixels, own) = if is_group { (&mut *group, 1.0) } else { (&mut *out, opacity) };
            let depths = layer.has_depth.then_some(&mut *depths);
            let mut screen = Screen { width: self.width, pixels, depths, opacity: own, is_group };
            for element in order {
                picture.draw(number, &layer, (*element).into(), &mut screen, &mut drawn);
            }
            if is_group {
                blend_group(group, layer.clip.map(|_| &*clips), opacity, out);
            }
        }
        Ok(drawn)
    }

    fn check(&self, scratch: &RenderScratch<'_>, out: &[[u8; 4]]) -> Result<(), CallError> {
        let views = &self.views;
        Argument::Points.check_len(views.point_len(), self.points.len())?;
        Argument::Visibility.check_len(views.point_len(), self.visibility.len())?;
        Argument::Scores.check_len(views.view_len(), self.scores.len())?;
        Argument::Layers.check_len(views.layer_len(), self.layers.len())?;
        let height = out.len().checked_div(self.width).unwrap_or(0);
        Argument::Pixels.check_len(height * self.width, out.len())?;
        Argument::Vertices.check_len(views.vertex_len(), scratch.vertices.len())?;
        Argument::Scratch.check_len(views.order_len(), scratch.order.len())?;
        let asked = |has: bool| if has { out.len() } else { 0 };
        Argument::Depths.check_least(asked(views.has_depth()), scratch.depths.len())?;
        Argument::Group.check_least(asked(views.has_groups()), scratch.group.len())?;
        Argument::Clips.check_least(asked(views.has_clips()), scratch.clips.len())?;
        let is_unsound = |point: &[f32; 3]| !point.iter().all(|x| x.is_finite());
        Argument::Points.check_finite(self.points.iter().position(is_unsound))
    }

    /// Returns the key views and shares for the colours of an element in a layer.
    pub fn blend(&self, layer: usize, element: usize) -> Option<Blend> {
        let element = self.views.element(element)?;
        let vertices = element.vertices();
        let place = |vertex: usize| {
            let vertex = self.views.vertex(vertex);
            vertex.map_or([0.0; 2], |vertex| flat(vertex.at(self.points)))
        };
        Some(self.blend_for(layer, vertices, area(vertices, place)))
    }

    /// Lists the vertices of an element that are points.
    fn points_of(&self, vertices: &[usize]) -> impl Iterator<Item = usize> {
        vertices.iter().filter_map(|vertex| self.views.vertex(*vertex)?.point())
    }

    /// Computes the shares of the key views for an element, from the view's scores and how well
    /// each view shows the element.
    ///
    /// - `layer`: the element's layer.
    /// - `own`: the element's signed area on the screen.
    fn blend_for(&self, layer: usize, vertices: &[usize], own: f32) -> Blend {
        // Vertices that are not points have no visibility of their own.
        let mut points = [None; 4];
        points.iter_mut().zip(self.points_of(vertices)).for_each(|(out, point)| *out = Some(point));
        let points = points.iter().flatten();
        let seen = points.clone().filter_map(|point| self.visibility.get(*point).copied());
        let shows = |view: usize| {
            !points.clone().any(|point| self.views.is_visible(view, *point) == Some(false))
        };
        // A view that shows the element smaller has fewer texels. A view that shows the element
        // flipped shows its other side.
        let detail = |view: usize| {
            if self.views.view_texture(view, layer).is_none() {
                return 1.0;
            }
            let place = |vertex: usize| self.views.texel(view, vertex).unwrap_or_default();
            let share = area(vertices, place) / own;
            if share > 0.0 { lesser(1.0, share) } else { 0.0 }
        };
        let whole = smoothstep(lesser(1.0, greater(0.0, seen.fold(1.0, lesser))));
        let fits = |view| detail(view) * if shows(view) { whole } else { 1.0 - whole };
        Blend::new(self.scores, fits)
    }

    /// Returns the opacity (0 to 1) and the order of a layer.
    fn layer_numbers(&self, layer: usize) -> [f32; 2] {
        let [opacity, order] = self.layers.get(layer).copied().unwrap_or_default();
        [lesser(1.0, greater(0.0, opacity)), order]
    }
}

/// A job with computed vertices.
struct Picture<'a> {
    job: &'a RenderJob<'a>,
    vertices: &'a [[f32; 3]],
}

impl Picture<'_> {
    /// Computes the coverage of every pixel by the layers that clip a layer.
    fn clip(&self, layer: usize, group: &mut [[u8; 4]], clips: &mut [u8]) {
        clips.fill(u8::MAX);
        for number in self.job.views.clips(layer) {
            let Some(layer) = self.job.views.layer(number) else { continue };
            group.fill([0; 4]);
            let mut screen = Screen {
                width: self.job.width,
                pixels: group,
                depths: None,
                opacity: 1.0,
                is_group: true,
            };
            for element in layer.first..layer.end {
                self.draw(number, &layer, element, &mut screen, &mut Drawn::default());
            }
            multiply_mask(group, self.job.layer_numbers(number)[0], clips);
        }
    }

    /// Draws an element, if a key view has a texture for the layer.
    fn draw(
        &self,
        number: usize,
        layer: &Layer,
        at: usize,
        screen: &mut Screen<'_>,
        drawn: &mut Drawn,
    ) {
        let views = &self.job.views;
        let Some(element) = views.element(at) else { return };
        let vertices = element.vertices();
        let area = self.area(vertices);
        if layer.is_one_sided && area < 0.0 {
            return;
        }
        let blend = self.job.blend_for(number, vertices, area);
        let mut sources = [Source::default(); SOURCES_MAX];
        let mut len = 0;
        for (view, share) in blend.views() {
            // A view without the layer contributes nothing.
            let texture = views.view_texture(*view, number).and_then(|at| views.texture(at));
            if let (Some(texture), Some(out)) = (texture, sources.get_mut(len)) {
                let mut texels = [[0.0; 2]; 4];
                for (out, vertex) in texels.iter_mut().zip(vertices) {
                    *out = views.texel(*view, *vertex).unwrap_or_default();
                }
                *out = Source { texture, texels, share: *share };
                len += 1;
            }
        }
        let sources = sources.get(..len).unwrap_or_default();
        if sources.is_empty() {
            return;
        }
        let neighbours = views.neighbours(at).unwrap_or_default();
        let corner = |number: usize, vertex: usize| {
            let [x, y, depth] = self.vertices.get(vertex).copied().unwrap_or_default();
            let across = neighbours.get(number).copied().flatten();
            let soft = across.map_or(1.0, |other| {
                let next = vertices.get(number + 1).or(vertices.first());
                let next = next.copied().unwrap_or(vertex);
                self.outline(layer, area, other, [vertex, next])
            });
            Corner { place: [x, y], depth, number, soft }
        };
        let is_flipped = match element {
            Element::Triangle([a, b, c]) => {
                let corners = [corner(0, a), corner(1, b), corner(2, c)];
                triangle(screen, corners, sources)
            }
            Element::Quad([a, b, c, d]) => {
                let corners = [corner(0, a), corner(1, b), corner(2, c), corner(3, d)];
                quad(screen, corners, sources)
            }
        };
        drawn.element_len += 1;
        let is_seen = |point| self.job.visibility.get(point).is_some_and(|x| *x > 0.5);
        if is_flipped && self.job.points_of(vertices).all(is_seen) {
            drawn.flipped_len += 1;
        }
    }

    /// Returns the width in pixels over which an edge fades out, at most 1.
    ///
    /// The width is positive only in layers with depth, at a fold: the element across the edge
    /// turns the other way and reaches back over this element. The first pixel of this reach does
    /// not count, so that a thin fold leaves no slit.
    fn outline(&self, layer: &Layer, area: f32, across: usize, edge: [usize; 2]) -> f32 {
        let Some(across) = self.job.views.element(across).filter(|_| layer.has_depth) else {
            return 0.0;
        };
        let other = self.area(across.vertices());
        if (other > 0.0) == (area > 0.0) {
            return 0.0;
        }
        let [a, b] = edge.map(|vertex| self.vertices.get(vertex).copied().unwrap_or_default());
        let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
        lesser(
            1.0,
            greater(0.0, other.abs() / greater(f32::MIN_POSITIVE, sqrt(dx * dx + dy * dy)) - 1.0),
        )
    }

    /// Returns twice the signed area of an element on the screen, positive for a clockwise element.
    fn area(&self, vertices: &[usize]) -> f32 {
        area(vertices, |vertex| flat(self.vertices.get(vertex).copied().unwrap_or_default()))
    }

    fn mean_depth(&self, element: usize) -> f32 {
        let Some(element) = self.job.views.element(element) else { return 0.0 };
        let vertices = element.vertices();
        let depths = vertices.iter().filter_map(|vertex| self.vertices.get(*vertex));
        depths.map(|[_, _, depth]| depth).sum::<f32>() / vertices.len() as f32
    }
}

/// Drops the depth of a place.
const fn flat([x, y, _]: [f32; 3]) -> [f32; 2] {
    [x, y]
}

/// Returns twice the signed area of a triangle or a quad, positive for a clockwise ring.
fn area(vertices: &[usize], place: impl Fn(usize) -> [f32; 2]) -> f32 {
    let at = |corner: usize| vertices.get(corner).map(|vertex| place(*vertex));
    let (Some([ax, ay]), Some([bx, by]), Some([cx, cy])) = (at(0), at(1), at(2)) else {
        return 0.0;
    };
    // Computed from the diagonals of a quad; a triangle is a quad with two equal corners.
    let [dx, dy] = at(3).unwrap_or([ax, ay]);
    (cx - ax) * (dy - by) - (cy - ay) * (dx - bx)
}

/// Sorts numbers by a key, then by the numbers themselves, with an in-place heap sort.
fn sort(numbers: &mut [u16], key: impl Fn(u16) -> f32) {
    let is_before = |a: u16, b: u16| key(a).total_cmp(&key(b)).then(a.cmp(&b)).is_lt();
    for root in (0..numbers.len() / 2).rev() {
        sink(numbers, root, &is_before);
    }
    let mut heap = numbers;
    while let Some((last, rest)) = heap.split_last_mut() {
        let Some(first) = rest.first_mut() else { return };
        core::mem::swap(first, last);
        sink(rest, 0, &is_before);
        heap = rest;
    }
}

/// Sifts a number down to its place in the heap.
fn sink(heap: &mut [u16], root: usize, is_before: &impl Fn(u16, u16) -> bool) {
    let Some(own) = heap.get(root).copied() else { return };
    let mut at = root;
    loop {
        let child = 2 * at + 1;
        let next = match (heap.get(child), heap.get(child + 1)) {
            (Some(a), Some(b)) if is_before(*a, *b) => child + 1,
            (Some(_), _) => child,
            (None, _) => break,
        };
        let Some(other) = heap.get(next).copied().filter(|other| is_before(own, *other)) else {
            break;
        };
        if let Some(place) = heap.get_mut(at) {
            *place = other;
        }
        at = next;
    }
    if let Some(place) = heap.get_mut(at) {
        *place = own;
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    #[test]
    fn numbers_come_in_the_order_of_their_keys() {
        for len in 0..60u16 {
            let keys: Vec<f32> = (0..len).map(|i| f32::from(i * 7 % 13) - 4.0).collect();
            let mut found: Vec<u16> = (0..len).collect();
            sort(&mut found, |i| keys[usize::from(i)]);
            let mut expected: Vec<u16> = (0..len).collect();
            expected.sort_by(|a, b| keys[usize::from(*a)].total_cmp(&keys[usize::from(*b)]));
            assert_eq!(found, expected);
        }
    }
}
