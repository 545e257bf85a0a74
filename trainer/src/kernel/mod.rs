//! Kernel maps (S2, METHOD §2): functions fitted to samples, `f(x) = Σ_k c_k G(x, t_k) + mean`.

pub mod ridge;
