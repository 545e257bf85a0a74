//! Model of f32 rounding, on the CPU and where a standard allows larger errors.

/// Unit roundoff of f32.
pub const U: f64 = 1.0 / (1 << 24) as f64;

/// Returns γₙ, which bounds the relative error of a value behind n roundings of f32.
pub fn gamma(n: usize) -> f64 {
    let nu = n as f64 * U;
    nu / (1.0 - nu)
}

/// Number of roundings that an operation counts for, if the operation is not correctly rounded everywhere.
///
/// Sums, differences and products are correctly rounded, fused or not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Arithmetic {
    /// Roundings of a quotient.
    pub division: usize,
    /// Roundings of a square root.
    pub root: usize,
}

impl Arithmetic {
    /// Arithmetic of the runtime on any CPU: every operation rounds once.
    pub const IEEE: Self = Self { division: 1, root: 1 };

    /// Arithmetic that Vulkan (appendix "Precision and Operation of SPIR-V Instructions") and WGSL (§15.7.4.1) allow.
    ///
    /// A ULP is at most 2u of the value. A quotient may be 2.5 ULP off: 5u. A root may be 1 / inversesqrt: 2 ULP and a
    /// quotient, 9u.
    pub const VULKAN: Self = Self { division: 5, root: 9 };
}
