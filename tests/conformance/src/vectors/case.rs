//! A case of a model with poses, and the outputs of every stage.

use super::written::{Tolerance, Written, numbers_tolerance, transforms_tolerance};
use super::{Folder, VectorError};
use crate::backend::{Failure, Loaded, floats, part};
use crate::cpu::Cpu;
use crate::poses::{Kind, Pose, poses};
use crate::stages::correction::{base_of, exact_floats};
use crate::stages::exact;
use crate::stages::features::features_of;
use crate::stages::gradients::{columns, exact_rotations, gradients_of};
use crate::stages::polar::split_of;
use crate::stages::skin::{Skinned, whole_of};
use crate::subject::Subject;
use crate::tolerance::{self, Arithmetic, Inexact, Transform};
use serde::Serialize;
use sinew_gpu::layout::SkinBatch;
use sinew_runtime::Matrix3x4;
use sinew_runtime::envelope::STRAIN_LEN;
use std::f64::consts::PI;

/// Precision that a foreign backend must have.
const ARITHMETIC: Arithmetic = Arithmetic::VULKAN;

/// A case with its subject.
pub(super) struct Case<'a> {
    subject: &'a Subject<'a>,
    written: Written<Counts>,
}

#[derive(Serialize)]
struct Counts {
    poses: usize,
    joints: usize,
    proxies: usize,
    palette: usize,
    vertices: usize,
    influences: usize,
    curves: usize,
    features: usize,
}

/// Loads a model and draws poses. Poses with a joint at a half turn, within the tolerance, are left
/// out: two rotation vectors represent a half turn, and gradients depend on the choice.
pub(super) fn subject(bytes: &[u8], pose_len: usize) -> Subject<'_> {
    let out = Subject::new("vectors", bytes, 0);
    let turned = |pose: &Pose| {
        if pose.transforms.is_empty() {
            return false;
        }
        let pose = Inexact::exact(pose.widened());
        let relative = tolerance::relative(&out.oracle, &pose, ARITHMETIC);
        let turning = tolerance::turning(&out.oracle, &pose, &relative);
        let found = tolerance::rotations(&out.oracle, turning, ARITHMETIC);
        found.value.iter().zip(&found.error).any(|(theta, error)| theta.norm() + error >= PI)
    };
    let all = poses(&out.loaded.envelope, pose_len).into_iter();
    let kept = all.filter(|pose| pose.kind != Kind::HalfTurn && !turned(pose));
    Subject::with_poses(out.name, out.loaded, kept.collect())
}

impl<'a> Case<'a> {
    pub(super) fn new(name: &str, subject: &'a Subject<'a>) -> Self {
        let Loaded { envelope, skin, .. } = &subject.loaded;
        let counts = Counts {
            poses: subject.poses.len(),
            joints: envelope.joint_len(),
            proxies: envelope.proxy_len(),
            palette: envelope.palette_len(),
            vertices: skin.vertex_len(),
            influences: skin.influence_len(),
            curves: envelope.curve_len(),
            features: envelope.counts().feature_len(),
        };
        let predictor = Some(envelope.predictor().name());
        Self { subject, written: Written::new(name, predictor, counts) }
    }

    /// Evaluates all stages, and writes the case into a folder with its name.
    pub(super) fn write(mut self, model: &[u8], folder: &Folder) -> Result<(), VectorError> {
        self.mesh();
        self.poses()?;
        self.written.write(model, folder)
    }

    /// Adds the mesh. The model has the mesh as well, but this way a skin can be checked without a
    /// reader of models.
    fn mesh(&mut self) {
        let skin = self.subject.loaded.skin;
        let (v, k) = (skin.vertex_len(), skin.influence_len());
        let flat = |list: Vec<[f32; 3]>| list.into_flattened();
        let positions = (0..v).filter_map(|vertex| skin.rest_position(vertex)).collect();
        self.written.array("rest_positions", vec![v, 3], &flat(positions));
        let normals = (0..v).filter_map(|vertex| skin.rest_normal(vertex)).collect();
        self.written.array("rest_normals", vec![v, 3], &flat(normals));
        if skin.has_tangents() {
            let tangents = (0..v).filter_map(|vertex| skin.rest_tangent(vertex));
            self.written.array(
                "rest_tangents",
                vec![v, 4],
                &tangents.flatten().collect::<Vec<_>>(),
            );
        }
        let influences: Vec<_> = (0..v).flat_map(|vertex| skin.influences(vertex)).collect();
        let indices: Vec<_> = influences.iter().map(|(index, _)| *index as u32).collect();
        self.written.indices("influence_indices", vec![v, k], &indices);
        let weights: Vec<_> = influences.iter().map(|(_, weight)| *weight).collect();
        self.written.array("influence_weights", vec![v, k], &weights);
        if skin.has_coefficients() {
            let coefficients = (0..v).flat_map(|vertex| skin.tangent_coefficients(vertex));
            let flat: Vec<_> = coefficients.flatten().collect();
            self.written.array("tangent_coefficients", vec![v, k - 1, 2], &flat);
        }
    }

