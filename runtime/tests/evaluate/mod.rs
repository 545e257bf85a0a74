//! Results of evaluations, and refused calls.

mod closed_forms;
mod correction;
mod filter;
mod golden;
mod kernel;
mod normals;
mod outputs;
mod pictures;
mod poses;
mod reference;
mod refusals;
mod rest_mesh;
mod scratch;
mod shapes;
mod trs;
mod views;
