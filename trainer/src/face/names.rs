//! Matches the columns of a take with the shapes of a face.

use crate::Error;
use crate::formats::csv::NO_VALUES;
use std::fmt::Display;

/// ARKit's rotation angles of head and eyes. Joints carry these rotations, so no shape has these names.
const ANGLES: [&str; 9] = [
    "headyaw",
    "headpitch",
    "headroll",
    "lefteyeyaw",
    "lefteyepitch",
    "lefteyeroll",
    "righteyeyaw",
    "righteyepitch",
    "righteyeroll",
];

/// Column with the number of weights in a row.
const COUNT: &str = "blendshapecount";
/// Characters between the name of a node or mesh and the name of a shape.
const PREFIX_ENDS: [char; 4] = ['.', ':', '|', '/'];
/// Characters that end a prefix or separate the words of a name.
const WORD_ENDS: [char; 3] = ['_', '-', ' '];

/// Stems of ARKit's expressions: without a side, and with a side.
const ARKIT: [&[&str]; 2] = [
    &[
        "jawforward",
        "jawopen",
        "mouthclose",
        "mouthfunnel",
        "mouthpucker",
        "mouthrolllower",
        "mouthrollupper",
        "mouthshruglower",
        "mouthshrugupper",
        "browinnerup",
        "cheekpuff",
        "tongueout",
    ],
    &[
        "eyeblink",
        "eyelookdown",
        "eyelookin",
        "eyelookout",
        "eyelookup",
        "eyesquint",
        "eyewide",
        "jaw",
        "mouth",
        "mouthsmile",
        "mouthfrown",
        "mouthdimple",
        "mouthstretch",
        "mouthpress",
        "mouthlowerdown",
        "mouthupperup",
        "browdown",
        "browouterup",
        "cheeksquint",
        "nosesneer",
    ],
];

/// Most suggestions for an unknown name.
const SUGGESTIONS: usize = 3;
/// Least Jaro-Winkler similarity of a suggestion: misspelt names have 0.7 and more, other names 0.63 and less.
const LEAST_SIMILARITY: f64 = 0.7;

/// A parsed name, independent of its spelling.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Expression {
    /// Name in lower case, letters and digits only, without the side.
    pub stem: String,
    /// Its side: left or right.
    pub side: Option<Side>,
}

/// A side of a face, as seen by the face's owner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Left.
    Left,
    /// Right.
    Right,
}

/// Match of a take's columns with a face's shapes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Columns {
    /// Shapes that each column drives; empty for a skipped column.
    pub driven: Vec<Vec<usize>>,
    /// Names of expressions and angles without a shape.
    pub skipped: Vec<String>,
    /// Names that are not shapes, and not known as columns without a shape.
    pub unknown: Vec<String>,
}

impl Expression {
    /// Parses a name: `EyeBlinkLeft`, `eyeBlink_L` and `eye_blink.l` are equal.
    pub fn of(name: &str) -> Self {
        let small = name.to_lowercase();
        let sides = [
            ("left", Side::Left),
            ("right", Side::Right),
            ("_l", Side::Left),
            ("_r", Side::Right),
            (".l", Side::Left),
            (".r", Side::Right),
        ];
        let found = sides.iter().find_map(|(end, side)| Some((small.strip_suffix(end)?, *side)));
        let (stem, side) = found.map_or((small.as_str(), None), |(stem, side)| (stem, Some(side)));
        Self { stem: stem.chars().filter(|c| c.is_alphanumeric()).collect(), side }
    }

    /// Parses a name like [`Expression::of`], without the prefix of a node or mesh: `blendShape1.eyeBlink_L`,
    /// `Head|eyeBlink.L` and `BS_EyeBlinkLeft` are `eyeBlink_L`.
    pub fn without_prefix(name: &str) -> Self {
        // These characters also separate words, so a known name must follow.
        let name = after(name, &PREFIX_ENDS).last().unwrap_or(name);
        let known = after(name, &WORD_ENDS).map(Self::of).find(Self::is_known);
        known.unwrap_or_else(|| Self::of(name))
    }

    /// Returns whether this column is allowed in a take for any face.
    fn is_known(&self) -> bool {
        self.is_arkit() || self.is_angle() || self.is_other()
    }

    fn is_angle(&self) -> bool {
        ANGLES.contains(&self.stem.as_str())
    }

    fn is_other(&self) -> bool {
        NO_VALUES.contains(&self.stem.as_str())
    }

    fn is_arkit(&self) -> bool {
        ARKIT[usize::from(self.side.is_some())].contains(&self.stem.as_str())
    }
}

/// Lists the rest of a name after each of the given characters, the longest rest first. Skips rests that are only a
/// side.
fn after<'a>(name: &'a str, ends: &'a [char]) -> impl Iterator<Item = &'a str> {
    let rests = name.match_indices(ends).map(|(at, end)| &name[at + end.len()..]);
    rests.filter(|rest| !["", "l", "r"].contains(&Expression::of(rest).stem.as_str()))
}

