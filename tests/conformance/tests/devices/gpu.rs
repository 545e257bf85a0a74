//! The backend for devices, tested on a simulated device: it returns every output and detects every
//! fault.

use crate::devices::software::{Fault, Software};
use conformance::backend::Failure;
use conformance::compare::Mismatch;
use conformance::finding::{Finding, sound};
use conformance::gpu::Gpu;
use conformance::models::{self, SHAPES, shape_of, stretching_shape_of};
use conformance::stages::{Body, applies, body, layout, whole};
use conformance::subject::Subject;
use sinew_gpu::headless::Device;
use sinew_gpu::layout::{DeviceLimits, Resource, Stage};
use sinew_runtime::envelope::Predictor;

pub(crate) fn fails(found: Result<Vec<Finding>, Failure>) -> bool {
    match found {
        Ok(findings) => {
            sound(&findings).is_err() || findings.iter().any(|finding| finding.differing > 0)
        }
        Err(failure) => matches!(failure, Failure::Touched { .. }),
    }
}

#[test]
fn the_runtime_behind_the_trait_gives_the_runtimes_bits() {
    for shape in SHAPES {
        let bytes = models::random(shape);
        let subject = Subject::new("random", &bytes, 65);
        let device = Software::new(&bytes, None);
        // The second limits cut batches into chunks of few instances.
        let cut = DeviceLimits { storage_binding_bytes: 48 << 10, ..device.limits() };
        for limits in [device.limits(), cut] {
            let gpu = Gpu { device: &device, limits };
            let stages = Stage::ALL.into_iter().filter(|own| applies(*own, &gpu, &subject.loaded));
            let bodies = stages.map(|stage| (stage.name(), body(stage)));
            // A layout with all instances of a vertex side by side is too wide for small bindings.
            let skinned = match shape.vertices {
                0 => 0,
                _ if limits == cut => 1,
                _ => 2,
            };
            let whole: [(_, Body); 2] = [("whole", whole::body), ("layout", layout::body)];
            for (name, body) in bodies.chain(whole.into_iter().take(skinned)) {
                let findings = body(&gpu, &subject).unwrap();
                assert_eq!(sound(&findings), Ok(()), "{name} of {shape:?}");
                assert!(findings.iter().all(|own| own.differing == 0), "{name} of {shape:?}");
            }
        }
    }
}

/// Returns a float that the stage writes, and a float near the first instance that the stage must
/// not write.
fn places(stage: Stage) -> (Resource, usize, Resource, usize) {
    match stage {
        Stage::Polar => (Resource::Scratch, 12 * 6, Resource::Poses, 5),
        Stage::Gradients => (Resource::Scratch, 1, Resource::Palettes, 2),
        Stage::Palette => (Resource::Palettes, 5, Resource::Scratch, 0),
        Stage::Joints => (Resource::Palettes, 5, Resource::Palettes, 1),
        Stage::Features => (Resource::Scratch, 12, Resource::Poses, 5),
        Stage::Correction => (Resource::Palettes, 4 + 12 * 6, Resource::Scratch, 0),
        Stage::Confidence => (Resource::Confidences, 1, Resource::Confidences, 2),
        Stage::Skin => (Resource::Out, 0, Resource::Palettes, 1),
        Stage::Kernel | Stage::Shapes | Stage::Filter => panic!("files of their own have them"),
    }
}

#[test]
fn a_device_that_is_wrong_is_caught() {
    let alone = |stage: &Stage| matches!(stage, Stage::Kernel | Stage::Shapes | Stage::Filter);
    for stage in Stage::ALL.into_iter().filter(|stage| !alone(stage)) {
        let shape = match stage {
            Stage::Polar => stretching_shape_of(Predictor::Kernel),
            Stage::Joints | Stage::Features | Stage::Correction => shape_of(Predictor::Kernel),
            _ => shape_of(Predictor::Rotational),
        };
        let bytes = models::random(shape);
        let subject = Subject::new("random", &bytes, 14);
        let (own, place, other, stray) = places(stage);
        let run = |fault| {
            let device = Software::new(&bytes, fault);
            let gpu = Gpu::new(&device);
            assert!(applies(stage, &gpu, &subject.loaded));
            body(stage)(&gpu, &subject)
        };
        assert!(!fails(run(None)), "{stage:?}");
        assert!(fails(run(Some(Fault::Bit(stage, own, place)))), "{stage:?}: one bit");
        assert!(fails(run(Some(Fault::Idle(stage)))), "{stage:?}: left alone");
        let touched = run(Some(Fault::Stray(stage, other, stray)));
        assert!(matches!(touched, Err(Failure::Touched { .. })), "{stage:?}: {touched:?}");
        let device = Software::new(&bytes, Some(Fault::Idle(stage)));
        assert!(fails(whole::body(&Gpu::new(&device), &subject)), "{stage:?}: from end to end");
    }
}

#[test]
fn a_float_between_attributes_is_seen() {
    let bytes = models::random(shape_of(Predictor::Rotational));
    let subject = Subject::new("random", &bytes, 3);
    // The float before the interleaved layout, which starts at 1.
    let stray = Fault::Stray(Stage::Skin, Resource::Out, 0);
    let device = Software::new(&bytes, Some(stray));
    let found = layout::body(&Gpu::new(&device), &subject);
    assert!(matches!(found, Err(Failure::Touched { .. })), "{found:?}");
}

#[test]
fn a_flipped_bit_is_one_value_that_differs_within_its_tolerance() {
    let bytes = models::random(shape_of(Predictor::Rotational));
    let subject = Subject::new("random", &bytes, 14);
    let flipped = Fault::Bit(Stage::Palette, Resource::Palettes, 4);
    let device = Software::new(&bytes, Some(flipped));
    let findings = body(Stage::Palette)(&Gpu::new(&device), &subject).unwrap();
    assert_eq!((findings[0].differing, sound(&findings)), (1, Ok(())));
    let idle = Software::new(&bytes, Some(Fault::Idle(Stage::Palette)));
    let findings = body(Stage::Palette)(&Gpu::new(&idle), &subject).unwrap();
    assert!(matches!(sound(&findings), Err(Mismatch::Beyond { found, .. }) if found.is_nan()));
}
