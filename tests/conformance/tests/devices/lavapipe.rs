//! Real devices: lavapipe, which is required and has the CPU's bits, and every other device of the
//! machine.

use conformance::backend::Failure;
use conformance::devices::{Counter, LAVAPIPE, list, open};
use conformance::finding::{Finding, sound};
use conformance::gpu::Gpu;
use conformance::models::{self, Shape, shape_of, stretching_shape_of};
use conformance::poses::POSES;
use conformance::stages::{applies, body, layout, whole};
use conformance::subject::{FEWER_POSES, Subject, random, shapes, trained};
use sinew_gpu::headless::{Device, DeviceInfo};
use sinew_gpu::layout::{DeviceLimits, Stage};
use sinew_runtime::envelope::Predictor;
use wgpu::{
    Backends, DeviceDescriptor, ExperimentalFeatures, Features, Instance, InstanceDescriptor,
    InstanceFlags, Limits, PassthroughShaderEntryPoint, ShaderModuleDescriptorPassthrough,
};

const APIS: [&str; 2] = ["wgpu", "vulkan"];

fn lavapipe(api: &str) -> DeviceInfo {
    let all = list().unwrap_or_default();
    let found = all.iter().find(|info| info.api == api && info.driver == LAVAPIPE);
    found.cloned().unwrap_or_else(|| {
        panic!("{api} finds no lavapipe among {all:?}: install mesa-vulkan-drivers (Debian)")
    })
}

/// Runs every stage alone and from pose to skin; returns the number of values compared. `same`
/// requires the CPU's bits.
fn evaluate(device: &dyn Device, limits: DeviceLimits, subject: &Subject<'_>, same: bool) -> usize {
    let gpu = Gpu { device, limits };
    let stages = Stage::ALL.into_iter().filter(|stage| applies(*stage, &gpu, &subject.loaded));
    let bodies = stages.map(|stage| (stage.name(), body(stage)));
    let skinned = subject.loaded.skin.vertex_len() > 0;
    let whole = skinned.then_some(("whole", whole::body as conformance::stages::Body));
    let mut values = 0;
    for (name, body) in bodies.chain(whole) {
        let of = || format!("{name} of {}", subject.described());
        let findings = body(&gpu, subject).unwrap_or_else(|failure| panic!("{}: {failure}", of()));
        assert_eq!(sound(&findings), Ok(()), "{}", of());
        for finding in findings {
            let differs = finding.differing > 0;
            assert!(
                !(same && differs),
                "{}: {} bits differ in {finding:?}",
                of(),
                finding.differing
            );
            values += finding.values;
        }
    }
    values
}

/// Lists each predictor's first shape, and its first shape whose joints stretch.
fn first_shapes() -> Vec<Shape> {
    [Predictor::ALL.map(shape_of), Predictor::ALL.map(stretching_shape_of)].concat()
}

/// Runs a random model of each of the first shapes, in batches of one instance, an odd number, and
/// more than a workgroup; returns the number of values compared.
fn sizes(device: &dyn Device, same: bool) -> usize {
    let mut values = 0;
    for bytes in first_shapes().into_iter().map(models::random) {
        for pose_len in [1, 7, 65] {
            let subject = Subject::new("random", &bytes, pose_len);
            values += evaluate(device, device.limits(), &subject, same);
            // Chunks of few instances.
            let cut = DeviceLimits { storage_binding_bytes: 48 << 10, ..device.limits() };
            values += evaluate(device, cut, &subject, same);
        }
    }
    values
}

/// Runs every shape, those with a count of 0 included; returns the number of values compared.
fn every_shape(device: &dyn Device, same: bool) -> usize {
    shapes(FEWER_POSES).map(|subject| evaluate(device, device.limits(), &subject, same)).sum()
}

