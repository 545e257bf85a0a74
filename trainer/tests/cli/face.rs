//! `sinew face`: training, pins, and refusals.

use super::common::{Folder, Run};
use npyz::{AutoSerialize, WriteOptions, WriterBuilder};
use serde_json::Value;
use std::fs::{self, File};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// A strip of eight points in two rows. One shape lifts its left end, one its right end, one widens
/// the strip; `both` lifts both ends in the take.
const NAMES: [&str; 3] = ["lift_L", "lift_R", "jawOpen"];
const V: usize = 8;

fn place(vertex: usize) -> [f64; 3] {
    [(vertex / 2) as f64, (vertex % 2) as f64, 0.0]
}

fn delta(shape: usize, vertex: usize) -> [f64; 3] {
    let [x, y, _] = place(vertex);
    match shape {
        0 => [0.0, 0.0, 1.0 - x / 3.0],
        1 => [0.0, 0.0, x / 3.0],
        _ => [0.0, y - 0.5, 0.0],
    }
}

fn array<T: AutoSerialize + Copy>(
    zip: &mut ZipWriter<File>,
    name: &str,
    shape: &[u64],
    numbers: &[T],
) {
    zip.start_file(format!("{name}.npy"), SimpleFileOptions::DEFAULT).unwrap();
    let mut array =
        WriteOptions::new().default_dtype().shape(shape).writer(zip).begin_nd().unwrap();
    array.extend(numbers.iter().copied()).unwrap();
    array.finish().unwrap();
}

fn texts(zip: &mut ZipWriter<File>, name: &str, texts: &[&str]) {
    zip.start_file(format!("{name}.npy"), SimpleFileOptions::DEFAULT).unwrap();
    let dtype = npyz::DType::Plain("<U16".parse().unwrap());
    let options = WriteOptions::<str>::new().dtype(dtype);
    let mut array = options.shape(&[texts.len() as u64]).writer(zip).begin_nd().unwrap();
    texts.iter().for_each(|text| array.push(text).unwrap());
    array.finish().unwrap();
}

/// Writes the face, and a take in which both ends rise and fall together.
fn made(test: &str) -> Folder {
    let folder = Folder::new(test);
    write_face(&folder, &NAMES);
    let mut take = "Timecode,LiftLeft,LiftRight,JawOpen,HeadYaw,TongueOut\n".to_owned();
    for frame in 0..60 {
        let lift = 0.5 + 0.5 * (0.3 * f64::from(frame)).sin();
        let open = 0.5 + 0.5 * (0.17 * f64::from(frame)).cos();
        take += &format!("00:00:{frame},{lift},{lift},{open},0.1,0\n");
    }
    fs::write(folder.path("take.csv"), take).unwrap();
    folder
}

fn write_face(folder: &Folder, names: &[&str]) {
    let mut zip = ZipWriter::new(File::create(folder.path("face.npz")).unwrap());
    let all: Vec<f64> = (0..V).flat_map(place).collect();
    array(&mut zip, "neutral", &[V as u64, 3], &all);
    let quads: Vec<i32> = (0..3).flat_map(|k| [2 * k, 2 * k + 2, 2 * k + 3, 2 * k + 1]).collect();
    array(&mut zip, "quads", &[3, 4], &quads);
    let deltas: Vec<f64> =
        (0..3).flat_map(|shape| (0..V).flat_map(move |vertex| delta(shape, vertex))).collect();
    array(&mut zip, "expression_deltas", &[3, V as u64, 3], &deltas);
    texts(&mut zip, "expression_names", names);
    let raised: Vec<f64> = (0..V).flat_map(|_| [0.0, 0.0, 2.0]).collect();
    array(&mut zip, "identity_deltas", &[1, V as u64, 3], &raised);
    array(&mut zip, "landmarks", &[4], &[0_i32, 1, 6, 7]);
    zip.finish().unwrap();
}