    fn poses(&mut self) -> Result<(), Failure> {
        let subject = self.subject;
        let Counts { poses: n, joints: j, palette: m, curves: c, .. } =
            self.written.description.counts;
        self.written.array("pose", vec![n, j, 3, 4], floats(&subject.transforms));
        if c > 0 {
            self.written.array("curves", vec![n, c], &subject.curves);
        }
        self.polar()?;
        let whole = whole_of(&Cpu, subject)?;
        let (reconstructs, corrects) =
            (subject.oracle.predictor().reconstructs(), subject.oracle.predictor().corrects());
        // The palette before a correction is the array `base`.
        let base_name = if corrects { "base" } else { "palette" };
        let base = base_of(&Cpu, subject)?;
        let mut rotations = Vec::new();
        if reconstructs {
            rotations = self.reconstruction(base_name, &base)?;
        } else {
            let bounds: Vec<_> =
                subject.transforms_of(|pose| tolerance::joints(&subject.oracle, &pose));
            self.transforms("base", vec![n, m, 3, 4], &base);
            self.written.stage(
                "joints",
                &["pose"],
                vec![("base", transforms_tolerance(&base, &bounds))],
            );
        }
        if corrects {
            self.correction(&base, &whole.palettes, &whole.confidences)?;
        } else {
            self.written.array("confidence", vec![n], &whole.confidences);
            let bounds = (0..n).map(|i| {
                let pose = exact(part(&subject.transforms, n, i));
                let given = exact_rotations(part(&rotations, n, i));
                tolerance::confidence(&subject.oracle, &pose, &given, ARITHMETIC)
            });
            let tolerance = numbers_tolerance(&whole.confidences, &bounds.collect::<Vec<_>>());
            let inputs = self.given(&["pose", "rotations"], &["strains"]);
            self.written.stage("confidence", &inputs, vec![("confidence", tolerance)]);
        }
        let skin = SkinBatch::new(&subject.loaded.skin);
        let skinned = Skinned::gather(&whole.skin, &skin, n);
        self.skin(&whole.palettes, &skinned);
        self.end_to_end(&rotations, &whole.palettes, &whole.confidences, &skinned);
        Ok(())
    }

    /// Adds stage polar, if joints stretch.
    fn polar(&mut self) -> Result<(), Failure> {
        let subject = self.subject;
        if !subject.loaded.envelope.stretches() {
            return Ok(());
        }
        let Counts { poses: n, joints: j, .. } = self.written.description.counts;
        let all = split_of(&Cpu, subject)?;
        let (turns, strains) = (all.turns.as_flattened(), all.strains.as_flattened());
        self.written.array("turns", vec![n, j, 3, 3], turns.as_flattened());
        self.written.array("strains", vec![n, j, STRAIN_LEN], strains);
        let [mut of_turns, mut of_strains] = [const { Tolerance::new() }; 2];
        for i in 0..n {
            let pose = exact(part(&subject.transforms, n, i));
            let (turn, strain) = tolerance::polar(&subject.oracle, &pose, ARITHMETIC);
            of_turns.columns(part(turns, n, i), &turn);
            let right = strain.value.iter().flatten().zip(strain.error.iter().flatten());
            for (x, (value, error)) in part(strains, n, i).iter().zip(right) {
                of_strains.add(*x, *value, *error);
            }
        }
        let outputs = vec![("turns", of_turns.0), ("strains", of_strains.0)];
        self.written.stage("polar", &["pose"], outputs);
        Ok(())
    }

