//! Negative controls: a backend with one value off by twice the tolerance is caught, and so is a
//! backend that writes nothing.

use crate::stages::altered::{Step, altered, idle};
use ::models::Pieces;
use conformance::backend::{Backend, Failure, Loaded, Poses, part};
use conformance::compare::Mismatch;
use conformance::cpu::Cpu;
use conformance::finding::{Finding, sound};
use conformance::models::{self, SHAPES, shape_of, stretching_shape_of};
use conformance::poses::widened;
use conformance::stages::correction::exact_floats;
use conformance::stages::gradients::{columns, exact_rotations};
use conformance::stages::{self, bounds, correction, exact, joints, layout, whole};
use conformance::subject::{FEWER_POSES, Subject};
use conformance::tolerance::{self, Arithmetic, Inexact};
use sinew_gpu::layout::{SkinBatch, Stage};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::SectionKind;
use std::cell::Cell;

const IEEE: Arithmetic = Arithmetic::IEEE;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Output {
    /// Of models whose joints stretch.
    Turns,
    /// Of models whose joints stretch.
    Strains,
    Relative,
    Rotations,
    Gradients,
    Palette,
    Features,
    Correction,
    /// The confidence of the correction.
    CorrectionConfidence,
    /// The confidence of a rotational model.
    Confidence,
    Positions,
    Normals,
    Tangents,
}

const OUTPUTS: [Output; 13] = [
    Output::Turns,
    Output::Strains,
    Output::Relative,
    Output::Rotations,
    Output::Gradients,
    Output::Palette,
    Output::Features,
    Output::Correction,
    Output::CorrectionConfidence,
    Output::Confidence,
    Output::Positions,
    Output::Normals,
    Output::Tangents,
];

impl Output {
    /// Returns the predictor of a model that has the output.
    fn predictor(self) -> Predictor {
        match self {
            Self::Turns | Self::Features | Self::Correction | Self::CorrectionConfidence => {
                Predictor::Kernel
            }
            _ => Predictor::Rotational,
        }
    }

    /// Lists a model that has the output whose joints stretch, and one whose joints do not.
    fn models(self) -> Vec<Vec<u8>> {
        let stretching = stretching_shape_of(self.predictor());
        let rigid = (self.stage() != Stage::Polar).then(|| shape_of(self.predictor()));
        [stretching].into_iter().chain(rigid).map(models::random).collect()
    }

    fn stage(self) -> Stage {
        match self {
            Self::Turns | Self::Strains => Stage::Polar,
            Self::Relative | Self::Rotations | Self::Gradients => Stage::Gradients,
            Self::Palette => Stage::Palette,
            Self::Features => Stage::Features,
            Self::Correction | Self::CorrectionConfidence => Stage::Correction,
            Self::Confidence => Stage::Confidence,
            Self::Positions | Self::Normals | Self::Tangents => Stage::Skin,
        }
    }
}

/// Changes one value of one output, once, to an error of `factor` tolerances.
struct Spoil<'a> {
    subject: &'a Subject<'a>,
    output: Output,
    factor: f64,
    /// Number of values so far that have a tolerance above 0.
    seen: Cell<usize>,
}

