//! Pins: from where a few vertices are to be to the weights of all shapes (METHOD §5.1).

use super::active_set::{ActiveSet, End, FREE, HIGH, LOW};
use super::packed::{add, add_square, add_to_diagonal, dot, packed_len};
use super::part::{Prior, shapes};
use super::pins::{PinList, Vertex, not_finite};
use super::scratch::{Head, Scratch};
use crate::error::{Argument, CallError, CallErrorKind};
use crate::linear::{Le, Matrix3x4, floats};
use crate::skin::Skin;

/// What is changed as little as pins allow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Anchor {
    /// The weights now: an artist's edit.
    #[default]
    Current,
    /// The mean weights: a face that is nothing but what pins say.
    Mean,
}

/// How little weights change from one frame to the next.
#[derive(Clone, Copy, Debug)]
pub struct Temporal<'a> {
    /// S weights, those of the frame before.
    pub weights: &'a [f32],
    /// The reciprocal of the mean square by which a weight changes.
    pub stiffness: f32,
}

/// Solves weights for pins: the least of `|U (w - anchor)|² + sum stiffness / β (row - target)²`, U the prior's factor.
#[derive(Clone, Debug)]
pub struct PinJob<'a> {
    /// The prior.
    pub prior: Prior<'a>,
    /// Its skin, or another with the same shapes.
    pub skin: Skin<'a>,
    /// [`Skin::palette_len`] transforms of the pose in which pins are where they are.
    pub palette: &'a [Matrix3x4],
    /// The pins. Those of a vertex that no shape moves, along what they look at, count as none.
    pub pins: PinList<'a>,
    /// What is changed as little as pins allow.
    pub anchor: Anchor,
    /// β: the square of the length by which a pin of stiffness 1 may miss; [`super::PriorFit::beta`], or another.
    pub beta: f32,
    /// Whether weights stay between the prior's bounds.
    pub is_bounded: bool,
    /// What keeps the weights near those of the frame before.
    pub temporal: Option<Temporal<'a>>,
    /// How much the prior's symmetry counts; 0 leaves it out, 1 is as stiff as the prior has it.
    pub symmetry: f32,
    /// Whether of the pairs that cancel the smaller weight is held at 0.
    pub cancels: bool,
}

/// What a [`PinJob`] did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Edit {
    /// `|U (w - anchor)|`: how unlikely the prior finds the change (S0, Eq. 5).
    pub norm: f32,
    /// Pins that no shape moves.
    pub unreachable_len: usize,
    /// Factors and solves that it took; 0 where there was nothing to solve.
    pub round_len: u32,
    /// Whether bounds were found to hold at the least; else weights were cut to them.
    pub is_least: bool,
}

impl<'a> PinJob<'a> {
    /// Makes the job of an artist's edit at rest: from the weights now, between the bounds, without the terms of
    /// trackers.
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

    /// Changes weights. Without a pin that any shape moves they stay as they are.
    ///
    /// What scratch holds from a run with the same prior, terms and pins, but for their targets, is used again: then a
    /// run costs only the solve. The result is the same, to the last bit.
    ///
    /// - `scratch`: at least [`super::PriorCounts::pin_scratch_len`] numbers, of any content.
    /// - `weights`: S weights, the anchor [`Anchor::Current`]; then those solved.
    ///
    /// # Errors
    /// - [`CallErrorKind::Length`]: the prior has not as many shapes as the skin; or `palette`, `weights` or those of
    ///   the frame before have another length.
    /// - [`CallErrorKind::TooShort`]: `scratch` is too short.
    /// - [`CallErrorKind::OutOfRange`]: a pin's vertex, whose place in the list is the index, is not of the skin; or β
    ///   or a stiffness is not positive and finite.
    /// - [`CallErrorKind::NonFinite`]: a weight is not finite, or would not be; or what a pin looks at; or pins are so
    ///   stiff that nothing is left of the prior.
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
        let head = Head::new(&self.prior, scalar_len, terms);
        let was = core::mem::replace(scratch.head, Head::NOTHING.0);
        let (is_same, unreachable_len) = self.observe(&mut scratch)?;
        let is_same = is_same && was == head.0;
        if unreachable_len == self.pins.iter().len() {
            return Ok(Edit { unreachable_len, is_least: true, ..Edit::default() });
        }
        self.add_terms(&mut scratch);
        if !is_same {
            self.set_hessian(&mut scratch);
        }
        let (end, round_len) = self.search(&mut scratch, is_same);
        if end == End::Least {
            *scratch.head = head.0;
        }
        let [step, ..] = &scratch.loose;
        let solved =
            scratch.anchor.iter().zip(&**step).map(|(anchor, step)| (anchor + step) as f32);
        if end == End::NoFactor {
            return Err(CallError::new(CallErrorKind::NonFinite, Argument::Pins));
        }
        if let Some(at) = solved.clone().position(|weight| !weight.is_finite()) {
            return Err(CallError::new(CallErrorKind::NonFinite, Argument::Weights).at(at));
        }
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

    /// Writes what weights are changed from, and how far each may go.
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

