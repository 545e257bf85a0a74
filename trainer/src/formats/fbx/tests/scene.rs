//! Builds scenes as FBX text, piece by piece.

use std::fmt::Write;

/// FBX's clock, in ticks a second.
const TICKS: i64 = 46_186_158_000;

/// A 4 x 4 matrix as files store it: column by column.
pub(super) type Columns = [f64; 16];

pub(super) fn translation(x: f64, y: f64, z: f64) -> Columns {
    [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., x, y, z, 1.]
}

/// Objects of a scene, numbered for their connections.
#[derive(Clone, Default)]
pub(super) struct Scene {
    objects: String,
    connections: String,
    last: u32,
}

impl Scene {
    pub(super) fn text(&self) -> String {
        format!(
            "; FBX 7.4.0 project file\nFBXHeaderExtension: {{\nFBXVersion: 7400\n}}\n\
             Objects: {{\n{}}}\nConnections: {{\n{}}}\n",
            self.objects, self.connections
        )
    }

    /// Adds a node under another node; 0 is the root of the scene. The `kind` of a bone is LimbNode.
    pub(super) fn node(
        &mut self,
        name: &str,
        kind: &str,
        under: u32,
        properties: &[(&str, [f64; 3])],
    ) -> u32 {
        let mut inside = "Properties70: {\n".to_owned();
        for (property, [x, y, z]) in properties {
            writeln!(inside, "P: \"{property}\", \"{property}\", \"\", \"A\",{x},{y},{z}").unwrap();
        }
        let node = self.object("Model", name, kind, &(inside + "}\n"));
        self.connect(node, under);
        if kind == "LimbNode" {
            let bone = self.object("NodeAttribute", name, kind, "TypeFlags: \"Skeleton\"\n");
            self.connect(bone, node);
        }
        node
    }

    /// Adds a mesh to a node. As in FBX, the last corner of each face is stored as its complement.
    pub(super) fn mesh(
        &mut self,
        node: u32,
        vertices: &[[f64; 3]],
        faces: &[i32],
        more: &str,
    ) -> u32 {
        let inside = numbers("Vertices", vertices.as_flattened())
            + &numbers("PolygonVertexIndex", faces)
            + more;
        let mesh = self.object("Geometry", "", "Mesh", &inside);
        self.connect(mesh, node);
        mesh
    }

    pub(super) fn skin(&mut self, mesh: u32, method: &str) -> u32 {
        let skin = self.object("Deformer", "", "Skin", &format!("SkinningType: \"{method}\"\n"));
        self.connect(skin, mesh);
        skin
    }

    /// Adds a joint's cluster to a skin: weights, the transform from the mesh to the joint, and the frame of the joint,
    /// both in the bind pose.
    pub(super) fn cluster(
        &mut self,
        skin: u32,
        joint: u32,
        weights: &[(i32, f64)],
        mesh: Columns,
        link: Columns,
    ) {
        let (indices, weights): (Vec<i32>, Vec<f64>) = weights.iter().copied().unzip();
        let inside = numbers("Indexes", &indices)
            + &numbers("Weights", &weights)
            + &numbers("Transform", &mesh)
            + &numbers("TransformLink", &link);
        let cluster = self.object("Deformer", "", "Cluster", &inside);
        self.connect(cluster, skin);
        self.connect(joint, cluster);
    }

    /// Adds a bind pose of a single node.
    pub(super) fn bind_pose(&mut self, node: u32, place: Columns) {
        let place = numbers("Matrix", &place);
        let inside = format!("Type: \"BindPose\"\nPoseNode: {{\nNode: {node}\n{place}}}\n");
        self.object("Pose", "bind", "BindPose", &inside);
    }

