//! Arguments that several commands share, and parsers of their numbers.

use super::files::{OfFile, read_model};
use crate::examples::Examples;
use crate::space::{Conversion, SpaceRequest};
use anyhow::Context;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use serde_json::{Value, json};
use sinew_runtime::Model;
use sinew_runtime::format::{Axis, Handedness, Space};
use std::fmt::Display;
use std::ops::{Bound, RangeBounds};
use std::path::{Path, PathBuf};

/// Baked model to read.
#[derive(clap::Args)]
pub(super) struct ModelArgs {
    /// Model that a `train` command wrote
    #[arg(value_name = "MODEL")]
    pub(super) file: PathBuf,
}

impl ModelArgs {
    /// Loads the model.
    ///
    /// # Errors
    /// The file cannot be read, or is no model.
    pub(super) fn load(&self) -> anyhow::Result<Model<Vec<u8>>> {
        load(&self.file)
    }
}

/// Loads a model.
///
/// # Errors
/// The file cannot be read, or is no model.
pub(super) fn load(file: &Path) -> anyhow::Result<Model<Vec<u8>>> {
    Model::from_bytes(read_model(file)?).of(file)
}

/// Numbers above 0.
pub(super) const POSITIVE: (Bound<f64>, Bound<f64>) = (Bound::Excluded(0.0), Bound::Unbounded);

/// Makes a parser of a finite number in a range. Its message states the range and the unit.
pub(super) fn number(
    range: impl RangeBounds<f64> + Clone + Send + Sync + 'static,
    unit: &'static str,
) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    move |text| {
        let number = text.parse().ok().filter(|x: &f64| x.is_finite() && range.contains(x));
        number.ok_or_else(|| {
            let least = match range.start_bound() {
                Bound::Included(least) => format!(" from {}", short(*least)),
                Bound::Excluded(least) => format!(" above {}", short(*least)),
                Bound::Unbounded => String::new(),
            };
            let most = match range.end_bound() {
                Bound::Included(most) => format!(" to {}", short(*most)),
                Bound::Excluded(most) => format!(" and below {}", short(*most)),
                Bound::Unbounded => String::new(),
            };
            format!("expected a number{least}{most}{unit}")
        })
    }
}

/// Makes a parser of a whole number from `least` to `most`.
pub(super) fn count(
    least: usize,
    most: usize,
) -> impl Fn(&str) -> Result<usize, String> + Clone + Send + Sync + 'static {
    move |text| {
        let number = text.parse().ok().filter(|number| (least..=most).contains(number));
        number.ok_or_else(|| format!("expected a whole number from {least} to {most}"))
    }
}

/// Makes a parser of names for values. The help and errors list the names.
pub(super) fn named<T: Copy + Send + Sync + 'static>(
    all: impl IntoIterator<Item = (&'static str, T)>,
) -> impl TypedValueParser<Value = T> {
    let all: Vec<(&str, T)> = all.into_iter().collect();
    let value = {
        let all = all.clone();
        move |name: String| {
            let found = all.iter().find(|(own, _)| *own == name);
            found.map(|(_, value)| *value).ok_or("unknown name")
        }
    };
    PossibleValuesParser::new(all.into_iter().map(|(name, _)| name)).try_map(value)
}

/// Writes a bound of a range, with an exponent if it is very small or large.
fn short(x: f64) -> String {
    if x == 0.0 || (1e-4..1e6).contains(&x.abs()) { x.to_string() } else { format!("{x:e}") }
}

/// Axes and unit of the examples, where their file lacks them or has wrong ones.
#[derive(clap::Args)]
#[command(next_help_heading = "Space of the examples")]
pub(super) struct StatedSpace {
    /// Axis along which the character stands [default: from the file; a .npz may lack it]
    #[arg(long, value_name = "AXIS", value_parser = axis(), allow_hyphen_values = true)]
    pub(super) up: Option<Axis>,
    /// Axis along which the character looks [default: from the file]
    #[arg(long, value_name = "AXIS", value_parser = axis(), allow_hyphen_values = true)]
    forward: Option<Axis>,
    /// Unit of length in metres: 0.01 for centimetres [default: from the file]
    #[arg(long, value_name = "METRES", value_parser = metres(), allow_negative_numbers = true)]
    unit: Option<f64>,
}