impl Spoil<'_> {
    /// Counts a value if its tolerance is above 0, and changes the tenth.
    fn off(&self, value: &mut f32, expected: f64, tolerance: f64) {
        if tolerance > 0.0 {
            self.seen.set(self.seen.get() + 1);
            if self.seen.get() == 10 {
                *value = (expected + self.factor * tolerance) as f32;
            }
        }
    }

    fn alter(&self, step: Step<'_>) {
        let (oracle, envelope) = (&self.subject.oracle, &self.subject.loaded.envelope);
        let joint_len = envelope.joint_len();
        match (self.output, step) {
            (Output::Turns | Output::Strains, Step::Polar { poses, out }) => {
                for i in 0..poses.len {
                    let (turns, strains) =
                        tolerance::polar(oracle, &exact(poses.one(i).joints), IEEE);
                    let (last, at) = (joint_len - 1, (i + 1) * joint_len - 1);
                    if self.output == Output::Turns {
                        let (value, error) = (turns.value[last], turns.error[last]);
                        self.off(&mut out.turns[at][1][2], value[(2, 1)], error[(2, 1)]);
                    } else {
                        let (value, error) = (strains.value[last], strains.error[last]);
                        self.off(&mut out.strains[at][4], value[4], error[4]);
                    }
                }
            }
            (Output::Relative, Step::Gradients { poses, out }) => {
                for (i, out) in out.relative.chunks_mut(4 * joint_len).enumerate() {
                    let right = tolerance::relative(oracle, &exact(poses.one(i).joints), IEEE);
                    let (value, error) = (right.value[joint_len - 1], right.error[joint_len - 1]);
                    self.off(&mut out[4 * joint_len - 1][2], value[(2, 3)], error[(2, 3)]);
                }
            }
            (Output::Rotations, Step::Gradients { poses, out }) => {
                for i in 0..poses.len {
                    let pose = exact(poses.one(i).joints);
                    let relative = Inexact::exact(columns(part(&out.relative, poses.len, i)));
                    let turning = tolerance::turning(oracle, &pose, &relative);
                    let right = tolerance::rotations(oracle, turning, IEEE);
                    let (last, at) = (joint_len - 1, (i + 1) * joint_len - 1);
                    self.off(&mut out.rotations[at][1], right.value[last][1], right.error[last]);
                }
            }
            (Output::Gradients, Step::Gradients { poses, out }) => {
                let n = poses.len;
                let own = out.gradients.len() / n;
                for i in 0..n {
                    let pose = exact(poses.one(i).joints);
                    let relative = Inexact::exact(columns(part(&out.relative, n, i)));
                    let angles = exact_rotations(part(&out.rotations, n, i));
                    let turning = tolerance::turning(oracle, &pose, &relative);
                    let right = tolerance::gradients(oracle, turning, &angles, IEEE);
                    let (value, error) = (right.value[0][(0, 1)], right.error[0][(0, 1)]);
                    self.off(&mut out.gradients[i * own + 1][0], value, error);
                }
            }
            (Output::Palette, Step::Palette { poses, input, out }) => {
                let n = poses.len;
                for (i, out) in out.chunks_mut(envelope.palette_len()).enumerate() {
                    let relative = Inexact::exact(columns(part(&input.relative, n, i)));
                    let gradients = Inexact::exact(columns(part(&input.gradients, n, i)));
                    let root = &poses.one(i).joints[envelope.root()];
                    let root = Inexact::exact(vec![widened(root)]);
                    let right = tolerance::palette(oracle, &root, &relative, &gradients);
                    self.off(&mut out[1][2][3], right.value[1][(2, 3)], right.error[1][(2, 3)]);
                }
            }
            (Output::Features, Step::Features { poses, out }) => {
                let feature_len = envelope.counts().feature_len();
                for (i, out) in out.chunks_mut(feature_len).enumerate() {
                    let Poses { joints, curves, .. } = poses.one(i);
                    let curves = exact_floats(curves).value;
                    let right = tolerance::features(oracle, &exact(joints), &curves, IEEE);
                    // The last entry of the first joint's gap.
                    self.off(&mut out[11], right.value[11], right.error[11]);
                }
            }
            (
                Output::Correction | Output::CorrectionConfidence,
                Step::Correction { poses, features, base, out, confidences },
            ) => {
                let n = confidences.len();
                for i in 0..n {
                    let pose = exact(poses.one(i).joints);
                    let (features, base) =
                        (exact_floats(part(features, n, i)), exact(part(&base, n, i)));
                    let (transforms, confidence) =
                        tolerance::correction(oracle, &pose, &features, base, IEEE);
                    let last = transforms.value.len() - 1;
                    let (value, error) = (transforms.value[last], transforms.error[last]);
                    let transform = &mut out[(i + 1) * transforms.value.len() - 1];
                    if self.output == Output::Correction {
                        self.off(&mut transform[2][3], value[(2, 3)], error[(2, 3)]);
                    } else {
                        self.off(&mut confidences[i], confidence.value[0], confidence.error[0]);
                    }
                }
            }
            (Output::Confidence, Step::Confidence { poses, rotations, out }) => {
                for (i, out) in out.iter_mut().enumerate() {
                    let pose = exact(poses.one(i).joints);
                    let rotations = exact_rotations(part(rotations, poses.len, i));
                    let right = tolerance::confidence(oracle, &pose, &rotations, IEEE);
                    self.off(out, right.value[0], right.error[0]);
                }
            }
            (
                Output::Positions | Output::Normals | Output::Tangents,
                Step::Skin { palettes, skin, out },
            ) => {
                let Some(vertex) = skin.vertices.clone().last() else { return };
                let own = (&self.subject.loaded.skin, vertex);
                let vertex = self.subject.skin.vertex(vertex);
                for (i, palette) in palettes.chunks(envelope.palette_len()).enumerate() {
                    let palette = exact(palette);
                    let right = tolerance::skin(own, &vertex, &palette, IEEE);
                    let (attribute, expected, tolerance) = match (self.output, right.tangent) {
                        (Output::Positions, _) => {
                            (skin.positions, right.position[0], right.position_error[0])
                        }
                        (Output::Tangents, Some((tangent, _))) => {
                            (skin.tangents, tangent.value[0], tangent.error)
                        }
                        _ => (skin.normals, right.normal.value[0], right.normal.error),
                    };
                    let Some(own) = attribute else { continue };
                    let place = own.offset
                        + i * own.instance_stride
                        + (skin.vertices.len() - 1) * own.stride;
                    self.off(&mut out[place], expected, tolerance);
                }
            }
            _ => {}
        }
    }
}

