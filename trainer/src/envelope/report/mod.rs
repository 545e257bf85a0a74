//! The page that shows where a model's error is: pictures, charts and tables in one HTML file, and
//! the same figures as CSV and PLY. Every number is measured by the f32 runtime on the file's bytes.

mod bars;
pub mod csv;
mod joints;
mod palette;
pub mod ply;
mod sections;
mod shots;
mod sizes;
mod stopwatch;
pub mod subject;

pub use sections::{Page, ReportError};
pub use shots::Wish;
