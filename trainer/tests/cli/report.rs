//! `sinew report`: files and refusals.

use super::common::{Folder, HELD_OUT, Set, TRAINING};
use serde_json::Value;

const REPORT: &str = "report demo.sinew demo.npz -o page.html";

#[test]
fn report_writes_the_page_and_the_requested_extras() {
    let folder = Folder::with_demo("report");
    let run = folder.sinew(&format!("{REPORT} --quick --csv frames.csv --ply rest.ply")).done();
    for file in ["page.html", "frames.csv", "rest.ply"] {
        let bytes = folder.read(file).len();
        assert!(run.out.contains(&format!("wrote {file} ({bytes} bytes)")), "{}", run.out);
    }
    let page = String::from_utf8(folder.read("page.html")).unwrap();
    assert!(page.starts_with("<!DOCTYPE html>") && page.ends_with("</html>\n"));
    assert!(page.contains("<h1>demo.sinew on demo.npz</h1>"));
    let rows = String::from_utf8(folder.read("frames.csv")).unwrap().lines().count();
    assert_eq!(rows, 1 + HELD_OUT);
    assert!(folder.read("rest.ply").starts_with(b"ply\n"));
    assert!(run.out.starts_with(folder.sinew("eval demo.sinew demo.npz").done().out.trim_end()));

    // Another viewpoint gives other pictures.
    folder.sinew(&format!("{REPORT} --quick --up z --view -30,60")).done();
    assert!(folder.read("page.html") != page.as_bytes());
}

#[test]
fn a_gif_shows_the_truth_lbs_and_the_model_in_each_frame() {
    let folder = Folder::with_demo("report-gif");
    let run = folder.sinew(&format!("{REPORT} --quick --gif frames.gif")).done();
    assert!(run.out.contains("wrote frames.gif ("), "{}", run.out);
    let frames = folder.gif("frames.gif");
    assert_eq!(frames.len(), HELD_OUT);
    // Three columns of 300 pixels. Errors are red: clay has no red, and LBS has more red than the
    // model.
    for (rgba, hundredths) in &frames {
        let red = |column: usize| -> u64 {
            let pixels = rgba.chunks_exact(4).enumerate();
            let own = pixels.filter(|(place, _)| place % 900 / 300 == column);
            own.map(|(_, c)| u64::from(c[0].saturating_sub(c[1]).saturating_sub(20))).sum()
        };
        let [truth, lbs, model] = [0, 1, 2].map(red);
        assert!(50 * truth < model && 3 * model < 2 * lbs, "{truth} {model} {lbs}");
        assert_eq!(*hundredths, 3);
    }
}

#[test]
fn report_measures_as_eval_does_and_compares() {
    let folder = Folder::with_demo("report-json");
    folder.sinew("train demo.npz -o other.sinew --predictor kernel --proxies 2").done();
    let found = folder.sinew(&format!("{REPORT} --quick --compare other.sinew --json")).json();
    let eval = |model: &str| folder.sinew(&format!("eval {model} demo.npz --json")).json();
    assert_eq!(found["model"], eval("demo.sinew"));
    assert_eq!(found["compared"], eval("other.sinew"));
    let page = String::from_utf8(folder.read("page.html")).unwrap();
    assert!(page.contains("<h1>demo.sinew on demo.npz, compared with other.sinew</h1>"));
}

#[test]
fn training_frames_are_never_called_held_out() {
    let folder = Folder::with_demo("report-train");
    let mut set = Set::demo();
    set.wholes.get_mut("split").unwrap().1.fill(0);
    set.write(&folder.path("all.npz"));
    let report = "report demo.sinew all.npz -o page.html --quick";
    let measured = |options: &str| {
        let found = folder.sinew(&format!("{report} {options} --json")).json();
        assert_eq!(found["compared"], Value::Null);
        let model = &found["model"];
        let figures = ["frames", "read"].map(|key| model[key].as_u64().unwrap());
        let page = String::from_utf8(folder.read("page.html")).unwrap();
        (model["split"].as_str().unwrap().to_owned(), figures, page)
    };
    // The model knows which frames its training used, whatever the file says.
    let (split, figures, page) = measured("");
    assert_eq!((&*split, figures), ("new", [HELD_OUT as u64, 0]));
    assert!(page.contains(&format!("measured on {HELD_OUT} frames that the fit has not read")));
    let (split, figures, page) = measured("--split train");
    assert_eq!((&*split, figures), ("train", [52, TRAINING as u64]));
    assert!(page.contains(&format!("of which the fit has read {TRAINING}")), "{page:.2000}");
    let (split, figures, page) = measured("--hold-out 0.25");
    assert_eq!((&*split, figures[0]), ("held-out", 15));
    assert!(figures[1] > 0 && page.contains("15 held-out frames, of which the fit has read"));
    let line = folder.sinew(&format!("{report} --split held-out")).failed();
    let expected = "all.npz: the examples have no held-out frame: 52 training, 0 held-out, 0 \
                    extreme frames; see --split and --hold-out";
    assert_eq!(line, expected);
}

#[test]
fn reports_that_cannot_be_made_are_refused_and_nothing_is_written() {
    let folder = Folder::with_demo("report-refusals");
    std::fs::create_dir(folder.path("inner")).unwrap();
    let mut other = Set::demo();
    other.json["bone_names"][6] = serde_json::json!("paw");
    other.write(&folder.path("other.npz"));
    std::fs::write(folder.path("bad.sinew"), "no model").unwrap();
    let before = folder.list();
    let named = "joint 6 is called hand in the model, paw in the examples";
    for (arguments, expected) in [
        ("demo.sinew demo.npz -o inner", "cannot write inner: it is a folder".to_owned()),
        ("demo.sinew demo.npz -o demo.sinew", "cannot write demo.sinew: it is an input".to_owned()),
        ("demo.sinew demo.npz -o demo.json", "cannot write demo.json: it is an input".to_owned()),
        (
            "demo.sinew demo.npz --compare bad.sinew -o p --ply bad.sinew",
            "cannot write bad.sinew: it is an input".to_owned(),
        ),
        (
            "demo.sinew demo.npz -o p --csv ./p",
            "cannot write ./p: two outputs are one file".to_owned(),
        ),
        (
            "demo.sinew demo.npz -o p --csv no/f",
            "cannot write no/f: there is no folder no".to_owned(),
        ),
        ("inner demo.npz -o p", "cannot read inner: it is a folder".to_owned()),
        ("demo.sinew inner -o p", "inner: is a folder, expected a file".to_owned()),
        ("demo.sinew other.npz -o p", format!("demo.sinew: {named}")),
        (
            "demo.sinew demo.npz -o p --split extreme",
            "demo.npz: the examples have no extreme frame: \
            40 training, 12 held-out, 0 extreme frames"
                .to_owned(),
        ),
    ] {
        assert_eq!(folder.sinew(&format!("report {arguments}")).failed(), expected);
        assert_eq!(folder.list(), before, "{arguments}");
    }
    let compared = "report demo.sinew demo.npz -o p --compare bad.sinew";
    let line = folder.sinew(compared).failed();
    assert!(line.starts_with("bad.sinew: the model is refused: "), "{line}");
    for view in ["30", "30,91", "a,b", "nan,0", "1,2,3"] {
        let run = folder.sinew(&format!("{REPORT} --view {view}"));
        assert_eq!(run.code, Some(2), "{view}");
        assert!(run.err.contains("AZIMUTH,ELEVATION in degrees"), "{}", run.err);
    }
    assert_eq!(folder.sinew(&format!("{REPORT} --up w")).code, Some(2));
    assert_eq!(folder.list(), before);
}
