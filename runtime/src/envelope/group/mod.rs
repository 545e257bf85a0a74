//! Groups of helpers: each group shares a dominant joint and one kernel map (METHOD §1.9).

mod kernel;
mod row;
mod view;

pub use kernel::GroupKernel;
pub use row::GroupRow;
pub use view::Group;
