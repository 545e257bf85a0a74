//! Every backend's stages against the f64 oracle: one body a stage, run on the oracle's tolerances
//! over models of every shape and over more than a thousand poses.

mod bounds;
mod controls;
mod gradients;
mod layout;
mod palette;
mod skin;
mod whole;

use conformance::backend::{Backend, Cpu};
use conformance::compare::Mismatch;
use conformance::models::{self, SHAPES};
use conformance::poses::{POSES, Pose, poses};
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

/// The trained character and, where it is there, the real arm.
pub(crate) fn characters() -> Vec<Subject<'static>> {
    let demo = Subject::new("demo", models::trained(), POSES);
    let arm = models::arm().map(|bytes| Subject::new("arm", bytes, FEWER_POSES));
    [Some(demo), arm].into_iter().flatten().collect()
}

/// Runs a body on every model that has vertices, and prints the largest ratios of an error to its
/// tolerance.
fn on_every_model<B: Backend, const N: usize>(
    backend: &B,
    body: impl Fn(&B, &Subject<'_>) -> Result<[f64; N], Mismatch>,
) {
    let bytes = SHAPES.map(models::random);
    let shapes = bytes.iter().zip(SHAPES).filter(|(_, shape)| shape.vertices > 0);
    let random = shapes.map(|(bytes, _)| Subject::new("random", bytes, FEWER_POSES));
    for subject in characters().into_iter().chain(random) {
        match body(backend, &subject) {
            Ok(ratios) => println!("{}, {:?}: {ratios:.3?}", subject.name, subject.envelope),
            Err(mismatch) => panic!("{}, {:?}: {mismatch:?}", subject.name, subject.envelope),
        }
    }
}

#[test]
fn gradients() {
    on_every_model(&Cpu, gradients::body);
}

#[test]
fn palette() {
    on_every_model(&Cpu, palette::body);
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