    /// Writes the rows of pins and what they pull, and returns whether they are those that were there, and how many
    /// pins no shape moves.
    fn observe(&self, scratch: &mut Scratch<'_>) -> Result<(bool, usize), CallError> {
        scratch.pull.fill(0.0);
        let (mut is_same, mut unreachable) = (true, 0);
        // Chunks of zero would panic.
        let mut rows = scratch.rows.chunks_exact_mut((scratch.anchor.len() + 1).max(1));
        for (index, pin) in self.pins.iter().enumerate() {
            let Some(vertex) = Vertex::new(&self.skin, self.palette, pin.vertex) else { continue };
            let [x, y, z, _] = &mut scratch.loose;
            [&mut **x, &mut **y, &mut **z].into_iter().for_each(|deltas| deltas.fill(0.0));
            for (shape, delta) in self.skin.deltas_of(pin.vertex as usize) {
                for (out, u) in [&mut *x, &mut *y, &mut *z].into_iter().zip(delta) {
                    out.get_mut(shape..).into_iter().flatten().take(1).for_each(|x| *x = u.into());
                }
            }
            let strength = f64::from(pin.stiffness) / f64::from(self.beta);
            let mut is_reached = false;
            for (row, target) in pin.looks() {
                let Some((strength_was, out)) = rows.next().and_then(<[_]>::split_first_mut) else {
                    break;
                };
                let (at_rest, [a, b, c]) = vertex.seen(row);
                is_same &= *strength_was == strength;
                *strength_was = strength;
                for (out, ((x, y), z)) in out.iter_mut().zip(x.iter().zip(&**y).zip(&**z)) {
                    let b = a * x + b * y + c * z;
                    is_same &= *out == b;
                    is_reached |= b != 0.0;
                    *out = b;
                }
                let missing = f64::from(target) - at_rest - dot(out, scratch.anchor);
                if !missing.is_finite() || !dot(out, out).is_finite() {
                    return Err(not_finite(index));
                }
                add(scratch.pull, strength * missing, out);
            }
            unreachable += usize::from(!is_reached);
        }
        Ok((is_same, unreachable))
    }

    /// Adds what the terms of trackers pull.
    fn add_terms(&self, scratch: &mut Scratch<'_>) {
        if let Some(Temporal { weights, stiffness }) = self.temporal {
            let pulls = scratch.pull.iter_mut().zip(weights).zip(&*scratch.anchor);
            for ((pull, weight), anchor) in pulls {
                *pull += f64::from(stiffness) * (f64::from(*weight) - anchor);
            }
        }
        for (pair, stiffness) in self.symmetry() {
            let [a, b] = pair.map(|shape| scratch.anchor.get(shape).copied().unwrap_or_default());
            for (shape, by) in pair.into_iter().zip([b - a, a - b]) {
                scratch
                    .pull
                    .iter_mut()
                    .skip(shape)
                    .take(1)
                    .for_each(|pull| *pull += stiffness * by);
            }
        }
    }

    /// Computes H.
    fn set_hessian(&self, scratch: &mut Scratch<'_>) {
        let n = scratch.anchor.len();
        let hessian = &mut *scratch.hessian;
        hessian.fill(0.0);
        let [row, ..] = &mut scratch.loose;
        let mut rest = &mut *hessian;
        for len in (1..=n).rev() {
            let start = packed_len(n) - packed_len(len);
            let own = row.get_mut(..len).unwrap_or_default();
            read(self.prior.factor(), start, own);
            add_square(rest, 1.0, own);
            rest = rest.get_mut(len..).unwrap_or_default();
        }
        // Likewise.
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

    /// Searches the step, with what was held last where H is the same.
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
        let [step, aim, slope, free] = &mut scratch.loose;
        let mut set = ActiveSet {
            hessian: scratch.hessian,
            pull: scratch.pull,
            low: scratch.low,
            high: scratch.high,
            zero: scratch.zero,
            held: scratch.held,
            factor: scratch.factor,
            is_factored,
            is_bounded: self.is_bounded,
            step,
            aim,
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

    /// Holds the smaller weight of each pair that is at work, and returns whether there was one.
    fn cancel(&self, set: &mut ActiveSet<'_>) -> bool {
        let mut found = false;
        for pair in self.prior.cancel_pairs() {
            let [a, b] = pair.map(|shape| set.weight(shape).abs());
            if a.min(b) > SILENT {
                let [first, second] = pair;
                set.hold_at_zero(if a < b { first } else { second });
                found = true;
            }
        }
        found
    }

    /// Lists the pairs that mirror each other, with the stiffness that they have here.
    fn symmetry(&self) -> impl Iterator<Item = ([usize; 2], f64)> {
        let by = f64::from(self.symmetry);
        // Without it there are none, so that nothing is added.
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

/// Reads floats of the file from one on.
fn read(from: &[Le], start: usize, out: &mut [f64]) {
    let from = from.get(start..).unwrap_or_default();
    out.iter_mut().zip(from).for_each(|(out, le)| *out = f32::from_le_bytes(*le).into());
}

/// Up to what weight a shape of a pair that cancels counts as not at work.
const SILENT: f64 = 1.0e-9;
