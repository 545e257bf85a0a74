//! Which pixels of a picture are covered: those with an alpha above 0.

use crate::page::camera::Resolution;
use crate::page::picture::Picture;

/// Cuts a picture to its covered pixels and `border` pixels around them, and returns the place of its corner; none of a
/// picture that covers nothing.
pub(super) fn cropped(whole: &Picture, border: usize) -> Option<(Picture, [usize; 2])> {
    let [width, height] = [whole.size.width, whole.size.height];
    let covers = |x: usize, y: usize| whole.rgba[4 * (y * width + x) + 3] > 0;
    let mut rows = (0..height).filter(|&y| (0..width).any(|x| covers(x, y)));
    let (top, bottom) = (rows.next()?, rows.next_back());
    let bottom = bottom.unwrap_or(top);
    let mut columns = (0..width).filter(|&x| (top..=bottom).any(|y| covers(x, y)));
    let (left, right) = (columns.next()?, columns.next_back());
    let right = right.unwrap_or(left);
    let [left, top] = [left, top].map(|first| first.saturating_sub(border));
    let [right, bottom] = [(right + 1 + border).min(width), (bottom + 1 + border).min(height)];
    let rgba = (top..bottom)
        .flat_map(|y| whole.rgba[4 * (y * width + left)..4 * (y * width + right)].iter().copied());
    let size = Resolution { width: right - left, height: bottom - top };
    Some((Picture { size, rgba: rgba.collect() }, [left, top]))
}

/// Counts of a picture's covered pixels, over all rectangles from its corner.
pub(super) struct Covered {
    size: [usize; 2],
    sums: Vec<u32>,
}

impl Covered {
    /// Counts the covered pixels of a picture.
    pub(super) fn of(picture: &Picture) -> Self {
        let [width, height] = [picture.size.width, picture.size.height];
        let at = |x: usize, y: usize| y * (width + 1) + x;
        let mut sums = vec![0; (width + 1) * (height + 1)];
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let own = u32::from(picture.rgba[4 * (y * width + x) + 3] > 0);
            sums[at(x + 1, y + 1)] = own + sums[at(x, y + 1)] + sums[at(x + 1, y)] - sums[at(x, y)];
        }
        Self { size: [width, height], sums }
    }

    /// Whether a pixel of a rectangle is covered.
    ///
    /// - `low`, `high`: its corners between pixels, whole numbers; beyond the picture there are none.
    pub(super) fn any(&self, low: [f64; 2], high: [f64; 2]) -> bool {
        let within = |place: [f64; 2]| {
            [0, 1].map(|axis| place[axis].clamp(0.0, self.size[axis] as f64) as usize)
        };
        let ([left, top], [right, bottom]) = (within(low), within(high));
        let sum = |x: usize, y: usize| self.sums[y * (self.size[0] + 1) + x];
        sum(right, bottom) + sum(left, top) > sum(right, top) + sum(left, bottom)
    }
}
