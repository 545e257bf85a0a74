//! Pins: from target places of a few vertices to the weights of all shapes (METHOD §5.1).

use super::active_set::{ActiveSet, End, FREE, HIGH, LOW};
use super::packed::{add, add_square, add_to_diagonal, dot, packed_len};
use super::part::{Prior, shapes};
use super::pins::{PinList, Vertex, not_finite};
use super::scratch::{CacheKey, Scratch};
use crate::error::{Argument, CallError, CallErrorKind};
use crate::linear::{Le, Matrix3x4, floats};
use crate::skin::Skin;

/// Weights that an edit changes as little as the pins allow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(not(feature = "internals"), non_exhaustive)]
pub enum Anchor {
    /// The current weights, for an artist's edit.
    #[default]
    Current,
    /// The mean weights: the pins alone decide the face.
    Mean,
}

/// Penalty on the change of weights from frame to frame.
#[derive(Clone, Copy, Debug)]
pub struct Temporal<'a> {
    /// S weights of the previous frame.
    pub weights: &'a [f32],
    /// Reciprocal of the mean squared change of a weight.
    pub stiffness: f32,
}

/// Solves weights for pins. Minimises `|U (w - anchor)|² + sum stiffness / β (row - target)²`, with
/// U the prior's factor.
#[derive(Clone, Debug)]
#[cfg_attr(not(feature = "internals"), non_exhaustive)]
pub struct PinJob<'a> {
    /// The prior.
    pub prior: Prior<'a>,
    /// The prior's skin, or another skin with equal shapes.
    pub skin: Skin<'a>,
    /// [`Skin::palette_len`] transforms of the pose in which the pins apply.
    pub palette: &'a [Matrix3x4],
    /// The pins. A pin has no effect if no shape moves its vertex along its rows.
    pub pins: PinList<'a>,
    /// Weights from which the change is measured.
    pub anchor: Anchor,
    /// β, the squared distance by which a pin of stiffness 1 may miss: [`super::PriorFit::beta`] or
    /// another value.
    pub beta: f32,
    /// Whether the weights stay between the prior's bounds.
    pub is_bounded: bool,
    /// Penalty that keeps the weights near the previous frame's.
    pub temporal: Option<Temporal<'a>>,
    /// Weight of the prior's symmetry term: 0 turns the term off, and 1 is the prior's own
    /// stiffness.
    pub symmetry: f32,
    /// Whether to hold the smaller weight of each mutually exclusive pair at 0.
    pub cancels: bool,
}

/// Result of a [`PinJob`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(not(feature = "internals"), non_exhaustive)]
pub struct Edit {
    /// `|U (w - anchor)|`: how unlikely the change is under the prior (S0, Eq. 5).
    pub norm: f32,
    /// Pins that no shape moves.
    pub unreachable_len: usize,
    /// Number of solves; 0 if there was nothing to solve.
    pub round_len: u32,
    /// Whether the solution is the minimum between the bounds. Otherwise weights were cut to the
    /// bounds.
    pub is_least: bool,
}

impl<'a> PinJob<'a> {
    /// Makes the job of an artist's edit at rest: from the current weights, between the bounds,
    /// without temporal and symmetry terms.
    pub fn new(prior: Prior<'a>, skin: Skin<'a>, pins: PinList<'a>) -> Self {
        Self {
            prior,
            skin,
            palette: &[],
            pins,
            anchor: Anchor::Current,
            beta: prior.fit().beta,
            is_bounded: true,
            temporal: None,
            symmetry: 0.0,
            cancels: false,
        }
    }

    /// Returns the numbers of scratch that [`PinJob::run`] needs.
    pub fn scratch_len(&self) -> usize {
        self.prior.counts().pin_scratch_len(self.pins.scalar_len())
    }

