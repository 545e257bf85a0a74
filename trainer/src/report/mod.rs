//! Reports: one HTML page that shows a model's errors in pictures, charts and tables; the same figures as CSV and PLY;
//! and the frames as a GIF. The f32 runtime measures every number on the file's bytes.

pub mod comparison;
pub mod outputs;
mod pictures;
mod sections;
mod sizes;

pub use pictures::PictureOptions;
pub use sections::Page;
