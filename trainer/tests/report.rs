//! The report, compared with the measurement that `sinew eval` prints.

use sinew_runtime::envelope::{Certificate, Predictor};
use sinew_trainer::envelope::fitted::Fitted;
use sinew_trainer::envelope::lbs::training::Training;
use sinew_trainer::envelope::s3::ProxyCount;
use sinew_trainer::envelope::{Options, Predict, train};
use sinew_trainer::evaluate::{Errors, Frames, evaluate};
use sinew_trainer::examples::demo::{DemoOptions, demo};
use sinew_trainer::examples::{Clip, Examples, Split};
use sinew_trainer::progress::Silent;
use sinew_trainer::report::comparison::{Comparison, NamedExamples, NamedModel};
use sinew_trainer::report::{Page, PictureOptions, outputs};
use std::collections::HashMap;

const HELD_OUT: Frames = Frames::Of(Split::HeldOut);

/// Makes a small arm with names that contain markup, in two clips.
fn arm() -> (Examples, Vec<Clip>) {
    let mut examples = demo(&DemoOptions { vertices: 250, poses: 24, held_out: 8, seed: 3 });
    examples.skeleton.names[2] = "<script>alert(1)</script> & \"co\"".to_owned();
    let clip = |name: &str, frames: std::ops::Range<usize>| Clip {
        name: name.to_owned(),
        first: frames.start,
        times: frames.map(|frame| frame as f64 / 30.0).collect(),
        numbers: None,
    };
    let middle = examples.frames_of(Split::HeldOut)[4];
    let len = examples.frame_len();
    (examples, vec![clip("walk", 0..middle), clip("</title><img src=x>", middle..len)])
}

fn model(examples: &Examples, predictor: Predictor) -> Vec<u8> {
    let proxies = Some(ProxyCount::Fixed(8));
    let options = Options { predictor: Predict::Only(predictor), proxies, ..Options::default() };
    train(examples, &options, &Silent).unwrap().model
}

/// Bakes LBS as a model, with one rest vertex moved by `by`.
fn disturbed(examples: &Examples, vertex: usize, by: f64) -> Vec<u8> {
    let training = Training::new(examples, &Silent).unwrap();
    let weights = training.lbs.weights.clone();
    let fitted = Fitted::new(&training, weights, None);
    let mut model = fitted.file_model(&training, Certificate::default());
    model.skins[0].rest_positions[vertex][1] += by;
    model.bake().unwrap()
}

fn source<'a>(examples: &'a Examples, clips: &'a [Clip]) -> NamedExamples<'a> {
    NamedExamples { examples, clips, name: "arm <1>.npz" }
}

fn file(bytes: &[u8]) -> NamedModel<'_> {
    NamedModel { name: "a&b.sinew", bytes, skin: None }
}

fn page(comparison: &Comparison<'_>, sizes: bool) -> String {
    let options = PictureOptions { width: 90, ..PictureOptions::default() };
    Page { comparison, options, sizes }.html(&Silent).unwrap()
}

/// Checks that tags are balanced, and that attributes and text contain no unescaped `<`; lists the
/// tags.
fn tags(html: &str) -> Vec<String> {
    let mut open: Vec<&str> = Vec::new();
    let mut all = Vec::new();
    let mut rest = html.strip_prefix("<!DOCTYPE html>").unwrap();
    while let Some((text, after)) = rest.split_once('<') {
        assert!(!text.contains('>') || open.last() == Some(&"style"), "{text}");
        let (tag, after) = after.split_once('>').unwrap();
        assert!(!tag.contains('<') && tag.matches('"').count() % 2 == 0, "{tag}");
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name));
        } else {
            let name = tag.split([' ', '/']).next().unwrap();
            all.push(name.to_owned());
            if !["meta", "img"].contains(&name) && !tag.ends_with('/') {
                open.push(name);
            }
        }
        rest = after;
    }
    assert!(open.is_empty(), "{open:?}");
    all
}

/// Lists the cells of every table without markup, by row.
fn rows(html: &str) -> Vec<Vec<String>> {
    let cells = |row: &str| -> Vec<String> {
        let (cells, _) = row.rsplit_once("</t").unwrap();
        cells.split("</t").map(|cell| cell.rsplit_once('>').unwrap().1.to_owned()).collect()
    };
    html.split("<tr>").skip(1).map(|row| cells(row.split("</tr>").next().unwrap())).collect()
}

