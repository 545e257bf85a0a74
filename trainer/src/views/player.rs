//! A model file drawn by the runtime, as an engine does in each frame.

use super::fit::{given, weights, with_features};
use super::set::Values;
use crate::Error;
use crate::page::camera::Resolution;
use crate::page::picture::Picture;
use crate::scattered::model::{Input, InputKind, inputs_of, query_numbers};
use sinew_runtime::Model;
use sinew_runtime::kernel::KernelMap;
use sinew_runtime::views::{Drawn, Element, Frame, FrameJob, RenderJob, RenderScratch, Views};

/// A map of a model, and its object.
pub struct Player<'a> {
    views: Views<'a>,
    map: KernelMap<'a>,
    inputs: Vec<Input>,
}

/// Outputs of a map in single precision.
#[derive(Clone, Debug, PartialEq)]
pub struct Played {
    /// The K points: x, y and depth, pixels.
    pub points: Vec<[f32; 3]>,
    /// The K visibilities; above 0.5 a point is visible.
    pub visibility: Vec<f32>,
    /// The N scores of the key views.
    pub scores: Vec<f32>,
    /// Opacity and order of the L layers.
    pub layers: Vec<[f32; 2]>,
    /// Index of the characteristic view.
    pub view: usize,
    /// Confidence of the map.
    pub confidence: f32,
}

impl Played {
    /// Returns the weights of the N key views, by [`weights`].
    pub fn weights(&self) -> Vec<f64> {
        weights(&self.scores.iter().copied().map(f64::from).collect::<Vec<_>>())
    }

    /// Returns a drawing job. The caller sets its width.
    pub(super) fn job<'a>(&'a self, views: Views<'a>) -> RenderJob<'a> {
        let Self { points, visibility, scores, layers, .. } = self;
        RenderJob { views, points, visibility, scores, layers, width: 0 }
    }
}

impl<'a> Player<'a> {
    /// Opens a map of the first object of a file: the named map, or the first map.
    ///
    /// # Errors
    /// [`ErrorKind::Missing`](crate::ErrorKind::Missing): the file has no object, or no map of this name.
    pub fn new(model: &'a Model<Vec<u8>>, map: Option<&str>) -> Result<Self, Error> {
        let views = model.first::<Views>().ok_or_else(|| Error::missing("it has no views"))?;
        let maps = (0..).map_while(|number| model.map_of(&views, number));
        let names: Vec<&str> = maps.clone().map(|map| map.name()).collect();
        let found = maps.clone().find(|own| map.is_none_or(|name| own.name() == name));
        let unknown = || {
            let map = map.unwrap_or_default();
            Error::missing(format!("it has no map \"{map}\"; there are {}", names.join(", ")))
        };
        let map = found.ok_or_else(unknown)?;
        Ok(Self { views, map, inputs: inputs_of(&map) })
    }

