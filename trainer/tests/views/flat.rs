//! A renderer of pictures with a mesh, as tools for 2-D rigs draw them, and a set in layers for such tools.

use super::common::Folder;
use serde_json::{Value, json};
use sinew_runtime::Model;
use sinew_runtime::format::Space;
use sinew_trainer::bake::bake;
use sinew_trainer::page::camera::Resolution;
use sinew_trainer::page::picture::Picture;
use sinew_trainer::views::fit::FitOptions;
use sinew_trainer::views::model::ViewsModel;
use sinew_trainer::views::model::parts;
use sinew_trainer::views::player::Player;
use sinew_trainer::views::set::{Values, ViewSet, read};
use sinew_trainer::views::train::{Trained, train};
use std::path::{Path, PathBuf};

/// A picture with a mesh, in one frame.
#[derive(Clone)]
pub(crate) struct Sheet {
    /// Positions of the vertices on the screen, pixels, y down.
    pub(crate) places: Vec<[f64; 2]>,
    /// Positions of the vertices in the picture, pixels.
    pub(crate) texels: Vec<[f64; 2]>,
    pub(crate) triangles: Vec<[usize; 3]>,
    /// Picture with straight alpha.
    pub(crate) picture: Picture,
    pub(crate) opacity: f64,
    /// Indices of the masking sheets. The sheet is visible where one of them has an alpha above a half, or everywhere
    /// without masks.
    pub(crate) masks: Vec<usize>,
}

impl Sheet {
    /// Draws the sheet alone, without its opacity: the premultiplied colour at the centre of each pixel.
    fn pixels(&self, [width, height]: [usize; 2]) -> Vec<[f64; 4]> {
        let mut out = vec![None; width * height];
        for corners in &self.triangles {
            let [a, b, c] = corners.map(|at| self.places[at]);
            let side = |a: [f64; 2], b: [f64; 2], p: [f64; 2]| {
                (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
            };
            let whole = side(a, b, c);
            let range = |axis: usize, len: usize| {
                let own = [a, b, c].map(|place| place[axis]);
                let low = own.into_iter().fold(f64::INFINITY, f64::min).max(0.0);
                let high = own.into_iter().fold(0.0, f64::max).min(len as f64);
                low as usize..high.ceil() as usize
            };
            for (y, x) in range(1, height).flat_map(|y| range(0, width).map(move |x| (y, x))) {
                let place = [x as f64 + 0.5, y as f64 + 0.5];
                let shares = [side(b, c, place), side(c, a, place), side(a, b, place)];
                let shares = shares.map(|share| share / whole);
                if shares.iter().all(|share| *share >= -1e-9) {
                    let texel = |axis: usize| {
                        let own = corners.iter().zip(shares);
                        own.map(|(&at, share)| share * self.texels[at][axis]).sum::<f64>()
                    };
                    let own: &mut Option<[f64; 4]> = &mut out[y * width + x];
                    own.get_or_insert_with(|| sampled(&self.picture, [texel(0), texel(1)]));
                }
            }
        }
        out.into_iter().map(Option::unwrap_or_default).collect()
    }
}

/// Returns the premultiplied colour between the four nearest texels.
fn sampled(picture: &Picture, place: [f64; 2]) -> [f64; 4] {
    let Resolution { width, height } = picture.size;
    let kept = |x: f64, len: usize| (x - 0.5).clamp(0.0, (len - 1) as f64);
    let [x, y] = [kept(place[0], width), kept(place[1], height)];
    let mut out = [0.0; 4];
    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let share = (1.0 - (x.floor() + f64::from(dx) - x).abs())
            * (1.0 - (y.floor() + f64::from(dy) - y).abs());
        let column = (x as usize + dx as usize).min(width - 1);
        let row = (y as usize + dy as usize).min(height - 1);
        let texel = &picture.rgba[4 * (row * width + column)..][..4];
        let alpha = f64::from(texel[3]) / 255.0;
        for (out, x) in out.iter_mut().zip([texel[0], texel[1], texel[2], 255]) {
            *out += share * alpha * f64::from(x);
        }
    }
    out
}