fn row<'a>(rows: &'a [Vec<String>], first: &str) -> &'a [String] {
    rows.iter().find(|row| row.first().is_some_and(|cell| cell == first)).unwrap()
}

fn accuracy(e: &Errors) -> [String; 6] {
    [
        format!("{:.4}\u{a0}%", e.rms_percent),
        format!("{:.4}\u{a0}%", e.p99_percent),
        format!("{:.4}\u{a0}%", e.max_percent),
        format!("{:.2}°", e.normal_rms_degrees),
        format!("{:.2}°", e.normal_median_degrees),
        format!("{:.2}°", e.normal_p99_degrees),
    ]
}

#[test]
fn the_page_is_well_formed_and_its_figures_are_those_of_evaluate() {
    let (examples, mut clips) = arm();
    clips[1].numbers = Some((101..).take(clips[1].times.len()).collect());
    let [bytes, other] = [Predictor::Kernel, Predictor::Rotational].map(|p| model(&examples, p));
    let mut comparison =
        Comparison::new(source(&examples, &clips), Some(HELD_OUT), file(&bytes)).unwrap();
    comparison.compare(NamedModel { name: "other", bytes: &other, skin: None }).unwrap();
    let html = page(&comparison, true);
    let tags = tags(&html);
    let count = |name: &str| tags.iter().filter(|tag| *tag == name).count();
    assert_eq!(
        (count("script"), count("link"), count("h1"), count("title")),
        (0, 0, 1, tags_of_titles(&html))
    );
    // Truth, LBS and two models, twice, as clay and as heat; then the rest pose of all; the angles
    // of three models on both poses; then the palettes: joints only with the map of each vertex,
    // and the other palette's maps.
    assert_eq!(count("img"), 4 * 4 + 5 + 2 * 3 + 3);
    assert!(!html.contains("http") && !html.contains("src=\"/"));
    assert!(!html.contains("own weights"), "the mesh comes without");
    assert!(html.contains("&lt;script&gt;alert(1)&lt;/script&gt; &amp; &quot;co&quot;"));
    assert!(html.contains("a&amp;b.sinew on arm &lt;1&gt;.npz, compared with other"));
    assert!(html.contains("&lt;/title&gt;&lt;img src=x&gt;"), "the clip of some frame");

    let rows = rows(&html);
    let found = [&bytes, &other].map(|model| evaluate(model, None, &examples, HELD_OUT).unwrap());
    assert_eq!(comparison.evaluations()[..].len(), 2);
    for (a, b) in comparison.evaluations().iter().zip(&found) {
        assert_eq!(serde_json::to_value(a).unwrap(), serde_json::to_value(b).unwrap());
    }
    assert_eq!(row(&rows, "LBS, fitted")[1..7], accuracy(&found[0].lbs));
    assert_eq!(row(&rows, "a&amp;b.sinew")[1..7], accuracy(&found[0].errors));
    assert_eq!(row(&rows, "other")[1..7], accuracy(&found[1].errors));

    // Joints partition the vertices, so their squares sum to the total.
    let names = examples.skeleton.names.iter();
    let names: Vec<String> = names
        .map(|n| {
            n.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
        })
        .collect();
    let joints: Vec<_> = rows.iter().filter(|row| names.contains(&row[0])).collect();
    let number = |cell: &str| cell.replace('\u{202f}', "").parse::<f64>().unwrap();
    let vertices: f64 = joints.iter().map(|row| number(&row[1])).sum();
    assert_eq!(vertices, examples.vertex_len() as f64);
    for (column, whole) in [
        (2, found[0].lbs.rms_percent),
        (3, found[0].errors.rms_percent),
        (4, found[1].errors.rms_percent),
    ] {
        let squares: f64 = joints.iter().map(|r| number(&r[1]) * number(&r[column]).powi(2)).sum();
        assert!(((squares / vertices).sqrt() / whole - 1.0).abs() < 0.01, "{column}");
    }
    // Training with the model's number of proxies reproduces the model.
    let again = row(&rows, "8");
    assert_eq!(again[1..7], accuracy(&found[0].errors));
    assert_eq!(again[8].replace('\u{202f}', ""), format!("{} B", bytes.len()));
    for proxies in ["2", "4", "16"] {
        assert_eq!(row(&rows, proxies).len(), 10);
    }
}

