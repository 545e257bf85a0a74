//! Further meshes as skins of a model's file.

use super::follow::{Influences, Level, LevelError, LevelReport, SkinSurface};
use crate::bake::BakeError;
use crate::envelope::model::{FileModel, Shapes, SkinModel};
use crate::envelope::normals::{Fan, PosedSurface};
use crate::envelope::posed::{FrameError, influences, palette, rest, skin_on};
use crate::examples::{Examples, Split};
use faer::Mat;
use rayon::prelude::*;
use sinew_runtime::{FileError, Model};

/// Further meshes that cannot become skins.
#[derive(Debug, thiserror::Error)]
pub enum AddError {
    /// A mesh cannot follow the model.
    #[error(transparent)]
    Level(#[from] LevelError),
    /// The model that they are to follow cannot be written.
    #[error(transparent)]
    Bake(#[from] BakeError),
    /// The model that they are to follow cannot be loaded.
    #[error("the model is refused: {0}")]
    Model(#[from] FileError),
    /// The runtime refuses a frame.
    #[error(transparent)]
    Frame(#[from] FrameError),
}

/// What the examples' own skin is called.
pub const OWN: &str = "skin";

/// Checks that no two skins of a file would have one name.
///
/// # Errors
/// [`LevelError::Duplicate`].
pub fn check_names(levels: &[Level]) -> Result<(), LevelError> {
    let names = levels.iter().map(|level| level.name.as_str());
    let names: Vec<&str> = std::iter::once(OWN).chain(names).collect();
    let again = (1..names.len()).find(|&number| names[..number].contains(&names[number]));
    again.map_or(Ok(()), |number| Err(LevelError::Duplicate { name: names[number].to_owned() }))
}

/// Adds meshes as skins that follow a model's first envelope, as its first skin does in the training
/// frames by the runtime.
///
/// - `coefficients`: whether they get tangent coefficients.
///
/// # Errors
/// Every [`AddError`].
pub fn add(
    model: &mut FileModel,
    levels: &[Level],
    coefficients: bool,
    examples: &Examples,
) -> Result<Vec<LevelReport>, AddError> {
    if levels.is_empty() {
        return Ok(Vec::new());
    }
    let loaded = Model::from_bytes(model.bake()?)?;
    let Some((envelope, skin)) = loaded.envelope().zip(loaded.skin()) else {
        return Ok(Vec::new());
    };
    let own = examples.surface();
    let frames = examples.frames_of(Split::Train);
    let posed = frames.par_iter().map(|&frame| {
        let (palette, _) = palette(&envelope, examples.pose(frame), frame)?;
        let [positions, _] = skin_on(&skin, &palette, frame)?;
        Ok((palette, own.of_first_copies(positions.as_chunks().0)))
    });
    let (palettes, posed): (Vec<_>, Vec<_>) =
        posed.collect::<Result<Vec<_>, FrameError>>()?.into_iter().unzip();
    // Without those that weigh nothing, which normals alone follow.
    let followed = own.of_first_copies(&influences(&skin));
    let surface = SkinSurface {
        rest: &own.of_first_copies(&rest(&skin)),
        triangles: &examples.solid_triangles(),
        influences: &followed,
        most: followed.iter().map(Vec::len).max().unwrap_or(0),
        diagonal: examples.diagonal(),
        palettes: &palettes,
        posed,
    };
    let mut levels = levels.to_vec();
    let (influences, reports) = surface.follow_all(&mut levels)?;
    for (level, influences) in levels.iter().zip(influences) {
        let mut further = skin_of(level, &influences);
        if coefficients {
            fit_normals(&mut further, level, &surface, skin.influence_len());
        }
        model.skins.push(further);
    }
    Ok(reports)
}

/// Fits the tangent coefficients of a further mesh to where the surface carries it, with at most `most` influences a
/// vertex.
fn fit_normals(skin: &mut SkinModel, level: &Level, surface: &SkinSurface<'_>, most: usize) {
    let SkinSurface { palettes, diagonal, .. } = *surface;
    let rest: Vec<_> = level.mesh.positions.iter().map(|x| x.map(|x| x / diagonal)).collect();
    let palette_len = palettes.first().map_or(0, Vec::len);
    let stacked = Mat::from_fn(3 * palettes.len(), 4 * palette_len, |row, column| {
        let entry = f64::from(palettes[row / 3][column / 4][row % 3][column % 4]);
        if column % 4 == 3 { entry / diagonal } else { entry }
    });
    let posed = PosedSurface {
        rest: &rest,
        trajectories: &(faer::Scale(1.0 / diagonal) * surface.carried(&level.mesh)),
        palettes: &stacked,
        fans: &Fan::of(&level.mesh.surface()),
        authored: level.mesh.surface().authored_normals().is_some(),
    };
    posed.fit(skin, diagonal, most);
}

/// Adds as many bytes as meshes can take at the most: before it is known what they follow.
pub fn reserve(model: &mut FileModel, levels: &[Level]) {
    let all = model.skins.first().map_or(&[][..], |skin| &skin.influences);
    let most = all.iter().map(Vec::len).max().unwrap_or(0);
    for level in levels {
        let any = vec![(0, 1.0); most];
        model.skins.push(skin_of(level, &vec![any; level.mesh.positions.len()]));
    }
}

fn skin_of(level: &Level, influences: &Influences) -> SkinModel {
    let Level { name, mesh, .. } = level;
    let surface = mesh.surface();
    SkinModel {
        name: name.clone(),
        envelope: Some(0),
        rest_positions: surface.copied(&mesh.positions),
        rest_normals: surface.normals(),
        rest_tangents: surface.tangents(),
        influences: surface.copied(influences),
        tangent_coefficients: None,
        normal_errors: None,
        ranges: Vec::new(),
        shapes: Shapes::default(),
    }
}
