//! What a fit makes, in f64: what is baked, what the oracle evaluates, and what a file loads back into.

mod envelope;
mod file;
mod group;
mod key;
mod order;
mod prior;
mod record;
mod restated;
mod shapes;
mod skin;

pub use envelope::{EnvelopeModel, Reconstruction};
pub use file::FileModel;
pub use group::{Group, Input};
pub use key::{Factors, Key, angles, stretch, symmetric};
pub use prior::PriorModel;
pub use record::RecordModel;
pub use shapes::{ShapeNumbers, Shapes};
pub use skin::{SkinModel, Vertex};