/// Returns whether a column holds the number of weights in a row.
pub(super) fn is_count(name: &str) -> bool {
    Expression::without_prefix(name).stem == COUNT
}

impl Columns {
    /// Finds the shapes that columns drive. The first rule that matches applies: equal name; equal expression and side;
    /// equal expression, if the column has no side (`BrowInnerUp` drives both sides). Names are compared with their
    /// prefixes first, then without.
    pub fn of(names: &[String], shapes: &[String]) -> Self {
        let readings: [fn(&str) -> Expression; 2] = [Expression::of, Expression::without_prefix];
        let own = readings.map(|read| shapes.iter().map(|shape| read(shape)).collect::<Vec<_>>());
        let (mut driven, mut skipped, mut unknown) = (Vec::new(), Vec::new(), Vec::new());
        for name in names {
            let which = |is: &dyn Fn(usize) -> bool| -> Vec<usize> {
                (0..shapes.len()).filter(|&shape| is(shape)).collect()
            };
            let mut found = which(&|shape| shapes[shape] == *name);
            for (read, own) in readings.iter().zip(&own) {
                let expression = read(name);
                if found.is_empty() {
                    found = which(&|shape| own[shape] == expression);
                }
                if found.is_empty() && expression.side.is_none() {
                    found = which(&|shape| own[shape].stem == expression.stem);
                }
            }
            let read = readings.map(|read| read(name));
            if found.is_empty() && !read.iter().any(Expression::is_other) {
                match read.iter().any(Expression::is_known) {
                    true => skipped.push(name.clone()),
                    false => unknown.push(name.clone()),
                }
            }
            driven.push(found);
        }
        Self { driven, skipped, unknown }
    }

    /// Checks the columns.
    ///
    /// # Errors
    /// - [`ErrorKind::Value`](crate::ErrorKind::Value): columns are not shapes, and not known as columns without a
    ///   shape.
    /// - [`ErrorKind::Missing`](crate::ErrorKind::Missing): no column drives a shape.
    pub fn check(&self, shapes: &[String]) -> Result<(), Error> {
        if !self.unknown.is_empty() {
            let unknown = listed(self.unknown.iter().map(|name| suggested(name, shapes)));
            return Err(Error::value(format!(
                "unknown {unknown}: name each column after a shape of the face, or remove the column"
            )));
        }
        if self.driven.iter().all(Vec::is_empty) {
            let known = listed(shapes.iter());
            return Err(Error::missing(format!(
                "no column drives a shape of the face; its shapes are {known}"
            )));
        }
        Ok(())
    }
}

/// Items that a message lists; further items are counted.
const LISTED: usize = 5;

/// Joins the first items of a list and counts the rest.
pub fn listed(items: impl ExactSizeIterator<Item = impl Display>) -> String {
    let more = items.len().saturating_sub(LISTED);
    let first: Vec<String> = items.take(LISTED).map(|item| item.to_string()).collect();
    let first = first.join(", ");
    if more == 0 { first } else { format!("{first} and {more} more") }
}

/// Quotes an unknown name, and suggests similar names.
fn suggested(name: &str, shapes: &[String]) -> String {
    match nearest(name, shapes).as_slice() {
        [] => format!("{name:?}"),
        nearest => format!("{name:?} (did you mean {}?)", nearest.join(", ")),
    }
}

