//! `sinew views`: from pictures to all between them.

use super::common::{Folder, Run};
use serde_json::json;
use sinew_trainer::page::picture::Picture;
use std::fs;

/// A folder with the demo's sets and a model of one of them.
fn trained(test: &str, set: &str) -> Folder {
    let folder = Folder::new(test);
    folder.sinew("views demo demo").done();
    let found =
        folder.sinew(&format!("views train demo/{set}/views.json -o {set}.sinew --json")).json();
    assert_eq!(found["bytes"], fs::read(folder.path(&format!("{set}.sinew"))).unwrap().len());
    folder
}

/// Returns the size of a PNG, and the number of its covered pixels.
fn picture(folder: &Folder, name: &str) -> ([u32; 2], usize) {
    let (size, rgba) = decoded(folder, name);
    (size, rgba.chunks(4).filter(|pixel| pixel[3] > 0).count())
}

/// Reads the pixels of a PNG.
fn decoded(folder: &Folder, name: &str) -> ([u32; 2], Vec<u8>) {
    let bytes = std::io::Cursor::new(folder.read(name));
    let mut reader = png::Decoder::new(bytes).read_info().unwrap();
    let mut rgba = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut rgba).unwrap();
    ([info.width, info.height], rgba)
}

#[test]
fn a_head_is_trained_measured_drawn_and_reported() {
    let folder = trained("views-head", "head");
    let found = folder.sinew("views eval head.sinew demo/head/views.json --json").json();
    assert_eq!((found["views"].as_u64(), found["flipped"].as_u64()), (Some(24), Some(0)));
    assert!(found["rms"].as_f64().unwrap() < 0.05, "{found}");
    let drawn = folder.sinew("views render head.sinew --set yaw=137 -o head.png --json").json();
    assert_eq!(drawn["flipped"], 0);
    assert_eq!(drawn["points"].as_array().unwrap().len(), 128);
    let (size, covered) = picture(&folder, "head.png");
    assert_eq!(size, [160, 192]);
    assert!(covered > 8000, "{covered}");
    let round = ["1", "361"].map(|yaw| {
        let name = format!("yaw{yaw}.png");
        folder.sinew(&format!("views render head.sinew --set yaw={yaw} -o {name}")).done();
        folder.read(&name)
    });
    assert_eq!(round[0], round[1], "once round is none");
    folder.sinew("views report head.sinew demo/head/views.json -o head.html").done();
    let page = String::from_utf8(folder.read("head.html")).unwrap();
    assert!(page.contains("A network over pixels") && page.matches("<img").count() > 7);
    let about = &folder.sinew("inspect head.sinew --json").json()["views"][0];
    assert_eq!((about["points"].as_u64(), about["maps"].as_u64()), (Some(128), Some(1)));
}

#[test]
fn maps_are_named_after_their_parameters() {
    let folder = Folder::new("views-named");
    folder.sinew("views demo demo").done();
    let text = folder.sinew("views train demo/head/views.json -o head.sinew").done().out;
    assert!(text.contains("\nmap \"main\" of yaw\n"), "{text}");
}

