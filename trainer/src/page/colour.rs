//! Colours: a heat scale for errors, and hues that set neighbours apart.

/// Red, green and blue in sRGB, 0 to 255.
pub type Colour = [u8; 3];

/// Heat from no error to the largest. Each stop is darker than the one before, so readers who cannot tell red from
/// green still see the order.
const HEAT: [Colour; 6] = [
    [0xec, 0xea, 0xe4],
    [0xfd, 0xdf, 0x97],
    [0xfb, 0xa9, 0x4f],
    [0xec, 0x6a, 0x38],
    [0xbd, 0x2b, 0x44],
    [0x5c, 0x0d, 0x44],
];

/// Hues around the colour wheel at even lightness; the wheel is used twice, the second time darker.
const HUES: usize = 12;

/// A colour scale of errors from 0 to `most`, by their square root: an error of a hundredth of `most` stays visible.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    /// Error at the hot end.
    pub most: f64,
}

impl Scale {
    /// Makes a scale for the errors, up to a round number.
    pub fn of<'a>(errors: impl IntoIterator<Item = &'a f64>) -> Self {
        let most = errors.into_iter().copied().fold(0.0, f64::max);
        Self { most: round_up(most) }
    }

    /// Returns the place of an error on the scale, in [0, 1].
    pub fn place(&self, error: f64) -> f64 {
        (error / self.most).clamp(0.0, 1.0).sqrt()
    }

    /// Returns the colour of an error.
    pub fn colour(&self, error: f64) -> Colour {
        heat(self.place(error))
    }

    /// Lists the errors to label on the scale, ascending, with enough room between the labels.
    pub fn ticks(&self) -> [f64; 6] {
        [0.0, 0.02, 0.1, 0.25, 0.5, 1.0].map(|share| share * self.most)
    }
}

/// Returns the heat colour at a place in [0, 1].
pub fn heat(place: f64) -> Colour {
    let along = place.clamp(0.0, 1.0) * (HEAT.len() - 1) as f64;
    let stop = (along as usize).min(HEAT.len() - 2);
    let share = along - stop as f64;
    let mix =
        |c: usize| f64::from(HEAT[stop][c]) * (1.0 - share) + f64::from(HEAT[stop + 1][c]) * share;
    [0, 1, 2].map(|c| mix(c).round() as u8)
}

/// Colours the nodes of a graph so that neighbours differ as much as possible; earlier nodes choose first.
pub fn distinct_colours(neighbours: &[Vec<usize>]) -> Vec<Colour> {
    let wheel: Vec<Colour> = (0..2 * HUES).map(hue).collect();
    let mut used = vec![0_usize; wheel.len()];
    let mut taken: Vec<Option<usize>> = vec![None; neighbours.len()];
    for node in 0..neighbours.len() {
        let near: Vec<usize> = neighbours[node].iter().filter_map(|&other| taken[other]).collect();
        let room = |colour: usize| near.iter().map(|&other| wheel_steps(colour, other)).min();
        // Among colours with equally distant neighbours, take the least used.
        let best = (0..wheel.len()).rev().max_by_key(|&colour| {
            let room = room(colour).unwrap_or(usize::MAX).min(HUES / 3);
            (room, usize::MAX - used[colour])
        });
        if let Some(best) = best {
            used[best] += 1;
            taken[node] = Some(best);
        }
    }
    taken.into_iter().map(|colour| wheel[colour.unwrap_or(0)]).collect()
}

/// Returns the steps between two colours of the wheel.
fn wheel_steps(a: usize, b: usize) -> usize {
    let steps = (a % HUES).abs_diff(b % HUES);
    steps.min(HUES - steps) + usize::from(a / HUES != b / HUES)
}

/// Returns a colour of the wheel, 0 to 2 `HUES` - 1.
fn hue(number: usize) -> Colour {
    let angle = std::f64::consts::TAU * (number % HUES) as f64 / HUES as f64;
    let (middle, swing) = if number < HUES { (190.0, 50.0) } else { (136.0, 50.0) };
    [0.0, 1.0, 2.0].map(|part| {
        let turned = angle - std::f64::consts::TAU * part / 3.0;
        (middle + swing * libm::cos(turned)).round() as u8
    })
}

/// Rounds up to a number of one or two digits; 0 becomes 1.
fn round_up(value: f64) -> f64 {
    if value <= 0.0 {
        return 1.0;
    }
    let unit = 10_f64.powi(value.log10().floor() as i32);
    let steps = [1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0];
    let most = steps.iter().map(|step| step * unit).find(|&most| most >= value);
    most.unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heat_grows_darker_all_the_way() {
        let luminance = |[r, g, b]: Colour| {
            0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
        };
        let along: Vec<f64> = (0..=100).map(|k| luminance(heat(f64::from(k) / 100.0))).collect();
        assert!(along.windows(2).all(|pair| pair[1] < pair[0]), "{along:?}");
        assert_eq!((heat(0.0), heat(1.0), heat(7.0)), (HEAT[0], HEAT[5], HEAT[5]));
    }

    #[test]
    fn a_scale_goes_to_a_round_number_by_square_roots() {
        let scale = Scale::of(&[0.3, 1.7, 0.0]);
        assert_eq!(scale.most, 2.0);
        assert_eq!(scale.place(0.5), 0.5);
        assert_eq!(scale.colour(2.0), HEAT[5]);
        assert_eq!(scale.ticks(), [0.0, 0.04, 0.2, 0.5, 1.0, 2.0]);
        for (most, expected) in [(0.0, 1.0), (1.0, 1.0), (0.000_31, 0.000_4), (83.0, 100.0)] {
            let found = Scale::of(&[most]).most;
            assert!((found / expected - 1.0).abs() < 1e-12, "{most} {found}");
        }
    }

    #[test]
    fn neighbours_differ() {
        // A ring of 30 nodes, each next to the two nodes on either side.
        let near = |k: usize| [1, 2, 28, 29].map(|step| (k + step) % 30).to_vec();
        let neighbours: Vec<Vec<usize>> = (0..30).map(near).collect();
        let colours = distinct_colours(&neighbours);
        for (node, others) in neighbours.iter().enumerate() {
            for &other in others {
                let apart = (0..3).map(|c| colours[node][c].abs_diff(colours[other][c])).max();
                assert!(apart > Some(30), "{node} {other} {colours:?}");
            }
        }
        let mut kinds = colours.clone();
        kinds.sort_unstable();
        kinds.dedup();
        assert!(kinds.len() > 6, "{kinds:?}");
    }
}