    /// Solves the weights. Without a pin that any shape moves, the weights stay unchanged.
    ///
    /// Scratch from a run with equal prior, terms and pins is reused, even if the pins' targets
    /// differ. A reusing run costs only the solve, and gives equal results to the last bit.
    ///
    /// - `scratch`: at least [`PinJob::scratch_len`] numbers, of any content.
    /// - `weights`: S weights. On entry the anchor [`Anchor::Current`]; on return the solution.
    ///
    /// # Errors
    /// - [`CallErrorKind::Length`]: the prior and the skin differ in their number of shapes; or
    ///   `palette`, `weights` or the previous frame's weights have another length.
    /// - [`CallErrorKind::TooShort`]: `scratch` is too short.
    /// - [`CallErrorKind::OutOfRange`]: a pin's vertex is not in the skin, and the index is the
    ///   pin's place in the list; or β or a stiffness is not positive and finite.
    /// - [`CallErrorKind::NonFinite`]: a weight is not finite or would not be; or a pin's row gives
    ///   a value that is not finite; or pins are so stiff that nothing of the prior is left.
    pub fn run(&self, scratch: &mut [f64], weights: &mut [f32]) -> Result<Edit, CallError> {
        self.check(weights)?;
        let (n, scalar_len) = (self.prior.shape_len(), self.pins.scalar_len());
        let least = self.prior.counts().pin_scratch_len(scalar_len);
        Argument::Scratch.check_least(least, scratch.len())?;
        let Some(mut scratch) = Scratch::new(scratch, n, scalar_len) else {
            return Ok(Edit::default());
        };
        self.set_anchor(&mut scratch, weights);
        let terms = [self.temporal.map_or(0.0, |temporal| temporal.stiffness), self.symmetry];
        let key = CacheKey::new(&self.prior, scalar_len, terms);
        let was = core::mem::replace(scratch.key, CacheKey::NOTHING.0);
        let (is_same, unreachable_len) = self.observe(&mut scratch)?;
        let is_same = is_same && was == key.0;
        if unreachable_len == self.pins.iter().len() {
            return Ok(Edit { unreachable_len, is_least: true, ..Edit::default() });
        }
        self.add_terms(&mut scratch);
        if !is_same {
            self.set_hessian(&mut scratch);
        }
        let (end, round_len) = self.search(&mut scratch, is_same);
        if end == End::Least {
            *scratch.key = key.0;
        }
        let [step, ..] = &scratch.work;
        let solved =
            scratch.anchor.iter().zip(&**step).map(|(anchor, step)| (anchor + step) as f32);
        if end == End::NoFactor {
            return Err(CallError::new(CallErrorKind::NonFinite, Argument::Pins));
        }
        Argument::Weights.check_finite(solved.clone().position(|weight| !weight.is_finite()))?;
        for ((weight, solved), bounds) in weights.iter_mut().zip(solved).zip(self.prior.bounds()) {
            let [low, high] = floats(bounds);
            *weight = if self.is_bounded { solved.max(low).min(high) } else { solved };
        }
        let norm = libm::sqrt(self.squared_norm(step)) as f32;
        Ok(Edit { norm, unreachable_len, round_len, is_least: end == End::Least })
    }

    fn check(&self, weights: &[f32]) -> Result<(), CallError> {
        let shape_len = self.skin.shape_len();
        Argument::Prior.check_len(shape_len, self.prior.shape_len())?;
        Argument::Palette.check_len(self.skin.palette_len(), self.palette.len())?;
        let last = self.temporal.map_or(weights, |temporal| temporal.weights);
        for weights in [weights, last] {
            self.skin.check_weights(weights)?;
        }
        let stiffness = self.temporal.map_or(1.0, |temporal| temporal.stiffness);
        let is_sound = |x: f32| (0.0..=f32::MAX).contains(&x);
        if ![self.beta, stiffness, self.symmetry].into_iter().all(is_sound) || self.beta == 0.0 {
            return Err(CallError::new(CallErrorKind::OutOfRange, Argument::Prior));
        }
        let vertex_len = self.skin.vertex_len();
        let beyond = |vertex: u32| vertex as usize >= vertex_len;
        match self.pins.iter().position(|pin| beyond(pin.vertex)) {
            None => Ok(()),
            Some(at) => Err(CallError::new(CallErrorKind::OutOfRange, Argument::Pins).at(at)),
        }
    }

