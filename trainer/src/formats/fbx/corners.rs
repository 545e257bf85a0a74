//! The faces of meshes and what is authored of their corners.

use nalgebra::Vector3;
use ufbx::{Matrix, Mesh, Vec3, VertexVec3};

use crate::formats::polygons::Polygons;
use crate::mesh::Corners;

/// Gives the faces of a mesh.
pub(super) fn polygons(mesh: &Mesh) -> Polygons {
    let mut polygons = Polygons::default();
    for face in &mesh.faces {
        let corners = mesh.vertex_indices.iter().skip(face.index_begin as usize);
        polygons.push(corners.take(face.num_indices as usize).map(|&vertex| vertex as usize));
    }
    polygons
}

/// The corners of several meshes, one after another.
#[derive(Default)]
pub(super) struct CornerLists {
    all: Corners,
}

impl CornerLists {
    /// Counts the corners so far.
    pub(super) fn len(&self) -> usize {
        self.all.vertices.len()
    }

    /// Adds the corners of a mesh's faces.
    ///
    /// - `first`: number of the mesh's first vertex among all.
    /// - `rest`: from the mesh to where it is bound.
    pub(super) fn add(&mut self, mesh: &Mesh, first: usize, rest: &Matrix) {
        let begin = self.len();
        let corners: Vec<usize> = mesh
            .faces
            .iter()
            .flat_map(|face| face.index_begin..face.index_begin + face.num_indices)
            .map(|corner| corner as usize)
            .collect();
        let vertices = corners.iter().map(|&corner| first + mesh.vertex_indices[corner] as usize);
        self.all.vertices.extend(vertices);
        let turn = ufbx::matrix_for_normals(rest);
        let normal = |corner| {
            at(&mesh.vertex_normal, corner).map(|n| array(ufbx::transform_direction(&turn, n)))
        };
        let tangent = |corner| {
            let tangent = at(&mesh.vertex_tangent, corner)?;
            let [x, y, z] = array(ufbx::transform_direction(rest, tangent));
            Some([x, y, z, handedness(mesh, corner, tangent)])
        };
        let uv = |corner: usize| {
            let uv = &mesh.vertex_uv;
            let place = *uv.indices.get(corner)? as usize;
            uv.values.get(place).map(|uv| [uv.x, uv.y])
        };
        let corners = corners.as_slice();
        extend(&mut self.all.normals, begin, corners, normal);
        extend(&mut self.all.tangents, begin, corners, tangent);
        extend(&mut self.all.uv, begin, corners, uv);
    }

    /// Gives them all.
    pub(super) fn finish(self) -> Corners {
        self.all
    }
}

/// Adds what a mesh has of its corners, and 0 where it, or one before it, has nothing.
fn extend<T: Copy + Default>(
    all: &mut Option<Vec<T>>,
    begin: usize,
    corners: &[usize],
    of: impl Fn(usize) -> Option<T>,
) {
    let found: Vec<Option<T>> = corners.iter().map(|&corner| of(corner)).collect();
    if all.is_none() && found.iter().all(Option::is_none) {
        return;
    }
    let all = all.get_or_insert_with(|| vec![T::default(); begin]);
    all.extend(found.into_iter().map(Option::unwrap_or_default));
}

/// On which side of normal and tangent v grows: -1 or 1.
fn handedness(mesh: &Mesh, corner: usize, tangent: Vec3) -> f64 {
    let [normal, across] = [&mesh.vertex_normal, &mesh.vertex_bitangent]
        .map(|attribute| at(attribute, corner).map(|v| Vector3::from(array(v))));
    let tangent = Vector3::from(array(tangent));
    let side = normal.zip(across).map(|(normal, across)| normal.cross(&tangent).dot(&across));
    if side.is_some_and(|side| side < 0.0) { -1.0 } else { 1.0 }
}

fn at(attribute: &VertexVec3, corner: usize) -> Option<Vec3> {
    let place = *attribute.indices.get(corner)? as usize;
    attribute.values.get(place).copied()
}

fn array(v: Vec3) -> [f64; 3] {
    [v.x, v.y, v.z]
}