/// Draws sheets over one another. Colours are premultiplied.
///
/// - `order`: indices of the sheets, the hindmost first.
pub(crate) fn draw([width, height]: [usize; 2], sheets: &[Sheet], order: &[usize]) -> Picture {
    let of = |sheet: &Sheet| sheet.pixels([width, height]);
    let all: Vec<Vec<[f64; 4]>> = sheets.iter().map(of).collect();
    let pixel = |at: usize| {
        let mut pixel = [0.0; 4];
        for &number in order {
            let sheet = &sheets[number];
            let masks = |&mask: &usize| all[mask][at][3] > 127.5;
            if sheet.opacity == 0.0 || !sheet.masks.is_empty() && !sheet.masks.iter().any(masks) {
                continue;
            }
            let own = all[number][at].map(|x| x * sheet.opacity);
            let left = 1.0 - own[3] / 255.0;
            pixel.iter_mut().zip(own).for_each(|(below, own)| *below = *below * left + own);
        }
        pixel.map(|x| x.round() as u8)
    };
    let rgba = (0..width * height).flat_map(pixel).collect();
    Picture { size: Resolution { width, height }, rgba }
}

/// Returns the PSNR of pictures with premultiplied colours, dB.
pub(crate) fn psnr(a: &Picture, b: &Picture) -> f64 {
    assert_eq!(a.size, b.size);
    let apart = a.rgba.iter().zip(&b.rgba).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2));
    10.0 * (255.0f64.powi(2) * a.rgba.len() as f64 / apart.sum::<f64>()).log10()
}

/// Returns the mean and the smallest of PSNR figures.
pub(crate) fn mean_and_worst(all: &[f64]) -> [f64; 2] {
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    [mean, all.iter().copied().fold(f64::INFINITY, f64::min)]
}

/// Returns the picture that the runtime draws.
pub(crate) fn drawn(file: &Model<Vec<u8>>, values: &Values) -> Picture {
    let player = Player::new(file, None).unwrap();
    player.draw(&player.play(values).unwrap()).unwrap().0
}

/// Returns the layer and the key view in the name of a sheet, and the vertices at places in its picture.
pub(crate) fn found(
    model: &ViewsModel,
    name: &str,
    picture: &Picture,
    texels: &[[f64; 2]],
) -> (usize, usize, Vec<usize>) {
    let of = |layer: usize, view: usize| {
        let (layer, key) = (&model.layers[layer].name, &model.keys[view].name);
        let is_one = model.layers.len() == 1;
        name.replace(' ', "-") == if is_one { key.clone() } else { format!("{layer}-{key}") }
    };
    let all = (0..model.layers.len())
        .flat_map(|layer| (0..model.keys.len()).map(move |view| (layer, view)));
    let (layer, view) = all.into_iter().find(|&(layer, view)| of(layer, view)).unwrap();
    let (shown, corner) = model.keys[view].pictures[layer].as_ref().unwrap();
    assert_eq!(shown, picture, "{name}");
    let corner = corner.map(|x| x as f64);
    let places = |&vertex: &usize| model.mesh.vertices[vertex].at(&model.keys[view].points);
    let mut vertices: Vec<usize> =
        model.mesh.layers[layer].iter().flat_map(|own| own.vertices()).copied().collect();
    vertices.sort_unstable();
    vertices.dedup();
    let nearest = |texel: &[f64; 2]| {
        let apart = |vertex: &usize| {
            let place = places(vertex);
            (place[0] - corner[0] - texel[0]).hypot(place[1] - corner[1] - texel[1])
        };
        let nearest = vertices.iter().min_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap();
        assert!(apart(nearest) < 1e-2, "{}", apart(nearest));
        *nearest
    };
    (layer, view, texels.iter().map(nearest).collect())
}

/// A square of [`in_layers`].
struct Square {
    name: &'static str,
    /// Left, top, right and bottom in the first view.
    sides: [f64; 4],
    /// Shift from the first to the second view.
    moves: [f64; 2],
    /// Colours in both views.
    colours: [[u8; 4]; 2],
}

