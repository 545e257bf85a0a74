//! Objects of views in f64, and the parts that bake writes of them (FORMAT.md).

use super::fit::MapOutputs;
use super::mesh::{Mesh, Vertex};
use super::object::{Deformation, KeyView};
use super::set::Element;
use crate::Error;
use crate::bake::sections::{floats, names, narrow, words};
use crate::bake::{Part, Sections};
use crate::scattered::bake::part;
use crate::scattered::model::KernelModel;
use nalgebra::Complex;
use sinew_runtime::format::{Element as Number, PartKind, SectionKind};
use sinew_runtime::views::{Layer, NO_VERTEX, NOTHING, ViewsCounts};

/// An object: key views, and maps from parameters to its points.
#[derive(Clone, Debug)]
pub struct ViewsModel {
    /// Name of the object.
    pub name: String,
    /// Width and height of the screen, pixels.
    pub size: [usize; 2],
    /// Number of control points, K.
    pub point_len: usize,
    /// Vertices, and the elements of each layer between the vertices.
    pub mesh: Mesh,
    /// The L layers, the hindmost first.
    pub layers: Vec<LayerModel>,
    /// The N key views.
    pub keys: Vec<KeyView>,
    /// Maps of the motions, each with the outputs of [`MapOutputs`].
    pub maps: Vec<KernelModel>,
    /// Errors on the training views.
    pub fit: Reached,
}

/// Properties of a layer. [`Mesh::layers`] has the elements.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LayerModel {
    /// Name of the layer.
    pub name: String,
    /// Index of the layer that clips this layer.
    pub clip: Option<usize>,
    /// Whether the elements hide each other by depth.
    pub has_depth: bool,
    /// Whether the layer is drawn separately before blending: elements may overlap where the layer is translucent.
    pub is_group: bool,
    /// Whether elements that turn over are skipped.
    pub is_one_sided: bool,
}

/// Errors on the training views. Lengths are in pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reached {
    /// RMS error of the points of the training views.
    pub rms: f64,
    /// RMS error of the points of left-out views; 0 if no view could be left out.
    pub left_out: f64,
    /// Share of the known marks of visibility that the maps predict.
    pub visibility: f64,
}

impl ViewsModel {
    /// Returns the number of outputs of each map.
    pub fn outputs(&self) -> MapOutputs {
        MapOutputs { points: self.point_len, views: self.keys.len(), layers: self.layers.len() }
    }
}

/// Bits in one word of a visibility mask.
const BITS: usize = 32;

/// Makes the parts of a model: the maps first, then the object.
///
/// # Errors
/// [`ErrorKind::Limit`](crate::ErrorKind::Limit): a count does not fit the file.
pub fn parts(model: &ViewsModel) -> Result<Vec<Part>, Error> {
    let maps = model.maps.iter().map(part);
    let mut out = maps.collect::<Result<Vec<_>, _>>()?;
    out.push(object(model)?);
    Ok(out)
}

fn object(model: &ViewsModel) -> Result<Part, Error> {
    let all = || model.keys.iter().flat_map(|key| key.pictures.iter().flatten());
    let texels = || all().map(|(picture, _)| picture.rgba.len() / 4);
    let mesh = &model.mesh;
    let weights = || mesh.vertices.iter().flat_map(|vertex| &vertex.weights);
    let elements: Vec<&Element> = mesh.layers.iter().flatten().collect();
    let [width, height] = model.size;
    let counts = ViewsCounts {
        point_len: narrow("points", model.point_len)?,
        vertex_len: narrow("vertices", mesh.vertices.len())?,
        weight_len: narrow("weights", weights().count())?,
        element_len: narrow("elements", elements.len())?,
        layer_len: narrow("layers", model.layers.len())?,
        view_len: narrow("key views", model.keys.len())?,
        map_len: narrow("maps", model.maps.len())?,
        texture_len: narrow("textures", all().count())?,
        texel_len: narrow("texels", texels().sum())?,
        size: [narrow("the pictures' width", width)?, narrow("the pictures' height", height)?],
    };
    let mut textures = Vec::new();
    let mut start = 0;
    for ((picture, _), texels) in all().zip(texels()) {
        textures.push(narrow("a texture's width", picture.size.width)?);
        textures.push(narrow("a texture's height", picture.size.height)?);
        textures.push(narrow("texels", start)?);
        start += texels;
    }
    let mut next = 0;
    let texture = |picture: &Option<_>| match picture {
        None => NOTHING,
        Some(_) => {
            next += 1;
            next - 1
        }
    };
    let view_textures = model.keys.iter().flat_map(|key| &key.pictures).map(texture);
    let view_textures: Vec<u32> = view_textures.collect();
    let names_of_keys = model.keys.iter().map(|key| &key.name);
    let names_of_layers = model.layers.iter().map(|layer| &layer.name);
    let named = std::iter::once(&model.name).chain(names_of_keys).chain(names_of_layers);
    let maps: Vec<u32> = (0..counts.map_len).collect();
    let corners = |element: &&Element| [0, 1, 2, 3].map(|at| element.vertices().get(at).copied());
    let mut sections: Sections = vec![
        (SectionKind::ViewsCounts, true, words(&counts.words())),
        (SectionKind::Names, true, names(named)?),
        (SectionKind::Maps, true, words(&maps)),
        (SectionKind::Layers, true, words(&layers(model)?)),
        (SectionKind::Vertices, true, vertices(mesh)?),
        (SectionKind::VertexWeights, true, weight_rows(weights())?),
        (SectionKind::Elements, true, indices("vertices", elements.iter().map(corners))?),
        (SectionKind::Neighbours, true, indices("elements", mesh.neighbours().into_iter())?),
        (SectionKind::ViewTextures, true, words(&view_textures)),
        (SectionKind::VertexTexels, true, vertex_texels(model)),
        (
            SectionKind::References,
            true,
            model.keys.iter().flat_map(|key| floats(key.points.as_flattened())).collect(),
        ),
        (SectionKind::ViewMasks, true, words(&masks(&model.keys))),
        (SectionKind::Textures, true, words(&textures)),
        (
            SectionKind::Texels,
            true,
            all().flat_map(|(picture, _)| picture.rgba.iter().copied()).collect(),
        ),
    ];
    let lent: Option<Vec<_>> = model.keys.iter().map(|key| key.deformation.as_ref()).collect();
    if let Some(lent) = lent.filter(|all| !all.is_empty()) {
        let own = |key: &Deformation| floats(&[&[key.scale], key.offsets.as_flattened()].concat());
        sections.push((SectionKind::Deformations, true, lent.into_iter().flat_map(own).collect()));
    }
    let fit = [model.fit.rms, model.fit.left_out, model.fit.visibility];
    sections.push((SectionKind::ViewsFit, true, floats(&fit)));
    Ok(Part { kind: PartKind::Views, sections, element: Number::F32 })
}