#[test]
fn a_figure_walks_is_driven_lends_its_motion_and_is_dragged() {
    let folder = trained("views-figure", "figure");
    fs::write(
        folder.path("path.json"),
        json!({ "keys": [{ "phase": 0 }, { "phase": 90 }], "frames": 3 }).to_string(),
    )
    .unwrap();
    folder.sinew("views animate figure.sinew --map walk --path path.json -o walk").done();
    assert_eq!(folder.list().iter().filter(|name| *name == "walk").count(), 1);
    assert!(
        folder.path("walk/frame0002.png").exists() && !folder.path("walk/frame0003.png").exists()
    );
    let again = folder.sinew("views animate figure.sinew --map walk --path path.json -o walk");
    assert_eq!(again.failed(), "walk: it holds frames already");

    let set = folder.json("demo/figure/views.json");
    let view = &set["maps"][0]["train"][2];
    let points = view["points"].as_array().unwrap();
    let row: Vec<String> =
        points.iter().flat_map(|point| [point[0].to_string(), point[1].to_string()]).collect();
    fs::write(folder.path("track.csv"), row.join(",") + "\n").unwrap();
    let driven = folder
        .sinew("views drive figure.sinew --map walk --track track.csv -o driven --json")
        .json();
    let phase = driven["frames"][0]["values"]["phase"].as_f64().unwrap().rem_euclid(360.0);
    assert!((phase - view["phase"].as_f64().unwrap()).abs() < 0.01, "{phase}");
    assert_eq!(driven["bytes"], 4);
    folder.sinew("views render figure.sinew --map walk --set phase=90 -o set.png").done();
    assert!(folder.path("driven/frame0000.png").exists());

    let rest = &set["maps"][1]["train"][0];
    let wider: Vec<_> = rest["points"]
        .as_array()
        .unwrap()
        .iter()
        .map(|point| json!([1.2 * point[0].as_f64().unwrap() - 20.0, point[1]]))
        .collect();
    let instance = json!({ "views": [{ "view": "texture", "image": "texture.png", "mask": "mask.png", "points": wider }] });
    fs::write(folder.path("demo/figure/sister.json"), instance.to_string()).unwrap();
    folder
        .sinew("views transfer figure.sinew demo/figure/sister.json -o sister.sinew --by-size")
        .done();
    let drawn = folder
        .sinew("views render sister.sinew --map walk --set phase=45 -o sister.png --json")
        .json();
    assert!(drawn["elements"].as_u64().unwrap() > 200);
    let twice =
        folder.sinew("views transfer sister.sinew demo/figure/sister.json -o x.sinew").failed();
    assert!(twice.ends_with("its motion is lent itself: take its prototype"), "{twice}");

    let foot = view["points"][15].clone();
    let (x, y) = (foot[0].as_f64().unwrap(), foot[1].as_f64().unwrap());
    let pinned = folder
        .sinew(&format!(
            "views pin figure.sinew --map walk --set phase=60 --pin 15={x},{y} -o pinned.png --json"
        ))
        .json();
    assert!((pinned["values"]["phase"].as_f64().unwrap() - 90.0).abs() < 12.0, "{pinned}");
}

/// Checks exit status 2, and returns the usage message.
fn misused(run: Run) -> String {
    assert_eq!((run.code, run.out.as_str()), (Some(2), ""), "{}", run.err);
    run.err
}