/// Lists the most similar names; empty if no name is similar.
fn nearest(name: &str, shapes: &[String]) -> Vec<String> {
    let small = name.to_lowercase();
    let similarity = |shape: &String| strsim::jaro_winkler(&small, &shape.to_lowercase());
    let mut order: Vec<(f64, &String)> =
        shapes.iter().map(|shape| (similarity(shape), shape)).collect();
    order.retain(|(similarity, _)| *similarity >= LEAST_SIMILARITY);
    order.sort_by(|a, b| b.0.total_cmp(&a.0));
    order.into_iter().take(SUGGESTIONS).map(|(_, shape)| shape.clone()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn owned(names: &[&str]) -> Vec<String> {
        names.iter().map(|name| (*name).to_owned()).collect()
    }

    fn columns(names: &[String], shapes: &[String]) -> Result<Columns, Error> {
        let columns = Columns::of(names, shapes);
        columns.check(shapes).map(|()| columns)
    }

    #[test]
    fn one_expression_has_many_spellings() {
        let blink = Expression { stem: "eyeblink".to_owned(), side: Some(Side::Left) };
        for name in ["EyeBlinkLeft", "eyeBlink_L", "eyeBlinkLeft", "eye_blink.L"] {
            assert_eq!(Expression::of(name), blink);
        }
        assert_eq!(Expression::of("jawLeft"), Expression::of("JawLeft"));
        assert_eq!(Expression::of("JawOpen").side, None);
    }

    #[test]
    fn arkit_drives_a_face_of_another_spelling() {
        let shapes =
            owned(&["eyeBlink_L", "eyeBlink_R", "jawLeft", "browInnerUp_L", "browInnerUp_R"]);
        let names = owned(&[
            "Timecode",
            "BlendShapeCount",
            "EyeBlinkRight",
            "JawLeft",
            "BrowInnerUp",
            "TongueOut",
            "HeadYaw",
            "RightEyeRoll",
            "MouthLeft",
        ]);
        let found = columns(&names, &shapes).unwrap();
        let none = Vec::new;
        let driven = [none(), none(), vec![1], vec![2], vec![3, 4], none(), none(), none(), none()];
        assert_eq!(found.driven, driven);
        assert_eq!(found.skipped, ["TongueOut", "HeadYaw", "RightEyeRoll", "MouthLeft"]);
    }

    #[test]
    fn prefixes_of_nodes_and_meshes_are_left_out() {
        let blink = Expression { stem: "eyeblink".to_owned(), side: Some(Side::Left) };
        for name in [
            "blendShape1.eyeBlink_L",
            "blendShape1.eyeBlink.L",
            "head:face|eyeBlinkLeft",
            "Face/eye_blink_l",
            "BS_EyeBlinkLeft",
            "head_lod0_eyeBlink_L",
            "head_geo.blendShape1_eyeBlink_L",
            "head|BS_eyeBlink.L",
            "BS-EyeBlinkLeft",
            "Face EyeBlinkLeft",
            "eyeBlink.L",
            "EyeBlinkLeft",
        ] {
            assert_eq!(Expression::without_prefix(name), blink, "{name}");
        }
        // Each mesh has its own shape of the same expression. An exact name selects only that shape.
        let shapes = owned(&["head.jawOpen", "teeth.jawOpen", "head.jawLeft", "jawLeft"]);
        let found = columns(&owned(&["JawOpen", "JawLeft", "headYaw", "HEADROLL", ""]), &shapes);
        let found = found.unwrap();
        assert_eq!(found.driven, [vec![0, 1], vec![3], vec![], vec![], vec![]]);
        assert_eq!(found.skipped, ["headYaw", "HEADROLL"]);
        // Angles and other known columns may have these prefixes too.
        for prefix in ["BS_", "CTRL_expressions_", "bs_node_", "head_geo.", "head|BS_", "Face "] {
            let names = ["Timecode", "BlendShapeCount", "EyeBlinkLeft", "HeadYaw", "LeftEyeRoll"];
            let names = names.map(|name| format!("{prefix}{name}"));
            let found = columns(&names, &owned(&["eyeBlink_L", "eyeBlink_R"])).unwrap();
            assert_eq!(found.driven, [vec![], vec![], vec![0], vec![], vec![]], "{prefix}");
            assert_eq!(found.skipped, names[3..], "{prefix}");
            assert!(is_count(&names[1]), "{prefix}");
        }
        // The take may have a prefix that the face lacks.
        let found = columns(&owned(&["blendShape1.jawOpen"]), &owned(&["JawOpen"])).unwrap();
        assert_eq!(found.driven, [[0]]);
    }

    #[test]
    fn unknown_names_get_suggestions() {
        let shapes = owned(&["eyeBlink_L", "eyeBlink_R", "jawOpen", "mouthSmile_L"]);
        let error = columns(&owned(&["JawOpen", "jawOpn", "EyeBlnkLeft"]), &shapes).unwrap_err();
        assert_eq!(
            error.to_string(),
            "unknown \"jawOpn\" (did you mean jawOpen?), \"EyeBlnkLeft\" (did you mean eyeBlink_L, \
             eyeBlink_R?): name each column after a shape of the face, or remove the column"
        );
        // Names without a similar shape get no suggestion, and a long list is cut.
        let others = ["Confidence", "FrameNumber", "Date", "Name", "Index", "Comment", "Quality"];
        let error = columns(&owned(&[&["JawOpen"], &others[..]].concat()), &shapes).unwrap_err();
        assert_eq!(
            error.to_string(),
            "unknown \"Confidence\", \"FrameNumber\", \"Date\", \"Name\", \"Index\" and 2 more: \
             name each column after a shape of the face, or remove the column"
        );
        let error = columns(&owned(&["TongueOut", "HeadYaw"]), &shapes).unwrap_err();
        assert!(error.to_string().starts_with("no column drives a shape"), "{error}");
    }

    #[test]
    fn arkit_has_52_expressions() {
        assert_eq!(ARKIT[0].len() + 2 * ARKIT[1].len(), 52);
    }
}
