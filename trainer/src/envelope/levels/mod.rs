//! Further meshes on a model's palette: one evaluation moves all levels of detail.

mod follow;
mod nearest;

pub use follow::{Influences, Level, LevelReport, SkinSurface};

use crate::Error;
use crate::envelope::model::{FileModel, SkinModel};
use crate::envelope::normals::{Fan, PosedSurface};
use crate::envelope::posed::{Pose, influences, palette, rest, skin_on};
use crate::examples::{Examples, Split, spread};
use crate::space::{Conversion, SCALES, rotations};
use faer::Mat;
use follow::{FAR, far_away, median};
use nalgebra::Vector3;
use nearest::Tree;
use rayon::prelude::*;
use sinew_runtime::{Envelope, Model, Skin};

/// Name of the examples' own skin.
pub const OWN: &str = "skin";
/// Maximum median distance of a further mesh from the model's surface, as a share of the diagonal. A body reduced from
/// 13,380 to 218 vertices has 0.2 %. A garment 3 cm away from a person of 2 m has 1.5 %.
pub const NEAR: f64 = 0.02;

/// Axes are unambiguous if their distance is at most this share of the distance in all other axes.
const CLEAR: f64 = 0.5;
/// Distance of a coarser mesh from the surface, as a share of the diagonal. Smaller distances are ties.
const TIED: f64 = 1e-3;
/// Number of vertices whose distances are measured.
const SAMPLE: usize = 150;

/// Checks that all skins of a file have different names.
///
/// # Errors
/// A name appears twice.
pub fn check_names(levels: &[Level]) -> Result<(), Error> {
    let names = levels.iter().map(|level| level.name.as_str());
    let names: Vec<&str> = std::iter::once(OWN).chain(names).collect();
    let again = (1..names.len()).find(|&number| names[..number].contains(&names[number]));
    let Some(number) = again else { return Ok(()) };
    Err(Error::value(format!(
        "two skins have the name {}: a further mesh has the name of its file without the ending, \
         and the examples' own skin is called skin; rename the file",
        names[number]
    )))
}

/// Adds meshes as skins that follow a model's first envelope. Their weights are fitted to the first skin, which the
/// runtime evaluates in the training frames.
///
/// - `coefficients`: whether the new skins get tangent coefficients.
///
/// # Errors
/// - A mesh cannot follow the model, as in [`SkinSurface::follow_all`].
/// - The model cannot be written or loaded.
/// - The runtime refuses a training frame.
pub fn add(
    model: &mut FileModel,
    levels: &[Level],
    coefficients: bool,
    examples: &Examples,
) -> Result<Vec<LevelReport>, Error> {
    if levels.is_empty() {
        return Ok(Vec::new());
    }
    let loaded = Model::from_bytes(model.bake()?)
        .map_err(|error| Error::from(error).within("the model is refused"))?;
    let Some((envelope, skin)) = loaded.first::<Envelope>().zip(loaded.first::<Skin>()) else {
        return Ok(Vec::new());
    };
    let own = examples.surface();
    let frames = examples.frames_of(Split::Train);
    let posed = frames.par_iter().map(|&frame| {
        let (palette, _) = palette(&envelope, &Pose::of(&envelope, examples, frame), frame)?;
        let [positions, _] = skin_on(&skin, &palette, frame)?;
        Ok((palette, own.of_first_copies(positions.as_chunks().0)))
    });
    let (palettes, posed): (Vec<_>, Vec<_>) =
        posed.collect::<Result<Vec<_>, Error>>()?.into_iter().unzip();
    // Without influences of weight 0, which only normals use.
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
        let mut further = SkinModel::new(&level.name, &level.mesh.surface(), &influences);
        if coefficients {
            fit_normals(&mut further, level, &surface, skin.influence_len());
        }
        model.skins.push(further);
    }
    Ok(reports)
}

/// Adds placeholder skins of the maximum size, before the weights of the meshes are fitted.
pub fn reserve(model: &mut FileModel, levels: &[Level]) {
    let all = model.skins.first().map_or(&[][..], |skin| &skin.influences);
    let most = all.iter().map(Vec::len).max().unwrap_or(0);
    for level in levels {
        let any = vec![vec![(0, 1.0); most]; level.mesh.positions.len()];
        model.skins.push(SkinModel::new(&level.name, &level.mesh.surface(), &any));
    }
}

/// Checks that further meshes lie on the surface of the examples at rest, in any axes and unit.
///
/// # Errors
/// - A mesh is far from the surface in all axes and units.
/// - Several axes are equally near.
/// - A mesh is far from the surface in the axes given for it.
pub fn check_places(levels: &[Level], examples: &Examples) -> Result<(), Error> {
    let surface = SkinSurface {
        rest: &examples.rest,
        triangles: &examples.solid_triangles(),
        influences: &Vec::new(),
        most: 1,
        diagonal: examples.diagonal(),
        palettes: &[],
        posed: Vec::new(),
    };
    for level in levels {
        let mut level = level.clone();
        surface.place(&mut level)?;
        surface.check_near(&level)?;
    }
    Ok(())
}

/// Fits the tangent coefficients of a further mesh, with the positions on the posed surface as targets.
///
/// - `len_max`: maximum number of influences of a vertex.
fn fit_normals(skin: &mut SkinModel, level: &Level, surface: &SkinSurface<'_>, len_max: usize) {
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
    posed.fit(skin, diagonal, len_max);
}

