//! What a rotational fit is asked for.

use serde::Serialize;

/// How many proxies.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ProxyCount {
    /// Exactly so many.
    Fixed(usize),
    /// The fewest whose RMS error on the training frames is at most this share of the diagonal.
    MaxError(f64),
}

/// What a fit is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RotationalOptions {
    /// P, or the error that decides it.
    pub proxies: ProxyCount,
    /// K, the most proxies a vertex follows.
    pub influences: usize,
    /// Whether c1 and c2 may be refined on the training meshes; S3 as published does not.
    pub refine: bool,
}

impl Default for RotationalOptions {
    fn default() -> Self {
        Self { proxies: ProxyCount::Fixed(40), influences: 4, refine: true }
    }
}