#[test]
fn pictures_become_one_gif_and_follow_tracked_points() {
    let folder = trained("views-gif", "figure");
    let path = json!({ "keys": [{ "phase": 0 }, { "phase": 90 }], "frames": 3 });
    fs::write(folder.path("path.json"), path.to_string()).unwrap();
    let animate = "views animate figure.sinew --map walk --path path.json";
    folder.sinew(&format!("{animate} -o walk")).done();
    let told = folder.sinew(&format!("{animate} -o walk.gif --frame-time 0.12 --json")).json();
    assert_eq!((told["frames"].as_u64(), told["frame_time"].as_f64()), (Some(3), Some(0.12)));
    let frames = folder.gif("walk.gif");
    assert_eq!(frames.len(), 3);
    for (number, (rgba, delay)) in frames.iter().enumerate() {
        assert_eq!(*delay, 12);
        let png = decoded(&folder, &format!("walk/frame{number:04}.png")).1;
        let on_white = |c: u8, alpha: u8| {
            let alpha = f64::from(alpha) / 255.0;
            f64::from(c) * alpha + 255.0 * (1.0 - alpha)
        };
        let apart = png.chunks(4).zip(rgba.chunks(4)).flat_map(|(own, found)| {
            (0..3).map(move |c| (on_white(own[c], own[3]) - f64::from(found[c])).abs())
        });
        // The GIF has 256 colours.
        let mean = apart.sum::<f64>() / (rgba.len() as f64 * 0.75);
        assert!(mean < 2.0, "frame {number}: {mean}");
    }
    // The requested number of frames, from the first key to the last.
    for count in [1, 2, 5] {
        let told =
            folder.sinew(&format!("{animate} --frames {count} -o some{count} --json")).json();
        assert_eq!(told["frames"], count);
        assert_eq!(fs::read_dir(folder.path(&format!("some{count}"))).unwrap().count(), count);
        folder.sinew(&format!("{animate} --frames {count} -o some.gif")).done();
        assert_eq!(folder.gif("some.gif").len(), count);
        let last = format!("some{count}/frame{:04}.png", count - 1);
        let key = if count == 1 { "frame0000.png" } else { "frame0002.png" };
        assert_eq!(folder.read(&last), folder.read(&format!("walk/{key}")));
    }
    assert_eq!(folder.read("some5/frame0002.png"), folder.read("walk/frame0001.png"));
    let none = folder.sinew(&format!("{animate} --frames 0 -o none"));
    assert!(misused(none).contains("expected a whole number from 1 to"));
    let refused = folder.sinew(&format!("{animate} -o walk.gif --frame-time 0.01"));
    assert!(misused(refused).contains("expected a number from 0.02 to 655.35 seconds"));

    let set = folder.json("demo/figure/views.json");
    let points = set["maps"][0]["train"][2]["points"].as_array().unwrap();
    let row: Vec<String> = points.iter().map(|at| format!("{},{}", at[0], at[1])).collect();
    fs::write(folder.path("frame.csv"), row.join(",") + "\n").unwrap();
    let render = "views render figure.sinew --map walk";
    let found = folder.sinew(&format!("{render} --points frame.csv -o points.png --json")).json();
    assert!((found["values"]["phase"].as_f64().unwrap() - 90.0).abs() < 0.01, "{found}");
    folder.sinew(&format!("{render} --set phase=90 -o set.png")).done();
    let (points, set) = (decoded(&folder, "points.png").1, decoded(&folder, "set.png").1);
    assert!(points.iter().zip(&set).all(|(a, b)| a.abs_diff(*b) <= 2));
    let both = folder.sinew(&format!("{render} --set phase=9 --points frame.csv -o x.png"));
    assert!(misused(both).contains("cannot be used with"));
    fs::write(folder.path("frames.csv"), (row.join(",") + "\n").repeat(2)).unwrap();
    let many = folder.sinew(&format!("{render} --points frames.csv -o x.png")).failed();
    assert_eq!(many, "frames.csv: expected one frame, found 2");
}

