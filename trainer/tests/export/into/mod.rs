//! A model in an artist's file.

mod alone;
mod file;
mod plays;

use super::{arm, clip, model};
pub(super) use file::Glb;
use sinew_runtime::envelope::Predictor;
use sinew_trainer::envelope::export::{ExportError, ExportInto, Grafted, by_use, demo_glb};
use sinew_trainer::envelope::levels::Level;
use sinew_trainer::examples::{Clip, Examples, JointNames};
use std::path::Path;

/// Exports a model's first skin into a file.
fn export_into(
    model: &[u8],
    examples: &Examples,
    clips: &[Clip],
    levels: &[Level],
    file: &Path,
) -> Result<Grafted, ExportError> {
    let names = JointNames::default();
    ExportInto { model, skin: None, examples, clips, between: false, levels, names, file }.run()
}

/// The demo as an artist's file, with a trained model.
struct Character {
    examples: Examples,
    clips: Vec<Clip>,
    glb: Glb,
    model: Vec<u8>,
}

impl Character {
    fn new() -> Self {
        let (examples, clips) = by_use(arm(300));
        let glb = Glb::read(&demo_glb(&examples, &clips).unwrap());
        let model = model(&examples, Predictor::Kernel, 6, 4);
        Self { examples, clips: vec![clip(&clips[0].name, 0, 6), clip("new", 6, 3)], glb, model }
    }

    /// Returns the index of an accessor of the file's mesh.
    fn attribute(&self, name: &str) -> usize {
        let attributes = &self.glb.json["meshes"][0]["primitives"][0]["attributes"];
        attributes[name].as_u64().unwrap() as usize
    }
}
