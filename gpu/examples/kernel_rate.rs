//! Measures the time of kernel queries on a device, through each API, and on one core of the CPU:
//! many queries with few values, and few queries with many values.
//!
//! `cargo run --release -p sinew-gpu --example kernel_rate [-- DRIVER]`

use models::{KernelContent, Pieces, Rng};
use sinew_gpu::headless::Device;
use sinew_gpu::layout::{KernelBatch, Plan, Resource, Stage};
use sinew_gpu::{vulkan, wgpu};
use sinew_runtime::kernel::Kernel;
use sinew_runtime::{KernelMap, Model};
use std::error::Error;
use std::time::Instant;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

const MEDIAN_OF: usize = 5;
/// Inputs, centres and values; and the number of queries.
const SIZES: [([usize; 3], usize); 3] =
    [([3, 200, 3], 100_000), ([27, 64, 480], 16), ([27, 64, 480], 4096)];

fn main() -> Result<()> {
    let driver = std::env::args().nth(1).unwrap_or_else(|| "llvmpipe".to_owned());
    let devices: [Box<dyn Device>; 2] = [
        Box::new(wgpu::headless::Device::of_driver(&driver, false)?),
        Box::new(vulkan::headless::Device::of_driver(&driver, false)?),
    ];
    println!("{:?}\nmedians of {MEDIAN_OF}, us a query", devices[0].info());
    for kernel in [Kernel::Gaussian, Kernel::ThinPlate] {
        for ([d, n, m], instance_len) in SIZES {
            let content = KernelContent::plain(kernel, [d, n, m]);
            println!("{}, d {d}, n {n}, m {m}, {instance_len} queries", kernel.name());
            measure(&content, instance_len, &devices)?;
        }
    }
    Ok(())
}

/// Measures one kernel on the CPU and on the devices.
fn measure(
    content: &KernelContent,
    instance_len: usize,
    devices: &[Box<dyn Device>],
) -> Result<()> {
    let model = Model::from_bytes(Pieces::kernels(std::slice::from_ref(content)).bytes())?;
    let kernel = model.first::<KernelMap>().ok_or("there is no kernel")?;
    let mut random = Rng(2015);
    let queries: Vec<_> = (0..instance_len).flat_map(|_| content.query(&mut random, 1.0)).collect();
    let mut out = vec![0.0; kernel.result_len()];
    let mut scratch = vec![0.0; kernel.counts().scratch_len()];
    let cpu = median(|| {
        let start = Instant::now();
        for query in queries.chunks(kernel.query_len()) {
            kernel.evaluate(query, &mut scratch, &mut out)?;
        }
        Ok(start.elapsed().as_secs_f64())
    })?;
    println!("  {:8} {:9.4}", "cpu", 1e6 * cpu / instance_len as f64);
    for device in devices {
        let batch = KernelBatch::new(&kernel, instance_len);
        let plan = Plan::of_kernel(&model, &kernel, &batch, &device.limits())?;
        let mut uploaded = device.upload(model.blob(), &plan)?;
        uploaded.write(Resource::Queries, 0, &queries)?;
        uploaded.run(instance_len)?;
        let time =
            median(|| Ok(uploaded.time_stage(Stage::Kernel, instance_len, 1)?.as_secs_f64()))?;
        println!(
            "  {:8} {:9.4} {:8.1} MB of scratch",
            device.info().api,
            1e6 * time / instance_len as f64,
            plan.bytes(Resource::Scratch) as f64 / 1e6
        );
    }
    Ok(())
}

fn median(mut measured: impl FnMut() -> Result<f64>) -> Result<f64> {
    let mut all = (0..MEDIAN_OF).map(|_| measured()).collect::<Result<Vec<_>>>()?;
    all.sort_by(f64::total_cmp);
    Ok(all[MEDIAN_OF / 2])
}
