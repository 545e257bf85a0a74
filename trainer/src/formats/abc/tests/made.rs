//! Builds Alembic archives for tests, byte by byte.

/// A group or data of a file.
pub(super) enum Node {
    Group(Vec<Node>),
    Data(Vec<u8>),
}

use Node::{Data, Group};

const SEVERAL: u32 = 0x200;
const DATA: u64 = 1 << 63;

/// An object with its properties and children.
pub(super) struct Object {
    name: &'static str,
    schema: &'static str,
    properties: Vec<Property>,
    children: Vec<Object>,
}

/// A property of an object or compound.
pub(super) struct Property {
    name: &'static str,
    info: u32,
    /// Number of samples, first and last sample that change; empty for a compound.
    counts: Vec<u32>,
    node: Node,
}

/// Returns the bytes of a file with some objects at its top.
pub(super) fn archive(objects: Vec<Object>) -> Vec<u8> {
    let version = |number: u32| Data(number.to_le_bytes().to_vec());
    let top = Object { name: "", schema: "", properties: Vec::new(), children: objects };
    let text = |text: &str| Data(text.as_bytes().to_vec());
    // The table holds one text, with its length; objects without metadata refer to it.
    let table = text("\u{9}a=b;c=d;e");
    file(&Group(vec![version(0), version(10803), top.node(), text("made"), text(""), table]))
}

/// Returns the bytes of a file with a root.
pub(super) fn file(root: &Node) -> Vec<u8> {
    let mut bytes = b"Ogawa\xff\0\x01".to_vec();
    bytes.extend([0; 8]);
    let place = root.write(&mut bytes);
    bytes[8..16].copy_from_slice(&place.to_le_bytes());
    bytes
}

impl Node {
    fn write(&self, bytes: &mut Vec<u8>) -> u64 {
        let (numbers, mark): (Vec<u64>, u64) = match self {
            Group(nodes) if nodes.is_empty() => return 0,
            Data(data) if data.is_empty() => return DATA,
            Group(nodes) => (nodes.iter().map(|node| node.write(bytes)).collect(), 0),
            Data(_) => (Vec::new(), DATA),
        };
        let place = bytes.len() as u64;
        match self {
            Group(nodes) => {
                bytes.extend((nodes.len() as u64).to_le_bytes());
                bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
            }
            Data(data) => {
                bytes.extend((data.len() as u64).to_le_bytes());
                bytes.extend(data);
            }
        }
        place | mark
    }
}

impl Object {
    fn node(self) -> Node {
        let mut headers = Vec::new();
        let mut nodes = vec![compound_node(self.properties)];
        for child in self.children {
            headers.extend((child.name.len() as u32).to_le_bytes());
            headers.extend(child.name.as_bytes());
            if child.schema.is_empty() {
                headers.push(1);
            } else {
                headers.push(0xff);
                let text = format!("schema={};schemaObjTitle=x", child.schema);
                headers.extend((text.len() as u32).to_le_bytes());
                headers.extend(text.as_bytes());
            }
            nodes.push(child.node());
        }
        headers.extend([7; 32]);
        nodes.push(Data(headers));
        Group(nodes)
    }

    /// Adds an object as a child of this object.
    pub(super) fn over(mut self, child: Object) -> Self {
        self.children.push(child);
        self
    }
}

/// An object that is neither mesh nor transform.
pub(super) fn other(name: &'static str) -> Object {
    Object { name, schema: "", properties: Vec::new(), children: Vec::new() }
}

/// Makes a transform with properties in its schema.
pub(super) fn transform(name: &'static str, properties: Vec<Property>) -> Object {
    let properties = vec![compound(".xform", properties)];
    Object { name, schema: "AbcGeom_Xform_v3", properties, children: Vec::new() }
}

/// Makes a mesh with properties in its schema.
pub(super) fn mesh(name: &'static str, properties: Vec<Property>) -> Object {
    let properties = vec![compound(".geom", properties)];
    Object { name, schema: "AbcGeom_PolyMesh_v1", properties, children: Vec::new() }
}

pub(super) fn compound(name: &'static str, properties: Vec<Property>) -> Property {
    Property { name, info: 0, counts: Vec::new(), node: compound_node(properties) }
}

fn compound_node(properties: Vec<Property>) -> Node {
    let mut headers = Vec::new();
    let mut nodes = Vec::new();
    for Property { name, info, counts, node } in properties {
        headers.extend((info | 2 << 2).to_le_bytes());
        headers.extend(counts.iter().flat_map(|count| count.to_le_bytes()));
        headers.extend((name.len() as u32).to_le_bytes());
        headers.extend(name.as_bytes());
        nodes.push(node);
    }
    nodes.push(Data(headers));
    Group(nodes)
}

/// Makes a constant scalar; `kind` is its type in the file: 0 for truth values, 1 for bytes, 11 for doubles.
pub(super) fn scalar(name: &'static str, kind: u32, extent: u32, bytes: Vec<u8>) -> Property {
    let info = 1 | kind << 4 | 0x800 | extent << 12;
    Property { name, info, counts: vec![1], node: Group(vec![sample(bytes)]) }
}

/// Makes doubles over time, as a scalar or as an array.
pub(super) fn doubles(name: &'static str, array: bool, samples: &[Vec<f64>]) -> Property {
    let extent = if array { 1 } else { samples[0].len() as u32 };
    let bytes = |sample: &Vec<f64>| sample.iter().flat_map(|x| x.to_le_bytes()).collect();
    let samples: Vec<Vec<u8>> = samples.iter().map(bytes).collect();
    sampled(name, if array { 2 } else { 1 } | 11 << 4 | extent << 12, &samples)
}

/// Makes points over time.
pub(super) fn points(name: &'static str, samples: &[Vec<[f32; 3]>]) -> Property {
    let bytes = |sample: &Vec<[f32; 3]>| {
        sample.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect()
    };
    let samples: Vec<Vec<u8>> = samples.iter().map(bytes).collect();
    sampled(name, 2 | 10 << 4 | 3 << 12, &samples)
}

/// Makes whole numbers over time.
pub(super) fn wholes(name: &'static str, samples: &[Vec<i32>]) -> Property {
    let bytes = |sample: &Vec<i32>| sample.iter().flat_map(|x| x.to_le_bytes()).collect();
    let samples: Vec<Vec<u8>> = samples.iter().map(bytes).collect();
    sampled(name, 2 | 6 << 4 | 1 << 12, &samples)
}

/// Makes a sampled property; samples before the first change and after the last change are stored once.
fn sampled(name: &'static str, info: u32, samples: &[Vec<u8>]) -> Property {
    let changes: Vec<usize> =
        (1..samples.len()).filter(|&i| samples[i] != samples[i - 1]).collect();
    let (first, last) = match (changes.first(), changes.last()) {
        (Some(&first), Some(&last)) => (first, last),
        _ => (0, 0),
    };
    let mut stored = vec![0];
    stored.extend((first..=last).filter(|_| last > 0));
    let mut nodes = Vec::new();
    for place in stored {
        nodes.push(sample(samples[place].clone()));
        if info & 3 == 2 {
            nodes.push(Data(Vec::new()));
        }
    }
    let counts = [samples.len(), first, last].map(|count| count as u32).to_vec();
    Property { name, info: info | SEVERAL, counts, node: Group(nodes) }
}

fn sample(bytes: Vec<u8>) -> Node {
    Data([vec![3; 16], bytes].concat())
}

impl Property {
    /// Replaces the counts: samples, first and last sample that change.
    pub(super) fn claiming(mut self, counts: [u32; 3]) -> Self {
        self.counts = counts.to_vec();
        self
    }
}
