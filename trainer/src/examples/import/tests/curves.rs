//! Tests of tables of curves beside a scene.

use super::super::curves::{SampledCurves, of_table};
use crate::examples::{Clip, Curves};
use crate::formats::testing::Folder;
use crate::{Error, ErrorKind};

/// A clip of 3 frames, at 0.5, 0.75 and 1 s.
fn clip(name: &str) -> Clip {
    Clip { name: name.into(), first: 0, times: vec![0.5, 0.75, 1.0], numbers: None }
}

fn read(
    test: &str,
    text: &str,
    clips: &[Clip],
    choice: Curves<'_>,
) -> Result<SampledCurves, Error> {
    let folder = Folder::new(test);
    let path = folder.write("take.csv", text);
    let found = of_table(&path, clips, choice);
    if let Err(error) = &found {
        assert_eq!(error.file(), Some(path.as_path()));
    }
    found
}

/// As Live Link Face writes a take.
const TAKE: &str = "Timecode,BlendshapeCount,JawOpen,HeadYaw\n\
                    10:00:00:01.5,61,0.25,-0.5\n10:00:00:02.5,61,0.5,0\n10:00:00:03.5,61,0.75,0.5\n";

#[test]
fn a_row_belongs_to_each_frame() {
    let found = read("rows", TAKE, &[clip("talk")], Curves::Usual).unwrap();
    assert_eq!(found.names, ["JawOpen", "HeadYaw"]);
    assert_eq!(found.values, [0.25, -0.5, 0.5, 0.0, 0.75, 0.5]);
    let names = ["HeadYaw".to_owned()];
    let found = read("rows-named", TAKE, &[clip("talk")], Curves::Named(&names)).unwrap();
    assert_eq!((found.names, found.values), (names.to_vec(), vec![-0.5, 0.0, 0.5]));
    let none = read("rows-none", TAKE, &[clip("talk")], Curves::None).unwrap();
    assert_eq!(none, SampledCurves::default());
}

#[test]
fn a_table_with_times_is_interpolated_at_the_frames() {
    let text = "Time;jaw\n0,4;1\n0,8;3\n0,9;3\n1,0;-1\n";
    let found = read("times", text, &[clip("talk")], Curves::All).unwrap();
    assert_eq!(found.names, ["jaw"]);
    let apart = found.values.iter().zip([1.5, 2.75, -1.0]).map(|(a, b)| (a - b).abs());
    assert!(apart.fold(0.0, f64::max) < 1e-12, "{:?}", found.values);
}

#[test]
fn tables_that_do_not_fit_are_refused_by_line_and_column() {
    let talk = [clip("talk")];
    for (test, text, clips, choice, kind, words) in [
        (
            "lost",
            &TAKE.replace("0.5,0\n", ",0\n"),
            &talk[..],
            Curves::Usual,
            ErrorKind::Value,
            "line 3, column \"JawOpen\": expected a number, found \"\"",
        ),
        (
            "short",
            &TAKE.replace("10:00:00:03.5,61,0.75,0.5\n", ""),
            &talk,
            Curves::Usual,
            ErrorKind::Mismatch,
            "has 2 rows, the scene's clips have 3 frames (talk: 3): give a row for each frame, sample",
        ),
        (
            "unknown",
            &TAKE.to_owned(),
            &talk,
            Curves::Named(&["brow".to_owned()]),
            ErrorKind::Missing,
            "there is no curve brow: it has JawOpen, HeadYaw",
        ),
        (
            "empty",
            &"Timecode,Frame\n1,1\n".to_owned(),
            &talk,
            Curves::All,
            ErrorKind::Missing,
            "line 1: no column is a curve; there are Timecode, Frame",
        ),
        (
            "descends",
            &"time,jaw\n0.5,1\n0.9,2\n0.8,3\n".to_owned(),
            &talk,
            Curves::All,
            ErrorKind::Value,
            "line 4, column \"time\": expected a time above 0.9, found 0.8",
        ),
        (
            "outside",
            &"time,jaw\n0.5,1\n0.6,2\n0.7,3\n".to_owned(),
            &talk,
            Curves::All,
            ErrorKind::Missing,
            "clip talk plays it at 1.0000 s, and the rows are from 0.5000 to 0.7000 s: give rows",
        ),
        (
            "several",
            &"time,jaw\n0.5,1\n0.6,2\n0.7,3\n".to_owned(),
            &[clip("talk"), clip("sing")],
            Curves::All,
            ErrorKind::Mismatch,
            "has a column \"time\", and the scene has 2 clips: choose one with --clip, or remove",
        ),
    ] {
        let error = read(test, text, clips, choice).unwrap_err();
        assert_eq!(error.kind(), kind, "{error}");
        assert!(error.message().starts_with(words), "{error}");
        assert_eq!(error.frame(), (test == "outside").then_some(2));
    }
}
