//! Names of expressions: what a column of a take drives.

use super::error::{FaceError, Unknown};

/// What ARKit names and no column of a face's weights is: angles of the head and of the eyes, which are turned by
/// joints.
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

/// The column that counts the weights of a row.
const COUNT: &str = "blendshapecount";
/// Columns of a take that are no weights; one without a name is the end of a line.
const OTHERS: [&str; 6] = ["timecode", COUNT, "frame", "time", "norm", ""];
/// Characters between the name of a node or a mesh and that of a shape.
const PREFIX_ENDS: [char; 4] = ['.', ':', '|', '/'];

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

    /// Takes a name apart as [`Expression::of`] does, without the name of a node or a mesh before it:
    /// `blendShape1.eyeBlink_L`, `Head|eyeBlink.L` and `BS_EyeBlinkLeft` are `eyeBlink_L`.
    pub fn without_prefix(name: &str) -> Self {
        let after = |ends: &[char]| -> Vec<Self> {
            let rest = name.match_indices(ends).map(|(at, end)| Self::of(&name[at + end.len()..]));
            rest.filter(|rest| !["", "l", "r"].contains(&rest.stem.as_str())).collect()
        };
        // An underscore also parts words, so that what follows it must be known.
        let known = || after(&['_']).into_iter().find(Self::is_arkit);
        after(&PREFIX_ENDS).pop().or_else(known).unwrap_or_else(|| Self::of(name))
    }

    fn is_arkit(&self) -> bool {
        ARKIT[usize::from(self.side.is_some())].contains(&self.stem.as_str())
    }
}

/// Tells whether a column counts the weights of a row.
pub(super) fn is_count(name: &str) -> bool {
    Expression::without_prefix(name).stem == COUNT
}

/// Finds what columns drive: the shape of the same name, or of the same expression and side; one without a side, as
/// `BrowInnerUp`, drives both sides of a shape. Prefixes of nodes and meshes are left out where names with them match
/// no shape.
///
/// # Errors
/// - [`FaceError::Names`]: columns that are neither shapes nor known to have none.
/// - [`FaceError::NoColumns`]: there is no shape among them.
pub fn columns(names: &[String], shapes: &[String]) -> Result<Columns, FaceError> {
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
        if found.is_empty() && !read.iter().any(|read| OTHERS.contains(&read.stem.as_str())) {
            let is_angle = |read: &Expression| ANGLES.contains(&read.stem.as_str());
            let is_known = read.iter().any(|read| is_angle(read) || read.is_arkit());
            match is_known {
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
    fn prefixes_of_nodes_and_meshes_are_left_out() {
        let blink = Expression { stem: "eyeblink".to_owned(), side: Some(Side::Left) };
        for name in [
            "blendShape1.eyeBlink_L",
            "blendShape1.eyeBlink.L",
            "head:face|eyeBlinkLeft",
            "Face/eye_blink_l",
            "BS_EyeBlinkLeft",
            "head_lod0_eyeBlink_L",
            "eyeBlink.L",
            "EyeBlinkLeft",
        ] {
            assert_eq!(Expression::without_prefix(name), blink, "{name}");
        }
        // Of two meshes each has its shape; a name that is there as it stands is that shape alone.
        let shapes = owned(&["head.jawOpen", "teeth.jawOpen", "head.jawLeft", "jawLeft"]);
        let found = columns(&owned(&["JawOpen", "JawLeft", "headYaw", "HEADROLL", ""]), &shapes);
        let found = found.unwrap();
        assert_eq!(found.driven, [vec![0, 1], vec![3], vec![], vec![], vec![]]);
        assert_eq!(found.skipped, ["headYaw", "HEADROLL"]);
        // A take may have the prefix, and the face none.
        let found = columns(&owned(&["blendShape1.jawOpen"]), &owned(&["JawOpen"])).unwrap();
        assert_eq!(found.driven, [[0]]);
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
