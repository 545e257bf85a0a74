//! Further meshes in other axes, or another unit, than the model's.

use super::follow::{FAR, Influences, Level, LevelError, LevelReport, SkinSurface};
use super::nearest::Tree;
use crate::examples::{Examples, spread};
use crate::space::rotations;
use crate::space::{Conversion, SCALES};
use nalgebra::Vector3;
use rayon::prelude::*;

/// Furthest from the model's surface that a mesh of its character is expected: the median, as a share of the diagonal. A
/// body cut from 13,380 to 218 vertices is 0.2 % away, a garment 3 cm off a person of 2 m 1.5 %.
pub const NEAR: f64 = 0.02;
/// Share of the distance in any others at which it must be there.
const CLEAR: f64 = 0.5;
/// Distances, over the diagonal, that are alike: what a coarser mesh leaves.
const ALIKE: f64 = 1e-3;
/// Vertices that are looked at.
const SAMPLE: usize = 150;

/// Checks that further meshes lie on a mesh at rest, in whatever axes and unit.
///
/// # Errors
/// [`LevelError::Far`], [`LevelError::Axes`] and [`LevelError::GivenAxes`].
pub fn check_places(levels: &[Level], examples: &Examples) -> Result<(), LevelError> {
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
        surface.place(&mut level.clone())?;
    }
    Ok(())
}

impl SkinSurface<'_> {
    /// Finds weights for further meshes as [`Self::follow`] does, of which those in other axes or another unit are moved
    /// first.
    ///
    /// # Errors
    /// [`LevelError::Far`], [`LevelError::Axes`] and [`LevelError::GivenAxes`].
    pub fn follow_all(
        &self,
        levels: &mut [Level],
    ) -> Result<(Vec<Influences>, Vec<LevelReport>), LevelError> {
        let follow = |level: &mut Level| {
            let moved = self.place(level)?;
            let (influences, report) = self.follow(level)?;
            Ok((influences, LevelReport { moved, ..report }))
        };
        let followed = levels.iter_mut().map(follow).collect::<Result<Vec<_>, _>>()?;
        Ok(followed.into_iter().unzip())
    }

    /// Moves a mesh that is far from the surface to where it is near, by a turn by right angles and a change of unit;
    /// tells how, where it had to be moved.
    ///
    /// # Errors
    /// [`LevelError::Far`] where no way brings it near, [`LevelError::Axes`] where several bring it as near, and
    /// [`LevelError::GivenAxes`] for a placed mesh that is far.
    fn place(&self, level: &mut Level) -> Result<Option<String>, LevelError> {
        let tree = Tree::new(self.rest, self.triangles);
        let positions = &level.mesh.positions;
        let looked = spread(positions.len(), SAMPLE);
        let distance = |conversion: &Conversion| {
            let from = |&v: &usize| Vector3::from(conversion.point(positions[v]));
            let feet = looked.iter().filter_map(|v| tree.nearest(&from(v)));
            let mut distances: Vec<f64> = feet.map(|foot| foot.distance / self.diagonal).collect();
            distances.sort_by(f64::total_cmp);
            distances.get(distances.len() / 2).copied().unwrap_or(f64::INFINITY)
        };
        let turns = rotations().flat_map(|turn| SCALES.map(|scale| Conversion::new(turn, scale)));
        let turns: Vec<Conversion> = turns.collect();
        // The first leaves all as it is.
        let unmoved = turns.first().map_or(0.0, distance);
        if unmoved <= FAR {
            return Ok(None);
        }
        if level.is_placed {
            let (name, percent) = (level.name.clone(), 100.0 * unmoved);
            return Err(LevelError::GivenAxes { name, percent });
        }
        let mut found: Vec<_> = turns.into_par_iter().map(|turn| (distance(&turn), turn)).collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let [(nearest, conversion), others @ ..] = &found[..] else { return Ok(None) };
        if *nearest > NEAR {
            return Err(LevelError::Far { name: level.name.clone(), percent: 100.0 * unmoved });
        }
        let as_near = others.iter().take_while(|(other, _)| nearest.max(ALIKE) > CLEAR * other);
        let as_near: Vec<String> = as_near.map(|(_, conversion)| conversion.to_string()).collect();
        if !as_near.is_empty() {
            let (name, axes) = (level.name.clone(), conversion.to_string());
            return Err(LevelError::Axes { name, percent: 100.0 * nearest, axes, as_near });
        }
        level.mesh.convert(conversion);
        Ok(Some(conversion.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::Mesh;

    /// A bar along x with square ends, the far one so far along y.
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

    fn place(bent: f64) -> Result<(Level, Option<String>), LevelError> {
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
    fn a_mesh_is_moved_where_one_way_is_clear_and_refused_where_several_are() {
        let (level, how) = place(1.5).unwrap();
        assert_eq!(how.as_deref(), Some("(z, x, y) x 0.01"));
        let apart =
            level.mesh.positions.iter().flatten().zip(bar(1.5).positions.into_iter().flatten());
        assert!(apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 1e-12);

        // Its four sides are alike.
        let LevelError::Axes { name, axes, as_near, .. } = place(0.0).unwrap_err() else {
            panic!("it is told")
        };
        let mut all = [vec![axes], as_near].concat();
        all.sort();
        assert_eq!(name, "bar");
        assert_eq!(
            all,
            ["(z, -x, -y) x 0.01", "(z, -y, x) x 0.01", "(z, x, y) x 0.01", "(z, y, -x) x 0.01"]
        );
    }
}
