//! From points to a picture (METHOD §6.5, §6.9).

use super::order::sort;
use super::raster::{Corner, Screen};
use super::view::{Element, Views};
use crate::error::{Argument, CallError, CallErrorKind};

/// Draws an object into a picture of the caller's.
#[derive(Clone, Copy, Debug)]
pub struct RenderJob<'a> {
    /// The object.
    pub views: Views<'a>,
    /// K points, as [`super::Frame`] has them.
    pub points: &'a [[f32; 3]],
    /// K visibilities; an element with a point that is not above 0.5 is not drawn.
    pub visibility: &'a [f32],
    /// N scores: an element of which the characteristic view does not show all points is textured by the view of the
    /// highest score that does.
    pub scores: &'a [f32],
    /// The characteristic view, whose texture elements have.
    pub view: usize,
    /// Width of the picture in pixels.
    pub width: usize,
}

/// Which of two elements hides the other.
#[derive(Debug)]
pub enum Order<'o> {
    /// The one that is nearer at the pixel, of equally near ones the first. Texels of alpha below a half are not drawn,
    /// the others replace what is there. A float a pixel, infinite where nothing has been drawn.
    Depth(&'o mut [f32]),
    /// The one whose points are nearer on average, of equally near ones the last: what it covers is blended. E numbers
    /// of scratch, of any content.
    Painter(&'o mut [u16]),
}

/// What a [`RenderJob`] drew.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Drawn {
    /// Elements drawn.
    pub element_len: usize,
    /// Those of them that are turned over against their texture, or folded.
    pub flipped_len: usize,
}

impl RenderJob<'_> {
    /// Draws the elements over what the picture holds.
    ///
    /// Points more than 2^20 pixels out are drawn as if they were there.
    ///
    /// - `out`: pixels row by row from the top, RGBA8: sRGB, each times its alpha. Textures are sampled between texels
    ///   and blended as sRGB encodes them.
    ///
    /// # Errors
    /// - [`CallErrorKind::Length`]: `points`, `visibility`, `scores`, or the numbers or floats of `order` have another
    ///   length; or `out` is not of whole rows.
    /// - [`CallErrorKind::OutOfRange`]: `view` is no key view.
    /// - [`CallErrorKind::NonFinite`]: a point is not finite.
    pub fn run(&self, order: Order<'_>, out: &mut [[u8; 4]]) -> Result<Drawn, CallError> {
        self.check(&order, out)?;
        let mut drawn = Drawn::default();
        let mut screen = Screen { width: self.width, pixels: out, depths: None };
        match order {
            Order::Depth(depths) => {
                screen.depths = Some(depths);
                let elements = 0..self.views.element_len();
                elements.for_each(|element| self.draw(element, &mut screen, &mut drawn));
            }
            Order::Painter(order) => {
                order.iter_mut().zip(0..).for_each(|(out, element)| *out = element);
                // From the far ones to the near ones, then by number.
                sort(order, |element| -self.mean_depth(element.into()));
                for element in order {
                    self.draw((*element).into(), &mut screen, &mut drawn);
                }
            }
        }
        Ok(drawn)
    }

    fn check(&self, order: &Order<'_>, out: &[[u8; 4]]) -> Result<(), CallError> {
        let views = &self.views;
        Argument::Points.check_len(views.point_len(), self.points.len())?;
        Argument::Visibility.check_len(views.point_len(), self.visibility.len())?;
        Argument::Scores.check_len(views.view_len(), self.scores.len())?;
        let height = out.len().checked_div(self.width).unwrap_or(0);
        Argument::Pixels.check_len(height * self.width, out.len())?;
        match order {
            Order::Depth(depths) => Argument::Depths.check_len(out.len(), depths.len())?,
            Order::Painter(order) => {
                Argument::Scratch.check_len(views.element_len(), order.len())?;
            }
        }
        if self.view >= views.view_len() {
            let error = CallError::new(CallErrorKind::OutOfRange, Argument::Scores);
            return Err(error.values(views.view_len().saturating_sub(1), self.view));
        }
        match self.points.iter().position(|point| !point.iter().all(|x| x.is_finite())) {
            None => Ok(()),
            Some(at) => Err(CallError::new(CallErrorKind::NonFinite, Argument::Points).at(at)),
        }
    }

    /// Draws an element, if all of its points are visible.
    fn draw(&self, element: usize, screen: &mut Screen<'_>, drawn: &mut Drawn) {
        let Some(element) = self.views.element(element) else { return };
        if !element.points().iter().all(|point| self.is_visible(*point)) {
            return;
        }
        let view = self.source(&element);
        let texture = self.views.view_texture(view).and_then(|at| self.views.texture(at));
        let Some(texture) = texture else { return };
        let corner = |point: usize| {
            let [x, y, depth] = self.points.get(point).copied().unwrap_or_default();
            let texel = self.views.reference(view, point).unwrap_or_default();
            Corner { place: [x, y], depth, texel }
        };
        let is_flipped = match element {
            Element::Triangle(points) => screen.triangle(points.map(corner), &texture),
            Element::Quad(points) => screen.quad(points.map(corner), &texture),
        };
        drawn.element_len += 1;
        drawn.flipped_len += usize::from(is_flipped);
    }

    fn is_visible(&self, point: usize) -> bool {
        self.visibility.get(point).is_some_and(|x| *x > 0.5)
    }

    /// Returns the view that an element has its texture from.
    fn source(&self, element: &Element) -> usize {
        let shows = |view: usize| {
            let mut points = element.points().iter();
            points.all(|point| self.views.is_visible(view, *point) == Some(true))
        };
        if shows(self.view) {
            return self.view;
        }
        let (mut best, mut highest) = (self.view, f32::NEG_INFINITY);
        for (view, score) in self.scores.iter().enumerate() {
            if *score > highest && shows(view) {
                (best, highest) = (view, *score);
            }
        }
        best
    }

    fn mean_depth(&self, element: usize) -> f32 {
        let Some(element) = self.views.element(element) else { return 0.0 };
        let depths = element.points().iter().filter_map(|point| self.points.get(*point));
        depths.map(|[_, _, depth]| depth).sum::<f32>() / element.points().len() as f32
    }
}

impl Element {
    /// Returns the numbers of its points.
    pub const fn points(&self) -> &[usize] {
        match self {
            Self::Triangle(points) => points,
            Self::Quad(points) => points,
        }
    }
}
