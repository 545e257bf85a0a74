//! The one maker of model files for tests: sound samples of every shape, and pieces that are free to be
//! wrong.
//!
//! Every byte is written here, after FORMAT.md, so that no mistake of the trainer's `bake` or of the
//! runtime is shared. Of the runtime come the names of kinds, whose numbers its `document` test holds to
//! FORMAT.md, and what a reader must find bit for bit as it computes it itself: kernels at rest.

mod bytes;
mod filters;
mod golden;
mod groups;
pub mod head;
mod kernels;
mod message;
mod pieces;
mod priors;
mod records;
#[path = "../../golden/rng.rs"]
mod rng;
mod sample;
mod shape;
mod shapes;
mod views;

pub use bytes::{
    blocks, floats, group_row, halves, input_row, kernel_rule, names, output_row, part_row,
    section_row, words,
};
pub use filters::FilterContent;
pub use golden::{GOLDEN, GOLDEN_NAMES, TURNED, TURNED_NAMES, golden_path};
pub use groups::{GroupContent, sample_groups};
pub use kernels::{KernelContent, VarianceContent};
pub use message::{Message, seal};
pub use pieces::{Content, Pieces};
pub use priors::{FACE_NAME, PriorContent};
pub use records::RecordContent;
pub use rng::Rng;
pub use sample::direction;
pub use shape::{SMALL, Shape, TINY};
pub use shapes::{SHAPED_NAMES, ShapeContent};
pub use views::{
    LayerContent, TextureContent, VIEWED_NAMES, VertexContent, ViewContent, ViewsContent,
};
