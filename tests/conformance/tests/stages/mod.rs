//! The runtime's stages compared with the f64 oracle: one comparison for each stage, within the
//! oracle's tolerances, on models of every shape and more than a thousand poses.

mod altered;
mod controls;
mod correction;
mod filter;
mod kernel;
mod polar;
mod shapes;

use conformance::backend::Loaded;
use conformance::compare::Mismatch;
use conformance::cpu::Cpu;
use conformance::finding::{Finding, sound};
use conformance::models::{self, SHAPES};
use conformance::stages::skin::{skinned_by, whole_of};
use conformance::stages::{Body, applies, body, bounds, layout, whole};
use conformance::subject::{FEWER_POSES, Subject, characters, random};
use sinew_gpu::layout::{SkinBatch, Stage};

/// Runs a comparison on every model that has vertices and for which `of` is true, and prints the
/// largest ratios of an error to its tolerance.
fn on_models_of(of: impl Fn(&Subject<'_>) -> bool, pose_len: usize, body: Body) {
    let mut count = 0;
    for subject in characters().into_iter().chain(random()).filter(of) {
        let subject = subject.shortened(pose_len);
        let named = subject.described();
        let findings = body(&Cpu, &subject).unwrap_or_else(|failure| panic!("{named}: {failure}"));
        sound(&findings).unwrap_or_else(|mismatch| panic!("{named}: {mismatch:?}"));
        assert!(
            findings.iter().all(|finding| finding.differing == 0),
            "the CPU differs from itself"
        );
        let ratios: Vec<_> = findings.iter().map(|Finding { worst, .. }| *worst).collect();
        println!("{named}: {ratios:.3?}");
        count += 1;
    }
    assert!(count > 0, "no model has the stage");
}

fn on_every_model(body: Body) {
    on_models_of(|_| true, usize::MAX, body);
}

fn on_models_with(stage: Stage) {
    on_models_of(|subject| applies(stage, &Cpu, &subject.loaded), usize::MAX, body(stage));
}

#[test]
fn polar() {
    on_models_with(Stage::Polar);
}

#[test]
fn gradients() {
    on_models_with(Stage::Gradients);
}

#[test]
fn palette() {
    on_models_with(Stage::Palette);
}

#[test]
fn joints() {
    on_models_with(Stage::Joints);
}

#[test]
fn features() {
    on_models_with(Stage::Features);
}

#[test]
fn correction() {
    on_models_with(Stage::Correction);
}

#[test]
fn confidence() {
    on_models_with(Stage::Confidence);
}

#[test]
fn skin() {
    on_models_with(Stage::Skin);
}

#[test]
fn from_pose_to_skin() {
    on_every_model(whole::body);
}

#[test]
fn global_motion() {
    on_models_of(|_| true, FEWER_POSES, whole::equivariance);
}

#[test]
fn rest_is_rest() {
    on_models_of(|_| true, 1, whole::rest);
}

#[test]
fn layouts_and_ranges() {
    on_models_of(|_| true, 28, layout::body);
}

#[test]
fn bounds() {
    on_every_model(bounds::body);
}

#[test]
fn a_mesh_without_vertices_has_a_palette_and_nothing_to_skin() {
    for shape in SHAPES.into_iter().filter(|shape| shape.vertices == 0) {
        let bytes = models::random(shape);
        let subject = Subject::new("nothing", &bytes, 14);
        let Loaded { envelope, skin: own, .. } = &subject.loaded;
        if shape.predictor.reconstructs() {
            assert_eq!(sound(&body(Stage::Palette)(&Cpu, &subject).unwrap()), Ok(()));
        }
        if shape.predictor.corrects() {
            assert_eq!(sound(&body(Stage::Correction)(&Cpu, &subject).unwrap()), Ok(()));
        }
        let palettes = whole_of(&Cpu, &subject).unwrap().palettes;
        assert!(SkinBatch::new(own).vertices.is_empty());
        assert!(skinned_by(&Cpu, &subject, &palettes).unwrap().positions.is_empty());
        assert_eq!(own.bounds(&palettes[..envelope.palette_len()], 0.0).unwrap(), None);
        let findings = body(Stage::Skin)(&Cpu, &subject).unwrap();
        assert_eq!(sound(&findings), Err(Mismatch::Empty), "it proves nothing");
    }
}
