//! Further meshes on the palette of a model.

use super::error::ExportError;
use super::mesh::SkinnedMesh;
use super::played::Played;
use crate::envelope::levels::{Influences, Level, LevelReport, SkinSurface};
use crate::envelope::posed::{FrameError, rest, skin_on};
use crate::evaluate::Character;
use crate::examples::Examples;
use crate::formats::gltf::write::{Document, SkinIndex};
use crate::space::Conversion;
use rayon::prelude::*;

/// Further meshes and their weights on the palette.
#[derive(Default)]
pub(super) struct Further {
    levels: Vec<Level>,
    influences: Vec<Influences>,
    /// Reports on the meshes, in their order.
    pub(super) reports: Vec<LevelReport>,
}

impl Further {
    /// Finds the weights of meshes, and moves meshes in other axes or another unit.
    ///
    /// # Errors
    /// [`ExportError::Level`] and [`ExportError::Frame`].
    pub(super) fn new(
        played: &Played<'_>,
        examples: &Examples,
        levels: &[Level],
    ) -> Result<Self, ExportError> {
        if levels.is_empty() {
            return Ok(Self::default());
        }
        let own = examples.surface();
        let Played { character: Character { skin, .. }, palettes, influences, .. } = played;
        let posed = palettes
            .par_iter()
            .enumerate()
            .map(|(key, palette)| {
                let [positions, _] = skin_on(skin, palette, key)?;
                Ok(own.of_first_copies(positions.as_chunks().0))
            })
            .collect::<Result<Vec<_>, FrameError>>()?;
        let surface = SkinSurface {
            rest: &own.of_first_copies(&rest(skin)),
            triangles: &examples.solid_triangles(),
            influences: &own.of_first_copies(influences),
            most: skin.influence_len(),
            diagonal: examples.diagonal(),
            palettes,
            posed,
        };
        let mut levels = levels.to_vec();
        let (influences, reports) = surface.follow_all(&mut levels)?;
        Ok(Self { levels, influences, reports })
    }

    /// Mirrors the meshes.
    pub(super) fn convert(&mut self, mirror: &Conversion) {
        self.levels.iter_mut().for_each(|level| level.mesh.convert(mirror));
    }

    /// Adds the meshes to a document, on a skin.
    pub(super) fn add(&self, document: &mut Document, skin: SkinIndex) {
        for (level, influences) in self.levels.iter().zip(&self.influences) {
            let surface = level.mesh.surface();
            let mesh = SkinnedMesh {
                name: &level.name,
                positions: &surface.copied(&level.mesh.positions),
                normals: &surface.normals(),
                uv: surface.uv(),
                influences: &surface.copied(influences),
                primitives: &[(None, surface.engine_triangles().to_vec())],
            };
            document.mesh(&mesh, skin);
        }
    }
}
