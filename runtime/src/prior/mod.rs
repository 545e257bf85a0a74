//! The part prior: how weights of a skin's shapes belong together, and what pins do with that (METHOD §5).

mod active_set;
mod packed;
