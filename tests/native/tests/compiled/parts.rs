//! Shapes, priors, pins, views and filters of sinew.hpp, compared with the runtime.

use crate::compiled::host::{CXX, GCC, SANITIZERS, compile, static_library};
use crate::compiled::output;
use models::{FACE_NAME, VIEWED_NAMES, golden_path};
use sinew_runtime::filter::Samples;
use sinew_runtime::skin::Output;
use sinew_runtime::views::RenderScratch;
use sinew_runtime::{
    Filter, Frame, FrameJob, Model, Pin, PinJob, Pins, Prior, RenderJob, ShapesJob, Skin, Views,
};
use std::process::Command;

#[test]
fn cpp_has_the_bits_of_faces_views_and_filters() {
    let library = static_library();
    let flags = [&SANITIZERS[..], &["-fno-exceptions", &library]].concat();
    let program = compile(
        "g++",
        CXX,
        concat!(env!("CARGO_MANIFEST_DIR"), "/tests/compiled/parts.cpp"),
        "parts",
        &flags,
    );
    let paths = [FACE_NAME, VIEWED_NAMES[1], "filter-11.snw"].map(golden_path);
    let found = output(Command::new(program).args(&paths), GCC);
    let [face_file, views_file, filter_file] = paths.map(|path| std::fs::read(path).unwrap());
    assert_eq!(found, face(&face_file) + &views(&views_file) + &filter(&filter_file));
}

/// Writes a line of the program's output: a label and the FNV-1a hash of bytes.
fn line(what: &str, bytes: impl IntoIterator<Item = u8>) -> String {
    let hash = bytes.into_iter().fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    format!("{what} {hash:016x}\n")
}

fn bytes(floats: &[f32]) -> impl Iterator<Item = u8> {
    floats.iter().flat_map(|x| x.to_bits().to_le_bytes())
}

fn face(file: &[u8]) -> String {
    let model = Model::from_bytes(file).unwrap();
    let (prior, skin) = (model.first::<Prior>().unwrap(), model.first::<Skin>().unwrap());
    let n = prior.shape_len();
    let mut out = format!("prior {} of {n} shapes\n", prior.name());
    out += &format!("shape {}\n", skin.shape_name(1).unwrap());
    let mut weights = vec![0.25; n];
    let place = skin.place(2, &[], &weights).unwrap();
    out += &line("place", bytes(&place));
    let [x, y, z] = place;
    let mut pins = Pins::<2>::new();
    pins.add(Pin::new(2, [x + 0.125, y, z])).unwrap();
    let screen = [[1.0, 0.0, 0.0, 0.5], [0.0, 1.0, 0.5, 0.0]];
    pins.add(Pin::on_screen(7, screen, [0.5, 0.25]).with_stiffness(2.0)).unwrap();
    let mut scratch = vec![0.0; prior.counts().pin_scratch_len(6)];
    let edit = PinJob::new(prior, skin, pins.list()).run(&mut scratch, &mut weights).unwrap();
    assert!(edit.round_len > 0 && weights.iter().any(|weight| *weight != 0.25));
    out += &line("pinned", bytes(&weights));
    out += &format!("rounds {}, unreachable {}\n", edit.round_len, edit.unreachable_len);
    let mut positions = vec![0.0; 3 * skin.vertex_len()];
    let floats = Output::new(&mut positions, 3);
    let job = ShapesJob::new(skin, &weights).positions(floats);
    job.run().unwrap();
    out += &line("shaped", bytes(&positions));
    let bounds = skin.shaped_bounds(&[], &weights).unwrap().unwrap();
    out + &line("bounds", bytes(&[bounds.min, bounds.max].concat()))
}

fn views(file: &[u8]) -> String {
    let model = Model::from_bytes(file).unwrap();
    let views = model.first::<Views>().unwrap();
    let map = model.map_of(&views, 0).unwrap();
    let mut out = format!("views {}, map {}\n", views.name(), map.name());
    let [width, height] = views.size();
    let (mut points, mut visibility) =
        (vec![[0.0; 3]; views.point_len()], vec![0.0; views.point_len()]);
    let (mut scores, mut layers) = (vec![0.0; views.view_len()], vec![[0.0; 2]; views.layer_len()]);
    out += &format!("screen {width} x {height}, layers {}\n", layers.len());
    let mut scratch = vec![0.0; views.counts().frame_scratch_len(&map.counts())];
    for step in 0..8 {
        let mut frame = Frame::new(&mut points, &mut visibility, &mut scores, &mut layers);
        let parameters = [0.25 * step as f32 - 1.0, 0.125];
        let found =
            FrameJob { views, map, parameters: &parameters }.run(&mut scratch, &mut frame).unwrap();
        out += &line("points", bytes(points.as_flattened()));
        out += &line("layers", bytes(layers.as_flattened()));
        out += &format!("view {}, confidence {:.6}\n", found.view, found.confidence);
    }
    let (points, visibility, scores, layers) = (&points, &visibility, &scores, &layers);
    let job = RenderJob { views, points, visibility, scores, layers, width };
    let mut pixels = vec![[9; 4]; width * height];
    let scratch = RenderScratch {
        vertices: &mut vec![[0.0; 3]; views.vertex_len()],
        order: &mut vec![0; views.order_len()],
        depths: &mut vec![0.0; width * height],
        group: &mut vec![[0; 4]; width * height],
        clips: &mut vec![0; width * height],
    };
    let drawn = job.run(scratch, &mut pixels).unwrap();
    assert!(drawn.element_len > 0);
    out += &line("picture", pixels.iter().flatten().copied());
    out + &format!("drawn {}\n", drawn.element_len)
}

fn filter(file: &[u8]) -> String {
    let model = Model::from_bytes(file).unwrap();
    let filter = model.named::<Filter>("sensor").unwrap();
    let shape = Samples { signal_len: 2, sample_len: 7, lane_len: 3 };
    let samples: Vec<f32> = (0..2 * 7 * 3).map(|i| 0.25 * (i % 5) as f32 - 0.5).collect();
    let mut fine = vec![0.0; filter.factor() * samples.len()];
    filter.apply(shape, &samples, &mut fine).unwrap();
    line("fine", bytes(&fine))
}
