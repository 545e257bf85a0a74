//! Measures the share of a device's memory bandwidth that skinning reaches, and compares the costs
//! of the two APIs. All in one run, on one device. On lavapipe the program fails if it misses a
//! bar.
//!
//! `cargo run --release -p sinew-gpu --example bandwidth [-- DRIVER]`

mod copy;
mod model;

use copy::Copy;
use sinew_gpu::headless::{Device, Uploaded};
use sinew_gpu::layout::{Batch, Plan, Resource, Stage};
use sinew_gpu::{vulkan, wgpu};
use sinew_runtime::{Envelope, Model, Skin};
use std::error::Error;
use std::time::{Duration, Instant};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

const MEDIAN_OF: usize = 7;
/// Least duration of a measurement, so that the cost of submitting and waiting is negligible.
const LEAST: Duration = Duration::from_millis(100);
/// The driver for which the bars hold.
const LAVAPIPE: &str = "llvmpipe";
/// Largest ratio of wgpu's time to Vulkan's.
const WGPU_MOST: f64 = 1.3;
/// Largest relative difference between the time of an instance among many and among few.
const APART_MOST: f64 = 0.15;

fn main() -> Result<()> {
    let (wgpu, vulkan) = open(std::env::args().nth(1).as_deref())?;
    let devices: [&dyn Device; 2] = [&wgpu, &vulkan];
    let info = wgpu.info();
    println!("{}, {} {}", info.name, info.driver, info.driver_info);
    println!("medians of {MEDIAN_OF}");
    // A buffer has at most 256 MiB at downlevel limits; on hardware the output almost fills it.
    let instances = if info.software { 64 } else { 1024 };
    bandwidth(&devices, &wgpu, instances, 10_000)?;
    let ratio = side_by_side(&devices)?;
    let by_instances = by_instances(&devices)?;
    let missed = missed(ratio, &by_instances);
    if info.driver == LAVAPIPE && !missed.is_empty() {
        return Err(missed.join("; ").into());
    }
    Ok(())
}

/// Lists the missed bars. `wgpu` is the ratio of wgpu's time to Vulkan's. `by_instances` has for
/// each API the time for an instance among many over that among few.
fn missed(wgpu: f64, by_instances: &[(&str, f64)]) -> Vec<String> {
    let mut missed = Vec::new();
    if wgpu > WGPU_MOST {
        missed.push(format!(
            "wgpu takes {wgpu:.2} times as long as Vulkan, above the bar of {WGPU_MOST}"
        ));
    }
    for (api, ratio) in by_instances {
        if (ratio - 1.0).abs() > APART_MOST {
            missed.push(format!(
                "{api}: an instance among many takes {ratio:.2} times as long as among few, the bar is within {:.0} %",
                100.0 * APART_MOST
            ));
        }
    }
    missed
}

/// Opens a device through each API: with the given driver, or hardware if there is any.
fn open(driver: Option<&str>) -> Result<(wgpu::headless::Device, vulkan::headless::Device)> {
    let found = wgpu::headless::devices();
    let hardware = || found.iter().find(|info| !info.software).or(found.first());
    let driver = match driver {
        Some(driver) => driver.to_owned(),
        None => hardware().ok_or("there is no device")?.driver.clone(),
    };
    Ok((
        wgpu::headless::Device::of_driver(&driver, false)?,
        vulkan::headless::Device::of_driver(&driver, false)?,
    ))
}

/// Measures the skin stage, and a copy of as many bytes on one device.
fn bandwidth(
    devices: &[&dyn Device],
    copying: &wgpu::headless::Device,
    instances: usize,
    vertices: usize,
) -> Result<()> {
    let model = loaded(vertices)?;
    let (envelope, skin) = parts(&model)?;
    let moved = Moved::new(&envelope, &skin, instances);
    println!("\nskin, {instances} instances of {vertices} vertices, positions and normals");
    println!(
        "counted once each, however often they are read: {:.1} MB of the model, {:.1} MB of \
         palettes, {:.1} MB written",
        moved.model as f64 / 1e6,
        moved.palettes as f64 / 1e6,
        moved.written as f64 / 1e6
    );
    let rate = |seconds: f64| moved.all() as f64 / seconds / 1e9;
    // A copy reads as much as it writes.
    let copy = Copy::new(copying, moved.all() / 2)?;
    copy.time(1)?;
    let copy = each(|repeat_len| copy.time(repeat_len))?;
    println!("copied by a shader: {:.1} GB/s", rate(copy));
    println!("{:8} {:>9} {:>9} {:>7}", "", "skin ms", "GB/s", "share");
    for device in devices {
        let mut uploaded = posed(*device, &model, instances)?;
        uploaded.run(instances)?;
        let skin = each(|repeat_len| uploaded.time_stage(Stage::Skin, instances, repeat_len))?;
        println!(
            "{:8} {:9.3} {:9.1} {:6.1}%",
            device.info().api,
            1e3 * skin,
            rate(skin),
            100.0 * copy / skin
        );
    }
    Ok(())
}

/// Least number of bytes that the skin stage must move.
struct Moved {
    /// Rest positions and normals, 12 bytes each; an index of 2 bytes and a weight of 4 for each
    /// influence.
    model: usize,
    /// The palettes of all instances.
    palettes: usize,
    /// Positions and normals of all instances.
    written: usize,
}

impl Moved {
    fn new(envelope: &Envelope<'_>, skin: &Skin<'_>, instances: usize) -> Self {
        let vertices = skin.vertex_len();
        Self {
            model: vertices * (24 + 6 * skin.influence_len()),
            palettes: instances * 48 * envelope.palette_len(),
            written: instances * vertices * 24,
        }
    }