/// Counts titles; SVG has titles too, which show under the pointer.
fn tags_of_titles(html: &str) -> usize {
    html.matches("<title>").count()
}

#[test]
fn a_disturbed_vertex_is_the_worst_one_everywhere() {
    let (examples, clips) = arm();
    let (vertex, by) = (123, 0.2 * examples.diagonal());
    let bytes = disturbed(&examples, vertex, by);
    let comparison =
        Comparison::new(source(&examples, &clips), Some(HELD_OUT), file(&bytes)).unwrap();
    let html = page(&comparison, false);
    tags(&html);
    let sentence = format!("Vertex {vertex}, where the model is off by ");
    let (_, after) = html.split_once(&sentence).expect("the worst vertex is named");
    // LBS moves a vertex by the displacement of its rest position, or less if joints disagree.
    let percent: f64 = after.split('\u{a0}').next().unwrap().parse().unwrap();
    assert!((10.0..21.0).contains(&percent), "{percent}");
    assert!(html.contains(&format!("The vertices with the largest: {vertex} (")));
    // Empty sections are left out.
    for absent in ["More or fewer helpers", "near-rigid", "(0\u{a0}%)", "(100\u{a0}%)"] {
        assert!(!html.contains(absent), "{absent}");
    }
    for record in
        ::csv::Reader::from_reader(&outputs::frames_csv(&comparison).unwrap()[..]).records()
    {
        assert_eq!(&record.unwrap()[8], vertex.to_string());
    }
    // Without the disturbance, another vertex is the worst.
    let bytes = disturbed(&examples, vertex, 0.0);
    let comparison =
        Comparison::new(source(&examples, &clips), Some(HELD_OUT), file(&bytes)).unwrap();
    assert!(!page(&comparison, false).contains(&sentence));
}

#[test]
fn a_second_model_trained_on_the_measured_frames_is_reported() {
    let (examples, clips) = arm();
    let mut seen = examples.clone();
    seen.split.fill(Split::Train);
    let [bytes, other] = [&examples, &seen].map(|examples| model(examples, Predictor::Rotational));
    let told = |second| {
        let mut comparison =
            Comparison::new(source(&examples, &clips), Some(HELD_OUT), file(&bytes)).unwrap();
        comparison.compare(NamedModel { name: "other", bytes: second, skin: None }).unwrap();
        page(&comparison, false).contains("; other has read all of them in training")
    };
    assert!(told(&other) && !told(&bytes));
}

#[test]
fn the_table_by_frame_averages_to_what_evaluate_measures() {
    let (examples, mut clips) = arm();
    clips[1].numbers = Some((101..).take(clips[1].times.len()).collect());
    let [bytes, other] = [disturbed(&examples, 5, 0.01), disturbed(&examples, 6, 0.02)];
    let mut comparison =
        Comparison::new(source(&examples, &clips), Some(Frames::All), file(&bytes)).unwrap();
    comparison.compare(file(&other)).unwrap();
    let table = outputs::frames_csv(&comparison).unwrap();
    let mut reader = ::csv::Reader::from_reader(&table[..]);
    let names: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
    let rows: Vec<HashMap<String, String>> = reader.deserialize().map(Result::unwrap).collect();
    assert_eq!(
        names[..10],
        [
            "frame",
            "number",
            "clip",
            "split",
            "vertices",
            "rms",
            "p99",
            "max",
            "worst_vertex",
            "confidence"
        ]
    );
    assert!(!names.iter().any(|name| name.starts_with("own_weights")));
    assert_eq!(rows.len(), examples.frame_len());
    assert_eq!(comparison.source.label(1), "frame 1 (walk, 1)");
    assert_eq!(comparison.source.label(clips[1].first + 1), "frame 102 (</title><img src=x>)");
    let [found, second] =
        [&bytes, &other].map(|m| evaluate(m, None, &examples, Frames::All).unwrap());
    let errors = [("", found.errors), ("lbs_", found.lbs), ("other_", second.errors)];
    for (prefix, errors) in errors {
        let column = |name: &str| -> Vec<f64> {
            rows.iter().map(|row| row[&format!("{prefix}{name}")].parse().unwrap()).collect()
        };
        let squares = column("rms").iter().map(|rms| rms * rms).sum::<f64>();
        let rms = (squares / rows.len() as f64).sqrt();
        assert!((rms / errors.rms_percent - 1.0).abs() < 1e-12, "{prefix}: {rms}");
        assert_eq!(column("max").into_iter().fold(0.0, f64::max), errors.max_percent);
        assert!(column("rms").iter().zip(column("p99")).all(|(rms, p99)| *rms > 0.0 && *rms < p99));
    }
    for (frame, row) in rows.iter().enumerate() {
        assert_eq!(row["frame"], frame.to_string());
        let clip = if frame < clips[1].first { 0 } else { 1 };
        let number = frame + [0, 101 - clips[1].first][clip];
        assert_eq!(row["number"], number.to_string());
        assert_eq!(row["clip"], clips[clip].name);
        let held_out = examples.split[frame] == Split::HeldOut;
        assert_eq!(row["split"], if held_out { "held-out" } else { "train" });
    }
}

