//! What a rotational fit is asked for.

use serde::Serialize;
use sinew_runtime::Limits;

/// How many proxies.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ProxyCount {
    /// Exactly so many.
    Fixed(usize),
    /// The fewest whose RMS error on the training frames is at most this share of the diagonal.
    MaxError(f64),
}

/// How a reconstruction is fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// As S3 has it ([`published`](super::published)).
    Published,
    /// What cross-validation chooses.
    Unrefined,
    /// The same, with c1 and c2 refined on the training meshes where that predicts better.
    Refined,
}

impl Method {
    /// The most proxies that a file can hold of such a fit: with a bias each key takes
    /// the room of two.
    pub fn proxies_max(self) -> usize {
        let most = Limits::DEFAULT.proxies as usize;
        if self == Self::Published { most / 2 } else { most }
    }
}

/// What a fit is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RotationalOptions {
    /// P, or the error that decides it.
    pub proxies: ProxyCount,
    /// K, the most proxies a vertex follows.
    pub influences: usize,
    /// How c1 and c2 come about.
    pub method: Method,
}

impl Default for RotationalOptions {
    fn default() -> Self {
        Self { proxies: ProxyCount::Fixed(40), influences: 4, method: Method::Refined }
    }
}
