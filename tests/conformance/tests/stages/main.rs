//! Every backend's stages against the f64 oracle: one body a stage, run on the oracle's tolerances
//! over models of every shape and over more than a thousand poses.

mod bounds;
mod confidence;
mod controls;
mod correction;
mod features;
mod gradients;
mod joints;
mod layout;
mod palette;
mod skin;
mod whole;

use conformance::backend::{Backend, Cpu};
use conformance::compare::Mismatch;
use conformance::models::{self, SHAPES};
use conformance::poses::{POSES, Pose, poses};
use sinew_runtime::format::Predictor;
use sinew_runtime::{Envelope, Model};
use sinew_trainer::envelope::oracle::Oracle;

/// Poses of a model that is not the main one: ten rounds of every kind.
const FEWER_POSES: usize = 140;

/// A model under test.
pub(crate) struct Subject<'a> {
    pub(crate) name: &'static str,
    pub(crate) envelope: Envelope<'a>,
    pub(crate) oracle: Oracle,
    pub(crate) poses: Vec<Pose>,
}

impl<'a> Subject<'a> {
    pub(crate) fn new(name: &'static str, bytes: &'a [u8], pose_len: usize) -> Self {
        let envelope = Model::from_bytes(bytes).expect("a baked model loads").envelope();
        let envelope = envelope.expect("it holds an envelope");
        let (oracle, poses) = (Oracle::new(&envelope), poses(&envelope, pose_len));
        Self { name, envelope, oracle, poses }
    }
}

/// The trained character and, where it is there, the real arm, by every predictor.
pub(crate) fn characters() -> Vec<Subject<'static>> {
    let demo = models::trained().iter().map(|bytes| Subject::new("demo", bytes, POSES));
    let arms = models::arm().into_iter().flatten();
    demo.chain(arms.map(|bytes| Subject::new("arm", bytes, FEWER_POSES))).collect()
}

/// Runs a body on every model that has vertices, of the predictors that it is of, and prints the
/// largest ratios of an error to its tolerance.
fn on_models_of<B: Backend, const N: usize>(
    of: impl Fn(Predictor) -> bool,
    backend: &B,
    body: impl Fn(&B, &Subject<'_>) -> Result<[f64; N], Mismatch>,
) {
    let bytes = SHAPES.map(models::random);
    let shapes = bytes.iter().zip(SHAPES).filter(|(_, shape)| shape.vertices > 0);
    let random = shapes.map(|(bytes, _)| Subject::new("random", bytes, FEWER_POSES));
    let subjects = characters().into_iter().chain(random);
    let mut count = 0;
    for subject in subjects.filter(|subject| of(subject.envelope.predictor())) {
        let named = format!("{:?}, {:?}", subject.oracle.predictor, subject.envelope);
        match body(backend, &subject) {
            Ok(ratios) => println!("{}, {named}: {ratios:.3?}", subject.name),
            Err(mismatch) => panic!("{}, {named}: {mismatch:?}", subject.name),
        }
        count += 1;
    }
    assert!(count > 0, "no model has the stage");
}

/// Runs a body on the models of every predictor.
fn on_every_model<B: Backend, const N: usize>(
    backend: &B,
    body: impl Fn(&B, &Subject<'_>) -> Result<[f64; N], Mismatch>,
) {
    on_models_of(|_| true, backend, body);
}

#[test]
fn gradients() {
    on_models_of(Predictor::reconstructs, &Cpu, gradients::body);
}

#[test]
fn palette() {
    on_models_of(Predictor::reconstructs, &Cpu, palette::body);
}

#[test]
fn joints() {
    on_models_of(|predictor| !predictor.reconstructs(), &Cpu, joints::body);
}

#[test]
fn features() {
    on_models_of(Predictor::corrects, &Cpu, features::body);
}

#[test]
fn correction() {
    on_models_of(Predictor::corrects, &Cpu, correction::body);
}

#[test]
fn confidence() {
    on_models_of(|predictor| !predictor.corrects(), &Cpu, confidence::body);
}

#[test]
fn skin() {
    on_every_model(&Cpu, skin::body);
}

#[test]
fn from_pose_to_skin() {
    on_every_model(&Cpu, whole::body);
}

#[test]
fn global_motion() {
    on_every_model(&Cpu, whole::equivariance);
}

#[test]
fn rest_is_rest() {
    on_every_model(&Cpu, whole::rest);
}

#[test]
fn layouts_and_ranges() {
    on_every_model(&Cpu, layout::body);
}

#[test]
fn bounds() {
    on_every_model(&Cpu, bounds::body);
}
