//! An object of views in f64: what training makes and a file holds.

use super::deformation::Reference;
use super::fit::MapOutputs;
use super::set::Element;
use crate::kernel::model::KernelModel;
use crate::page::picture::Picture;

/// By how much a key view's score must be above that of the one before, where neighbours differ by 1 at their own
/// parameters: a tenth of the way between them.
pub const MARGIN: f64 = 0.2;

/// An object: its key views, and maps from parameters to its points.
#[derive(Clone, Debug)]
pub struct ViewsModel {
    /// Its name.
    pub name: String,
    /// Control points, K.
    pub point_len: usize,
    /// Elements.
    pub elements: Vec<Element>,
    /// Key views, N.
    pub keys: Vec<KeyView>,
    /// Maps, each with the outputs of [`MapOutputs`].
    pub maps: Vec<KernelModel>,
    /// What training reached.
    pub fit: Reached,
}

/// A key view.
#[derive(Clone, Debug)]
pub struct KeyView {
    /// Its name.
    pub name: String,
    /// Its picture.
    pub picture: Picture,
    /// Where points are in it, K.
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
        MapOutputs { points: self.point_len, views: self.keys.len() }
    }
}