const TRAIN: &str = "face train --basis face.npz --animation take.csv -o face.sinew -q";

fn trained(test: &str) -> Folder {
    let folder = made(test);
    folder.sinew(TRAIN).done();
    folder
}

fn weight(run: &Value, name: &str) -> f64 {
    run["weights"][name].as_f64().unwrap()
}

#[test]
fn correlated_shapes_of_the_take_move_together_in_a_drag() {
    let folder = trained("face-pin");
    let [lifted, alone] = ["", "--slider"].map(|how| {
        let run = format!("face pin face.sinew --pin 0=_,_,0.8 -o out.csv --json {how}");
        folder.sinew(&run).json()
    });
    for run in [&lifted, &alone] {
        assert!((weight(run, "lift_L") - 0.8).abs() < 0.05, "{run}");
        assert!(run["pins"][0]["missed"].as_f64().unwrap() < 0.02, "{run}");
    }
    assert!((weight(&lifted, "lift_R") - 0.8).abs() < 0.3, "{lifted}");
    assert!(weight(&alone, "lift_R").abs() < 1e-3, "{alone}");
    assert!(weight(&lifted, "jawOpen").abs() < 0.3, "{lifted}");
    let bounded = "face pin face.sinew --pin 0=_,_,3 --bounded -o out.csv --json";
    assert_eq!(weight(&folder.sinew(bounded).json(), "lift_L"), 1.0);
}

#[test]
fn a_pinned_face_is_a_mesh_a_scene_and_a_picture() {
    let folder = trained("face-outputs");
    let pin = |out: &str| {
        let run = format!("face pin face.sinew --pin 0=0,0,0.5 --hold 6 -o {out}");
        folder.sinew(&run).done()
    };
    pin("out.obj");
    let text = String::from_utf8(folder.read("out.obj")).unwrap();
    let heights: Vec<f64> = text
        .lines()
        .filter_map(|line| line.strip_prefix("v "))
        .map(|line| line.split(' ').nth(2).unwrap().parse().unwrap())
        .collect();
    assert!((heights[0] - 0.5).abs() < 0.02 && heights[6].abs() < 0.02, "{heights:?}");
    assert!(text.contains("f 1 3 4 2\n") && text.contains("p 7\n"), "{text}");
    pin("out.glb");
    let glb = gltf::Gltf::from_slice(&folder.read("out.glb")).unwrap();
    let mesh = glb.meshes().next().unwrap();
    assert_eq!(mesh.weights().unwrap().len(), 3);
    let primitive = mesh.primitives().next().unwrap();
    assert_eq!(primitive.morph_targets().len(), 3);
    // The output is a face again.
    fs::write(folder.path("again.csv"), "lift_L,lift_R,jawOpen\n0,0,0\n1,1,1\n").unwrap();
    let again = "face train --basis out.glb --animation again.csv -o again.sinew --json";
    let again = folder.sinew(again).json();
    assert_eq!((&again["shapes"], &again["vertices"]), (&3.into(), &V.into()));
    pin("out.png");
    assert!(folder.read("out.png").starts_with(b"\x89PNG"));
    let before = folder.list();
    pin("out.png");
    assert_eq!(folder.list(), before, "nothing is left behind");
}