    /// Writes the anchor, and the bounds of each step.
    fn set_anchor(&self, scratch: &mut Scratch<'_>, weights: &[f32]) {
        let pairs = scratch.anchor.iter_mut().zip(weights).zip(self.prior.means());
        for ((anchor, weight), mean) in pairs {
            *anchor = f64::from(match self.anchor {
                Anchor::Current => *weight,
                Anchor::Mean => f32::from_le_bytes(*mean),
            });
        }
        let steps = scratch.low.iter_mut().zip(&mut *scratch.high).zip(&mut *scratch.zero);
        let bounds = self.prior.bounds().iter().map(|bounds| floats(bounds).map(f64::from));
        for (((low, high), zero), ([least, most], anchor)) in
            steps.zip(bounds.zip(&*scratch.anchor))
        {
            *zero = -*anchor;
            (*low, *high) = match self.is_bounded {
                true => (least - anchor, most - anchor),
                false => (f64::NEG_INFINITY, f64::INFINITY),
            };
        }
    }

    /// Writes the pins' rows and their right-hand side. Returns whether the rows equal the previous
    /// run's, and the number of pins that no shape moves.
    fn observe(&self, scratch: &mut Scratch<'_>) -> Result<(bool, usize), CallError> {
        scratch.rhs.fill(0.0);
        let (mut is_same, mut unreachable) = (true, 0);
        // A chunk length of zero would panic.
        let mut rows = scratch.rows.chunks_exact_mut((scratch.anchor.len() + 1).max(1));
        for (index, pin) in self.pins.iter().enumerate() {
            let Some(vertex) = Vertex::new(&self.skin, self.palette, pin.vertex) else { continue };
            let [x, y, z, _] = &mut scratch.work;
            [&mut **x, &mut **y, &mut **z].into_iter().for_each(|deltas| deltas.fill(0.0));
            for (shape, delta) in self.skin.deltas_of(pin.vertex as usize) {
                for (out, u) in [&mut *x, &mut *y, &mut *z].into_iter().zip(delta) {
                    out.get_mut(shape..).into_iter().flatten().take(1).for_each(|x| *x = u.into());
                }
            }
            let strength = f64::from(pin.stiffness) / f64::from(self.beta);
            let mut is_reached = false;
            for (row, target) in pin.active_rows() {
                let Some((strength_was, out)) = rows.next().and_then(<[_]>::split_first_mut) else {
                    break;
                };
                let (at_rest, [a, b, c]) = vertex.apply_row(row);
                is_same &= *strength_was == strength;
                *strength_was = strength;
                for (out, ((x, y), z)) in out.iter_mut().zip(x.iter().zip(&**y).zip(&**z)) {
                    let b = a * x + b * y + c * z;
                    is_same &= *out == b;
                    is_reached |= b != 0.0;
                    *out = b;
                }
                let residual = f64::from(target) - at_rest - dot(out, scratch.anchor);
                if !residual.is_finite() || !dot(out, out).is_finite() {
                    return Err(not_finite(index));
                }
                add(scratch.rhs, strength * residual, out);
            }
            unreachable += usize::from(!is_reached);
        }
        Ok((is_same, unreachable))
    }

    /// Adds the right-hand sides of the temporal and symmetry terms.
    fn add_terms(&self, scratch: &mut Scratch<'_>) {
        if let Some(Temporal { weights, stiffness }) = self.temporal {
            let rhs_entries = scratch.rhs.iter_mut().zip(weights).zip(&*scratch.anchor);
            for ((rhs, weight), anchor) in rhs_entries {
                *rhs += f64::from(stiffness) * (f64::from(*weight) - anchor);
            }
        }
        for (pair, stiffness) in self.symmetry() {
            let [a, b] = pair.map(|shape| scratch.anchor.get(shape).copied().unwrap_or_default());
            for (shape, by) in pair.into_iter().zip([b - a, a - b]) {
                scratch.rhs.iter_mut().skip(shape).take(1).for_each(|rhs| *rhs += stiffness * by);
            }
        }
    }

