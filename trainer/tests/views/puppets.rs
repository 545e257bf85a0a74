//! Reads puppets by another project's parser, and interpolates their bindings as Inochi2D does.

use super::flat::Sheet;
use inochi2d_parser::prelude::{
    BindingValues, Interpolation, ParamBinding, ParamName, PartData, Puppet, TextureData,
};
use sinew_trainer::page::camera::Resolution;
use sinew_trainer::page::picture::Picture;

/// Returns the binding of a puppet's parameter to a node.
pub(crate) fn binding(puppet: &Puppet, node: u32, name: &ParamName) -> ParamBinding {
    let parameter = puppet.params.values().next().unwrap();
    let mut all = parameter.bindings.iter();
    all.find(|binding| binding.node == node && binding.param_name == *name).unwrap().clone()
}

/// Returns the value at a node of the grid.
pub(crate) fn number(binding: &ParamBinding, i: usize, j: usize) -> f32 {
    match &binding.values {
        BindingValues::Transform(values) => values.get(i, j).unwrap(),
        BindingValues::Other(values) => values[i][j].as_f32().unwrap(),
        BindingValues::Deform(_) => panic!("numbers"),
    }
}

/// Returns a part's picture.
pub(crate) fn picture(puppet: &Puppet, part: &PartData) -> Picture {
    match &puppet.textures[part.textures[0] as usize].data {
        TextureData::Encoded(bytes) => decoded(bytes),
        TextureData::Rgba(_) => panic!("it is PNG"),
    }
}

/// Reads a picture of RGBA8.
pub(crate) fn decoded(png: &[u8]) -> Picture {
    let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
    let mut rgba = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut rgba).unwrap();
    assert_eq!(info.color_type, png::ColorType::Rgba);
    let size = Resolution { width: info.width as usize, height: info.height as usize };
    Picture { size, rgba }
}

/// Returns the positions of a part's vertices in its picture, pixels.
pub(crate) fn texels(part: &PartData, picture: &Picture) -> Vec<[f64; 2]> {
    let size = [picture.size.width, picture.size.height].map(|side| side as f64);
    let (uvs, _) = part.mesh.as_ref().unwrap().uvs.as_chunks::<2>();
    uvs.iter().map(|uv| [0, 1].map(|axis| f64::from(uv[axis]) * size[axis])).collect()
}

/// A puppet at a value of its parameter: its parts, and their indices with the hindmost first. The hindmost part has
/// the largest zSort.
pub(crate) struct Posed {
    pub(crate) names: Vec<String>,
    pub(crate) sheets: Vec<Sheet>,
    pub(crate) order: Vec<usize>,
}

/// Poses a puppet of one parameter.
///
/// - `at`: position on each axis, in steps of the grid.
pub(crate) fn posed(puppet: &Puppet, screen: [usize; 2], at: [f64; 2]) -> Posed {
    let parts: Vec<_> =
        puppet.nodes.iter().filter(|node| node.type_node.as_part().is_some()).collect();
    let (mut names, mut sheets, mut sorts) = (Vec::new(), Vec::new(), Vec::new());
    for node in &parts {
        let part = node.type_node.as_part().unwrap();
        let mesh = part.mesh.as_ref().unwrap();
        let scalar = |name: &ParamName| {
            let own = binding(puppet, node.uuid, name);
            blended(&own, at, |i, j| vec![f64::from(number(&own, i, j))])[0]
        };
        let bend = binding(puppet, node.uuid, &ParamName::Deform);
        let BindingValues::Deform(values) = &bend.values else { panic!("a mesh is bent") };
        let len = mesh.vertices.len() / 2;
        let by = blended(&bend, at, |i, j| {
            (0..len).flat_map(|k| values.get(i, j * len + k).unwrap().map(f64::from)).collect()
        });
        let place = |(k, by): (usize, &[f64; 2])| {
            [0, 1].map(|axis| {
                f64::from(mesh.vertices[2 * k + axis]) + by[axis] + 0.5 * screen[axis] as f64
            })
        };
        let picture = picture(puppet, part);
        let mask = |mask: &inochi2d_parser::prelude::Mask| {
            parts.iter().position(|node| node.uuid == mask.source).unwrap()
        };
        names.push(node.name.clone());
        sorts.push(f64::from(node.zsort) + scalar(&ParamName::Other("zSort".to_owned())));
        sheets.push(Sheet {
            places: by.as_chunks::<2>().0.iter().enumerate().map(place).collect(),
            texels: texels(part, &picture),
            triangles: mesh
                .indices
                .as_chunks::<3>()
                .0
                .iter()
                .map(|corners| corners.map(|at| at as usize))
                .collect(),
            picture,
            opacity: f64::from(part.opacity) * scalar(&ParamName::Opacity),
            masks: part.mask.iter().map(mask).collect(),
        });
    }
    let mut order: Vec<usize> = (0..sheets.len()).collect();
    order.sort_by(|&a, &b| sorts[b].total_cmp(&sorts[a]));
    Posed { names, sheets, order }
}

/// Interpolates the values of the nodes around a place.
fn blended(
    binding: &ParamBinding,
    at: [f64; 2],
    of: impl Fn(usize, usize) -> Vec<f64>,
) -> Vec<f64> {
    if binding.interpolate_mode == Interpolation::Nearest {
        let [i, j] = at.map(|x| x.round() as usize);
        return of(i, j);
    }
    let ([i, j], [x, y]) = (at.map(|x| x as usize), at.map(f64::fract));
    let mut out = Vec::new();
    for (i, j, share) in [
        (i, j, (1.0 - x) * (1.0 - y)),
        (i + 1, j, x * (1.0 - y)),
        (i, j + 1, (1.0 - x) * y),
        (i + 1, j + 1, x * y),
    ] {
        if share > 0.0 {
            let own = of(i, j);
            out.resize(own.len(), 0.0);
            out.iter_mut().zip(own).for_each(|(out, x)| *out += share * x);
        }
    }
    out
}
