//! Groups of helpers: each group shares a dominant joint and one kernel map (METHOD §1.9).

mod confidence;
mod kernel;
mod row;
mod view;

pub(crate) use confidence::ExpectedError;
pub use confidence::GroupConfidence;
pub use kernel::GroupKernel;
pub use row::GroupRow;
pub use view::Group;