#[test]
fn a_pin_may_count_more_and_be_on_a_screen() {
    let folder = trained("face-screen");
    let lift = |pins: &str| {
        let run = format!("face pin face.sinew {pins} -o out.csv --json");
        folder.sinew(&run).json()
    };
    // Two contradictory pins: the result balances their stiffnesses.
    let even = weight(&lift("--pin 0=_,_,0.8 --pin 0=_,_,0.2"), "lift_L");
    let uneven = weight(&lift("--pin 0=_,_,0.8*3 --pin 0=_,_,0.2"), "lift_L");
    assert!((even - 0.5).abs() < 0.02 && (uneven - 0.65).abs() < 0.02, "{even} {uneven}");
    // A screen that shows z upside down, in units of 1/100.
    let screen = "--projection 100,0,0,50,0,0,-100,20";
    let seen = lift(&format!("{screen} --pin 0=_,-60"));
    assert!((weight(&seen, "lift_L") - 0.8).abs() < 0.05, "{seen}");
    let pin = &seen["pins"][0];
    assert_eq!((&pin["target"][0], &pin["target"][1]), (&50.0.into(), &(-60.0).into()));
    assert!(pin["missed"].as_f64().unwrap() < 2.0, "{seen}");
    // A screen pin is as stiff as a pin in space.
    let [inside, outside] = [lift("--pin 0=_,_,0.8"), seen].map(|run| weight(&run, "lift_L"));
    assert!((inside - outside).abs() < 1e-5, "{inside} {outside}");
    // Without a projection, picture coordinates apply: y points down, so a smaller y is higher.
    let y = |run: &Value| run["pins"][0]["at"][1].as_f64().unwrap();
    let still = lift("--pin 3=_,_ --width 200 -q");
    assert_eq!((weight(&still, "jawOpen"), &still["norm"]), (0.0, &0.0.into()));
    let higher = lift(&format!("--pin 3=_,{} --width 200", y(&still) - 5.0));
    assert!((y(&still) - y(&higher) - 5.0).abs() < 0.5, "{still} {higher}");
    assert!(weight(&higher, "jawOpen") > 0.1, "{higher}");
    folder.sinew("face pin face.sinew --pin 3=_,20 --width 200 -o out.png").done();
    for (arguments, expected) in [
        ("--pin 0=1,2,3*0", "expected VERTEX=X,Y,Z"),
        ("--pin 0=1,2 --projection 1,0,0,0", "expected eight numbers"),
        ("--pin 0=1,2 --projection 0,0,0,1,0,1,0,0", "expected eight numbers"),
    ] {
        let Run { code, err, .. } =
            folder.sinew(&format!("face pin face.sinew {arguments} -o a.csv"));
        assert!(code == Some(2) && err.contains(expected), "{err}");
    }
}

#[test]
fn a_face_says_in_which_space_it_is() {
    let folder = made("face-space");
    let space =
        |more: &str| folder.sinew(&format!("{TRAIN} --json {more}")).json()["space"].clone();
    assert_eq!(space("")["up"], Value::Null);
    let said = space("--up z --forward -y --unit 0.01");
    let expected = serde_json::json!({
        "up": "z", "forward": "-y", "handedness": "right", "unit_metres": 0.01,
    });
    assert_eq!(said, expected);
    let error = folder.sinew(&format!("{TRAIN} --up z --forward -z")).failed();
    assert!(error.starts_with("face.npz: "), "{error}");
}

#[test]
fn a_track_becomes_weights_and_weights_a_take() {
    let folder = trained("face-solve");
    let mut track = "frame,vertex,x,y,z\n".to_owned();
    for frame in 0..20 {
        let lift = 0.05 * f64::from(frame);
        for vertex in [0, 6] {
            let [x, y, _] = place(vertex);
            track += &format!("{frame},{vertex},{x},{y},{lift}\n");
        }
    }
    fs::write(folder.path("track.csv"), track).unwrap();
    let solve = "face solve face.sinew --track track.csv --plain -o weights.csv";
    folder.sinew(solve).done();
    let text = String::from_utf8(folder.read("weights.csv")).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!((lines[0], lines.len()), ("frame,lift_L,lift_R,jawOpen", 21));
    let last: Vec<f64> = lines[20].split(',').map(|cell| cell.parse().unwrap()).collect();
    assert!(last[0] == 19.0 && (last[1] - 0.95).abs() < 0.03 && (last[2] - 0.95).abs() < 0.03);
    let train = "face train --basis face.npz --animation weights.csv -o again.sinew";
    folder.sinew(train).done();
    folder.sinew("face solve face.sinew --track track.csv -o played.glb").done();
    let glb = gltf::Gltf::from_slice(&folder.read("played.glb")).unwrap();
    let channel = glb.animations().next().unwrap().channels().next().unwrap();
    assert_eq!(channel.target().property(), gltf::animation::Property::MorphTargetWeights);
    assert_eq!(channel.sampler().output().count(), 20 * 3);
}

