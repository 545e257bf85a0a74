//! The pictures of a report: camera, shapes and colours.

use super::comparison::{Comparison, Series, SeriesSkin};
use crate::Error;
use crate::envelope::normals::TrueNormals;
use crate::evaluate::skin;
use crate::examples::Examples;
use crate::numeric::columns::{ends, largest};
use crate::page::camera::{Camera, Resolution, View};
use crate::page::chart::colour_bar;
use crate::page::colour::{Colour, Scale};
use crate::page::html::{figure, text};
use crate::page::picture::Picture;
use crate::page::render::{Look, ShadedMesh};
use nalgebra::Vector3;
use rayon::prelude::*;
use sinew_runtime::format::Axis;

/// Width of a trial picture, in pixels.
const TRIAL: usize = 160;
/// Radius of a close-up of the worst vertex, in diagonals.
const NEAR: f64 = 0.12;
/// Shading of a shape. Full relief shows a shape; where colours have a meaning, weaker relief keeps the colours
/// readable.
const SHAPE: Look = Look { relief: 1.0, borders: false };
const ERRORS: Look = Look { relief: 0.35, borders: false };
const KINDS: Look = Look { relief: 0.6, borders: true };
/// Radius of a ring around a vertex, as a share of the picture's width.
const RING: f64 = 0.032;
/// A surface hides a vertex if it is nearer to the camera by more than this, in diagonals.
const SLACK: f64 = 0.01;
/// Colour of clay.
const CLAY: Colour = [0xd8, 0xcf, 0xc3];

/// Options of a report's pictures; missing values are chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureOptions {
    /// Width of a picture, in pixels.
    pub width: usize,
    /// Azimuth and elevation in degrees, as in [`View`]. The default is a view from the front or the back, whichever
    /// shows more of the error.
    pub from: Option<(f64, f64)>,
}

impl Default for PictureOptions {
    fn default() -> Self {
        Self { width: 620, from: None }
    }
}

/// Draws a report's pictures.
pub(super) struct Pictures<'a> {
    /// The models and their errors.
    pub(super) comparison: &'a Comparison<'a>,
    width: usize,
    /// Direction of the camera.
    pub(super) view: View,
    /// Index of the measured frame with the model's largest RMS error.
    pub(super) worst: usize,
}

/// A posed mesh of the character.
pub(super) struct Shape {
    /// Name of the shape.
    pub(super) name: String,
    /// Positions of the E engine vertices.
    pub(super) positions: Vec<[f64; 3]>,
    /// E normals: a model's as the runtime returns them, a baseline's by cofactors, and the true normals for the truth.
    normals: Vec<[f64; 3]>,
}

/// Colours of the vertices.
pub(super) enum Paint<'a> {
    /// One colour.
    Clay,
    /// Errors on a scale, with their unit.
    Heat(&'a [f64], Scale, &'static str),
    /// Kinds of vertices.
    Kinds(&'a [Colour]),
}

impl<'a> Pictures<'a> {
    /// Finds the worst frame and the camera's direction.
    pub(super) fn new(comparison: &'a Comparison<'a>, options: &PictureOptions) -> Self {
        let space = comparison.source.examples.space;
        let up = space.up.unwrap_or_else(|| upright(comparison.source.examples));
        let (azimuth, elevation) = options.from.unwrap_or_default();
        let worst = comparison.model.measured.worst();
        let width = options.width;
        let view = View { up, handedness: space.handedness, azimuth, elevation };
        let mut pictures = Self { comparison, width, view, worst };
        if options.from.is_none() {
            pictures.view = pictures.best_side();
        }
        pictures
    }

