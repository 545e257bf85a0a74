//! The container: the only writer of the file that [`sinew_runtime`] reads. It knows a part as its kind
//! and its sections; what they hold is the part's own to say.

mod container;
mod error;
pub(crate) mod sections;

pub use container::{Part, bake};
pub use error::BakeError;
pub use sections::Sections;
