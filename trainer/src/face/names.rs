//! Names of expressions: what a column of a take drives.

use super::error::{FaceError, Unknown};

/// What ARKit names and no column of a face's weights is: angles of the head and of the eyes, which are turned by
/// joints.
const ANGLES: [&str; 9] = [
    "HeadYaw",
    "HeadPitch",
    "HeadRoll",
    "LeftEyeYaw",
    "LeftEyePitch",
    "LeftEyeRoll",
    "RightEyeYaw",
    "RightEyePitch",
    "RightEyeRoll",
];

/// Columns of a take that are no weights.
const OTHERS: [&str; 5] = ["Timecode", "BlendShapeCount", "frame", "time", "norm"];

/// The expressions of ARKit by their stems; those of the second list have a side.
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

/// How many known names are told beside an unknown one.
const TOLD: usize = 3;

/// A name apart from how it is written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Expression {
    /// What it is called, in small letters, without its side.
    pub stem: String,
    /// Its side: left or right.
    pub side: Option<Side>,
}

/// A side of a face, its owner's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Left.
    Left,
    /// Right.
    Right,
}

/// What the columns of a take are to a face.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Columns {
    /// The shapes that each column drives; none where it is skipped.
    pub driven: Vec<Vec<usize>>,
    /// Expressions and angles that the face has no shape for.
    pub skipped: Vec<String>,
}

impl Expression {
    /// Takes a name apart: `EyeBlinkLeft`, `eyeBlink_L` and `eye_blink.l` are one.
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

    fn is_arkit(&self) -> bool {
        ARKIT[usize::from(self.side.is_some())].contains(&self.stem.as_str())
    }
}

/// Finds what columns drive: the shape of the same name, or of the same expression and side; one without a side, as
/// `BrowInnerUp`, drives both sides of a shape.
///
/// # Errors
/// - [`FaceError::Names`]: columns that are neither shapes nor known to have none.
/// - [`FaceError::NoColumns`]: there is no shape among them.
pub fn columns(names: &[String], shapes: &[String]) -> Result<Columns, FaceError> {
    let own: Vec<Expression> = shapes.iter().map(|shape| Expression::of(shape)).collect();
    let (mut driven, mut skipped, mut unknown) = (Vec::new(), Vec::new(), Vec::new());
    for name in names {
        let expression = Expression::of(name);
        let which = |is: &dyn Fn(usize) -> bool| -> Vec<usize> {
            (0..shapes.len()).filter(|&shape| is(shape)).collect()
        };
        let mut found = which(&|shape| shapes[shape] == *name);
        if found.is_empty() {
            found = which(&|shape| own[shape] == expression);
        }
        if found.is_empty() && expression.side.is_none() {
            found = which(&|shape| own[shape].stem == expression.stem);
        }
        if found.is_empty() && !OTHERS.contains(&name.as_str()) {
            match ANGLES.contains(&name.as_str()) || expression.is_arkit() {
                true => skipped.push(name.clone()),
                false => {
                    unknown.push(Unknown { name: name.clone(), nearest: nearest(name, shapes) })
                }
            }
        }
        driven.push(found);
    }
    if !unknown.is_empty() {
        return Err(FaceError::Names { unknown });
    }
    if driven.iter().all(Vec::is_empty) {
        return Err(FaceError::NoColumns { known: shapes.join(", ") });
    }
    Ok(Columns { driven, skipped })
}

/// Lists the names most like one.
fn nearest(name: &str, shapes: &[String]) -> Vec<String> {
    let small = name.to_lowercase();
    let like = |shape: &String| strsim::jaro_winkler(&small, &shape.to_lowercase());
    let mut order: Vec<(f64, &String)> = shapes.iter().map(|shape| (like(shape), shape)).collect();
    order.sort_by(|a, b| b.0.total_cmp(&a.0));
    order.into_iter().take(TOLD).map(|(_, shape)| shape.clone()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn owned(names: &[&str]) -> Vec<String> {
        names.iter().map(|name| (*name).to_owned()).collect()
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
    fn unknown_names_are_told_with_those_most_like_them() {
        let shapes = owned(&["eyeBlink_L", "eyeBlink_R", "jawOpen", "mouthSmile_L"]);
        let error = columns(&owned(&["JawOpen", "jawOpn", "EyeBlnkLeft"]), &shapes).unwrap_err();
        assert_eq!(
            error.to_string(),
            "unknown \"jawOpn\" (did you mean jawOpen, eyeBlink_L, eyeBlink_R?); \"EyeBlnkLeft\" \
             (did you mean eyeBlink_L, eyeBlink_R, jawOpen?)"
        );
        let error = columns(&owned(&["TongueOut", "HeadYaw"]), &shapes).unwrap_err();
        assert!(error.to_string().starts_with("no column drives a shape"), "{error}");
    }

    #[test]
    fn arkit_has_52_expressions() {
        assert_eq!(ARKIT[0].len() + 2 * ARKIT[1].len(), 52);
    }
}