#[test]
fn lavapipe_has_the_bits_of_the_cpu() {
    for api in APIS {
        let device = open(&lavapipe(api), false).unwrap();
        let mut values = 0;
        for subject in trained(POSES) {
            values += evaluate(&*device, device.limits(), &subject, true);
        }
        values += every_shape(&*device, true) + sizes(&*device, true);
        println!("{:?}: {values} values have the CPU's bits", device.info());
        assert!(values > 20_000_000, "{values}");
    }
}

#[test]
fn lavapipe_skins_in_every_layout() {
    for api in APIS {
        let device = open(&lavapipe(api), false).unwrap();
        let mut values = 0;
        for subject in random().into_iter().map(|subject| subject.shortened(28)) {
            let findings = layout::body(&Gpu::new(&*device), &subject).unwrap();
            assert_eq!(sound(&findings), Ok(()), "{:?}", subject.loaded.envelope);
            values += findings.iter().map(|finding| finding.values).sum::<usize>();
        }
        println!("{:?}: {values} values", device.info());
        assert!(values > 50_000, "{values}");
    }
}

#[test]
fn validation_is_silent() {
    Counter::install();
    let before = Counter::message_len();
    log::info!("this is not counted");
    log::warn!("this is counted, and so is the next");
    log::error!("this is counted as well");
    assert_eq!(Counter::message_len() - before, 2, "the counter counts");
    assert_eq!(messages_of_a_broken_shader(), 1, "the layer is not there, or is not heard");
    for api in APIS {
        let (info, before) = (lavapipe(api), Counter::message_len());
        let device = open(&info, true).unwrap();
        let mut values = 0;
        for bytes in first_shapes().into_iter().map(models::random) {
            let subject = Subject::new("random", &bytes, 65);
            values += evaluate(&*device, device.limits(), &subject, true);
            let cut = DeviceLimits { storage_binding_bytes: 48 << 10, ..device.limits() };
            values += evaluate(&*device, cut, &subject, true);
        }
        assert!(values > 100_000, "{values}");
        let counted = device.message_len().unwrap_or_else(|| Counter::message_len() - before);
        println!("{:?}: {values} values, {counted} messages", device.info());
        assert_eq!(counted, 0, "messages of the validation layers");
    }
}

#[test]
fn every_other_device_is_within_the_tolerances() {
    let all = list().unwrap();
    for info in all.iter().filter(|info| info.driver != LAVAPIPE) {
        let device = open(info, false).unwrap();
        let mut values = 0;
        for subject in trained(FEWER_POSES) {
            values += evaluate(&*device, device.limits(), &subject, false);
        }
        values += every_shape(&*device, false) + sizes(&*device, false);
        println!("{info:?}: {values} values within their tolerances");
        assert!(values > 1_000_000, "{values}");
    }
    if all.iter().all(|info| info.driver == LAVAPIPE) {
        // `cargo xtask test` finds SwiftShader beside Chromium.
        assert!(std::env::var_os("CI").is_none(), "CI is set, but no device but lavapipe is here");
        println!("no device but lavapipe is here");
    }
}

/// Runs all batches of a part on a device, each with the given number of instances; returns the
/// number of values compared, and of those that differ from the CPU's.
pub(crate) type Evaluate = fn(&dyn Device, usize) -> (usize, usize);

/// Asserts that lavapipe has the CPU's bits, in more than `least` values.
pub(crate) fn same_bits(evaluate: Evaluate, instance_len: usize, least: usize) {
    for api in APIS {
        let device = open(&lavapipe(api), false).expect("lavapipe opens");
        let (values, differing) = evaluate(&*device, instance_len);
        println!("{:?}: {differing} of {values} values have other bits", device.info());
        assert_eq!(differing, 0);
        assert!(values > least, "{values}");
    }
}

/// Asserts that validation reports nothing.
pub(crate) fn silent(evaluate: Evaluate, instance_len: usize, least: usize) {
    Counter::install();
    for api in APIS {
        let before = Counter::message_len();
        let device = open(&lavapipe(api), true).expect("lavapipe opens with its layer");
        let (values, _) = evaluate(&*device, instance_len);
        let counted = device.message_len().unwrap_or_else(|| Counter::message_len() - before);
        assert!(values > least && counted == 0, "{counted} messages");
    }
}