/// Compares a backend with one error of `factor` tolerances.
fn off_by(
    subject: &Subject<'_>,
    output: Output,
    factor: f64,
    body: stages::Body,
) -> Result<(), Mismatch> {
    let spoil = Spoil { subject, output, factor, seen: Cell::new(0) };
    let findings = body(&altered(|step: Step<'_>| spoil.alter(step), IEEE), subject)
        .expect("the backend gives something");
    assert!(spoil.seen.get() >= 10, "{output:?} was reached");
    sound(&findings)
}

#[test]
fn one_value_off_by_two_tolerances_is_caught() {
    for (output, bytes) in OUTPUTS.map(|output| (output, output.models())) {
        for bytes in bytes {
            let subject = Subject::new("random", &bytes, FEWER_POSES);
            let off_by = |factor| off_by(&subject, output, factor, stages::body(output.stage()));
            let caught = off_by(2.0);
            assert!(matches!(caught, Err(Mismatch::Beyond { .. })), "{output:?}: {caught:?}");
            assert_eq!(off_by(0.5), Ok(()), "{output:?}: half a tolerance is within it");
        }
    }
}

#[test]
fn a_value_within_its_tolerance_still_counts_as_one_that_differs() {
    let bytes = models::random(shape_of(Predictor::Rotational));
    let subject = Subject::new("random", &bytes, FEWER_POSES);
    let spoil =
        Spoil { subject: &subject, output: Output::Palette, factor: 0.9, seen: Cell::new(0) };
    let backend = altered(|step: Step<'_>| spoil.alter(step), IEEE);
    let [Finding { differing, worst, .. }] = stages::palette::body(&backend, &subject).unwrap()[..]
    else {
        panic!("one output");
    };
    assert_eq!(differing, 1);
    assert!((0.85..0.95).contains(&worst), "{worst}");
}

#[test]
fn a_misplaced_vertex_is_caught_from_pose_to_skin_and_by_the_bounds() {
    for predictor in Predictor::ALL {
        let bytes = models::random(shape_of(predictor));
        let subject = Subject::new("random", &bytes, 28);
        let off_by = |factor, body| off_by(&subject, Output::Positions, factor, body);
        assert!(off_by(1e6, whole::body).is_err());
        assert!(off_by(1e6, whole::equivariance).is_err());
        assert!(off_by(1e9, bounds::body).is_err());
        // Layouts are compared bit by bit, so a single changed value is detected.
        assert!(off_by(2.0, layout::body).is_err());
    }
}

#[test]
fn an_output_left_alone_is_caught() {
    let caught = |backend: &dyn Backend, body: stages::Body, subject: &Subject<'_>| {
        sound(&body(backend, subject).unwrap()).is_err()
    };
    for (output, bytes) in OUTPUTS.map(|output| (output, output.models())) {
        for bytes in bytes {
            let subject = Subject::new("random", &bytes, 2);
            assert!(caught(&idle(), stages::body(output.stage()), &subject), "{output:?}");
        }
    }
    for predictor in Predictor::ALL {
        let bytes = models::random(shape_of(predictor));
        let subject = Subject::new("random", &bytes, 28);
        let bodies: [stages::Body; 4] = [whole::body, whole::rest, layout::body, bounds::body];
        for (number, body) in bodies.into_iter().enumerate() {
            assert!(caught(&idle(), body, &subject), "{predictor:?}, body {number}");
        }
        if predictor.corrects() {
            // Returns the confidence, but adds no correction.
            let uncorrected = altered(
                |step: Step<'_>| {
                    if let Step::Correction { base, out, .. } = step {
                        out.copy_from_slice(&base);
                    }
                },
                IEEE,
            );
            assert!(caught(&uncorrected, correction::body, &subject));
            assert!(caught(&uncorrected, layout::body, &subject));
        }
    }
    let bytes = models::random(shape_of(Predictor::Kernel));
    assert!(caught(&idle(), joints::body, &Subject::new("random", &bytes, 1)));
}

/// Compares stage skin of a backend whose file has other tangent coefficients (pairs of halves).
fn with_others(bytes: &[u8], edit: fn(&mut [[[u8; 2]; 2]])) -> Result<(), Mismatch> {
    let subject = Subject::new("random", bytes, FEWER_POSES);
    let mut pieces = Pieces::of(bytes).expect("a sound file");
    pieces.edit_vertices(SectionKind::TangentCoefficients, |numbers| {
        edit(numbers.as_chunks_mut().0.as_chunks_mut().0);
    });
    let other = pieces.bytes();
    let other = Loaded::new(&other);
    let backend = altered(
        |step: Step<'_>| {
            if let Step::Skin { palettes, skin, out } = step {
                let skin = SkinBatch { skin: other.skin.layout(), ..skin.clone() };
                Cpu.skin(&other, palettes, &skin, out).expect("a sound batch");
            }
        },
        IEEE,
    );
    sound(&stages::body(Stage::Skin)(&backend, &subject).expect("it runs"))
}

