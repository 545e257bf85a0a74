//! The numbers that a fit of helpers and their maps is set to: each in one place, with its reason. A bench sets them to
//! others, to measure what hangs on each (`cargo bench -p sinew-trainer --bench figures -- constants`).

use std::sync::atomic::{AtomicU64, Ordering};

/// A number that a fit is set to.
pub struct Constant {
    /// Its name.
    pub name: &'static str,
    value: f64,
    bits: AtomicU64,
}

impl Constant {
    const fn new(name: &'static str, value: f64) -> Self {
        Self { name, value, bits: AtomicU64::new(value.to_bits()) }
    }

    /// Returns the number.
    pub fn get(&self) -> f64 {
        f64::from_bits(self.bits.load(Ordering::Relaxed))
    }

    /// Sets it to so many times what it is meant to be, for every fit of this process; 1 sets it back.
    pub fn vary(&self, factor: f64) {
        self.bits.store((factor * self.value).to_bits(), Ordering::Relaxed);
    }
}

/// A vertex on which LBS errs more, RMS in diagonals, is a helper's; less is not seen.
pub static ERRS: Constant = Constant::new("ERRS", 4e-4);
/// A vertex on which LBS errs less, RMS in diagonals, keeps its weights: there is nothing to gain.
pub static SERVED: Constant = Constant::new("SERVED", 1e-4);
/// A residual's weight against a position's where vertices are grouped.
pub static RESIDUAL_SHARE: Constant = Constant::new("RESIDUAL_SHARE", 8.0);
/// Pull of a helper to its dominant joint, of the mean diagonal: what few vertices support is noise that no map can predict.
pub static PULL: Constant = Constant::new("PULL", 3e-6);
/// Weight of the palette before any correction where weights are fitted: it is all that is left of poses unlike
/// those of training. With less of it a fit errs less on poses like those, and more on others.
pub static BASE: Constant = Constant::new("BASE", 0.015);
/// Most of its last step that a round of helpers starts ahead: with more the last digit of a file decides more of what
/// comes out.
pub static AHEAD: Constant = Constant::new("AHEAD", 0.7);
/// Weight of a displacement, in diagonals, against a rotation's entries.
pub static DISPLACEMENT: Constant = Constant::new("DISPLACEMENT", 3.0);
/// A displacement that spreads less, RMS in weighted diagonals, is no input.
pub static STILL: Constant = Constant::new("STILL", 3e-4);
/// How much better a score is to be with further joints or a wider kernel: folds of training tell little of
/// poses unlike it, and there a map that listens to less errs less.
pub static EARNS: Constant = Constant::new("EARNS", 0.2);
/// Share of the outputs' squared size that no latent output carries.
pub static NEGLIGIBLE: Constant = Constant::new("NEGLIGIBLE", 1e-7);
/// Share of the poses that are beyond a joint's range.
pub static BEYOND: Constant = Constant::new("BEYOND", 0.25);
/// Share of the linear kernel beside the other, over the median squared distance.
pub static LINEAR: Constant = Constant::new("LINEAR", 0.2);
/// Power of the mean over blocks: near 0 it is geometric, so that the hardest block does not decide alone.
pub static GENTLE: Constant = Constant::new("GENTLE", 0.1);
/// Most that a function's squared norm may be, over the one that its outputs' size tells by the prior: more hangs on
/// directions that the samples hardly take, is learned of their noise, and throws wherever a pose takes them.
pub static PLAUSIBLE: Constant = Constant::new("PLAUSIBLE", 1e6);

/// All of them.
pub static ALL: [&Constant; 14] = [
    &ERRS,
    &SERVED,
    &RESIDUAL_SHARE,
    &PULL,
    &BASE,
    &AHEAD,
    &DISPLACEMENT,
    &STILL,
    &EARNS,
    &NEGLIGIBLE,
    &BEYOND,
    &LINEAR,
    &GENTLE,
    &PLAUSIBLE,
];