    fn all(&self) -> u64 {
        (self.model + self.palettes + self.written) as u64
    }
}

/// Measures all stages of a large batch through each API, in turns; returns the ratio of wgpu's
/// time to Vulkan's.
fn side_by_side(devices: &[&dyn Device]) -> Result<f64> {
    let (instances, vertices) = (256, 10_000);
    let model = loaded(vertices)?;
    let mut batches = Vec::new();
    for device in devices {
        batches.push(posed(*device, &model, instances)?);
    }
    let mut times = vec![Vec::new(); batches.len()];
    for _ in 0..MEDIAN_OF {
        for (batch, times) in batches.iter_mut().zip(&mut times) {
            // Warms up after the other API's turn.
            run(batch.as_mut(), instances, 1)?;
            times.push(run(batch.as_mut(), instances, 1)?);
        }
    }
    println!("\nall stages, {instances} instances of {vertices} vertices, recorded to waited for");
    let times: Vec<_> = times.into_iter().map(median).collect();
    for (device, time) in devices.iter().zip(&times) {
        println!("{:8} {:9.3} ms", device.info().api, 1e3 * time);
    }
    let ratio = times[0] / times[1];
    println!("wgpu takes {ratio:.2} times as long (bar on lavapipe: {WGPU_MOST})");
    Ok(ratio)
}

/// Measures all stages of a small and of a large number of instances, in turns. Returns for each
/// API the time for an instance among many over that among few.
fn by_instances(devices: &[&dyn Device]) -> Result<Vec<(&'static str, f64)>> {
    let (few, many, vertices) = (64, 1024, 1000);
    let model = loaded(vertices)?;
    println!("\nall stages, time for an instance of {vertices} vertices");
    println!("{:8} {:>7} us {:>7} us {:>7}", "", few, many, "ratio");
    let mut ratios = Vec::new();
    for device in devices {
        let mut small = posed(*device, &model, few)?;
        let mut large = posed(*device, &model, many)?;
        let mut times = [Vec::new(), Vec::new()];
        for round in 0..=MEDIAN_OF {
            // Both evaluate the same total of instances.
            let own = [
                run(small.as_mut(), few, many / few)? / many as f64,
                run(large.as_mut(), many, 1)? / many as f64,
            ];
            if round > 0 {
                times.iter_mut().zip(own).for_each(|(times, time)| times.push(time));
            }
        }
        let [small, large] = times.map(median);
        println!(
            "{:8} {:10.2} {:10.2} {:7.2}",
            device.info().api,
            1e6 * small,
            1e6 * large,
            large / small
        );
        ratios.push((device.info().api, large / small));
    }
    println!("(bar on lavapipe: within {:.0} %)", 100.0 * APART_MOST);
    Ok(ratios)
}

fn loaded(vertices: usize) -> Result<Model<Vec<u8>>> {
    Ok(Model::from_bytes(model::file_model(vertices).bake()?)?)
}

fn parts(model: &Model<Vec<u8>>) -> Result<(Envelope<'_>, Skin<'_>)> {
    Ok((model.first::<Envelope>().ok_or("no envelope")?, model.first::<Skin>().ok_or("no skin")?))
}

/// Uploads a batch of instances at rest.
fn posed<'d>(
    device: &'d dyn Device,
    model: &Model<Vec<u8>>,
    instances: usize,
) -> Result<Box<dyn Uploaded + 'd>> {
    let (envelope, skin) = parts(model)?;
    let batch = Batch::skinned(&envelope, &skin, instances);
    let plan = Plan::new(model, &envelope, &batch, &device.limits())?;
    let mut uploaded = device.upload(model.blob(), &plan)?;
    const REST: [f32; 12] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    uploaded.write(Resource::Poses, 0, &REST.repeat(instances * envelope.joint_len()))?;
    Ok(uploaded)
}

/// Evaluates a batch `times` times, each submitted and waited for; returns the total seconds.
fn run(batch: &mut dyn Uploaded, instances: usize, times: usize) -> Result<f64> {
    let start = Instant::now();
    for _ in 0..times {
        batch.run(instances)?;
    }
    Ok(start.elapsed().as_secs_f64())
}

/// Returns the median seconds of a measurement, repeated in one submission until it takes long
/// enough.
fn each<E>(mut measure: impl FnMut(usize) -> std::result::Result<Duration, E>) -> Result<f64>
where
    Box<dyn Error>: From<E>,
{
    let mut repeat_len = 1;
    while measure(repeat_len)? < LEAST && repeat_len < 1 << 12 {
        repeat_len *= 2;
    }
    let mut times = Vec::new();
    for _ in 0..MEDIAN_OF {
        times.push(measure(repeat_len)?.as_secs_f64() / repeat_len as f64);
    }
    Ok(median(times))
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

#[cfg(test)]
mod tests {
    use super::missed;

    #[test]
    fn a_bar_that_is_missed_is_named_with_what_was_measured() {
        assert_eq!(missed(1.29, &[("wgpu", 1.14), ("vulkan", 0.86)]), Vec::<String>::new());
        assert_eq!(
            missed(1.31, &[("wgpu", 1.16), ("vulkan", 0.84)]),
            [
                "wgpu takes 1.31 times as long as Vulkan, above the bar of 1.3",
                "wgpu: an instance among many takes 1.16 times as long as among few, the bar is within 15 %",
                "vulkan: an instance among many takes 0.84 times as long as among few, the bar is within 15 %",
            ]
        );
    }
}