    /// Adds a channel of shapes. Each shape has the weight in percent at which it is reached, a vertex, and its offset.
    pub(super) fn channel(
        &mut self,
        mesh: u32,
        name: &str,
        shapes: &[(f64, i32, [f64; 3])],
    ) -> u32 {
        let blend = self.object("Deformer", "", "BlendShape", "");
        self.connect(blend, mesh);
        let weights: Vec<f64> = shapes.iter().map(|shape| shape.0).collect();
        let inside = "DeformPercent: 0\n".to_owned() + &numbers("FullWeights", &weights);
        let channel = self.object("Deformer", name, "BlendShapeChannel", &inside);
        self.connect(channel, blend);
        for (_, vertex, offset) in shapes {
            let inside = numbers("Indexes", &[*vertex]) + &numbers("Vertices", offset);
            let shape = self.object("Geometry", "", "Shape", &inside);
            self.connect(shape, channel);
        }
        channel
    }

    /// Sets the stored weight of a channel, in percent.
    pub(super) fn weigh(&mut self, channel: u32, percent: f64) {
        let begin = self.objects.find(&format!("Deformer: {channel},")).unwrap();
        let at = begin + self.objects[begin..].find("DeformPercent: 0").unwrap();
        let end = at + "DeformPercent: 0".len();
        self.objects.replace_range(at..end, &format!("DeformPercent: {percent}"));
    }

    /// Makes every key hold its value until the next key.
    pub(super) fn hold_keys(&mut self) {
        let [linear, constant] = [4, 2].map(|flags| numbers("KeyAttrFlags", &[flags]));
        self.objects = self.objects.replace(&linear, &constant);
    }

    /// Adds an animation and returns its layer.
    pub(super) fn animation(&mut self, name: &str) -> u32 {
        let stack = self.object("AnimationStack", name, "", "");
        let layer = self.object("AnimationLayer", "", "", "");
        self.connect(layer, stack);
        layer
    }

    /// Adds linear keys to an axis of a property. A key is a frame, at 24 a second, and a value. The axis is `d|X`, or
    /// the name of a scalar property. The other axes of a scale are 1, those of other properties 0.
    pub(super) fn keys(
        &mut self,
        layer: u32,
        object: u32,
        property: &str,
        axis: &str,
        keys: &[(i64, f64)],
    ) {
        let one = |axis: &str| format!("P: \"d|{axis}\", \"Number\", \"\", \"A\",1\n");
        let others = match property {
            "Lcl Scaling" => format!("Properties70: {{\n{}}}\n", ["X", "Y", "Z"].map(one).concat()),
            _ => String::new(),
        };
        let node = self.object("AnimationCurveNode", "", "", &others);
        self.connect(node, layer);
        self.connect_to(node, object, property);
        let (times, values): (Vec<i64>, Vec<f64>) =
            keys.iter().map(|&(frame, value)| (frame * TICKS / 24, value)).unzip();
        let inside = "KeyVer: 4009\n".to_owned()
            + &numbers("KeyTime", &times)
            + &numbers("KeyValueFloat", &values)
            + &numbers("KeyAttrFlags", &[4])
            + &numbers("KeyAttrDataFloat", &[0, 0, 0, 0])
            + &numbers("KeyAttrRefCount", &[keys.len()]);
        let curve = self.object("AnimationCurve", "", "", &inside);
        self.connect_to(curve, node, axis);
    }

    pub(super) fn object(&mut self, class: &str, name: &str, kind: &str, inside: &str) -> u32 {
        self.last += 1;
        let prefix = match class {
            "AnimationStack" => "AnimStack",
            other => other,
        };
        let (number, objects) = (self.last, &mut self.objects);
        writeln!(objects, "{class}: {number}, \"{prefix}::{name}\", \"{kind}\" {{\n{inside}}}")
            .unwrap();
        number
    }

    pub(super) fn connect(&mut self, from: u32, to: u32) {
        writeln!(self.connections, "C: \"OO\",{from},{to}").unwrap();
    }

    pub(super) fn connect_to(&mut self, from: u32, to: u32, property: &str) {
        writeln!(self.connections, "C: \"OP\",{from},{to},\"{property}\"").unwrap();
    }
}

fn numbers<T: ToString>(name: &str, numbers: &[T]) -> String {
    let list: Vec<String> = numbers.iter().map(T::to_string).collect();
    format!("{name}: *{} {{\na: {}\n}}\n", numbers.len(), list.join(","))
}
