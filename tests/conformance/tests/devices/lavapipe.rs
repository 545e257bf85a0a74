//! Real devices: lavapipe, which must be here and gives the CPU's bits, and whatever else is.

use crate::layer::messages_of_a_broken_shader;
use conformance::devices::{Counter, LAVAPIPE, list, open};
use conformance::finding::sound;
use conformance::gpu::Gpu;
use conformance::models::{self, shape_of};
use conformance::stages::{applies, body, layout, whole};
use conformance::subject::{FEWER_POSES, Subject, random, shapes, trained};
use sinew_gpu::headless::{Device, DeviceInfo};
use sinew_gpu::layout::{DeviceLimits, Stage};
use sinew_runtime::envelope::Predictor;

pub(crate) const APIS: [&str; 2] = ["wgpu", "vulkan"];

/// Poses of the trained character: at least a thousand of each predictor.
const POSES: usize = 1024;

pub(crate) fn lavapipe(api: &str) -> DeviceInfo {
    let all = list().unwrap_or_default();
    let found = all.iter().find(|info| info.api == api && info.driver == LAVAPIPE);
    found.cloned().unwrap_or_else(|| {
        panic!("{api} finds no lavapipe among {all:?}: install mesa-vulkan-drivers (Debian)")
    })
}

/// Runs every stage alone and from end to end; returns the values compared.
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

/// A random model of a predictor's first shape, in batches of one, an odd number, past a workgroup.
fn sizes(device: &dyn Device, same: bool) -> usize {
    let mut values = 0;
    for predictor in Predictor::ALL {
        let bytes = models::random(shape_of(predictor));
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

/// Every shape, nothing of which there are none included.
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
        for predictor in Predictor::ALL {
            let bytes = models::random(shape_of(predictor));
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
