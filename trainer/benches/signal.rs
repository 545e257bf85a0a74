//! Prints the time to enlarge 256 x 256 pixels of three channels to 512 x 512 on one thread. Compares our filter, in
//! f64 and by the runtime from a file, with `fast_image_resize`. Each time is the minimum of many runs.
//!
//! `cargo bench -p sinew-trainer --bench signal`

use anyhow::Context;
use fast_image_resize::images::Image as Pixels;
use fast_image_resize::{FilterType, PixelType, ResizeAlg, ResizeOptions, Resizer};
use sinew_runtime::filter::Samples;
use sinew_runtime::format::Space;
use sinew_runtime::{Filter, Model};
use sinew_trainer::bake::bake;
use sinew_trainer::signal::choose::{TAPS, of_images};
use sinew_trainer::signal::grid::{Grid, GridFilter, Sample};
use sinew_trainer::signal::image::Image;
use sinew_trainer::signal::kriging::Mean;
use sinew_trainer::signal::kriging::Process;
use sinew_trainer::signal::model::FilterModel;
use sinew_trainer::signal::model::part;
use std::hint::black_box;
use std::time::{Duration, Instant};

const SIDE: usize = 256;
const CHANNELS: usize = 3;
const RUNS: usize = 40;

fn main() -> anyhow::Result<()> {
    let bytes: Vec<u8> = (0..SIDE * SIDE * CHANNELS).map(|i| (i * i % 251) as u8).collect();
    let samples = bytes.iter().map(|byte| f64::from(*byte)).collect();
    let image = Image {
        width: SIDE,
        height: SIDE,
        channels: CHANNELS,
        has_alpha: false,
        most: 255.0,
        samples,
    };
    let process = Process { covariance: of_images(), mean: Mean::Constant, noise: 0.0 };
    let grid = Grid { factor: 2, taps: TAPS, sample: Sample::Average };
    let filter = GridFilter::new(&process, grid)?;
    image.finer(&filter)?;
    print("ours, f64", least(|| black_box(image.finer(&filter)).is_ok()));

    let model = FilterModel { name: "image".to_owned(), filter, variance: 1.0, fit: None };
    let file = bake(Space::default(), &[part(&model, false)?])?;
    let file = Model::from_bytes(&file)?;
    let filter = file.first::<Filter>().context("no filter")?;
    let narrow: Vec<f32> = bytes.iter().map(|byte| f32::from(*byte)).collect();
    let (mut tall, mut fine) = (vec![0.0; 2 * narrow.len()], vec![0.0; 4 * narrow.len()]);
    let columns = Samples { signal_len: 1, sample_len: SIDE, lane_len: SIDE * CHANNELS };
    let rows = Samples { signal_len: 2 * SIDE, sample_len: SIDE, lane_len: CHANNELS };
    let runtime = least(|| {
        let done = filter
            .apply(columns, &narrow, &mut tall)
            .and_then(|()| filter.apply(rows, &tall, &mut fine));
        black_box(&fine);
        done.is_ok()
    });
    print("ours, the runtime", runtime);

    let coarse = Pixels::from_vec_u8(SIDE as u32, SIDE as u32, bytes, PixelType::U8x3)?;
    let mut fine = Pixels::new(2 * SIDE as u32, 2 * SIDE as u32, PixelType::U8x3);
    let mut resizer = Resizer::new();
    for (name, kind) in
        [("Catmull-Rom", FilterType::CatmullRom), ("Lanczos3", FilterType::Lanczos3)]
    {
        let options = ResizeOptions::new().resize_alg(ResizeAlg::Convolution(kind));
        let own = least(|| black_box(resizer.resize(&coarse, &mut fine, &options)).is_ok());
        print(&format!("fast_image_resize, {name}, 8 bits"), own);
    }
    Ok(())
}

fn least(mut run: impl FnMut() -> bool) -> Duration {
    let time = |_| {
        let start = Instant::now();
        assert!(run(), "it was measured before that it can be done");
        start.elapsed()
    };
    (0..RUNS).map(time).min().unwrap_or_default()
}

fn print(name: &str, time: Duration) {
    println!("{name:<36}{:>8.2} ms", 1e3 * time.as_secs_f64());
}