#[test]
fn eval_reports_each_number_of_handles() {
    let folder = trained("face-eval");
    let eval = "face eval face.sinew --animation take.csv --handles 1,2 --every 3 --from 1 --frames 30.. -q";
    let found = folder.sinew(&format!("{eval} --json")).json();
    for handles in ["1", "2"] {
        let row = &found["handles"][handles];
        let number = |name: &str| row[name].as_f64().unwrap();
        assert!(number("prior") < 0.9 * number("slider"), "{row}");
        assert!(number("slider") <= number("nothing"), "{row}");
        assert_eq!(row["methods"]["bounded"]["outside"], 0.0);
    }
    assert_eq!((&found["frames"], &found["chosen_on"]), (&10.into(), &10.into()));
    assert_eq!(found["vertices"], serde_json::json!([0, V]));
    assert!(folder.sinew(eval).done().out.contains("handles"));
    let page = "face report face.sinew --animation take.csv --handles 1 --every 9 -o page.html --width 64 -q";
    folder.sinew(page).done();
    let page = String::from_utf8(folder.read("page.html")).unwrap();
    assert!(page.matches("<img").count() > 20 && page.contains("A drag"));
    assert!(!page.contains("http://") && !page.contains("<script"));
}

#[test]
fn identities_are_baked_into_the_neutral_face() {
    let folder = made("face-identity");
    folder.sinew(&format!("{TRAIN} --identity 0=-0.25")).done();
    let text = String::from_utf8(folder.read("face.obj")).unwrap();
    assert!(text.starts_with("v 0 0 -0.5\n"), "{text}");
    let error = folder.sinew(&format!("{TRAIN} --identity 1=1")).failed();
    assert!(error.contains("there is no identity 1: there are 1"), "{error}");
}

#[test]
fn meshes_without_shapes_are_a_face_of_their_components() {
    let folder = Folder::new("face-meshes");
    let mut zip = ZipWriter::new(File::create(folder.path("meshes.npz")).unwrap());
    let mesh = |k: usize| (0..5).flat_map(move |v| [v as f64, (k * v) as f64 * 0.1]);
    array(&mut zip, "meshes", &[4, 5, 2], &(0..4).flat_map(mesh).collect::<Vec<_>>());
    zip.finish().unwrap();
    let train = "face train --basis meshes.npz -o face.sinew";
    assert_eq!(folder.sinew(&format!("{train} --json --rank 1")).json()["shapes"], 1);
    let error = folder.sinew(&format!("{train} --rank 2")).failed();
    assert!(error.contains("rank 2: the meshes have 1 principal components"), "{error}");
    let error = folder.sinew(&format!("{train} --identity 0=1")).failed();
    assert!(error.contains("--identity is for a face"), "{error}");
    folder.sinew("face pin face.sinew --pin 4=_,0.4,_ -o out.obj").done();
    let error = folder.sinew("face pin face.sinew --pin 4=_,0.4,_ -o out.png").failed();
    assert!(error.contains("has points alone, no faces"), "{error}");
}