#[test]
fn grids_are_written_for_other_tools_and_lent_motion_is_reported() {
    let folder = trained("views-export", "figure");
    let export = "views export figure.sinew --map walk";
    let told = folder.sinew(&format!("{export} --inp phase:9 -o walk.inp --json")).json();
    assert_eq!(told["ranges"]["phase"], json!([0.0, 360.0]));
    assert_eq!(told["nodes"].as_array().unwrap().len(), 9);
    assert!(folder.read("walk.inp").starts_with(b"TRNSRTS\0"));
    folder.sinew(&format!("{export} --glb phase=0..90:4 -o walk.glb")).done();
    assert!(folder.read("walk.glb").starts_with(b"glTF"));
    folder.sinew("views export figure.sinew --map jump --glb -o jump.glb").done();
    for (arguments, told) in [
        ("--map walk --glb -o x.glb", "figure.sinew: no key view is of this map: say a grid"),
        (
            "--map jump --glb --set time=0 -o x.glb",
            "key views have parameters of their own: set none",
        ),
        (
            "--map walk --inp phase,nod:3x3 -o x.inp",
            "figure.sinew: \"nod\" is no parameter: expected phase",
        ),
        ("--map walk --inp phase:9 -o x.glb", "x.glb: expected a file that ends in .inp"),
        ("--map jump --glb -o x.gltf", "x.gltf: expected a file that ends in .glb"),
    ] {
        assert_eq!(folder.sinew(&format!("views export figure.sinew {arguments}")).failed(), told);
    }
    let shape = folder.sinew("views export figure.sinew --map walk --inp phase:3x3 -o x.inp");
    assert!(misused(shape).contains("expected a grid, as yaw,pitch:9x9 or yaw=-40..40:9"));

    let rest = folder.json("demo/figure/views.json")["maps"][1]["train"][0]["points"].clone();
    let instance = json!({ "views": [{
        "view": "texture", "image": "texture.png", "mask": "mask.png", "points": rest,
    }] });
    fs::write(folder.path("demo/figure/sister.json"), instance.to_string()).unwrap();
    folder.sinew("views transfer figure.sinew demo/figure/sister.json -o sister.sinew").done();
    let report = "views report sister.sinew demo/figure/views.json -o sister.html";
    folder.sinew(&format!("{report} --prototype figure.sinew")).done();
    let page = String::from_utf8(folder.read("sister.html")).unwrap();
    assert_eq!(page.matches("The motion that is lent").count(), 2);
    assert_eq!(page.matches("the object, before").count(), 2);
    assert!(page.contains("the prototype at phase") && page.contains("the object at time"));
    folder.sinew("views export sister.sinew --map walk --inp phase:9 -o sister.inp").done();
    // The parameters of a key view follow from the instance's own points.
    let key_views = folder.sinew("--json views export sister.sinew --map jump --glb -o sister.glb");
    assert_eq!(key_views.json()["nodes"].as_array().unwrap().len(), 1);
}

#[test]
fn paths_are_animations_of_a_skeleton_beside_its_pictures() {
    let folder = trained("views-spine", "panel");
    let key = |yaw: f64, bend: f64| json!({ "yaw": yaw, "pitch": 5, "bend": bend });
    let bent = json!({ "keys": [key(-30.0, 0.0), key(0.0, 1.0), key(30.0, 0.0)], "frames": 5 });
    fs::write(folder.path("bent.json"), bent.to_string()).unwrap();
    let turned = json!({ "keys": [{ "yaw": 0, "bend": 0 }, { "yaw": 20, "bend": 0 }] });
    fs::write(folder.path("turned.json"), turned.to_string()).unwrap();
    let export = "views export panel.sinew";
    let told = folder.sinew(&format!("{export} --spine bent.json -o panel.json --json")).json();
    assert_eq!(told["frames"], json!({ "bent": 5 }));
    assert_eq!(told["unclipped"], json!([]));
    let skeleton = folder.json("panel.json");
    assert_eq!(skeleton["skeleton"]["images"], "./panel/");
    for slot in skeleton["slots"].as_array().unwrap() {
        let name = slot["name"].as_str().unwrap();
        let (_, covered) = picture(&folder, &format!("panel/{name}.png"));
        assert!(covered > 1000, "{name}");
    }
    // The time between frames is that of `animate`.
    let meshes = &skeleton["animations"]["bent"]["attachments"]["default"];
    let times = |keys: &serde_json::Value| {
        keys.as_array().unwrap().iter().map(|key| key["time"].as_f64().unwrap()).collect::<Vec<_>>()
    };
    let all: Vec<f64> = meshes
        .as_object()
        .unwrap()
        .iter()
        .flat_map(|(name, own)| times(&own[name]["deform"]))
        .collect();
    assert!(all.iter().all(|time| [0.0, 0.04, 0.08, 0.12, 0.16].contains(time)), "{all:?}");
    for (arguments, told) in [
        (
            "--spine bent.json --set pitch=0 -o x.json",
            "bent.json: parameter \"pitch\" is set, and in the path",
        ),
        ("--spine turned.json -o x.json", "turned.json: parameter \"pitch\" is missing"),
        ("--spine bent.json -o x.glb", "x.glb: expected a file that ends in .json"),
        ("--spine bent.json -o bent.json", "cannot write bent.json: it is an input"),
        (
            "--spine bent.json bent.json -o x.json",
            "two paths are called \"bent\": animations have the names of their files",
        ),
    ] {
        assert_eq!(folder.sinew(&format!("{export} {arguments}")).failed(), told);
    }
    let both = "--spine bent.json turned.json --set pitch=0 -o two.json";
    let refused = folder.sinew(&format!("{export} {both}")).failed();
    assert_eq!(refused, "bent.json: parameter \"pitch\" is set, and in the path");
    let set = "--spine turned.json --set pitch=0 -o two.json --json";
    let told = folder.sinew(&format!("{export} {set}")).json();
    assert_eq!(told["frames"], json!({ "turned": 24 }));
}

