//! The numbers that set a fit of helpers and their maps.

/// Errors that differ by less than this factor are tied.
pub const TIED: f64 = 1.02;
/// RMS error in diagonals below which nobody sees a difference: a fifth of a millimetre on a body. Without this floor,
/// noise would choose between candidates that all fit well.
pub const UNSEEN: f64 = 1e-4;
/// Vertices on which candidates are compared and forecasts are made. More give the same result.
pub const FEW_VERTICES: usize = 250;
/// A file without tangent coefficients is chosen only if files with them have this many times its error.
pub const COEFFICIENTS_COST: f64 = 1.5;

/// The numbers that set a fit of helpers and their maps. Lengths are in diagonals of the rest mesh.
///
/// `cargo bench -p sinew-trainer --bench figures -- settings` trains with a third and with three times of each. The table is in
/// `trainer/NOTES.md`, "Settings".
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// A vertex with a larger RMS error of LBS belongs to a helper. Smaller errors are not seen.
    pub active: f64,
    /// A vertex with a smaller RMS error of LBS keeps its weights: there is nothing to gain.
    pub served: f64,
    /// Weight of residuals against positions where vertices are grouped.
    pub residuals: f64,
    /// Pull of a helper to its dominant joint, as a share of the mean diagonal of its equations. What few vertices support
    /// is noise that no map can predict.
    pub pull: f64,
    /// Weight of the palette before any correction where weights are fitted. Only this palette is left in poses unlike those of
    /// training.
    pub base: f64,
    /// Strength of the pull of helpers' weights to those of LBS, as a share of the strength by which these are pulled to
    /// prior weights.
    pub folded: f64,
    /// The largest strength of that pull, in squared lengths: a stronger one tilts normals at hinges.
    pub folded_most: f64,
    /// Most of its last step that a round of helpers starts ahead. With more, rounding decides more of the result.
    pub ahead: f64,
    /// Weight of a displacement as an input, against the entries of a rotation.
    pub displacement: f64,
    /// A displacement whose weighted RMS spread is smaller is no input.
    pub still: f64,
    /// Scores that differ by a smaller share are alike where joints and widths are chosen. Folds of training tell little of
    /// poses unlike it; there fewer inputs and narrower kernels have smaller errors.
    pub alike: f64,
    /// Share of the outputs' squared size that no latent output carries.
    pub negligible: f64,
    /// Share of the poses that lie beyond a joint's range, for the blocks that a map has to extrapolate to.
    pub beyond: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            active: 4e-4,
            served: UNSEEN,
            residuals: 8.0,
            pull: 3e-6,
            base: 0.015,
            folded: 1e-3,
            folded_most: 3e-7,
            ahead: 0.7,
            displacement: 3.0,
            still: 3e-4,
            alike: 0.2,
            negligible: 1e-7,
            beyond: 0.25,
        }
    }
}

impl Settings {
    /// Lists the numbers with their names.
    pub fn numbers(&mut self) -> [(&'static str, &mut f64); 13] {
        [
            ("active", &mut self.active),
            ("served", &mut self.served),
            ("residuals", &mut self.residuals),
            ("pull", &mut self.pull),
            ("base", &mut self.base),
            ("folded", &mut self.folded),
            ("folded_most", &mut self.folded_most),
            ("ahead", &mut self.ahead),
            ("displacement", &mut self.displacement),
            ("still", &mut self.still),
            ("alike", &mut self.alike),
            ("negligible", &mut self.negligible),
            ("beyond", &mut self.beyond),
        ]
    }
}