    /// Lists the inputs of a stage; the second list are outputs of stage polar, if joints stretch.
    fn given(&self, inputs: &[&'static str], split: &[&'static str]) -> Vec<&'static str> {
        let stretches = self.subject.loaded.envelope.stretches();
        [inputs, if stretches { split } else { &[] }].concat()
    }

    /// Adds stages gradients and palette; returns the rotations.
    fn reconstruction(
        &mut self,
        base_name: &'static str,
        base: &[Matrix3x4],
    ) -> Result<Vec<[f32; 3]>, Failure> {
        let (subject, oracle) = (self.subject, &self.subject.oracle);
        let Counts { poses: n, joints: j, proxies: p, palette: m, .. } =
            self.written.description.counts;
        let all = gradients_of(&Cpu, subject)?;
        self.written.array("relative", vec![n, 4 * j, 3], all.relative.as_flattened());
        self.written.array("rotations", vec![n, j, 3], all.rotations.as_flattened());
        self.written.array("gradients", vec![n, 3 * p, 3], all.gradients.as_flattened());
        let [mut relative, mut rotations, mut gradients, mut palette] =
            [const { Tolerance::new() }; 4];
        for i in 0..n {
            let pose = exact(part(&subject.transforms, n, i));
            let q = tolerance::relative(oracle, &pose, ARITHMETIC);
            relative.columns(part(&all.relative, n, i), &q);
            let turning = tolerance::turning(oracle, &pose, &q);
            let theta = tolerance::rotations(oracle, turning, ARITHMETIC);
            for (found, (value, error)) in
                part(&all.rotations, n, i).iter().zip(theta.value.iter().zip(&theta.error))
            {
                found.iter().zip(value).for_each(|(x, value)| rotations.add(*x, *value, *error));
            }
            let d = tolerance::gradients(oracle, turning, &theta, ARITHMETIC);
            gradients.columns(part(&all.gradients, n, i), &d);
            let given = |list: &[[f32; 3]]| Inexact::exact(columns(list));
            let root = Inexact::exact(vec![pose.value[oracle.skeleton.root()]]);
            let given_d = columns(part(&all.gradients, n, i));
            let bounds = tolerance::palette(
                oracle,
                &root,
                &given(part(&all.relative, n, i)),
                &Inexact::exact(given_d),
            );
            palette.transforms(part(base, n, i), &bounds);
        }
        let outputs =
            vec![("relative", relative.0), ("rotations", rotations.0), ("gradients", gradients.0)];
        let inputs = self.given(&["pose"], &["turns", "strains"]);
        self.written.stage("gradients", &inputs, outputs);
        self.transforms(base_name, vec![n, m, 3, 4], base);
        self.written.stage(
            "palette",
            &["pose", "relative", "gradients"],
            vec![(base_name, palette.0)],
        );
        Ok(all.rotations)
    }

    fn correction(
        &mut self,
        base: &[Matrix3x4],
        palettes: &[Matrix3x4],
        confidences: &[f32],
    ) -> Result<(), Failure> {
        let (subject, oracle) = (self.subject, &self.subject.oracle);
        let Counts { poses: n, palette: m, features: f, curves: c, .. } =
            self.written.description.counts;
        let features = features_of(&Cpu, subject)?;
        self.written.array("features", vec![n, f], &features);
        let bounds = subject.poses.iter().map(|pose| {
            let (given, curves) = (Inexact::exact(pose.widened()), pose.widened_curves());
            tolerance::features(oracle, &given, &curves, ARITHMETIC)
        });
        let mut tolerance = Tolerance::new();
        for (i, right) in bounds.enumerate() {
            let right = right.value.iter().zip(&right.error);
            for (x, (value, error)) in part(&features, n, i).iter().zip(right) {
                tolerance.add(*x, *value, *error);
            }
        }
        let curves: &[_] = if c > 0 { &["curves"] } else { &[] };
        let inputs = self.given(&[&["pose"][..], curves].concat(), &["turns", "strains"]);
        self.written.stage("features", &inputs, vec![("features", tolerance.0)]);
        self.transforms("palette", vec![n, m, 3, 4], palettes);
        self.written.array("confidence", vec![n], confidences);
        let bounds = (0..n).map(|i| {
            let [pose, base] = [&subject.transforms, base].map(|list| exact(part(list, n, i)));
            let features = exact_floats(part(&features, n, i));
            tolerance::correction(oracle, &pose, &features, base, ARITHMETIC)
        });
        let (transforms, certain): (Vec<_>, Vec<_>) = bounds.unzip();
        let outputs = vec![
            ("palette", transforms_tolerance(palettes, &transforms)),
            ("confidence", numbers_tolerance(confidences, &certain)),
        ];
        self.written.stage("correction", &["pose", "features", "base"], outputs);
        Ok(())
    }

    fn skin(&mut self, palettes: &[Matrix3x4], skinned: &Skinned) {
        let Counts { poses: n, vertices: v, .. } = self.written.description.counts;
        self.written.array("positions", vec![n, v, 3], &skinned.positions);
        self.written.array("normals", vec![n, v, 3], &skinned.normals);
        if self.subject.loaded.skin.has_tangents() {
            self.written.array("tangents", vec![n, v, 4], &skinned.tangents);
        }
        let given: Vec<_> = (0..n).map(|i| exact(part(palettes, n, i))).collect();
        let outputs = self.skin_tolerances(skinned, &given);
        self.written.stage("skin", &["palette"], outputs);
    }

    fn end_to_end(
        &mut self,
        rotations: &[[f32; 3]],
        palettes: &[Matrix3x4],
        confidences: &[f32],
        skinned: &Skinned,
    ) {
        let (subject, n) = (self.subject, self.written.description.counts.poses);
        let bounds = (0..n).map(|i| {
            let pose = exact(part(&subject.transforms, n, i));
            let curves = subject.poses[i].widened_curves();
            let rotations = part(rotations, n, i);
            tolerance::whole(&subject.oracle, &pose, &curves, rotations, ARITHMETIC)
        });
        let (transforms, certain): (Vec<_>, Vec<_>) = bounds.unzip();
        let mut outputs = vec![
            ("palette", transforms_tolerance(palettes, &transforms)),
            ("confidence", numbers_tolerance(confidences, &certain)),
        ];
        outputs.extend(self.skin_tolerances(skinned, &transforms));
        let curves = subject.loaded.envelope.curve_len() > 0;
        let inputs: &[_] = if curves { &["pose", "curves"] } else { &["pose"] };
        self.written.stage("whole", inputs, outputs);
    }

    fn skin_tolerances(
        &self,
        skinned: &Skinned,
        palettes: &[Inexact<Transform>],
    ) -> Vec<(&'static str, Vec<f32>)> {
        let n = palettes.len();
        let [mut positions, mut normals, mut tangents] = [const { Tolerance::new() }; 3];
        for (i, palette) in palettes.iter().enumerate() {
            let found = skinned.at(n, i);
            for (v, vertex) in self.subject.skin.vertices().enumerate() {
                let own = (&self.subject.loaded.skin, v);
                let right = tolerance::skin(own, &vertex, palette, ARITHMETIC);
                for c in 0..3 {
                    let at = 3 * v + c;
                    positions.add(found[0][at], right.position[c], right.position_error[c]);
                    normals.add(found[1][at], right.normal.value[c], right.normal.error);
                }
                if let Some((tangent, _)) = right.tangent {
                    for c in 0..3 {
                        tangents.add(found[2][4 * v + c], tangent.value[c], tangent.error);
                    }
                    // The handedness is copied.
                    tangents.0.push(0.0);
                }
            }
        }
        let mut out = vec![("positions", positions.0), ("normals", normals.0)];
        if self.subject.loaded.skin.has_tangents() {
            out.push(("tangents", tangents.0));
        }
        out
    }

    fn transforms(&mut self, name: &'static str, shape: Vec<usize>, transforms: &[Matrix3x4]) {
        self.written.array(name, shape, floats(transforms));
    }
}

impl Subject<'_> {
    /// Returns the bounds of a stage for every pose.
    fn transforms_of(
        &self,
        bound: impl Fn(Inexact<Transform>) -> Inexact<Transform>,
    ) -> Vec<Inexact<Transform>> {
        self.poses.iter().map(|pose| bound(Inexact::exact(pose.widened()))).collect()
    }
}