#[test]
fn clip_masks_that_a_format_lacks_cause_a_warning() {
    let folder = Folder::new("views-clipped");
    for (name, colour) in [("back", [200, 40, 40]), ("front", [40, 40, 200])] {
        let picture = Picture::filled(16, 16, colour).png().unwrap();
        fs::write(folder.path(&format!("{name}.png")), picture).unwrap();
    }
    let view = |x: f64| {
        json!({
            "x": x,
            "points": [[2.0 + x, 2], [14, 2], [14, 14], [4.0 + x, 4], [12, 4], [12, 12]],
            "layers": { "back": "back.png", "front": "front.png" },
        })
    };
    let layers = json!([
        { "name": "back", "points": [0, 1, 2] },
        { "name": "front", "points": [3, 4, 5], "clip": "back" },
    ]);
    let set = json!({ "image_size": [16, 16], "layers": layers, "train": [view(0.0), view(1.0)] });
    fs::write(folder.path("views.json"), set.to_string()).unwrap();
    folder.sinew("views train views.json -o clipped.sinew").done();
    fs::write(folder.path("path.json"), "{\"keys\": [{\"x\": 0}, {\"x\": 1}]}").unwrap();
    for (arguments, told) in [
        ("--inp x:2 -o x.inp", ""),
        (
            "--spine path.json -o x.json",
            "sinew: warning: clipped.sinew: clip masks are not written, Spine clips by polygons: front\n",
        ),
        (
            "--glb x:2 -o x.glb",
            "sinew: warning: clipped.sinew: clip masks are not written, glTF has none\n",
        ),
    ] {
        let run = folder.sinew(&format!("views export clipped.sinew {arguments}"));
        assert_eq!((run.code, run.err.as_str()), (Some(0), told));
    }
}

#[test]
fn failures_are_reported_in_one_line() {
    let folder = trained("views-refused", "panel");
    for (arguments, told) in [
        (
            "views render panel.sinew --set yaw=1 --set pitch=2 -o x.png",
            "parameter \"bend\" is missing",
        ),
        (
            "views render panel.sinew --set yaw=1 --set yaw=2 -o x.png",
            "parameter \"yaw\" is given twice",
        ),
        (
            "views render panel.sinew --set yaw=1 --set pitch=2 --set bend=0 --set nod=3 -o x.png",
            "\"nod\" is no parameter: expected pitch, yaw, bend",
        ),
        (
            "views render panel.sinew --set yaw=1 --set pitch=2 --set bend=5 -o x.png",
            "parameter \"bend\" is 5, expected -1 to 2",
        ),
        (
            "views render panel.sinew --map run -o x.png",
            "panel.sinew: it has no map \"run\"; there are main",
        ),
        (
            "views train demo/panel/none.json -o x.sinew",
            "demo/panel/none.json: cannot be read: No such file or directory (os error 2)",
        ),
        (
            "views pin panel.sinew --set yaw=0 --set pitch=0 --set bend=0 --pin 99=1,2 -o x.png",
            "pin 0: point 99, of 35",
        ),
        ("views render panel.sinew -o x.jpg", "x.jpg: expected a file that ends in .png"),
        ("views pin panel.sinew --pin 0=1,2 -o x", "x: expected a file that ends in .png"),
        (
            "views transfer panel.sinew demo/panel/views.json -o x.png",
            "cannot write x.png: a model is no .png file, name it .sinew",
        ),
    ] {
        assert_eq!(folder.sinew(arguments).failed(), told, "{arguments}");
    }
    fs::write(folder.path("track.csv"), "1,2,3\n").unwrap();
    let told = folder.sinew("views drive panel.sinew --track track.csv -o x").failed();
    assert_eq!(told, "track.csv: line 1: expected 70 numbers, found 3");
    fs::remove_file(folder.path("demo/panel/view03.png")).unwrap();
    let told = folder.sinew("views train demo/panel/views.json -o y.sinew").failed();
    assert!(told.starts_with("demo/panel/views.json: demo/panel/view03.png: "), "{told}");
}

