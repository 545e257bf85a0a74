//! Tests of fits: their inputs, their errors, and their files.

mod authored;
mod bones;
mod coarse;
#[path = "../../benches/figures/full.rs"]
mod full;
mod held_out;
mod importance;
mod moving;
mod near_rest;
mod normals;
mod numbers;
mod odd_characters;
mod poses;
mod published;
mod real_sets;
mod sampled;
mod scenes;
mod seams;
mod shapes;
mod skins;
mod spaces;
