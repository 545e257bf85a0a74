//! `sinew export-demo`: the demo's input as files that other programs read.

use super::demo::SizeArguments;
use crate::cli::files::{self, OutputFile};
use crate::cli::{Output, input};
use serde_json::json;
use sinew_trainer::export::{by_use, demo_glb};
use sinew_trainer::formats::save_pc2;
use std::path::PathBuf;

/// Writes the demo's rig and meshes as an artist exports them
///
/// The files show how input looks.
///
/// demo.glb holds the skeleton, the rest mesh with four LBS weights a vertex, and two animations at
/// 30 frames a second: train and held-out. demo.pc2 is a point cache of the meshes that the arm
/// takes in those frames, in the same order, vertex by vertex as in demo.glb.
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    /// Folder for demo.glb and demo.pc2, which is made if it is not there
    folder: PathBuf,
    #[command(flatten)]
    size: SizeArguments,
}

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let folder = &arguments.folder;
    files::make_folder(folder)?;
    let [glb, pc2] = ["demo.glb", "demo.pc2"].map(|name| folder.join(name));
    let target = OutputFile::new(&glb, &[])?;
    OutputFile::new(&pc2, &[])?;
    let (examples, clips) = by_use(arguments.size.generate(output)?);
    let bytes = demo_glb(&examples, &clips)?;
    save_pc2(&pc2, examples.vertex_len(), &examples.vertices)?;
    files::write(&[(&target, &bytes)])?;
    let command = format!(
        "sinew train {} --targets {} --hold-out-clip held-out -o demo.sinew",
        glb.display(),
        pc2.display()
    );
    let text = format!(
        "a procedural arm: {}\nwrote demo.glb, its skeleton, LBS skin and animations, and demo.pc2, \
         its meshes, to {}\nnext: {command}",
        input::describe(&examples),
        folder.display()
    );
    output.print(&json!({ "files": [glb, pc2], "next": command }), &text)
}