    /// Computes H.
    fn set_hessian(&self, scratch: &mut Scratch<'_>) {
        let n = scratch.anchor.len();
        let hessian = &mut *scratch.hessian;
        hessian.fill(0.0);
        let [row, ..] = &mut scratch.work;
        let mut rest = &mut *hessian;
        for len in (1..=n).rev() {
            let start = packed_len(n) - packed_len(len);
            let own = row.get_mut(..len).unwrap_or_default();
            read(self.prior.factor(), start, own);
            add_square(rest, 1.0, own);
            rest = rest.get_mut(len..).unwrap_or_default();
        }
        // A chunk length of zero would panic.
        for row in scratch.rows.chunks_exact((n + 1).max(1)) {
            if let Some((strength, row)) = row.split_first() {
                add_square(hessian, *strength, row);
            }
        }
        if let Some(temporal) = self.temporal {
            add_to_diagonal(hessian, n, temporal.stiffness.into());
        }
        for ([a, b], stiffness) in self.symmetry() {
            let (a, b) = (a.min(b), a.max(b));
            let start = |row: usize| packed_len(n) - packed_len(n.saturating_sub(row));
            for (at, by) in
                [(start(a), stiffness), (start(b), stiffness), (start(a) + b - a, -stiffness)]
            {
                hessian.iter_mut().skip(at).take(1).for_each(|entry| *entry += by);
            }
        }
    }

    /// Searches for the step. With an unchanged H the search starts at the held steps of the last
    /// run.
    fn search(&self, scratch: &mut Scratch<'_>, is_same: bool) -> (End, u32) {
        let mut is_factored = is_same;
        for held in &mut *scratch.held {
            let starts = if is_same && self.is_bounded && (*held == LOW || *held == HIGH) {
                *held
            } else {
                FREE
            };
            is_factored &= starts == *held;
            *held = starts;
        }
        let [step, solution, slope, free] = &mut scratch.work;
        let mut set = ActiveSet {
            hessian: scratch.hessian,
            rhs: scratch.rhs,
            low: scratch.low,
            high: scratch.high,
            zero: scratch.zero,
            held: scratch.held,
            factor: scratch.factor,
            is_factored,
            is_bounded: self.is_bounded,
            step,
            solution,
            slope,
            free,
        };
        let mut rounds = 0;
        loop {
            let (end, more) = set.search();
            rounds += more;
            if end == End::NoFactor || !self.cancels || !self.cancel(&mut set) {
                return (end, rounds);
            }
        }
    }

    /// Holds the smaller weight of each mutually exclusive pair with two active weights. Returns
    /// whether there was such a pair.
    fn cancel(&self, set: &mut ActiveSet<'_>) -> bool {
        let mut found = false;
        for pair in self.prior.cancel_pairs() {
            let [a, b] = pair.map(|shape| set.weight(shape).abs());
            if a.min(b) > INACTIVE_MAX {
                let [first, second] = pair;
                set.hold_at_zero(if a < b { first } else { second });
                found = true;
            }
        }
        found
    }

    /// Lists the symmetric pairs, with their stiffness in this job.
    fn symmetry(&self) -> impl Iterator<Item = ([usize; 2], f64)> {
        let by = f64::from(self.symmetry);
        // With weight 0 the list is empty, so that nothing is added.
        let rows = if by > 0.0 { self.prior.symmetry_rows() } else { &[] };
        rows.iter().map(move |[pair, stiffness]| {
            (shapes(pair), by * f64::from(f32::from_le_bytes(*stiffness)))
        })
    }

    /// Computes |U d|².
    fn squared_norm(&self, step: &[f64]) -> f64 {
        let mut start = 0;
        let mut sum = 0.0;
        for at in 0..step.len() {
            let tail = step.get(at..).unwrap_or_default();
            let row = self.prior.factor().get(start..start + tail.len()).unwrap_or_default();
            let product = row.iter().zip(tail);
            let own =
                product.fold(0.0, |sum, (le, d)| sum + f64::from(f32::from_le_bytes(*le)) * d);
            sum += own * own;
            start += tail.len();
        }
        sum
    }
}

/// Reads floats of the file, starting at index `start`.
fn read(from: &[Le], start: usize, out: &mut [f64]) {
    let from = from.get(start..).unwrap_or_default();
    out.iter_mut().zip(from).for_each(|(out, le)| *out = f32::from_le_bytes(*le).into());
}

/// Largest weight at which a shape of a mutually exclusive pair counts as inactive.
const INACTIVE_MAX: f64 = 1.0e-9;