#[test]
fn bad_takes_are_named_by_line_and_column() {
    let folder = made("face-takes");
    let said = |text: &str| {
        fs::write(folder.path("take.csv"), text).unwrap();
        folder.sinew(TRAIN).failed()
    };
    for (text, expected) in [
        ("LiftLeft,JawOpn\n0,1\n", "unknown \"JawOpn\" (did you mean jawOpen?)"),
        ("LiftLeft,JawOpen\n0,1\n0\n", "line 3: expected 2 columns, found 1"),
        ("LiftLeft,JawOpen\n0,x\n", "line 2, column \"JawOpen\": expected a number, found \"x\""),
        ("LiftLeft,JawOpen\n0,inf\n", "line 2, column \"JawOpen\": expected a number"),
        ("LiftLeft,LiftLeft\n0,1\n", "two columns are named \"LiftLeft\""),
        ("HeadYaw\n0\n", "no column drives a shape of the face"),
        ("LiftLeft\n", "has no row below its line of names"),
    ] {
        let error = said(text);
        assert!(error.starts_with("take.csv: ") && error.contains(expected), "{error}");
    }
    assert!(!folder.list().contains(&"face.sinew".to_owned()));
    let run =
        made("face-noted").sinew("face train --basis face.npz --animation take.csv -o f.sinew");
    assert_eq!(run.code, Some(0));
    let noted = "sinew: warning: take.csv: columns that the face has no shape for are left out: HeadYaw, TongueOut\n";
    assert_eq!(run.err, noted);
}

#[test]
fn impossible_requests_are_explained() {
    let folder = trained("face-refused");
    let failed = |arguments: &str, expected: &str| {
        let error = folder.sinew(arguments).failed();
        assert!(error.contains(expected), "{arguments}: {error}");
    };
    fs::write(folder.path("none.sinew"), "no model").unwrap();
    failed("face train --basis face.npz --frames 0..9 -o f.sinew", "give --animation");
    failed("face train --basis take.csv --animation take.csv -o f.sinew", ".glb, .gltf or .fbx");
    failed(&format!("{TRAIN} --rank 2"), "--rank is for example meshes");
    failed(&format!("{TRAIN} --frames 50..70"), "frames 50..70: expected a range within 0..60");
    failed("face train --basis face.npz --animation take.csv -o face.npz", "it is an input");
    failed("face pin face.sinew --pin 8=0,0,0 -o a.obj", "--pin 8: expected a vertex from 0 to 7");
    failed("face pin face.sinew --hold 9 -o a.obj", "--hold 9: expected a vertex from 0 to 7");
    failed("face pin face.sinew --pin 0=0,0,0 -o a.stl", "ends in .obj, .glb, .png or .csv");
    failed("face pin take.csv --pin 0=0,0,0 -o a.obj", "take.csv");
    failed("face eval face.sinew --animation take.csv --handles 5 -q", "expected 1 to 4");
    failed("face eval face.sinew --animation take.csv --vertices 3..9 -q", "vertices within 0..8");
    fs::write(folder.path("track.csv"), "frame,vertex,x,y,z\n0,8,0,0,0\n").unwrap();
    failed("face solve face.sinew --track track.csv -o w.csv", "line 2, column \"vertex\"");
    fs::remove_file(folder.path("face.obj")).unwrap();
    failed("face pin face.sinew --pin 0=0,0,0 -o a.obj", "face.obj: cannot be read");
    fs::write(folder.path("face.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    failed("face pin face.sinew --pin 0=0,0,0 -o a.obj", "expected 8 vertices");
    write_face(&folder, &["lift_L", "lift_L", "jawOpen"]);
    failed(TRAIN, "two shapes are named \"lift_L\"");
    // A pin that no shape can move is reported, and the face stays unchanged.
    let Run { code, err, .. } =
        trained("face-unreachable").sinew("face pin face.sinew --pin 0=5,_,_ -o a.csv");
    assert_eq!(code, Some(0));
    assert!(err.contains("1 of 1 are where no shape moves anything"), "{err}");
    // A free pin only reports the place of its vertex.
    let free = "face pin face.sinew --pin 0=_,_,0.5 --pin 3=_,_,_ --pin 1=_,_ -o a.csv";
    let Run { code, err, .. } = trained("face-free").sinew(free);
    let message = "sinew: note: pins: 2 of 3 are free in every coordinate\n";
    assert_eq!((code, err.as_str()), (Some(0), message));
}
