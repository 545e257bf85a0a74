//! Makes model files for tests: valid samples of every shape, and files in pieces that may be
//! invalid.
//!
//! This crate alone writes such bytes, after FORMAT.md: so it shares no mistake of the trainer's
//! `bake` or of the runtime. The crate takes two things from the runtime. The names of kinds: the
//! runtime's `document` test compares their numbers with FORMAT.md. And kernels at rest, because a
//! reader recomputes them and compares bit for bit.

mod bytes;
mod filters;
mod golden;
mod groups;
mod jobs;
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
mod shared;
mod views;

pub use bytes::{
    blocks, eights, floats, from_eights, group_row, halves, input_row, kernel_rule, names,
    output_row, part_row, section_row, words,
};
pub use filters::FilterContent;
pub use golden::{
    GOLDEN, GOLDEN_KIND, GOLDEN_KIND_NAMES, GOLDEN_NAMES, GOLDEN_STRETCH, GOLDEN_STRETCH_NAMES,
    TURNED, TURNED_NAMES, golden_path,
};
pub use groups::{GroupContent, sample_groups};
pub use jobs::{Rest, cells};
pub use kernels::{KernelContent, VarianceContent};
pub use message::{Message, head, seal};
pub use pieces::{Content, Pieces};
pub use priors::{FACE_NAME, PriorContent};
pub use records::RecordContent;
pub use rng::Rng;
pub use sample::direction;
pub use shape::{JOINTLESS, SMALL, STRETCHING, Shape, TINY};
pub use shapes::{SHAPED_NAMES, ShapeContent};
pub use shared::shared;
pub use views::{
    LayerContent, TextureContent, VIEWED_NAMES, VertexContent, ViewContent, ViewsContent,
};