#[test]
fn the_mesh_holds_every_vertex_with_its_error() {
    let (examples, clips) = arm();
    let vertex = 77;
    let bytes = disturbed(&examples, vertex, 0.1);
    let comparison =
        Comparison::new(source(&examples, &clips), Some(HELD_OUT), file(&bytes)).unwrap();
    let mesh = outputs::rest_mesh_ply(&comparison);
    let end = "end_header\n";
    let header_len = mesh.windows(end.len()).position(|w| w == end.as_bytes()).unwrap() + end.len();
    let header = std::str::from_utf8(&mesh[..header_len]).unwrap();
    let (v, t) = (examples.vertex_len(), examples.triangles.len());
    assert!(header.starts_with("ply\nformat binary_little_endian 1.0\n"), "{header}");
    assert!(header.contains(&format!("element vertex {v}\n")));
    assert!(header.contains(&format!("element face {t}\n")));
    assert_eq!(mesh.len(), header_len + v * (4 * 4 + 3) + t * (1 + 3 * 4));
    let float = |at: usize| f64::from(f32::from_le_bytes(mesh[at..][..4].try_into().unwrap()));
    let mut squares = 0.0;
    let mut largest = (0, 0.0);
    for k in 0..v {
        let at = header_len + 19 * k;
        for axis in 0..3 {
            assert!((float(at + 4 * axis) - examples.rest[k][axis]).abs() < 1e-6);
        }
        let error = float(at + 15);
        squares += error * error;
        largest = if error > largest.1 { (k, error) } else { largest };
    }
    let rms = evaluate(&bytes, None, &examples, HELD_OUT).unwrap().errors.rms_percent;
    assert!(((squares / v as f64).sqrt() / rms - 1.0).abs() < 1e-6);
    assert_eq!(largest.0, vertex);
    let corners = &mesh[header_len + 19 * v..];
    for (face, corner) in examples.triangles.iter().zip(corners.chunks(13)) {
        let expected = face.map(|c| (c as i32).to_le_bytes()).concat();
        assert_eq!((corner[0], &corner[1..]), (3, &expected[..]));
    }
}

#[test]
fn a_page_is_the_same_for_any_number_of_threads() {
    let (examples, clips) = arm();
    let bytes = disturbed(&examples, 9, 0.05);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let comparison =
                Comparison::new(source(&examples, &clips), Some(HELD_OUT), file(&bytes)).unwrap();
            page(&comparison, false)
        })
    };
    assert!(on(1) == on(3));
}

#[test]
fn training_frames_are_reported_as_such() {
    let (mut examples, clips) = arm();
    examples.split.fill(Split::Train);
    let bytes = disturbed(&examples, 9, 0.0);
    let train = Frames::Of(Split::Train);
    let comparison = Comparison::new(source(&examples, &clips), Some(train), file(&bytes)).unwrap();
    assert!(page(&comparison, false).contains("than on new frames"));
    // Without training frames nothing can be trained; the rest of the page is still complete.
    examples.split.fill(Split::HeldOut);
    let comparison =
        Comparison::new(source(&examples, &clips), Some(HELD_OUT), file(&bytes)).unwrap();
    let html = page(&comparison, true);
    assert!(html.contains("cannot be trained: the fit needs 6 training poses, found 0."));
    tags(&html);
}