    /// Returns the shapes of one frame: the truth, then each of the series.
    ///
    /// # Errors
    /// The runtime refuses the frame.
    pub(super) fn frame(&self, frame: usize, series: &[Series<'_>]) -> Result<Vec<Shape>, Error> {
        let examples = self.comparison.source.examples;
        let mut shapes = vec![self.truth(frame)];
        for series in series {
            let vertices = 0..examples.surface().engine_len();
            let skinned: Vec<_> = match series.skin {
                SeriesSkin::Baseline(baseline) => {
                    vertices.map(|vertex| baseline.vertex(examples, frame, vertex)).collect()
                }
                SeriesSkin::Model(model) => {
                    let skin = skin(&model.character, examples, frame)?;
                    vertices.map(|vertex| skin.vertex(vertex)).collect()
                }
            };
            let unit = |n: Vector3<f64>| n.try_normalize(0.0).unwrap_or_default();
            let positions = skinned.iter().map(|(x, _)| (*x).into()).collect();
            let normals = skinned.iter().map(|(_, n)| unit(*n).into()).collect();
            shapes.push(Shape { name: series.name.to_owned(), positions, normals });
        }
        Ok(shapes)
    }

    /// Returns the rest pose.
    pub(super) fn rest(&self) -> Shape {
        let examples = self.comparison.source.examples;
        let surface = examples.surface();
        let (positions, normals) = (surface.copied(&examples.rest), surface.normals());
        Shape { name: "rest".to_owned(), positions, normals }
    }

    /// Returns a camera that shows all of the shapes.
    pub(super) fn whole(&self, shapes: &[&Shape]) -> Camera {
        let all = shapes.iter().flat_map(|shape| &shape.positions);
        Camera::fit(&self.following(shapes[0]), all, self.width)
    }

    /// Returns a camera that shows the surroundings of a vertex from the side with most of the visible error.
    pub(super) fn near(&self, shape: &Shape, vertex: usize, errors: &[f64]) -> Camera {
        let surface = self.comparison.source.examples.surface();
        let centre = shape.positions[surface.first_copies()[vertex]];
        let errors = surface.copied(errors);
        let radius = NEAR * self.comparison.model.measured.diagonal;
        let weight = |(p, error): (&[f64; 3], &f64)| {
            let squared = (0..3).map(|k| (p[k] - centre[k]).powi(2)).sum::<f64>();
            error * error / (1.0 + squared / (0.2 * radius).powi(2)).powi(2)
        };
        let weights: Vec<f64> = shape.positions.iter().zip(&errors).map(weight).collect();
        let following = self.following(shape);
        let views = (0..12).flat_map(|turn| {
            let azimuth = following.azimuth + 30.0 * f64::from(turn);
            [10.0, -25.0, 45.0].map(|elevation| View { azimuth, elevation, ..following })
        });
        let views: Vec<View> = views.collect();
        let side = |width| Resolution { width, height: width };
        let seen = views.par_iter().map(|view| {
            let camera = Camera::around(view, &centre, radius, side(TRIAL));
            self.mesh(shape).seen(&weights, &camera)
        });
        let best = largest(&seen.collect::<Vec<_>>());
        Camera::around(&views[best], &centre, radius, side(self.width))
    }

    /// Draws a picture with a caption and, around a given vertex, a ring. The ring is broken if the vertex is hidden.
    ///
    /// # Errors
    /// The picture cannot be encoded.
    pub(super) fn take(
        &self,
        shape: &Shape,
        paint: &Paint<'_>,
        camera: &Camera,
        ring: Option<usize>,
        caption: &str,
    ) -> Result<String, Error> {
        let surface = self.comparison.source.examples.surface();
        let picture = self.draw(shape, paint, camera);
        let mut over = String::new();
        if let Some(vertex) = ring.map(|vertex| surface.first_copies()[vertex]) {
            let [x, y, _] = camera.project(&shape.positions[vertex]);
            let Resolution { width, height } = camera.size;
            let ring = RING * width as f64;
            let slack = SLACK * self.comparison.model.measured.diagonal;
            let is_hidden = self.mesh(shape).hides(vertex, slack, camera);
            let class = if is_hidden { "hidden" } else { "seen" };
            over = format!(
                "<svg viewBox=\"0 0 {width} {height}\" aria-hidden=\"true\"><g \
                 class=\"{class}\"><circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{ring:.1}\"/><circle cx=\"{x:.1}\" \
                 cy=\"{y:.1}\" r=\"{ring:.1}\"/></g></svg>"
            );
        }
        let bar = match paint {
            Paint::Heat(_, scale, unit) => colour_bar(scale, unit),
            _ => String::new(),
        };
        let under = bar + &text(caption);
        figure(&picture, caption, &over, &under)
    }

    /// Draws a shape.
    pub(super) fn draw(&self, shape: &Shape, paint: &Paint<'_>, camera: &Camera) -> Picture {
        let mesh = self.mesh(shape);
        let surface = self.comparison.source.examples.surface();
        match paint {
            Paint::Clay => mesh.draw(&vec![CLAY; shape.positions.len()], SHAPE, camera),
            Paint::Kinds(colours) => mesh.draw(&surface.copied(colours), KINDS, camera),
            Paint::Heat(errors, scale, _) => {
                let colours: Vec<Colour> = errors.iter().map(|e| scale.colour(*e)).collect();
                mesh.draw(&surface.copied(&colours), ERRORS, camera)
            }
        }
    }

    /// Returns the true mesh of a frame, with its true normals.
    pub(super) fn truth(&self, frame: usize) -> Shape {
        let examples = self.comparison.source.examples;
        let positions = examples.surface().copied(examples.frame(frame));
        let normals = TrueNormals::new(examples.surface()).posed(examples.frame(frame));
        Shape { name: "truth".to_owned(), positions, normals }
    }

    fn mesh<'b>(&'b self, shape: &'b Shape) -> ShadedMesh<'b> {
        let Shape { positions, normals, .. } = shape;
        let triangles = self.comparison.source.examples.surface().engine_triangles();
        ShadedMesh { positions, normals, triangles }
    }

    /// Returns the view, rotated with the character.
    fn following(&self, shape: &Shape) -> View {
        let examples = self.comparison.source.examples;
        self.view.following(&examples.surface().copied(&examples.rest), &shape.positions)
    }

    /// Returns the view from the front or the back, along the smaller extent, that shows most of the error. Each side
    /// is tried from a little left and a little right.
    fn best_side(&self) -> View {
        let (examples, measured) =
            (self.comparison.source.examples, &self.comparison.model.measured);
        let level = View { elevation: 0.0, azimuth: 0.0, ..self.view };
        let [width, depth] = [0, 2].map(|axis| {
            let along = level.axes()[axis];
            let places = examples.rest.iter().map(|p| along.dot(&Vector3::from(*p)));
            let [low, high] = ends(&places.collect::<Vec<_>>());
            high - low
        });
        let front = if depth <= width { 0.0 } else { 90.0 };
        let views: Vec<View> = [25.0, -25.0, 205.0, 155.0]
            .map(|turn| View { azimuth: front + turn, elevation: 8.0, ..self.view })
            .into();
        let squares: Vec<f64> = measured.percent_in(self.worst).iter().map(|e| e * e).collect();
        let squares = examples.surface().copied(&squares);
        let shape = self.truth(measured.frames[self.worst].frame);
        let rest = examples.surface().copied(&examples.rest);
        let seen = views.par_iter().map(|view| {
            let view = view.following(&rest, &shape.positions);
            let camera = Camera::fit(&view, &shape.positions, TRIAL);
            self.mesh(&shape).seen(&squares, &camera) / (camera.scale * camera.scale)
        });
        views[largest(&seen.collect::<Vec<_>>())]
    }
}

/// Guesses the up axis: z if the character is longest along z, else y.
fn upright(examples: &Examples) -> Axis {
    let [low, high] = examples.bounds();
    let extent = [0, 1, 2].map(|axis| high[axis] - low[axis]);
    if extent[2] > extent[0] && extent[2] > extent[1] { Axis::Z } else { Axis::Y }
}