const SQUARES: [Square; 4] = [
    Square {
        name: "back",
        sides: [8.0, 8.0, 84.0, 84.0],
        moves: [4.0, 2.0],
        colours: [[200, 40, 40, 255], [40, 160, 80, 255]],
    },
    Square {
        name: "face",
        sides: [24.0, 24.0, 64.0, 64.0],
        moves: [8.0, 0.0],
        colours: [[240, 220, 200, 255], [220, 240, 160, 255]],
    },
    Square {
        name: "eye",
        sides: [54.0, 36.0, 78.0, 52.0],
        moves: [8.0, 0.0],
        colours: [[20, 30, 60, 255], [60, 30, 120, 255]],
    },
    Square {
        name: "arm",
        sides: [16.0, 52.0, 44.0, 80.0],
        moves: [4.0, -12.0],
        colours: [[250, 180, 20, 255], [20, 120, 250, 255]],
    },
];

/// Width and height of the screen of [`in_layers`].
pub(crate) const SCREEN: [usize; 2] = [96, 96];

impl Square {
    /// Returns the shift of the square in a view.
    fn moved(&self, view: usize) -> [f64; 2] {
        self.moves.map(|by| by * view as f64)
    }

    fn corners(&self, view: usize) -> [[f64; 2]; 4] {
        let ([left, top, right, bottom], [dx, dy]) = (self.sides, self.moved(view));
        let corners = [[left, top], [right, top], [right, bottom], [left, bottom]];
        corners.map(|[x, y]| [x + dx, y + dy])
    }

    fn picture(&self, view: usize) -> Picture {
        let ([left, top, right, bottom], [dx, dy]) = (self.sides, self.moved(view));
        let [width, height] = SCREEN;
        let pixel = |at: usize| {
            let [x, y] = [(at % width) as f64 - dx, (at / width) as f64 - dy];
            let is_inside = (left..right).contains(&x) && (top..bottom).contains(&y);
            if is_inside { self.colours[view] } else { [0; 4] }
        };
        let rgba = (0..width * height).flat_map(pixel).collect();
        Picture { size: Resolution { width, height }, rgba }
    }
}

/// Writes a set of four squares at x = 0 and x = 1. The face clips the eye, which extends beyond its edge. The arm
/// moves from behind the face to the front, and fades to a half.
pub(crate) fn in_layers(folder: &Folder) -> PathBuf {
    let mut train = Vec::new();
    for view in 0..2 {
        let mut layers = serde_json::Map::new();
        for square in &SQUARES {
            let file = format!("{}{view}.png", square.name);
            std::fs::write(folder.path(&file), square.picture(view).png().unwrap()).unwrap();
            let (order, opacity) = ([0.5, 3.0][view], [1.0, 0.5][view]);
            let own = match square.name {
                "arm" => json!({ "image": file, "order": order, "opacity": opacity }),
                _ => json!(file),
            };
            layers.insert(square.name.to_owned(), own);
        }
        let points: Vec<[f64; 2]> = SQUARES.iter().flat_map(|own| own.corners(view)).collect();
        train.push(json!({ "x": view, "points": points, "layers": layers }));
    }
    let layer = |(number, square): (usize, &Square)| {
        let points: Vec<usize> = (4 * number..4 * number + 4).collect();
        match square.name {
            "eye" => json!({ "name": square.name, "points": points, "clip": "face" }),
            name => json!({ "name": name, "points": points }),
        }
    };
    let layers: Vec<Value> = SQUARES.iter().enumerate().map(layer).collect();
    let set = json!({ "image_size": SCREEN, "layers": layers, "train": train });
    let file = folder.path("views.json");
    std::fs::write(&file, set.to_string()).unwrap();
    file
}

/// Trains a set, and bakes it.
pub(crate) fn made(file: &Path) -> (Trained, Model<Vec<u8>>) {
    made_of(&read(file, None).unwrap())
}

/// Trains a set.
pub(crate) fn made_of(set: &ViewSet) -> (Trained, Model<Vec<u8>>) {
    let trained = train(set, FitOptions::default()).unwrap();
    let bytes = bake(Space::default(), &parts(&trained.model).unwrap()).unwrap();
    (trained, Model::from_bytes(bytes).unwrap())
}

#[test]
fn the_renderer_of_the_tests_finds_wrong_pictures() {
    let folder = Folder::new("flat");
    let (_, file) = made(&in_layers(&folder));
    let at = |x: f64| drawn(&file, &[("x".to_owned(), x)].into());
    assert!(psnr(&at(0.0), &at(0.0)).is_infinite());
    assert!(psnr(&at(0.0), &at(0.25)) < 25.0);
}
