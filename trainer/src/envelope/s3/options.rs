//! Options of a rotational fit.

use serde::Serialize;
use sinew_runtime::Limits;

/// Number of proxies.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ProxyCount {
    /// This number.
    Fixed(usize),
    /// The smallest number whose RMS error on the training frames is at most this share of the diagonal.
    MaxError(f64),
}

/// Way to fit a reconstruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// As in the paper (see [`published`](super::published)).
    Published,
    /// Near-rigid vertices and anchors are chosen by cross-validation.
    Unrefined,
    /// As [`Self::Unrefined`]; then c1 and c2 are refined on the training meshes if that lowers the cross-validated
    /// error.
    Refined,
}

impl Method {
    /// Returns the maximum number of proxies in a file. A key with a bias is stored as two keys.
    pub fn proxies_max(self) -> usize {
        let max = Limits::DEFAULT.proxies as usize;
        if self == Self::Published { max / 2 } else { max }
    }
}

/// Options of a rotational fit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RotationalOptions {
    /// P, or the error that determines P.
    pub proxies: ProxyCount,
    /// K, the maximum number of proxies that a vertex follows.
    pub influences: usize,
    /// Way to fit c1 and c2.
    pub method: Method,
}

impl Default for RotationalOptions {
    fn default() -> Self {
        Self { proxies: ProxyCount::Fixed(40), influences: 4, method: Method::Refined }
    }
}
