//! Examples moved into another space.

use super::Examples;
use crate::space::Conversion;
use rayon::prelude::*;
use sinew_runtime::format::Space;

impl Examples {
    /// Moves the examples into a space by what leads there; texture coordinates stay.
    pub fn convert(&mut self, conversion: &Conversion, space: Space) {
        self.rest.iter_mut().for_each(|x| *x = conversion.point(*x));
        self.vertices.par_iter_mut().for_each(|x| *x = conversion.point(*x));
        self.skeleton.rest.iter_mut().for_each(|frame| *frame = conversion.transform(frame));
        self.transforms.par_iter_mut().for_each(|b| *b = conversion.transform(b));
        conversion.triangles(&mut self.triangles);
        if let Some(engine) = &mut self.engine {
            engine.turn(|direction| conversion.direction(direction), conversion.is_mirrored());
        }
        self.space = space;
    }

    /// Moves the examples into the space of a model, as far as both are known: where they are equal or
    /// nothing is known, nothing changes. Returns what was done, for meshes that come with them.
    pub fn convert_to(&mut self, space: &Space) -> Option<Conversion> {
        let conversion = Conversion::between(&self.space, space)?;
        self.convert(&conversion, *space);
        Some(conversion)
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::triangle;
    use super::*;
    use crate::mesh::EngineMesh;

    #[test]
    fn there_and_back_again_is_the_same() {
        let mut examples = triangle(2);
        let uv = vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        examples.engine = Some(EngineMesh::of_vertices(&examples.rest, &examples.triangles, &uv));
        examples.vertices[4] = [0.5, -0.25, 0.125];
        examples.transforms[3][0][3] = 0.75;
        examples.space = Space::GLTF;
        let before = examples.clone();
        for space in [Space::UNITY, Space::UNREAL] {
            let there = examples.convert_to(&space).unwrap();
            assert!(examples.space == space && there.is_mirrored());
            assert_eq!(examples.triangles, [[0, 2, 1]]);
            examples.validate().unwrap();
            // Normals and tangents go with the surface; a mirrored cross product turns the handedness.
            assert_eq!(
                examples.surface().normals(),
                before.surface().normals().iter().map(|n| there.direction(*n)).collect::<Vec<_>>()
            );
            let tangents =
                before.surface().tangents().unwrap().into_iter().map(|[x, y, z, hand]| {
                    let [x, y, z] = there.direction([x, y, z]);
                    [x, y, z, -hand]
                });
            assert_eq!(examples.surface().tangents().unwrap(), tangents.collect::<Vec<_>>());
            examples.convert_to(&Space::GLTF).unwrap();
            assert_eq!(examples.rest, before.rest);
            assert_eq!(examples.vertices, before.vertices);
            assert_eq!(examples.transforms, before.transforms);
            assert_eq!(examples.skeleton.rest, before.skeleton.rest);
            assert_eq!(examples.triangles, before.triangles);
            assert_eq!(examples.engine, before.engine);
        }
        assert_eq!(examples.convert_to(&Space::GLTF), None);
    }
}
