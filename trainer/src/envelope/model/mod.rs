//! A fitted model in f64: baked into a file, evaluated by the oracle, and loaded back from a file.

mod envelope;
mod file;
mod key;
mod prior;
mod skin;

pub use envelope::{EnvelopeModel, Group, Input, Reconstruction};
pub use file::{FileModel, RecordModel};
pub use key::{Factors, Key, angles, stretch, symmetric};
pub use prior::PriorModel;
pub use skin::{ShapeNumbers, Shapes, SkinModel, Vertex};