const HANDS: [Handedness; 2] = [Handedness::Left, Handedness::Right];

/// Space to convert to.
#[derive(clap::Args)]
#[command(next_help_heading = "Space of an engine")]
pub(super) struct TargetSpace {
    /// Convert: the character then stands along this axis [default: unchanged]
    ///
    /// Unreal takes `--to-up z --to-forward x --to-hand left --to-unit 0.01`, Unity `--to-up y
    /// --to-forward z --to-hand left --to-unit 1`.
    #[arg(long, value_name = "AXIS", value_parser = axis(), allow_hyphen_values = true)]
    to_up: Option<Axis>,
    /// Convert: the character then looks along this axis [default: unchanged]
    #[arg(long, value_name = "AXIS", value_parser = axis(), allow_hyphen_values = true)]
    to_forward: Option<Axis>,
    /// Convert to axes of this handedness
    ///
    /// If the handedness changes, left and right of the coordinates are exchanged. Triangles are turned over, so that
    /// normals still point outward.
    #[arg(long, value_name = "HAND", value_parser = named(HANDS.map(|hand| (name(hand), hand))))]
    to_hand: Option<Handedness>,
    /// Convert to a unit of this many metres
    #[arg(long, value_name = "METRES", value_parser = metres(), allow_negative_numbers = true)]
    to_unit: Option<f64>,
}

impl StatedSpace {
    /// Sets the space of examples from a file.
    pub(super) fn set(&self, examples: &mut Examples, file: impl Display) -> anyhow::Result<()> {
        examples.space = self.of(examples.space, file)?;
        Ok(())
    }

    /// Returns the space of a file, with the stated axes and unit.
    pub(super) fn of(&self, space: Space, file: impl Display) -> anyhow::Result<Space> {
        let Self { up, forward, unit } = *self;
        let unit = unit.map(|unit| unit as f32);
        let request = SpaceRequest { up, forward, handedness: None, unit };
        request.of(space).with_context(|| file.to_string())
    }
}

impl TargetSpace {
    /// Returns the requested axes and unit.
    pub(super) fn request(&self) -> SpaceRequest {
        let unit = self.to_unit.map(|unit| unit as f32);
        SpaceRequest { up: self.to_up, forward: self.to_forward, handedness: self.to_hand, unit }
    }

    /// Converts examples from a file; returns the conversion.
    pub(super) fn convert(
        &self,
        examples: &mut Examples,
        file: impl Display,
    ) -> anyhow::Result<Option<Conversion>> {
        let found = Conversion::to(examples.space, &self.request());
        let (space, conversion) = found.with_context(|| file.to_string())?;
        if let Some(conversion) = &conversion {
            examples.convert(conversion, space);
        }
        Ok(conversion)
    }
}

fn axis() -> impl TypedValueParser<Value = Axis> {
    named(Axis::ALL.map(|axis| (axis.name(), axis)))
}

fn metres() -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    number(1e-9..=1e9, " metres, as 0.01 for centimetres")
}

fn name(handedness: Handedness) -> &'static str {
    match handedness {
        Handedness::Left => "left",
        Handedness::Right => "right",
    }
}

/// Describes a space in a line.
pub(super) fn describe_space(space: &Space) -> String {
    let axis = |axis: Option<Axis>| axis.map_or("not known", Axis::name);
    let unit = space.unit.map_or("not known".to_owned(), |metres| format!("{metres} m"));
    format!(
        "up {}, forward {}, {}-handed, unit {unit}",
        axis(space.up),
        axis(space.forward),
        name(space.handedness)
    )
}

/// Returns a space as JSON; unknown axes and an unknown unit are null.
pub(super) fn space_as_json(space: &Space) -> Value {
    json!({
        "up": space.up.map(Axis::name),
        "forward": space.forward.map(Axis::name),
        "handedness": name(space.handedness),
        "unit_metres": space.unit.map(|unit| unit.to_string().parse::<f64>().ok()),
    })
}
