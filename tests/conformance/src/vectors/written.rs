//! A case to be written: its description, the files that the description names, and the tolerances.

use super::{Folder, VectorError};
use crate::tolerance::{Inexact, Transform, UNDERFLOW};
use nalgebra::SMatrix;
use serde::Serialize;
use sinew_runtime::Matrix3x4;

/// A case with counts of type C.
pub(super) struct Written<C> {
    pub(super) description: Description<C>,
    files: Vec<(String, Vec<u8>)>,
}

#[derive(Serialize)]
pub(super) struct Description<C> {
    version: u32,
    case: String,
    model: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    predictor: Option<&'static str>,
    pub(super) counts: C,
    arrays: Vec<Array>,
    stages: Vec<Stage>,
}

#[derive(Serialize)]
struct Array {
    name: &'static str,
    file: String,
    r#type: &'static str,
    shape: Vec<usize>,
}

#[derive(Serialize)]
struct Stage {
    stage: &'static str,
    inputs: Vec<&'static str>,
    outputs: Vec<Output>,
}

#[derive(Serialize)]
struct Output {
    array: &'static str,
    tolerance: String,
}

impl<C: Serialize> Written<C> {
    /// Starts a case with a name, and with a predictor if it has one.
    pub(super) fn new(case: &str, predictor: Option<&'static str>, counts: C) -> Self {
        let description = Description {
            version: 1,
            case: case.to_owned(),
            model: "model.snw",
            predictor,
            counts,
            arrays: Vec::new(),
            stages: Vec::new(),
        };
        Self { description, files: Vec::new() }
    }

    /// Adds an array of floats.
    pub(super) fn array(&mut self, name: &'static str, shape: Vec<usize>, values: &[f32]) {
        let file = format!("{name}.f32");
        self.files.push((file.clone(), le(values)));
        self.description.arrays.push(Array { name, file, r#type: "f32", shape });
    }

    /// Adds an array of u32.
    pub(super) fn indices(&mut self, name: &'static str, shape: Vec<usize>, values: &[u32]) {
        let file = format!("{name}.u32");
        let bytes = values.iter().flat_map(|index| index.to_le_bytes()).collect();
        self.files.push((file.clone(), bytes));
        self.description.arrays.push(Array { name, file, r#type: "u32", shape });
    }

    /// Adds a stage with the tolerances of its outputs.
    pub(super) fn stage(
        &mut self,
        stage: &'static str,
        inputs: &[&'static str],
        outputs: Vec<(&'static str, Vec<f32>)>,
    ) {
        let whole = if stage == "whole" { "whole." } else { "" };
        let output = |(array, tolerance): (&'static str, Vec<f32>)| {
            let file = format!("{array}.{whole}tolerance.f32");
            self.files.push((file.clone(), le(&tolerance)));
            Output { array, tolerance: file }
        };
        let outputs = outputs.into_iter().map(output).collect();
        self.description.stages.push(Stage { stage, inputs: inputs.to_vec(), outputs });
    }

    /// Writes the case into a folder with its name.
    ///
    /// # Errors
    /// [`VectorError`]
    pub(super) fn write(self, model: &[u8], folder: &Folder) -> Result<(), VectorError> {
        let name = |file: &str| format!("{}/{file}", self.description.case);
        folder.write(&name("model.snw"), model)?;
        let json = serde_json::to_string_pretty(&self.description)? + "\n";
        folder.write(&name("case.json"), json.as_bytes())?;
        for (file, bytes) in &self.files {
            folder.write(&name(file), bytes)?;
        }
        Ok(())
    }
}

fn le(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// Tolerances of a backend's values relative to the CPU's values, which the vectors hold. Each
/// tolerance is the bound of the backend's error plus the CPU's own distance from the oracle,
/// rounded up.
pub(super) struct Tolerance(pub(super) Vec<f32>);

impl Tolerance {
    /// Starts without tolerances.
    pub(super) const fn new() -> Self {
        Self(Vec::new())
    }

    /// Adds the tolerance of a value.
    pub(super) fn add(&mut self, cpu: f32, oracle: f64, error: f64) {
        let apart = (f64::from(cpu) - oracle).abs();
        let most = if error + apart > 0.0 { error + UNDERFLOW + apart } else { 0.0 };
        let rounded = most as f32;
        self.0.push(if f64::from(rounded) < most { rounded.next_up() } else { rounded });
    }

    /// Adds the tolerances of columns.
    pub(super) fn columns<const C: usize>(
        &mut self,
        found: &[[f32; 3]],
        bounds: &Inexact<SMatrix<f64, 3, C>>,
    ) {
        let right = bounds.value.iter().flatten().zip(bounds.error.iter().flatten());
        for (x, (value, error)) in found.as_flattened().iter().zip(right) {
            self.add(*x, *value, *error);
        }
    }

    /// Adds the tolerances of transforms.
    pub(super) fn transforms(&mut self, found: &[Matrix3x4], bounds: &Inexact<Transform>) {
        for (found, (value, error)) in found.iter().zip(bounds.value.iter().zip(&bounds.error)) {
            for (r, row) in found.iter().enumerate() {
                for (c, x) in row.iter().enumerate() {
                    self.add(*x, value[(r, c)], error[(r, c)]);
                }
            }
        }
    }
}

/// Lists the tolerances of every pose's transforms.
pub(super) fn transforms_tolerance(found: &[Matrix3x4], bounds: &[Inexact<Transform>]) -> Vec<f32> {
    let mut out = Tolerance::new();
    for (i, bounds) in bounds.iter().enumerate() {
        out.transforms(&found[i * bounds.value.len()..], bounds);
    }
    out.0
}

/// Lists the tolerances of every pose's number.
pub(super) fn numbers_tolerance(found: &[f32], bounds: &[Inexact<f64>]) -> Vec<f32> {
    let mut out = Tolerance::new();
    for (x, bound) in found.iter().zip(bounds) {
        out.add(*x, bound.value[0], bound.error[0]);
    }
    out.0
}
