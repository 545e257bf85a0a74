//! Pictures of a face with its pins.

use super::baked::{BakedFace, Shaped};
use crate::formats::Mesh;
use crate::page::camera::{Camera, View};
use crate::page::colour::{Colour, Scale};
use crate::page::drawing::Drawing;
use crate::page::picture::Picture;
use crate::page::render::{Look, ShadedMesh};
use sinew_runtime::format::{Axis, Space};

/// Colours of the face, of pins and of their targets.
const CLAY: Colour = [0xd8, 0xcf, 0xc3];
const PIN: Colour = [0xd0, 0x30, 0x30];
const TARGET: Colour = [0xff, 0xff, 0xff];
/// Contrast of the shading: for clay, and for heat maps.
const RELIEF: [f64; 2] = [1.0, 0.35];
/// Radius of a pin and width of the line to its target: pixels, plus a fraction of the picture's width.
const SIZES: [(f64, f64); 2] = [(3.0, 0.006), (1.5, 0.002)];

/// Colouring of a face.
pub enum Paint<'a> {
    /// One colour.
    Clay,
    /// A heat map: one number per vertex.
    Heat(&'a [f64], Scale),
}

/// Camera for pictures of one face.
pub struct Photographer<'a> {
    mesh: &'a Mesh,
    camera: Camera,
}

impl<'a> Photographer<'a> {
    /// Places the camera in front of a face, so that the neutral mesh fits.
    ///
    /// - `vertices`: range of vertices that must fit, for example the face without the body.
    /// - `width`: width of the picture, pixels.
    pub fn new(
        face: &BakedFace<'_>,
        space: &Space,
        mesh: &'a Mesh,
        vertices: std::ops::Range<usize>,
        width: usize,
    ) -> Self {
        let up = space.up.unwrap_or(Axis::Y);
        let view = View { up, handedness: space.handedness, azimuth: AZIMUTH, elevation: 0.0 };
        let rest: Vec<[f64; 3]> = vertices
            .map(|v| face.skin.rest_position(v).unwrap_or_default().map(f64::from))
            .collect();
        Self { mesh, camera: Camera::fit(&view, &rest, width) }
    }

    /// Returns the projection from a place (x, y, z, 1) to pixels from the upper left.
    pub fn projection(&self) -> [[f64; 4]; 2] {
        let [origin_x, origin_y, _] = self.camera.project(&[0.0; 3]);
        let [right, up, _] = self.camera.axes.map(|axis| axis * self.camera.scale);
        [[right.x, right.y, right.z, origin_x], [-up.x, -up.y, -up.z, origin_y]]
    }

    /// Draws a picture.
    ///
    /// - `pins`: position and target of each pin.
    pub fn take(
        &self,
        shaped: &Shaped,
        paint: &Paint<'_>,
        pins: &[([f64; 3], [f64; 3])],
    ) -> Picture {
        let surface = self.mesh.surface();
        let positions = surface.copied(&shaped.positions);
        let normals = surface.copied(&shaped.normals);
        let triangles = surface.engine_triangles();
        let mesh = ShadedMesh { positions: &positions, normals: &normals, triangles };
        let (colours, relief) = match paint {
            Paint::Clay => (vec![CLAY; positions.len()], RELIEF[0]),
            Paint::Heat(numbers, scale) => {
                let colours: Vec<Colour> = numbers.iter().map(|x| scale.colour(*x)).collect();
                (surface.copied(&colours), RELIEF[1])
            }
        };
        let picture = mesh.draw(&colours, Look { relief, borders: false }, &self.camera);
        let size = picture.size;
        let mut drawing = Drawing::new(size.width, size.height);
        drawing.image([0.0, 0.0], picture.on_white());
        let [radius, line] = SIZES.map(|(least, share)| least + share * size.width as f64);
        for pin in pins {
            let [from, to] = [pin.0, pin.1].map(|place| {
                let [x, y, _] = self.camera.project(&place);
                [x, y]
            });
            drawing.line(vec![from, to], line, PIN);
            drawing.dot(to, radius, TARGET);
            drawing.dot(from, 0.7 * radius, PIN);
        }
        drawing.picture()
    }
}

/// Azimuth in degrees: slightly from the side, to show depth.
const AZIMUTH: f64 = 20.0;
