//! The page that shows where a model's error is: pictures, charts and tables in one HTML file, and
//! the same figures as CSV and PLY, the frames as a GIF. Every number is measured by the f32 runtime on the file's bytes.

pub mod comparison;
pub mod csv;
mod joints;
pub mod moving;
mod palette;
mod pictures;
pub mod ply;
mod sections;
mod sizes;
mod stopwatch;

pub use pictures::PictureOptions;
pub use sections::{Page, ReportError};