/// Returns the frames of a split, in one clip.
fn only(examples: &Examples, split: Split) -> (Examples, Vec<Clip>) {
    let frames = examples.frames_of(split);
    let mut out = examples.clone();
    out.vertices = frames.iter().flat_map(|&frame| examples.frame(frame).to_vec()).collect();
    out.transforms = frames.iter().flat_map(|&frame| examples.pose(frame).to_vec()).collect();
    out.split = vec![Split::Train; frames.len()];
    out.clip_starts = vec![0];
    let times = (0..frames.len()).map(|frame| frame as f64 / 30.0).collect();
    (out, vec![Clip { name: "walk".to_owned(), first: 0, times, numbers: None }])
}

#[test]
fn other_sizes_are_trained_on_the_frames_that_the_model_has_read() {
    let (examples, clips) = arm();
    let bytes = model(&examples, Predictor::Kernel);
    // Only the model knows that frames were held out.
    let mut bare = examples.clone();
    bare.split.fill(Split::Train);
    let comparison = Comparison::new(source(&bare, &clips), None, file(&bytes)).unwrap();
    assert_eq!(comparison.measured_frames(), examples.frames_of(Split::HeldOut));
    let found = evaluate(&bytes, None, &examples, HELD_OUT).unwrap();
    let html = page(&comparison, true);
    let cells = rows(&html);
    assert_eq!(row(&cells, "8")[1..7], accuracy(&found.errors));
    // The tables of the worst frames and of the least confident frames; the second names models.
    let named = cells.iter().filter(|row| row[0].starts_with("frame "));
    let uses: Vec<&str> =
        named.map(|row| &*row[1]).filter(|name| !name.contains("sinew")).collect();
    assert!(!uses.is_empty() && uses.iter().all(|name| *name == "held-out"), "{uses:?}");
    let table = outputs::frames_csv(&comparison).unwrap();
    let mut reader = ::csv::Reader::from_reader(&table[..]);
    assert!(reader.records().all(|row| &row.unwrap()[3] == "held-out"));

    // Frames held out at the time of the report are not used to train other sizes, even if the
    // model was trained on them.
    let mut other = bare.clone();
    let measured: Vec<usize> = examples.frames_of(Split::Train)[..6].to_vec();
    measured.iter().for_each(|&frame| other.split[frame] = Split::HeldOut);
    let rest = examples.without(&measured);
    let again = evaluate(&model(&rest, Predictor::Kernel), None, &other, HELD_OUT).unwrap();
    let comparison = Comparison::new(source(&other, &clips), Some(HELD_OUT), file(&bytes)).unwrap();
    let html = page(&comparison, true);
    assert_eq!(row(&rows(&html), "8")[1..7], accuracy(&again.errors));
}

#[test]
fn other_sizes_that_only_measured_frames_could_train_are_reported_or_left_out() {
    let (examples, clips) = arm();
    let bytes = model(&examples, Predictor::Kernel);
    let told = "trained on the measured frames";
    // All measured frames are training frames of the model: the errors are training errors.
    let (read, walk) = only(&examples, Split::Train);
    let comparison = Comparison::new(source(&read, &walk), None, file(&bytes)).unwrap();
    let html = page(&comparison, true);
    let again = model(&read, Predictor::Kernel);
    let found = evaluate(&again, None, &read, Frames::Of(Split::Train)).unwrap();
    assert!(html.contains(told));
    assert_eq!(row(&rows(&html), "8")[1..7], accuracy(&found.errors));
    // No new pose is a training frame.
    let (new, walk) = only(&examples, Split::HeldOut);
    let comparison = Comparison::new(source(&new, &walk), None, file(&bytes)).unwrap();
    let html = page(&comparison, true);
    assert!(html.contains("needs the training frames of the model among the examples"));
    assert!(!rows(&html).iter().any(|row| row[0] == "8"));
    let comparison = Comparison::new(source(&examples, &clips), None, file(&bytes)).unwrap();
    assert!(!page(&comparison, true).contains(told));
}