/// Asserts that every device but lavapipe is within the tolerances.
pub(crate) fn within_tolerances(evaluate: Evaluate, instance_len: usize, least: usize) {
    for info in list().expect("devices can be listed").iter().filter(|info| info.driver != LAVAPIPE)
    {
        let device = open(info, false).expect("a device that is listed opens");
        let (values, differing) = evaluate(&*device, instance_len);
        println!("{info:?}: {differing} of {values} values have other bits");
        assert!(values > least, "{values}");
    }
}

/// Compares a stage with the device's limits, and with smaller bindings, which cut the batch into
/// chunks; returns the number of values compared, and of those that differ from the CPU's.
pub(crate) fn whole_and_cut(
    device: &dyn Device,
    storage_binding_bytes: u64,
    described: &str,
    body: impl Fn(&Gpu<'_>) -> Result<Vec<Finding>, Failure>,
) -> (usize, usize) {
    let cut = DeviceLimits { storage_binding_bytes, ..device.limits() };
    let (mut values, mut differing) = (0, 0);
    for limits in [device.limits(), cut] {
        let findings = body(&Gpu { device, limits });
        let findings = findings.unwrap_or_else(|failure| panic!("{described}: {failure}"));
        assert_eq!(sound(&findings), Ok(()), "{described}");
        values += findings.iter().map(|finding| finding.values).sum::<usize>();
        differing += findings.iter().map(|finding| finding.differing).sum::<usize>();
    }
    (values, differing)
}

/// Adds up the counts of several subjects.
pub(crate) fn sum(counts: impl Iterator<Item = (usize, usize)>) -> (usize, usize) {
    counts.fold((0, 0), |(values, differing), own| (values + own.0, differing + own.1))
}

/// Passes a shader without the shader capability to the driver; returns the number of messages
/// counted.
#[allow(unsafe_code, reason = "the layer reports only a shader that nobody has checked")]
fn messages_of_a_broken_shader() -> usize {
    let instance = Instance::new(InstanceDescriptor {
        backends: Backends::VULKAN,
        flags: InstanceFlags::VALIDATION | InstanceFlags::DEBUG | InstanceFlags::DISCARD_HAL_LABELS,
        ..InstanceDescriptor::new_without_display_handle()
    });
    let adapters = pollster::block_on(instance.enumerate_adapters(Backends::VULKAN));
    let adapter = adapters.into_iter().find(|adapter| adapter.get_info().driver == LAVAPIPE);
    let opened = adapter.expect("lavapipe is here").request_device(&DeviceDescriptor {
        required_features: Features::PASSTHROUGH_SHADERS,
        required_limits: Limits::downlevel_defaults(),
        // SAFETY: the shader below is the only experimental feature in use.
        experimental_features: unsafe { ExperimentalFeatures::enabled() },
        ..Default::default()
    });
    let (device, _) = pollster::block_on(opened).expect("lavapipe takes shaders as they are");
    let words = Stage::Joints.spirv().as_chunks::<4>().0.iter().map(|le| u32::from_le_bytes(*le));
    let mut words: Vec<u32> = words.collect();
    // Replaces the first declared capability, that of shaders, by that of 16-bit integers.
    words[6] = 22;
    let before = Counter::message_len();
    let entry = PassthroughShaderEntryPoint { name: "main".into(), workgroup_size: (64, 1, 1) };
    // SAFETY: no pipeline uses the module; the layer reads it, and the driver keeps a copy.
    let module = unsafe {
        device.create_shader_module_passthrough(ShaderModuleDescriptorPassthrough {
            entry_points: vec![entry].into(),
            spirv: Some(words.into()),
            ..Default::default()
        })
    };
    drop(module);
    Counter::message_len() - before
}