impl SkinSurface<'_> {
    /// Finds weights for further meshes, as [`Self::follow`] does. First converts meshes in other axes or another unit.
    ///
    /// # Errors
    /// - A mesh is far from the surface in all axes and units.
    /// - Several axes are equally near.
    /// - A mesh is far from the surface in the axes given for it.
    pub fn follow_all(
        &self,
        levels: &mut [Level],
    ) -> Result<(Vec<Influences>, Vec<LevelReport>), Error> {
        let follow = |level: &mut Level| {
            let moved = self.place(level)?;
            self.check_near(level)?;
            let (influences, report) = self.follow(level);
            Ok((influences, LevelReport { moved, ..report }))
        };
        let followed = levels.iter_mut().map(follow).collect::<Result<Vec<_>, Error>>()?;
        Ok(followed.into_iter().unzip())
    }

    /// Converts a mesh that is far from the surface to the axes and unit in which it is near. Returns a description of
    /// the conversion, or `None` if the mesh was not converted.
    ///
    /// # Errors
    /// - The mesh is far from the surface in all axes and units.
    /// - Several axes are equally near.
    /// - The mesh is far from the surface in the axes given for it.
    fn place(&self, level: &mut Level) -> Result<Option<String>, Error> {
        let tree = Tree::new(self.rest, self.triangles);
        let positions = &level.mesh.positions;
        let sample = spread(positions.len(), SAMPLE);
        let distance = |conversion: &Conversion| {
            let from = |&v: &usize| Vector3::from(conversion.point(positions[v]));
            let feet = sample.iter().filter_map(|v| tree.nearest(&from(v)));
            median(feet.map(|foot| foot.distance / self.diagonal).collect())
        };
        let conversions: Vec<Conversion> = rotations()
            .flat_map(|rotation| SCALES.map(|scale| Conversion { axes: rotation, scale }))
            .collect();
        // The first conversion is the identity.
        let unmoved = conversions.first().map_or(0.0, distance);
        if unmoved <= FAR {
            return Ok(None);
        }
        if level.is_placed {
            return Err(Error::mismatch(format!(
                "mesh {} is {:.0} % of the diagonal away from the model's surface in the axes and unit given as \
                 --also-axes, expected at most 10 % at the median: give others, or leave --also-axes out, so that they are \
                 recognised",
                level.name,
                100.0 * unmoved
            )));
        }
        let conversions = conversions.into_par_iter();
        let mut found: Vec<_> = conversions.map(|c| (distance(&c), c)).collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let [(nearest, conversion), others @ ..] = &found[..] else { return Ok(None) };
        if *nearest > NEAR {
            return Err(far_away(&level.name, unmoved));
        }
        let ties = others.iter().take_while(|(other, _)| nearest.max(TIED) > CLEAR * other);
        let alternatives: Vec<String> =
            ties.map(|(_, conversion)| conversion.to_string()).collect();
        if !alternatives.is_empty() {
            return Err(Error::fit(format!(
                "mesh {} is not in the model's axes and unit: turned to {conversion} it is {:.1} % of the diagonal away \
                 from the model's surface, and nearly as near turned to {}: give one of these, as \
                 --also-axes \"{conversion}\", or export it in the axes and unit of the examples",
                level.name,
                100.0 * nearest,
                alternatives.join(", ")
            )));
        }
        level.mesh.convert(conversion);
        Ok(Some(conversion.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::Mesh;

    /// Returns a bar along x with square ends.
    ///
    /// - `bent`: offset of the far end along y.
    fn bar(bent: f64) -> Mesh {
        let end = |x: f64, y: f64| {
            [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[a, b]| [x, a + y, b])
        };
        let quads = [0, 1, 2, 3].map(|k| [k, (k + 1) % 4, (k + 1) % 4 + 4, k + 4]);
        Mesh {
            positions: [end(2.0, 0.0), end(12.0, bent)].concat(),
            triangles: quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
            engine: None,
        }
    }

    fn place(bent: f64) -> Result<(Level, Option<String>), Error> {
        let own = bar(bent);
        let surface = SkinSurface {
            rest: &own.positions,
            triangles: &own.triangles,
            influences: &Vec::new(),
            most: 1,
            diagonal: 10.0,
            palettes: &[],
            posed: Vec::new(),
        };
        let mut mesh = own.clone();
        mesh.positions
            .iter_mut()
            .for_each(|[x, y, z]| [*x, *y, *z] = [100.0 * *y, 100.0 * *z, 100.0 * *x]);
        let mut level = Level { name: "bar".to_owned(), mesh, is_placed: false };
        surface.place(&mut level).map(|how| (level, how))
    }

    #[test]
    fn a_mesh_is_converted_if_one_conversion_is_clear_and_refused_if_several_tie() {
        let (level, how) = place(1.5).unwrap();
        assert_eq!(how.as_deref(), Some("(z, x, y) x 0.01"));
        let apart =
            level.mesh.positions.iter().flatten().zip(bar(1.5).positions.into_iter().flatten());
        assert!(apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 1e-12);

        // The four sides of the straight bar are equal.
        let error = place(0.0).unwrap_err().to_string();
        let sides =
            ["(z, -x, -y) x 0.01", "(z, -y, x) x 0.01", "(z, x, y) x 0.01", "(z, y, -x) x 0.01"];
        // The nearest is named once more, in the advice.
        let mut counts = sides.map(|axes| error.matches(axes).count());
        counts.sort_unstable();
        assert_eq!((counts, error.matches(" x 0.01").count()), ([1, 1, 1, 2], 5), "{error}");
        let begin = "mesh bar is not in the model's axes and unit: turned to (z, ";
        assert!(error.starts_with(begin), "{error}");
    }
}