/// Lists three words for each layer: the end of its elements, the layer that clips it, and its flags.
fn layers(model: &ViewsModel) -> Result<Vec<u32>, Error> {
    let (mut out, mut end) = (Vec::new(), 0);
    for (layer, elements) in model.layers.iter().zip(&model.mesh.layers) {
        end += elements.len();
        let clip = layer.clip.map_or(Ok(NOTHING), |clip| narrow("layers", clip))?;
        let flags = [
            (layer.has_depth, Layer::DEPTH),
            (layer.is_group, Layer::GROUP),
            (layer.is_one_sided, Layer::ONE_SIDED),
        ];
        let flags: u32 = flags.iter().filter(|(is_set, _)| *is_set).map(|(_, bit)| bit).sum();
        out.extend([narrow("elements", end)?, clip, flags]);
    }
    Ok(out)
}

/// Writes the end of the weights and the place of each vertex.
fn vertices(mesh: &Mesh) -> Result<Vec<u8>, Error> {
    let (mut out, mut end) = (Vec::new(), 0);
    for vertex in &mesh.vertices {
        end += vertex.weights.len();
        let end: u32 = narrow("weights", end)?;
        out.extend(end.to_le_bytes());
        out.extend(floats(&vertex.place));
    }
    Ok(out)
}

fn weight_rows<'a>(
    weights: impl Iterator<Item = &'a (usize, Complex<f64>)>,
) -> Result<Vec<u8>, Error> {
    let mut out = Vec::new();
    for (point, weight) in weights {
        let point: u32 = narrow("points", *point)?;
        out.extend(point.to_le_bytes());
        out.extend(floats(&[weight.re, weight.im]));
    }
    Ok(out)
}

/// Writes the vertices or neighbours of each element. `what` names them in errors.
fn indices(what: &str, all: impl Iterator<Item = [Option<usize>; 4]>) -> Result<Vec<u8>, Error> {
    let mut out = Vec::new();
    for index in all.flatten() {
        let index = index.map_or(Ok(NO_VERTEX), |index| narrow(what, index))?;
        out.extend(index.to_le_bytes());
    }
    Ok(out)
}

/// Writes the position of each vertex in the picture of its layer, for each key view. The position is the origin if the
/// key view has no picture of the layer.
fn vertex_texels(model: &ViewsModel) -> Vec<u8> {
    // Layer of each vertex.
    let mut owners = vec![0; model.mesh.vertices.len()];
    for (layer, elements) in model.mesh.layers.iter().enumerate() {
        elements.iter().flat_map(Element::vertices).for_each(|&vertex| owners[vertex] = layer);
    }
    let of_key = |key: &KeyView| -> Vec<[f64; 2]> {
        let of_vertex = |(vertex, layer): (&Vertex, &usize)| match &key.pictures[*layer] {
            None => [0.0; 2],
            Some((_, corner)) => {
                let place = vertex.at(&key.points);
                [0, 1].map(|axis| place[axis] - corner[axis] as f64)
            }
        };
        model.mesh.vertices.iter().zip(&owners).map(of_vertex).collect()
    };
    model.keys.iter().flat_map(|key| floats(of_key(key).as_flattened())).collect()
}

/// Lists one bit for each point and key view. Each key view starts a new word.
fn masks(keys: &[KeyView]) -> Vec<u32> {
    let word = |seen: &[bool]| {
        seen.iter().enumerate().fold(0, |word, (bit, seen)| word | u32::from(*seen) << bit)
    };
    keys.iter().flat_map(|key| key.visible.chunks(BITS).map(word)).collect()
}
