//! How far f32 arithmetic may be from real arithmetic, on the CPU and where a standard allows more.

/// Unit roundoff of f32.
pub const U: f64 = 1.0 / (1 << 24) as f64;

/// Returns γₙ, which bounds the relative error of a value behind n roundings of f32.
pub fn gamma(n: usize) -> f64 {
    let nu = n as f64 * U;
    nu / (1.0 - nu)
}

/// How many roundings the operations count that are not correctly rounded everywhere; sums,
/// differences and products are, fused or not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Arithmetic {
    /// Of a quotient.
    pub division: usize,
    /// Of a square root.
    pub root: usize,
}

impl Arithmetic {
    /// Every operation rounds once: the runtime on any CPU.
    pub const IEEE: Self = Self { division: 1, root: 1 };

    /// What Vulkan (appendix "Precision and Operation of SPIR-V Instructions") and WGSL (§15.7.4.1)
    /// allow. A ULP is at most 2u of the value. A quotient may be 2.5 ULP off: 5u. A root may be
    /// 1 / inversesqrt, of which the one is 2 ULP off and the other a quotient: 9u.
    pub const VULKAN: Self = Self { division: 5, root: 9 };
}
