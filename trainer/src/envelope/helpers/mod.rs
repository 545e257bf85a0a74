//! Joints and helpers (METHOD §1.9): LBS stays where it is right, and helper proxies, driven by
//! local kernel maps, are added where it errs.

pub mod fit;