    /// Returns the map.
    pub fn map(&self) -> &KernelMap<'a> {
        &self.map
    }

    /// Returns the object.
    pub fn views(&self) -> &Views<'a> {
        &self.views
    }

    /// Lists the names of the N key views.
    pub fn key_names(&self) -> Vec<&'a str> {
        (0..).map_while(|view| self.views.view_name(view)).collect()
    }

    /// Returns the inputs of the map.
    pub fn inputs(&self) -> &[Input] {
        &self.inputs
    }

    /// Lists the elements. Without depth the hindmost is first.
    pub fn elements(&self) -> Vec<Element> {
        (0..).map_while(|element| self.views.element(element)).collect()
    }

    /// Returns the picture of a layer in a key view, with straight alpha. `None` if the key view does not show the
    /// layer.
    pub fn key_picture(&self, view: usize, layer: usize) -> Option<Picture> {
        let texture = self.views.texture(self.views.view_texture(view, layer)?)?;
        let [width, height] = texture.size();
        let rgba = texture.texels().as_flattened().to_vec();
        Some(Picture { size: Resolution { width, height }, rgba })
    }

    /// Returns the width and height of the screen.
    pub fn size(&self) -> [usize; 2] {
        self.views.size()
    }

    /// Lists the positions of the V vertices on the screen, with their depths.
    pub fn vertices(&self, played: &Played) -> Vec<[f32; 3]> {
        let vertices = (0..).map_while(|vertex| self.views.vertex(vertex));
        vertices.map(|vertex| vertex.at(&played.points)).collect()
    }

    /// Evaluates the map.
    ///
    /// # Errors
    /// The values are invalid; a value is farther outside the range of the training views than the range is wide; or
    /// the runtime refuses the call.
    pub fn play(&self, values: &Values) -> Result<Played, Error> {
        let given = given(&self.inputs, values)?;
        self.check(values)?;
        let numbers = query_numbers(&self.inputs, &given)?;
        let parameters: Vec<f32> = numbers.iter().map(|x| *x as f32).collect();
        let (k, n) = (self.views.point_len(), self.views.view_len());
        let mut out = Played {
            points: vec![[0.0; 3]; k],
            visibility: vec![0.0; k],
            scores: vec![0.0; n],
            layers: vec![[0.0; 2]; self.views.layer_len()],
            view: 0,
            confidence: 0.0,
        };
        let len = self.views.counts().frame_scratch_len(&self.map.counts());
        let job = FrameJob { views: self.views, map: self.map, parameters: &parameters };
        let mut frame = Frame {
            points: &mut out.points,
            visibility: &mut out.visibility,
            scores: &mut out.scores,
            layers: &mut out.layers,
        };
        let found = job.run(&mut vec![0.0; len], &mut frame)?;
        (out.view, out.confidence) = (found.view, found.confidence);
        Ok(out)
    }

    /// Refuses numbers far outside the range of the training views. Angles wrap around.
    fn check(&self, values: &Values) -> Result<(), Error> {
        for (input, first) in with_features(&self.inputs) {
            let range = self.map.feature(first).unwrap_or_default().map(f64::from);
            let ([.., low, high], Some(&value)) = (range, values.get(&input.name)) else {
                continue;
            };
            // A parameter that is constant in training has no range.
            let range = [2.0 * low - high, 2.0 * high - low];
            let is_within = range[0] == range[1] || (range[0]..=range[1]).contains(&value);
            if input.kind == InputKind::Scalar && !is_within {
                let (name, [least, most]) = (&input.name, range);
                return Err(Error::value(format!(
                    "parameter \"{name}\" is {value}, expected {least} to {most}"
                )));
            }
        }
        Ok(())
    }

    /// Draws evaluated outputs. Colours are premultiplied by alpha.
    ///
    /// # Errors
    /// The runtime refuses the call.
    pub fn draw(&self, played: &Played) -> Result<(Picture, Drawn), Error> {
        let [width, height] = self.size();
        let mut pixels = vec![[0; 4]; width * height];
        let job = RenderJob { width, ..played.job(self.views) };
        let scratch = RenderScratch {
            vertices: &mut vec![[0.0; 3]; self.views.vertex_len()],
            order: &mut vec![0; self.views.order_len()],
            depths: &mut vec![0.0; if self.views.has_depth() { pixels.len() } else { 0 }],
            group: &mut vec![[0; 4]; if self.views.has_groups() { pixels.len() } else { 0 }],
            clips: &mut vec![0; if self.views.has_clips() { pixels.len() } else { 0 }],
        };
        let drawn = job.run(scratch, &mut pixels)?;
        let size = Resolution { width, height };
        Ok((Picture { size, rgba: pixels.into_flattened() }, drawn))
    }
}

/// Premultiplies the colours of a picture by alpha.
pub fn multiplied(picture: &Picture) -> Picture {
    recoloured(picture, |x, alpha| x * alpha)
}

/// Divides the colours of a picture by alpha, as PNG stores them.
pub fn straight(picture: &Picture) -> Picture {
    recoloured(picture, |x, alpha| if alpha > 0.0 { x / alpha } else { x })
}

/// Changes the colours of a picture, given a byte and the alpha from 0 to 1.
fn recoloured(picture: &Picture, of: impl Fn(f64, f64) -> f64) -> Picture {
    let mut out = picture.clone();
    for pixel in out.rgba.chunks_mut(4) {
        let alpha = f64::from(pixel[3]) / 255.0;
        pixel[..3].iter_mut().for_each(|x| *x = of(f64::from(*x), alpha).round() as u8);
    }
    out
}