#[test]
fn proposed_points_are_written_out_and_train_the_same_model() {
    let folder = Folder::new("views-points");
    let size = [40u32, 30];
    for (number, left) in [(0, 6), (1, 10)] {
        let inside =
            |at: u32| (left..left + 20).contains(&(at % 40)) && (5..22).contains(&(at / 40));
        let pixels = (0..40 * 30).flat_map(|at| [90, 20, 200, if inside(at) { 255 } else { 0 }]);
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, size[0], size[1]);
        encoder.set_color(png::ColorType::Rgba);
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(&pixels.collect::<Vec<u8>>()).unwrap();
        writer.finish().unwrap();
        fs::write(folder.path(&format!("box{number}.png")), bytes).unwrap();
    }
    let view = |number: u32| json!({ "layers": { "box": format!("box{number}.png"), "lid": format!("box{number}.png") }, "x": number });
    let set = json!({
        "image_size": size, "points": "auto",
        "layers": [{ "name": "box" }, { "name": "lid", "clip": "box" }],
        "train": [view(0), view(1)],
    });
    fs::write(folder.path("views.json"), set.to_string()).unwrap();
    let text =
        folder.sinew("views train views.json -o a.sinew --points-out points.json").done().out;
    assert!(text.contains("wrote points.json ("), "{text}");
    let written = folder.json("points.json");
    assert_eq!(written["layers"][1]["clip"], "box");
    assert!(written["maps"][0]["train"][1]["points"][0].is_array());
    folder.sinew("views train points.json -o b.sinew").done();
    let [a, b] = ["a.sinew", "b.sinew"].map(|name| folder.read(name));
    assert_eq!(a, b, "points that nobody corrected");
    let about = folder.sinew("inspect a.sinew --json").json();
    let lid = &about["views"][0]["layers"][1];
    assert_eq!(
        (&lid["name"], &lid["clip"], &lid["key_views"]),
        (&json!("lid"), &json!("box"), &json!(2))
    );
    assert!(lid["points"].as_u64().unwrap() > 3 && lid["elements"].as_u64().unwrap() > 2);
    let text = folder.sinew("inspect a.sinew").done().out;
    let row = text.lines().find(|line| line.trim_start().starts_with("lid ")).unwrap();
    assert!(text.contains("clipped by") && row.ends_with("  box"), "{text}");
    folder.sinew("views report a.sinew views.json -o a.html").done();
    let page = String::from_utf8(folder.read("a.html")).unwrap();
    assert!(page.contains("clipped by") && page.contains("<th scope=\"row\">lid</th>"));
    fs::create_dir(folder.path("other")).unwrap();
    let refused =
        folder.sinew("views train views.json -o c.sinew --points-out other/points.json").failed();
    assert!(refused.contains("expected a file beside views.json"), "{refused}");
}
