//! Sets and models as the command line names them.

use crate::cli::input::read_model;
use anyhow::Context;
use sinew_runtime::Model;
use sinew_trainer::views::set::{ViewSet, read, read_drawing};
use std::path::{Path, PathBuf};

/// Views to read.
#[derive(clap::Args)]
pub(super) struct SetArguments {
    /// Views as JSON, or the char_cfg.yaml of a drawing with joints, beside its texture.png and mask.png
    views: PathBuf,
    /// The mesh of whose vertices `mesh_vertex_index` are the points, as OBJ: depths come from it
    #[arg(long, value_name = "OBJ")]
    mesh: Option<PathBuf>,
}

impl SetArguments {
    /// Returns the file.
    pub(super) fn file(&self) -> &Path {
        &self.views
    }

    /// Reads the views.
    pub(super) fn read(&self) -> anyhow::Result<ViewSet> {
        let is_drawing =
            self.views.extension().is_some_and(|ending| ending == "yaml" || ending == "yml");
        let set = if is_drawing {
            read_drawing(&self.views)
        } else {
            read(&self.views, self.mesh.as_deref())
        };
        set.with_context(|| self.views.display().to_string())
    }
}

/// Loads a model file.
pub(super) fn load(path: &Path) -> anyhow::Result<Model<Vec<u8>>> {
    Model::from_bytes(read_model(path)?).with_context(|| path.display().to_string())
}
