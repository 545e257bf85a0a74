//! Axes, handedness and unit as the command line says them.

use anyhow::Context;
use serde_json::{Value, json};
use sinew_runtime::format::{Axis, Handedness, Space};
use sinew_trainer::examples::Examples;
use sinew_trainer::space::{Conversion, SpaceRequest};

/// What the file of the examples does not say of their space, or says wrongly.
#[derive(clap::Args)]
#[command(next_help_heading = "The space of the examples")]
pub(super) struct StatedSpace {
    /// The axis along which the character stands in the examples: x, -x, y, -y, z or -z [default:
    /// what the file says, which a .npz need not]
    #[arg(long, value_name = "AXIS", value_parser = axis, allow_hyphen_values = true)]
    pub(super) up: Option<Axis>,
    /// The axis along which it looks [default: what the file says]
    #[arg(long, value_name = "AXIS", value_parser = axis, allow_hyphen_values = true)]
    forward: Option<Axis>,
    /// Metres of a unit of length: 0.01 for centimetres [default: what the file says]
    #[arg(long, value_name = "METRES", value_parser = metres, allow_negative_numbers = true)]
    unit: Option<f32>,
}

/// The space to convert to.
#[derive(clap::Args)]
#[command(next_help_heading = "The space of an engine")]
pub(super) struct TargetSpace {
    /// Convert, so that the character stands along this axis [default: as it does]
    ///
    /// Unreal takes `--to-up z --to-forward x --to-hand left --to-unit 0.01`, Unity `--to-up y
    /// --to-forward z --to-hand left --to-unit 1`.
    #[arg(long, value_name = "AXIS", value_parser = axis, allow_hyphen_values = true)]
    to_up: Option<Axis>,
    /// Convert, so that it looks along this axis [default: as it does]
    #[arg(long, value_name = "AXIS", value_parser = axis, allow_hyphen_values = true)]
    to_forward: Option<Axis>,
    /// Convert to axes of this handedness, left or right; where it changes, left and right of the
    /// coordinates change places, and triangles are turned over so that normals stay outward
    #[arg(long, value_name = "HAND", value_parser = hand)]
    to_hand: Option<Handedness>,
    /// Convert to a unit of so many metres
    #[arg(long, value_name = "METRES", value_parser = metres, allow_negative_numbers = true)]
    to_unit: Option<f32>,
}

impl StatedSpace {
    /// Says it of examples from a file.
    pub(super) fn say(&self, examples: &mut Examples, file: &str) -> anyhow::Result<()> {
        examples.space = self.of(examples.space, file)?;
        Ok(())
    }

    /// Says it of the space of a file.
    pub(super) fn of(&self, space: Space, file: &str) -> anyhow::Result<Space> {
        let Self { up, forward, unit } = *self;
        let request = SpaceRequest { up, forward, handedness: None, unit };
        request.of(space).with_context(|| file.to_owned())
    }
}

impl TargetSpace {
    /// Returns what is asked for.
    pub(super) fn request(&self) -> SpaceRequest {
        let Self { to_up: up, to_forward: forward, to_hand: handedness, to_unit: unit } = *self;
        SpaceRequest { up, forward, handedness, unit }
    }

    /// Converts examples from a file; returns what was done.
    pub(super) fn convert(
        &self,
        examples: &mut Examples,
        file: &str,
    ) -> anyhow::Result<Option<Conversion>> {
        let found = Conversion::to(examples.space, &self.request());
        let (space, conversion) = found.with_context(|| file.to_owned())?;
        if let Some(conversion) = &conversion {
            examples.convert(conversion, space);
        }
        Ok(conversion)
    }
}

/// Parses an axis.
fn axis(text: &str) -> Result<Axis, String> {
    let named = Axis::ALL.into_iter().find(|axis| axis.name() == text);
    named.ok_or_else(|| "expected x, -x, y, -y, z or -z".to_owned())
}

fn hand(text: &str) -> Result<Handedness, String> {
    let named = [Handedness::Left, Handedness::Right].into_iter().find(|&hand| name(hand) == text);
    named.ok_or_else(|| "expected left or right".to_owned())
}

/// Parses a length.
fn metres(text: &str) -> Result<f32, String> {
    match text.parse() {
        Ok(metres) if (1e-9..=1e9).contains(&metres) => Ok(metres),
        _ => {
            Err("expected metres of a unit of length, from 1e-9 to 1e9: 0.01 for centimetres"
                .into())
        }
    }
}

fn name(handedness: Handedness) -> &'static str {
    match handedness {
        Handedness::Left => "left",
        Handedness::Right => "right",
    }
}

/// Describes a space in a line.
pub(super) fn describe(space: &Space) -> String {
    let axis = |axis: Option<Axis>| axis.map_or("not known", Axis::name);
    let unit = space.unit.map_or("not known".to_owned(), |metres| format!("{metres} m"));
    format!(
        "up {}, forward {}, {}-handed, unit {unit}",
        axis(space.up),
        axis(space.forward),
        name(space.handedness)
    )
}

/// A space as JSON; what is not known is null.
pub(super) fn as_json(space: &Space) -> Value {
    json!({
        "up": space.up.map(Axis::name),
        "forward": space.forward.map(Axis::name),
        "handedness": name(space.handedness),
        "unit_metres": space.unit.map(|unit| unit.to_string().parse::<f64>().ok()),
    })
}
