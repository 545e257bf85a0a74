//! The inputs of a function in a file, as they were given.

use super::input::{Input, InputKind};
use crate::kernel::rotations::Feature;
use sinew_runtime::kernel::{InputKind as FileInput, KernelMap};

/// Returns the inputs of a file's function, of weight 1.
pub fn inputs_of(map: &KernelMap<'_>) -> Vec<Input> {
    let input = |(number, row): (usize, sinew_runtime::kernel::InputRow)| {
        let axis = row.axis.map(f64::from);
        let rotation = |feature| InputKind::Rotation { feature, order: row.euler };
        let kind = match row.kind {
            FileInput::Scalar => InputKind::Scalar,
            FileInput::Vector3 => InputKind::Vector3,
            FileInput::Rotation => rotation(Feature::Matrix),
            FileInput::TwoRows => rotation(Feature::TwoRows),
            FileInput::Swing => rotation(Feature::Swing(axis)),
            FileInput::Twist => rotation(Feature::Twist(axis)),
            FileInput::TwistAngle => rotation(Feature::TwistAngle(axis)),
        };
        let name = map.input_name(number).unwrap_or_default().to_owned();
        Input { name, kind, weight: 1.0 }
    };
    map.inputs().enumerate().map(input).collect()
}
