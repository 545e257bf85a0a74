//! The meshes of a glTF file by themselves, at rest.

use std::path::Path;

use sinew_runtime::format::Space;

use super::file::{self, Parsed};
use super::meshes::{Meshes, Wanted};
use super::nodes::Nodes;
use super::rigged::shown_meshes;
use super::skins::{Skins, move_mesh};
use super::welded::Welded;
use crate::formats::error::FormatError;
use crate::formats::mesh::{Mesh, MeshFile};
use crate::formats::scene::SceneError;
use crate::formats::warning::FormatWarning;

/// Reads the meshes of a file as one: those with a skin as they are bound, or, where none has one, all as they stand.
///
/// # Errors
/// [`FormatError::Read`], and [`FormatError::Scene`], which names the missing or damaged part.
pub(in crate::formats) fn read_mesh(path: &Path) -> Result<MeshFile, FormatError> {
    let Parsed { document, buffers, .. } = file::open(path)?;
    let nodes = Nodes::read(&document)?;
    let shown = nodes.shown(&document);
    let skinned_only =
        shown_meshes(&document, &nodes).iter().any(|(_, node)| node.skin().is_some());
    let wanted = Wanted { skinned_only, default_shape: true };
    let mut meshes = Meshes::read(&document, &buffers, |node| shown[node], wanted)?;
    if meshes.instances.is_empty() {
        let is_empty = !shown.contains(&true);
        return Err(if is_empty { SceneError::Empty } else { SceneError::NoMesh }.into());
    }
    Skins::read(&document, &buffers, &nodes, &mut meshes, true)?;
    let worlds = nodes.worlds(&nodes.locals);
    for instance in 0..meshes.instances.len() {
        if meshes.instances[instance].skin.is_none() {
            let world = worlds[meshes.instances[instance].node];
            move_mesh(&mut meshes, instance, &world);
        }
    }
    let welded = Welded::new(&meshes);
    let mut warnings: Vec<FormatWarning> = meshes.warnings().collect();
    if welded.repaired > 0 {
        warnings.push(FormatWarning::NormalsRepaired { count: welded.repaired });
    }
    let positions = welded.pick(&meshes.positions);
    let Welded { triangles, engine, .. } = welded;
    let mesh = Mesh { positions, triangles, engine }.checked()?;
    Ok(MeshFile { mesh, space: Some(Space::GLTF), warnings })
}