#[test]
fn other_tangent_coefficients_are_caught() {
    let last_place = |pairs: &mut [[[u8; 2]; 2]]| pairs[20][1][0] ^= 1;
    let swapped = |pairs: &mut [[[u8; 2]; 2]]| pairs.iter_mut().for_each(|pair| pair.swap(0, 1));
    let sign = |pairs: &mut [[[u8; 2]; 2]]| {
        pairs.as_flattened_mut().iter_mut().for_each(|half| half[1] ^= 0x80);
    };
    let order = |pairs: &mut [[[u8; 2]; 2]]| pairs.reverse();
    for shape in SHAPES.into_iter().filter(|shape| shape.coefficients && shape.vertices > 40) {
        let bytes = models::random(shape);
        assert_eq!(with_others(&bytes, |_| {}), Ok(()));
        for edit in [last_place, swapped, sign, order] as [fn(&mut [[[u8; 2]; 2]]); 4] {
            let caught = with_others(&bytes, edit);
            assert!(matches!(caught, Err(Mismatch::Beyond { .. })), "{shape:?}: {caught:?}");
        }
    }
}

#[test]
fn a_write_between_attributes_is_caught() {
    let bytes = models::random(shape_of(Predictor::Rotational));
    let subject = Subject::new("random", &bytes, 14);
    let careless = altered(
        |step: Step<'_>| {
            if let Step::Skin { out, .. } = step {
                let last = out.len() - 1;
                out[last] = 0.0;
            }
        },
        IEEE,
    );
    let caught = layout::body(&careless, &subject);
    assert!(matches!(caught, Err(Failure::Touched { .. })), "{caught:?}");
}

#[test]
fn vulkan_may_divide_and_take_roots_less_exactly_and_the_cpu_may_not() {
    for output in [Output::Rotations, Output::Gradients, Output::Normals] {
        let bytes = models::random(shape_of(output.predictor()));
        let subject = Subject::new("random", &bytes, FEWER_POSES);
        let run = |arithmetic| {
            // A tenth more than one rounding for each operation explains.
            let spoil = Spoil { subject: &subject, output, factor: 1.1, seen: Cell::new(0) };
            let backend = altered(|step: Step<'_>| spoil.alter(step), arithmetic);
            sound(&stages::body(output.stage())(&backend, &subject).unwrap())
        };
        assert_eq!(run(Arithmetic::VULKAN), Ok(()), "{output:?}");
        assert!(matches!(run(IEEE), Err(Mismatch::Beyond { .. })), "{output:?}");
    }
}
