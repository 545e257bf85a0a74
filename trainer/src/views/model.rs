//! An object of views in f64: what training makes and a file holds.

use super::deformation::Reference;
use super::fit::MapOutputs;
use super::mesh::Mesh;
use crate::page::picture::Picture;
use crate::scattered::model::KernelModel;

/// An object: its key views, and maps from parameters to its points.
#[derive(Clone, Debug)]
pub struct ViewsModel {
    /// Its name.
    pub name: String,
    /// Width and height of the screen, pixels.
    pub size: [usize; 2],
    /// Control points, K.
    pub point_len: usize,
    /// Vertices, and the elements of each layer between them.
    pub mesh: Mesh,
    /// Layers, L.
    pub layers: Vec<LayerModel>,
    /// Key views, N.
    pub keys: Vec<KeyView>,
    /// Maps, each with the outputs of [`MapOutputs`].
    pub maps: Vec<KernelModel>,
    /// What training reached.
    pub fit: Reached,
}

/// A layer beside its elements.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LayerModel {
    /// Its name.
    pub name: String,
    /// The layer that clips it.
    pub clip: Option<usize>,
    /// Whether its elements hide each other by depth.
    pub has_depth: bool,
    /// Whether it is drawn by itself before it is blended: elements may lie on each other where it is translucent.
    pub is_group: bool,
    /// Whether elements that turn over are not drawn.
    pub is_one_sided: bool,
}

/// A key view.
#[derive(Clone, Debug)]
pub struct KeyView {
    /// Its name.
    pub name: String,
    /// L pictures, each with where its corner is on the screen; none of a layer that it does not show.
    pub pictures: Vec<Option<(Picture, [usize; 2])>>,
    /// Where points are on the screen, K.
    pub points: Vec<[f64; 2]>,
    /// Which of them are seen, K.
    pub visible: Vec<bool>,
    /// What it has in common with its prototype, where its motion is lent.
    pub reference: Option<Reference>,
}

/// What training reached, pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reached {
    /// RMS over points of the examples.
    pub rms: f64,
    /// The same of examples that are left out; 0 where they could not be.
    pub left_out: f64,
    /// Share of points whose visibility the maps give as the examples do.
    pub visibility: f64,
}

impl ViewsModel {
    /// Returns how many outputs each map has.
    pub fn outputs(&self) -> MapOutputs {
        MapOutputs { points: self.point_len, views: self.keys.len(), layers: self.layers.len() }
    }
}