/// Sets weights of 2 on each of the arm's first five joints, and of 0 at the first vertex.
fn with_weights(examples: &mut Examples) {
    let joint_len = examples.joint_len();
    assert!(joint_len > 5);
    let row =
        |vertex: usize| (0..joint_len).map(move |j| if vertex > 0 && j < 5 { 2.0 } else { 0.0 });
    examples.joint_weights = Some((0..examples.vertex_len()).flat_map(row).collect());
}

/// Returns the V distances from a frame's mesh if each vertex follows the mean of the first five
/// joints.
fn distances_by_five_joints(examples: &Examples, frame: usize) -> Vec<f64> {
    let follow = |(x, truth): (&[f64; 3], &[f64; 3])| {
        let axis = |axis: usize| {
            let moved = examples.pose(frame)[..5].iter().map(|m| {
                let [a, b, c, d] = m[axis];
                a * x[0] + b * x[1] + c * x[2] + d
            });
            (moved.sum::<f64>() / 5.0 - truth[axis]).powi(2)
        };
        (axis(0) + axis(1) + axis(2)).sqrt()
    };
    examples.rest.iter().zip(examples.frame(frame)).map(follow).collect()
}

#[test]
fn own_weights_stand_beside_the_fitted_ones_with_all_their_influences() {
    let (mut examples, clips) = arm();
    with_weights(&mut examples);
    let bytes = disturbed(&examples, 123, 0.2 * examples.diagonal());
    let mut comparison =
        Comparison::new(source(&examples, &clips), Some(HELD_OUT), file(&bytes)).unwrap();
    comparison.compare(NamedModel { name: "other", bytes: &bytes, skin: None }).unwrap();
    let own = comparison.baselines.own_weights.as_ref().unwrap();
    let mut all = Vec::new();
    for (place, frame) in examples.frames_of(Split::HeldOut).into_iter().enumerate() {
        let mut expected = distances_by_five_joints(&examples, frame);
        // A vertex without authored weights follows the fitted weights.
        expected[0] = comparison.baselines.lbs.measured.frames[place].distances[0];
        let found = &own.measured.frames[place].distances;
        assert!(expected.iter().zip(found).all(|(a, b)| (a - b).abs() < 1e-12));
        all.extend(expected);
    }
    let errors = evaluate(&bytes, None, &examples, HELD_OUT).unwrap().own_weights.unwrap();
    let rms = (all.iter().map(|x| x * x).sum::<f64>() / all.len() as f64).sqrt();
    let most = all.iter().copied().fold(0.0, f64::max);
    assert!((errors.rms / rms - 1.0).abs() < 1e-9, "{} {rms}", errors.rms);
    assert!((errors.max_percent * examples.diagonal() / most - 100.0).abs() < 1e-7);

    let html = page(&comparison, true);
    // The worst pose, whole and close: the truth and four skins, four error maps and one with its
    // own scale. Then the rest pose with these maps, maps of four skins' angles on both poses, and
    // two palettes.
    let pictures = tags(&html).iter().filter(|tag| *tag == "img").count();
    assert_eq!(pictures, 4 * 5 + 6 + 2 * 4 + 2);
    let cells = rows(&html);
    assert_eq!(row(&cells, "own weights")[1..7], accuracy(&errors));
    for class in ["line own", "area own"] {
        assert!(html.contains(&format!("class=\"{class}\"")), "{class}");
    }
    // The report names the model's worst vertex.
    assert!(
        html.contains("Vertex 123, where the model is off by ")
            && html.contains(", own weights by ")
    );
    assert!(html.contains("The vertices with the largest: 123 ("));
    let table = outputs::frames_csv(&comparison).unwrap();
    let mut reader = ::csv::Reader::from_reader(&table[..]);
    let rows: Vec<HashMap<String, String>> = reader.deserialize().map(Result::unwrap).collect();
    for (row, frame) in rows.iter().zip(&own.measured.frames) {
        let squares: f64 = frame.distances.iter().map(|x| x * x).sum();
        let rms = (squares / frame.distances.len() as f64).sqrt();
        let percent = 100.0 * rms / examples.diagonal();
        let [found, lbs, model, other] = ["own_weights_rms", "lbs_rms", "rms", "other_rms"]
            .map(|name| row[name].parse::<f64>().unwrap());
        assert!((found / percent - 1.0).abs() < 1e-9);
        assert!(model == other && found > 2.0 * lbs);
        assert_eq!(row["worst_vertex"], "123");
    }
}
