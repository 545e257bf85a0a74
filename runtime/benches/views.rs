//! Prints the time of frames and pictures of views: `cargo bench -p sinew-runtime --bench views`.
//! One core; medians.
//!
//! The object has the size of a face of `ict-views`: 158 points, one layer, 27 key views, and a map
//! of 27 centres and 30 terms. Its elements fill a picture of 256 x 256 pixels, from one key view
//! or from the largest number of blended views.
#![allow(missing_docs, reason = "a program")]

use models::{KernelContent, Pieces, Rng, TextureContent, ViewContent, ViewsContent};
use sinew_runtime::kernel::{Kernel, NO_TERM, OutputKind, OutputRow};
use sinew_runtime::views::{Layer, NO_VERTEX, RenderScratch};
use sinew_runtime::{CallError, FileError, Frame, FrameJob, Model, RenderJob, Views};
use std::hint::black_box;
use std::time::Instant;

const RUNS: usize = 401;
const SIZE: usize = 256;
/// Points per row, and rows, of the textured grid. Two more points belong to no element.
const GRID: [usize; 2] = [12, 13];
const POINTS: usize = GRID[0] * GRID[1] + 2;
const VIEWS: usize = 27;
const INPUTS: usize = 6;
const TERMS: usize = 30;

#[derive(Debug)]
#[expect(dead_code, reason = "shown where main fails")]
enum Refused {
    File(FileError),
    Call(CallError),
}

/// Returns a point's place, in pixels of the screen and in texels of the texture.
fn place(point: usize) -> [f32; 2] {
    let [x, y] = [point % GRID[0], point / GRID[0]].map(|i| i as f32);
    [x * SIZE as f32 / (GRID[0] - 1) as f32, y.min(12.0) * SIZE as f32 / (GRID[1] - 1) as f32]
}

fn map() -> KernelContent {
    let m = 4 * POINTS + VIEWS + 2;
    let plain = KernelContent::plain(Kernel::Gaussian, [INPUTS, VIEWS, m]);
    let mut rng = Rng(6);
    let about = |value: usize| match (value / 3, value % 3) {
        (point, axis @ 0..2) if point < POINTS => place(point)[axis],
        (point, _) if point < POINTS => (point % 7) as f32,
        _ => 0.75,
    };
    let row = |value: usize| {
        let own = [(); VIEWS].map(|()| 0.02 * rng.unit());
        let terms = [(); TERMS - 1].map(|()| 0.02 * rng.unit());
        [&own[..], &[about(value)], &terms].concat()
    };
    let coefficients = (0..m).map(row).collect();
    let free = plain.outputs[0].1;
    let vector =
        OutputRow { kind: OutputKind::Vector3, range: (0.0, 0.0), neutral: [0.0; 4], ..free };
    let outputs = (0..2 * POINTS + VIEWS + 2)
        .map(|output| (String::new(), if output < POINTS { vector } else { free }));
    let first = [[NO_TERM; 2]].into_iter();
    let terms = first.chain((1..TERMS as u16).map(|term| [term / 6, term % INPUTS as u16]));
    KernelContent { outputs: outputs.collect(), terms: terms.collect(), coefficients, ..plain }
}

fn object(is_quads: bool, flags: u32) -> ViewsContent {
    let corner = |x: usize, y: usize| (y * GRID[0] + x) as u16;
    let cells = (0..GRID[1] - 1).flat_map(|y| (0..GRID[0] - 1).map(move |x| (x, y)));
    let elements = cells.flat_map(|(x, y)| {
        let ring = [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)];
        let [a, b, c, d] = ring;
        if is_quads { vec![ring] } else { vec![[a, b, c, NO_VERTEX], [a, c, d, NO_VERTEX]] }
    });
    let mut rng = Rng(9);
    let mut byte = || (rng.next_u64() >> 56) as u8;
    let texels = (0..SIZE * SIZE).map(|_| [byte(), byte(), byte(), 255]).collect();
    let view = ViewContent {
        name: String::new(),
        textures: vec![0],
        texels: (0..POINTS).map(place).collect(),
        references: (0..POINTS).map(place).collect(),
        visible: vec![true; POINTS],
        deformation: None,
    };
    let texture = TextureContent { width: SIZE as u32, height: SIZE as u32, texels };
    let mut out = ViewsContent::plain(elements.collect(), vec![view; VIEWS], texture);
    out.layers[0].flags = flags;
    out
}

/// Returns the median time of the runs, in microseconds.
fn median(mut run: impl FnMut(usize) -> Result<(), CallError>) -> Result<f64, Refused> {
    let mut times = Vec::new();
    for number in 0..RUNS {
        let before = Instant::now();
        run(number).map_err(Refused::Call)?;
        times.push(1e6 * before.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    Ok(times[RUNS / 2])
}

fn main() -> Result<(), Refused> {
    for (is_quads, has_depth) in [(false, false), (false, true), (true, false), (true, true)] {
        let mut pieces = Pieces::kernels(&[map()]);
        pieces.add_views(&object(is_quads, if has_depth { Layer::DEPTH } else { 0 }));
        let model = Model::from_bytes(pieces.bytes()).map_err(Refused::File)?;
        let Some(views) = model.first::<Views>() else { return Ok(()) };
        let Some(map) = model.map_of(&views, 0) else { return Ok(()) };
        let mut scratch = vec![0.0; views.counts().frame_scratch_len(&map.counts())];
        let (mut points, mut visibility) = (vec![[0.0; 3]; POINTS], vec![0.0; POINTS]);
        let (mut scores, mut layers) = (vec![0.0; VIEWS], [[0.0; 2]]);
        let frame = median(|number| {
            let parameters = [number as f32 / RUNS as f32; INPUTS];
            let (points, visibility) = (points.as_mut_slice(), visibility.as_mut_slice());
            let mut out = Frame { points, visibility, scores: &mut scores, layers: &mut layers };
            black_box(
                FrameJob { views, map, parameters: &parameters }.run(&mut scratch, &mut out)?,
            );
            Ok(())
        })?;
        let name = if is_quads { "quads" } else { "triangles" };
        let order_name = if has_depth { "by depth" } else { "painted" };
        println!("{} {name}, {order_name}: frame {frame:.1} us", views.element_len());
        for shown in [1, 2, 8] {
            let scores: Vec<f32> =
                (0..VIEWS).map(|view| f32::from(u8::from(view < shown))).collect();
            let layers = &[[1.0, 0.0]];
            let job = RenderJob {
                views,
                points: &points,
                visibility: &visibility,
                scores: &scores,
                layers,
                width: SIZE,
            };
            let mut pixels = vec![[0; 4]; SIZE * SIZE];
            let mut vertices = vec![[0.0; 3]; views.vertex_len()];
            let (mut order, mut depths) = (vec![0; views.order_len()], vec![0.0; SIZE * SIZE]);
            let picture = median(|_| {
                let (vertices, order) = (vertices.as_mut_slice(), order.as_mut_slice());
                let scratch = RenderScratch {
                    vertices,
                    order,
                    depths: &mut depths,
                    group: &mut [],
                    clips: &mut [],
                };
                black_box(job.run(scratch, &mut pixels)?);
                Ok(())
            })?;
            let drawn = pixels.iter().filter(|pixel| pixel[3] > 0).count();
            println!("  picture of {shown} key views: {picture:.0} us, {drawn} pixels");
        }
    }
    Ok(())
}
