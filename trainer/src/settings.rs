//! Settings of the fit of helpers and their kernel maps.

/// Errors that differ by less than this factor are tied.
pub const TIED: f64 = 1.02;
/// RMS error in diagonals below which nobody sees a difference: a twentieth of a millimetre on a body. The RMS hides
/// larger errors of a few vertices. Without this floor, noise would choose between candidates that all fit well.
pub const UNSEEN: f64 = 2.5e-5;
/// Number of vertices for comparing candidates and for forecasts. More vertices give equal results.
pub const FEW_VERTICES: usize = 250;
/// A file without tangent coefficients is chosen only if the best file with them has more than this multiple of its
/// error.
pub const COEFFICIENTS_COST: f64 = 1.5;

/// Settings of the fit of helpers and their kernel maps. Lengths are in diagonals of the rest mesh.
///
/// `cargo bench -p sinew-trainer --bench figures -- settings` trains with a third and with three times each number. The
/// results are in `trainer/NOTES.md`, "Settings".
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Vertices with a larger RMS error of LBS get helpers. Smaller errors are invisible.
    pub active: f64,
    /// Vertices with a larger RMS error of LBS get new weights. The others keep their LBS weights: there is nothing to
    /// gain.
    pub refit: f64,
    /// Weight of residuals against rest positions when vertices are clustered.
    pub residuals: f64,
    /// Pull of a helper's transform to that of its dominant joint, as a share of the mean diagonal of its equations. A
    /// motion that few vertices support is noise, and no map can predict noise.
    pub pull: f64,
    /// Weight of the error without a correction when vertex weights are fitted. Outside the trained range the
    /// correction fades out, and only the base palette is left.
    pub base: f64,
    /// Strength of the pull of helper weights to LBS weights, as a share of the strength of the pull of LBS weights to
    /// prior weights.
    pub weight_pull: f64,
    /// Largest strength of the pull to LBS weights, in squared lengths. A stronger pull tilts normals at hinges.
    pub weight_pull_max: f64,
    /// Largest momentum of a round of helpers, as a share of the last step. A larger momentum amplifies rounding.
    pub momentum: f64,
    /// Weight of a displacement as an input, against the entries of a rotation.
    pub displacement: f64,
    /// Smallest weighted RMS spread of a displacement that becomes an input.
    pub displacement_min: f64,
    /// Weight of the strain of a joint as an input, against the entries of a rotation.
    pub strain: f64,
    /// Spread of a curve as an input, against the entries of a rotation.
    pub curve: f64,
    /// Scores of joint sets and of kernel widths tie if they differ by less than this share. Folds of the training
    /// poses say little about other poses. There fewer inputs and narrower kernels have smaller errors.
    pub input_tie: f64,
    /// Share of the outputs' squared size that latent outputs may leave out.
    pub negligible: f64,
    /// Share of the poses in a block at the end of a joint's range. Such blocks test extrapolation.
    pub range_ends: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            active: 4e-4,
            refit: 1e-4,
            residuals: 8.0,
            pull: 3e-6,
            base: 0.015,
            weight_pull: 1e-3,
            weight_pull_max: 3e-7,
            momentum: 0.7,
            displacement: 3.0,
            displacement_min: 3e-4,
            strain: 0.4,
            curve: 0.2,
            input_tie: 0.2,
            negligible: 1e-7,
            range_ends: 0.25,
        }
    }
}

impl Settings {
    /// Lists the settings with their names.
    pub fn numbers(&mut self) -> [(&'static str, &mut f64); 15] {
        [
            ("active", &mut self.active),
            ("refit", &mut self.refit),
            ("residuals", &mut self.residuals),
            ("pull", &mut self.pull),
            ("base", &mut self.base),
            ("weight_pull", &mut self.weight_pull),
            ("weight_pull_max", &mut self.weight_pull_max),
            ("momentum", &mut self.momentum),
            ("displacement", &mut self.displacement),
            ("displacement_min", &mut self.displacement_min),
            ("strain", &mut self.strain),
            ("curve", &mut self.curve),
            ("input_tie", &mut self.input_tie),
            ("negligible", &mut self.negligible),
            ("range_ends", &mut self.range_ends),
        ]
    }
}
