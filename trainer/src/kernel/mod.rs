//! Kernel maps: any function of a pose, learned from samples (S2, METHOD §2).

pub mod arithmetic;
pub mod centres;
pub mod function;
pub mod map;
pub mod ridge;
