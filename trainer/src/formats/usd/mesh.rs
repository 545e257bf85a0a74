//! Skinned meshes of a document, and the names of their materials.

use ::gltf::{Gltf, Node, Primitive};

use super::rig::{Arrays, Rig, SKELETON};
use super::text::{Names, Text, list, quoted, schemas, tuple};

/// Name of the scope that holds the materials.
const LOOKS: &str = "Looks";

/// Writes the meshes with a skin, and the materials.
pub(super) fn write_all(
    text: &mut Text,
    file: &Gltf,
    rig: &Rig,
    arrays: Arrays<'_>,
    names: &mut Names,
) {
    let (looks, mut own) = (names.new_one(LOOKS), Names::default());
    let materials: Vec<_> = file.materials().map(|m| m.name().unwrap_or("material")).collect();
    let materials: Vec<_> = materials.iter().map(|name| (*name, own.new_one(name))).collect();
    if !materials.is_empty() {
        text.open(&format!("def Scope {}", quoted(&looks)), &[]);
        for (name, prim) in &materials {
            let prim = format!("def Material {}", quoted(prim));
            text.open(&prim, &[&format!("displayName = {}", quoted(name))]);
            text.close();
        }
        text.close();
    }
    let root = &rig.root;
    let paths: Vec<_> =
        materials.iter().map(|(_, own)| format!("</{root}/{looks}/{own}>")).collect();
    for node in file.nodes().filter(|node| node.skin().is_some()) {
        Mesh::read(&node, rig, arrays).write(text, root, &paths, names);
    }
}

/// A mesh whose primitives share their vertices.
struct Mesh {
    name: String,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    /// Texture coordinates, v upward; empty if there are none.
    uv: Vec<[f32; 2]>,
    /// Number of influences a vertex.
    width: usize,
    /// Joints and weights, `width` a vertex.
    joints: Vec<usize>,
    weights: Vec<f32>,
    /// Vertices of each triangle.
    triangles: Vec<u32>,
    /// Material of each primitive, and its number of triangles.
    parts: Vec<(Option<usize>, usize)>,
}

impl Mesh {
    fn read(node: &Node<'_>, rig: &Rig, arrays: Arrays<'_>) -> Self {
        let mesh = node.mesh();
        let primitives: Vec<Primitive<'_>> =
            mesh.iter().flat_map(|mesh| mesh.primitives()).collect();
        let mut read = Self {
            name: node.name().unwrap_or("mesh").to_owned(),
            positions: Vec::new(),
            normals: Vec::new(),
            uv: Vec::new(),
            width: 1,
            joints: Vec::new(),
            weights: Vec::new(),
            triangles: Vec::new(),
            parts: Vec::new(),
        };
        for primitive in &primitives {
            let indices = primitive.reader(arrays).read_indices();
            let before = read.triangles.len();
            read.triangles.extend(indices.into_iter().flat_map(|indices| indices.into_u32()));
            let len = (read.triangles.len() - before) / 3;
            read.parts.push((primitive.material().index(), len));
        }
        if let Some(first) = primitives.first() {
            read.vertices(first, rig, arrays);
        }
        read
    }

    fn vertices(&mut self, primitive: &Primitive<'_>, rig: &Rig, arrays: Arrays<'_>) {
        let reader = primitive.reader(arrays);
        self.positions = reader.read_positions().into_iter().flatten().collect();
        self.normals = reader.read_normals().into_iter().flatten().collect();
        let uv = reader.read_tex_coords(0).into_iter().flat_map(|uv| uv.into_f32());
        self.uv = uv.map(|[u, v]| [u, 1.0 - v]).collect();
        let mut all: Vec<Vec<(usize, f32)>> = vec![Vec::new(); self.positions.len()];
        for set in 0.. {
            let parts = reader.read_joints(set).zip(reader.read_weights(set));
            let Some((joints, weights)) = parts else { break };
            let rows = joints.into_u16().zip(weights.into_f32());
            for (own, (joints, weights)) in all.iter_mut().zip(rows) {
                let pairs = joints.into_iter().zip(weights).filter(|(_, weight)| *weight > 0.0);
                own.extend(pairs.map(|(joint, weight)| (rig.of_skin[usize::from(joint)], weight)));
            }
        }
        self.width = all.iter().map(Vec::len).max().unwrap_or(0).max(1);
        for mut own in all {
            own.resize(self.width, (0, 0.0));
            self.joints.extend(own.iter().map(|(joint, _)| *joint));
            self.weights.extend(own.iter().map(|(_, weight)| *weight));
        }
    }

    fn write(&self, text: &mut Text, root: &str, materials: &[String], names: &mut Names) {
        let has_material = self.parts.iter().any(|(material, _)| material.is_some());
        let applied: &[&str] = if has_material {
            &["MaterialBindingAPI", "SkelBindingAPI"]
        } else {
            &["SkelBindingAPI"]
        };
        text.open(
            &format!("def Mesh {}", quoted(&names.new_one(&self.name))),
            &[&schemas(applied), &format!("displayName = {}", quoted(&self.name))],
        );
        let bound = |choose: fn(f32, f32) -> f32, from: f32| {
            let all = |axis: usize| self.positions.iter().map(|x| x[axis]).fold(from, choose);
            tuple([0, 1, 2].map(all))
        };
        let (least, most) = (bound(f32::min, f32::INFINITY), bound(f32::max, f32::NEG_INFINITY));
        let width = self.width;
        let per_vertex = r#"interpolation = "vertex""#;
        let several = format!("elementSize = {width}; {per_vertex}");
        let points = list(self.positions.iter().map(|x| tuple(*x)));
        let normals = list(self.normals.iter().map(|x| tuple(*x)));
        let counts = list(self.triangles.chunks(3).map(<[u32]>::len));
        let [indices, joints, weights] =
            [list(self.triangles.iter()), list(self.joints.iter()), list(self.weights.iter())];
        for line in [
            r#"uniform token subdivisionScheme = "none""#.to_owned(),
            format!("float3[] extent = [{least}, {most}]"),
            format!("point3f[] points = {points}"),
            format!("normal3f[] normals = {normals} ({per_vertex})"),
            format!("int[] faceVertexCounts = {counts}"),
            format!("int[] faceVertexIndices = {indices}"),
            format!("rel skel:skeleton = </{root}/{SKELETON}>"),
            format!("int[] primvars:skel:jointIndices = {joints} ({several})"),
            format!("float[] primvars:skel:jointWeights = {weights} ({several})"),
        ] {
            text.line(&line);
        }
        if !self.uv.is_empty() {
            let uv = list(self.uv.iter().map(|x| tuple(*x)));
            text.line(&format!("texCoord2f[] primvars:st = {uv} ({per_vertex})"));
        }
        if has_material {
            text.line(r#"uniform token subsetFamily:materialBind:familyType = "nonOverlapping""#);
        }
        let (mut first, mut own) = (0, Names::default());
        for (material, len) in &self.parts {
            let faces = first..first + len;
            first = faces.end;
            let Some(path) = material.and_then(|material| materials.get(material)) else {
                continue;
            };
            let name = path.trim_end_matches('>').rsplit('/').next().unwrap_or_default();
            text.open(
                &format!("def GeomSubset {}", quoted(&own.new_one(name))),
                &[&schemas(&["MaterialBindingAPI"])],
            );
            text.line(r#"uniform token elementType = "face""#);
            text.line(r#"uniform token familyName = "materialBind""#);
            text.line(&format!("int[] indices = {}", list(faces)));
            text.line(&format!("rel material:binding = {path}"));
            text.close();
        }
        text.close();
    }
}
