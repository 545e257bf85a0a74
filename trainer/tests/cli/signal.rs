//! `sinew signal`: resampled signals and images, functions of mixed observations, and refusals.

use super::common::Folder;
use serde_json::json;
use std::fs;

/// Writes a wave into the second column of a CSV.
fn wave(folder: &Folder, name: &str, n: usize) {
    let rows = (0..n).map(|i| format!("{i},{}\n", 3.0 + (0.9 * i as f64).sin()));
    fs::write(folder.path(name), format!("t,angle\n{}", rows.collect::<String>())).unwrap();
}

fn column(text: &[u8], at: usize) -> Vec<f64> {
    let text = String::from_utf8(text.to_vec()).unwrap();
    text.lines().skip(1).map(|line| line.split(',').nth(at).unwrap().parse().unwrap()).collect()
}

/// Writes a PNG of 8 or 16 bits.
fn png(
    folder: &Folder,
    name: &str,
    colour: png::ColorType,
    depth: png::BitDepth,
    [w, h]: [u32; 2],
    bytes: &[u8],
) {
    let mut encoder = png::Encoder::new(fs::File::create(folder.path(name)).unwrap(), w, h);
    encoder.set_color(colour);
    encoder.set_depth(depth);
    if colour == png::ColorType::Indexed {
        encoder.set_palette(vec![10, 20, 30, 200, 100, 0]);
    }
    encoder.write_header().unwrap().write_image_data(bytes).unwrap();
}

/// Reads a PNG in its stored format.
fn pixels(folder: &Folder, name: &str) -> (png::ColorType, png::BitDepth, [u32; 2], Vec<u8>) {
    let file = std::io::BufReader::new(fs::File::open(folder.path(name)).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let frame = reader.next_frame(&mut bytes).unwrap();
    bytes.truncate(frame.buffer_size());
    (frame.color_type, frame.bit_depth, [frame.width, frame.height], bytes)
}

#[test]
fn a_signal_is_trained_inspected_and_made_finer_by_file_or_at_once() {
    let folder = Folder::new("signal");
    wave(&folder, "wave.csv", 120);
    let trained = folder
        .sinew("signal train wave.csv --column angle --factor 4 --variance -o wave.sinew --json")
        .json();
    assert_eq!((&trained["factor"], &trained["taps"]), (&json!(4), &json!(7)));
    let left_out = |key: &str| trained["left_out"][key].as_f64().unwrap();
    assert!(left_out("rms") < left_out("linear_rms"), "{trained}");
    let found = folder.sinew("inspect wave.sinew --json").json();
    let filter = &found["filters"][0];
    assert_eq!((&filter["name"], &filter["variances"]), (&json!("angle"), &json!(true)));
    assert_eq!(filter["fit"]["left_out_rms"].as_f64().unwrap() as f32, left_out("rms") as f32);
    let text = folder.sinew("inspect wave.sinew").done().out;
    for (label, value) in [("phases", "4"), ("taps of a phase", "7"), ("variances", "yes")] {
        let row = text.lines().find_map(|line| line.trim_start().strip_prefix(label));
        assert_eq!(row.unwrap_or_else(|| panic!("{label}: {text}")).trim(), value);
    }

    folder
        .sinew("signal superres wave.csv --column angle --factor 4 --variance -o once.csv")
        .done();
    folder
        .sinew("signal superres wave.csv --column angle --model wave.sinew --variance -o file.csv")
        .done();
    let (once, file) = (folder.read("once.csv"), folder.read("file.csv"));
    assert!(String::from_utf8_lossy(&once).starts_with("sample,angle,variance\n0,"));
    assert_eq!(column(&once, 0), column(&file, 0));
    for at in [1, 2] {
        let pairs = column(&once, at).into_iter().zip(column(&file, at));
        pairs.for_each(|(a, b)| assert!((a - b).abs() < 2e-6, "{a} {b}"));
    }
    let fine = column(&once, 1);
    assert_eq!(fine.len(), 480);
    for (at, value) in fine.iter().enumerate().skip(20).take(440) {
        let truth = 3.0 + (0.9 * at as f64 / 4.0).sin();
        assert!((value - truth).abs() < 0.01, "{at}: {value} {truth}");
    }
    folder.sinew("signal plot wave.csv --column angle -o wave.png").done();
    folder.sinew("signal plot wave.csv --column angle --averages -o wave.svg").done();
    assert!(pixels(&folder, "wave.png").2[0] > 800);
    assert!(String::from_utf8(folder.read("wave.svg")).unwrap().contains("angle, "));
}

#[test]
fn a_filter_that_lines_outdo_is_warned_of() {
    let folder = Folder::new("signal-lines");
    let rows = (0..80).map(|i| format!("{}\n", 0.25 * f64::from(i)));
    fs::write(folder.path("ramp.csv"), format!("angle\n{}", rows.collect::<String>())).unwrap();
    let train = "signal train ramp.csv --column angle --factor 2 -o ramp.sinew";
    let run = folder.sinew(&format!("{train} --covariance gaussian:1"));
    let expected = "sinew: warning: ramp.csv: the filter predicts samples left out worse than lines between samples do, ";
    assert!(run.code == Some(0) && run.err.starts_with(expected), "{}", run.err);
    assert_eq!(run.err.lines().count(), 1);
}

#[test]
fn samples_that_fill_no_box_are_not_measured_and_reported() {
    let folder = Folder::new("signal-rest");
    wave(&folder, "wave.csv", 121);
    let run = folder.sinew("signal train wave.csv --column angle --factor 4 -o wave.sinew");
    assert_eq!(run.code, Some(0));
    assert_eq!(
        run.err,
        "sinew: warning: wave.csv: samples at the end that fill no box of 4 are not measured: 1\n"
    );
}

#[test]
fn signals_that_nothing_can_be_made_of_are_refused_and_a_constant_stays() {
    let folder = Folder::new("signal-bad");
    let superres = |arguments: &str| {
        folder.sinew(&format!("signal superres s.csv --column a --factor 3 -o out.csv {arguments}"))
    };
    let write = |rows: &str| fs::write(folder.path("s.csv"), format!("a\n{rows}")).unwrap();
    write("1\n");
    assert_eq!(
        superres("").failed(),
        "s.csv: 1 samples are fewer than a window's 2: take fewer taps"
    );
    let one = superres("--covariance oscillating:3,2").failed();
    assert_eq!(one, "s.csv: 1 samples are fewer than a window's 7: take fewer taps");
    write("1\n2\nNaN\n4\n");
    assert_eq!(
        superres("").failed(),
        "s.csv: line 4, column \"a\": expected a number, found \"NaN\""
    );
    write(&"7.5\n".repeat(12));
    for covariance in ["auto", "matern?5/2:2"] {
        let mut command =
            folder.command("signal superres s.csv --column a --factor 3 -o out.csv --variance");
        command.args(["--covariance", &covariance.replace('?', " ")]);
        folder.run(command).done();
        let out = folder.read("out.csv");
        assert_eq!(column(&out, 1).len(), 36);
        column(&out, 1).iter().for_each(|x| assert!((x - 7.5).abs() < 1e-10, "{x}"));
        column(&out, 2).iter().for_each(|x| assert!(x.abs() < 1e-10, "{x}"));
    }
    let constant = superres("--covariance estimated").failed();
    assert_eq!(constant, "s.csv: covariance at lag 0: expected a finite number above 0, found 0");
    write("1\n2\n1\n3\n2\n2\n1\n");
    assert_eq!(superres("--taps 4").failed(), "taps: expected an odd number, found 4");
    assert_eq!(
        superres("--noise -1").failed(),
        "noise: expected a finite number above 0, found -1"
    );
    let unknown = superres("--covariance cubic").failed();
    assert!(
        unknown.starts_with("s.csv: there is no covariance \"cubic\": expected auto, "),
        "{unknown}"
    );
    fs::write(folder.path("lags.csv"), "c\n1\n0.9\n-0.9\n").unwrap();
    let run = superres("--covariance lags.csv");
    assert_eq!(run.code, Some(0), "{}", run.err);
    let said = "sinew: warning: lags.csv: the covariance was indefinite: ";
    assert!(run.err.starts_with(said) && run.err.ends_with(" and is clipped\n"), "{}", run.err);
    fs::write(folder.path("lags.csv"), "c\n1\n0.75\n0.5\n0.25\n").unwrap();
    superres("--covariance lags.csv").done();
    assert_eq!(
        superres("--model none.sinew").code,
        Some(2),
        "a factor and a model exclude each other"
    );
    let missing = folder.sinew("signal superres s.csv --factor 2 -o out.csv").failed();
    assert_eq!(missing, "a .csv needs --column NAME");
    let other = folder.sinew("signal superres s.csv --column a --factor 2 -o out.png").failed();
    assert_eq!(other, "out.png: expected a file that ends in .csv");
}

#[test]
fn images_keep_their_kind_and_their_pixels_give_themselves_back() {
    use png::{BitDepth, ColorType};
    let folder = Folder::new("signal-images");
    let bytes =
        |len: usize| -> Vec<u8> { (0..len).map(|i| (90 + 31 * i * i % 71) as u8).collect() };
    for (colour, depth, channels, wide) in [
        (ColorType::Grayscale, BitDepth::Eight, 1, 1),
        (ColorType::Rgb, BitDepth::Eight, 3, 1),
        (ColorType::Rgb, BitDepth::Sixteen, 3, 2),
        (ColorType::Grayscale, BitDepth::Sixteen, 1, 2),
    ] {
        let given = bytes(9 * 8 * channels * wide);
        png(&folder, "in.png", colour, depth, [9, 8], &given);
        for factor in [2, 3, 4] {
            folder.sinew(&format!("signal superres in.png --factor {factor} -o out.png")).done();
            let (out_colour, out_depth, size, found) = pixels(&folder, "out.png");
            assert_eq!((out_colour, out_depth, size), (colour, depth, [9 * factor, 8 * factor]));
            let number = |bytes: &[u8], at: usize| match wide {
                1 => f64::from(bytes[at]),
                _ => f64::from(u16::from_be_bytes([bytes[2 * at], bytes[2 * at + 1]])),
            };
            let f = factor as usize;
            for pixel in 0..72 {
                let (row, at) = (pixel / 9, pixel % 9);
                let sum: f64 = (0..f * f)
                    .map(|k| ((row * f + k / f) * 9 * f + at * f + k % f) * channels)
                    .map(|place| number(&found, place))
                    .sum();
                let error = sum / (f * f) as f64 - number(&given, pixel * channels);
                // The file rounds each value once.
                assert!(error.abs() <= 0.5, "{colour:?} {factor} {pixel}: {error}");
            }
        }
    }
    png(&folder, "in.png", ColorType::Indexed, BitDepth::Eight, [7, 7], &[1; 49]);
    folder.sinew("signal superres in.png --factor 2 -o out.png").done();
    let (colour, depth, _, found) = pixels(&folder, "out.png");
    assert_eq!((colour, depth), (ColorType::Rgb, BitDepth::Eight));
    assert!(found.chunks(3).all(|pixel| pixel == [200, 100, 0]));
}

#[test]
fn drawn_text_gives_itself_back_too() {
    use png::{BitDepth, ColorType};
    let folder = Folder::new("signal-text");
    // Black strokes on white: next to their edges, a filter overshoots both colours.
    let given: Vec<u8> =
        (0..16 * 12).map(|i| if i % 16 % 5 == 2 || i / 16 == 6 { 0 } else { 255 }).collect();
    png(&folder, "in.png", ColorType::Grayscale, BitDepth::Eight, [16, 12], &given);
    let options = "--averages --covariance ornstein-uhlenbeck:3";
    wave(&folder, "wave.csv", 60);
    folder
        .sinew(&format!("signal train wave.csv --column angle --factor 2 -o m.sinew {options}"))
        .done();
    for how in ["--factor 2", "--model m.sinew"] {
        folder.sinew(&format!("signal superres in.png {how} -o out.png")).done();
        let (_, _, _, found) = pixels(&folder, "out.png");
        for (pixel, expected) in given.iter().enumerate() {
            let (row, at) = (2 * (pixel / 16), 2 * (pixel % 16));
            let of = |r: usize, c: usize| f64::from(found[(row + r) * 32 + at + c]);
            let mean = (of(0, 0) + of(0, 1) + of(1, 0) + of(1, 1)) / 4.0;
            // Each of the four values is rounded.
            assert!(
                (mean - f64::from(*expected)).abs() <= 0.5,
                "{how}, {pixel}: {mean} {expected}"
            );
        }
    }
}

#[test]
fn transparent_pixels_add_no_colour() {
    use png::{BitDepth, ColorType};
    let folder = Folder::new("signal-alpha");
    // The left half is transparent and black; the right half is white, with an edge of half
    // coverage.
    let pixel = |i: usize| match i % 10 {
        0..5 => [0, 0, 0, 0],
        5 => [255, 255, 255, 128],
        _ => [255, 255, 255, 255],
    };
    let given: Vec<u8> = (0..80).flat_map(pixel).collect();
    png(&folder, "in.png", ColorType::Rgba, BitDepth::Eight, [10, 8], &given);
    folder.sinew("signal superres in.png --factor 2 -o out.png").done();
    let (colour, _, size, found) = pixels(&folder, "out.png");
    assert_eq!((colour, size), (ColorType::Rgba, [20, 16]));
    let mut partly = 0;
    for pixel in found.chunks(4) {
        partly += usize::from((1..255).contains(&pixel[3]));
        assert!(pixel[3] == 0 || pixel[0] >= 254, "{pixel:?}");
    }
    assert!(partly > 0, "the edge is between");
}

#[test]
fn images_that_cannot_be_read_or_are_too_small_are_refused() {
    let folder = Folder::new("signal-small");
    png(&folder, "in.png", png::ColorType::Grayscale, png::BitDepth::Eight, [9, 3], &[7; 27]);
    let superres = |arguments: &str| {
        folder.sinew(&format!("signal superres in.png --factor 2 -o out.png {arguments}"))
    };
    let small = superres("").failed();
    assert_eq!(small, "in.png: 3 samples are fewer than a window's 7: take fewer taps");
    superres("--taps 3").done();
    let other = superres("--column a").failed();
    assert_eq!(other, "--column, --variance and --averages are for a .csv");
    let estimated = superres("--covariance estimated").failed();
    let expected =
        "there is no covariance \"estimated\" for an image: expected auto, a table (.csv), or ";
    assert!(estimated.starts_with(expected), "{estimated}");
    fs::write(folder.path("in.png"), b"no picture").unwrap();
    assert!(superres("").failed().starts_with("in.png: "));
}

#[test]
fn an_image_goes_through_a_files_filter_too() {
    let folder = Folder::new("signal-model-image");
    wave(&folder, "wave.csv", 60);
    let options = "--averages --taps 5 --covariance ornstein-uhlenbeck:3";
    folder
        .sinew(&format!("signal train wave.csv --column angle --factor 2 -o m.sinew {options}"))
        .done();
    let given: Vec<u8> = (0..3 * 80).map(|i| (90 + 31 * i * i % 71) as u8).collect();
    png(&folder, "in.png", png::ColorType::Rgb, png::BitDepth::Eight, [10, 8], &given);
    folder.sinew("signal superres in.png --model m.sinew -o file.png").done();
    folder.sinew("signal superres in.png --factor 2 --taps 5 -o once.png").done();
    let (file, once) = (pixels(&folder, "file.png"), pixels(&folder, "once.png"));
    assert_eq!(file.2, once.2);
    assert!(file.3.iter().zip(&once.3).all(|(a, b)| a.abs_diff(*b) <= 1));
    let no_filter = folder.sinew("signal superres in.png --model in.png -o out.png");
    assert!(no_filter.failed().starts_with("in.png: "));
}

#[test]
fn values_derivatives_and_averages_become_a_function() {
    let folder = Folder::new("signal-fit");
    let observations = json!({
        "name": "spring", "covariance": "squared exponential:1", "mean": "zero",
        "observations": [
            { "at": 0, "value": 1 }, { "at": 0, "derivative": 0 },
            { "from": 1, "to": 2, "average": -0.5 }, { "at": 3, "value": 0.25 },
        ],
    });
    let write =
        |json: &serde_json::Value| fs::write(folder.path("o.json"), json.to_string()).unwrap();
    write(&observations);
    let fitted = folder.sinew("signal fit o.json -o o.sinew --json").json();
    assert_eq!(fitted["observations"], 4);
    // Even steps between 1 and 2 for the average; steps around 0 for the derivative.
    let at: Vec<f64> =
        (0..100).map(|i| 1.005 + 0.01 * f64::from(i)).chain([0.0, -0.01, 0.01, 3.0]).collect();
    fs::write(folder.path("q.json"), json!(at).to_string()).unwrap();
    let found = folder.sinew("kernel eval o.sinew q.json --json").json();
    let value = |at: usize| found["results"][at]["outputs"][0].as_f64().unwrap();
    let mean = (0..100).map(value).sum::<f64>() / 100.0;
    assert!((mean + 0.5).abs() < 1e-4, "{mean}");
    assert!((value(100) - 1.0).abs() < 1e-5 && (value(103) - 0.25).abs() < 1e-5);
    assert!((value(102) - value(101)).abs() < 1e-5);
    folder.sinew("signal plot o.json -o o.svg").done();

    let refused = folder.sinew("signal fit o.json -o none.csv").failed();
    assert_eq!(refused, "cannot write none.csv: a model is no .csv file, name it .sinew");
    let mut other = observations.clone();
    other["covariance"] = json!("oscillating:2,3");
    write(&other);
    let refused = folder.sinew("signal fit o.json -o none.sinew").failed();
    assert!(
        refused.starts_with("o.json: no part kernel holds covariance oscillating: it can hold"),
        "{refused}"
    );
    other["covariance"] = json!("ornstein-uhlenbeck:2");
    write(&other);
    let refused = folder.sinew("signal fit o.json -o none.sinew").failed();
    assert!(refused.starts_with("o.json: observation 1: functions of covariance"), "{refused}");
    other["covariance"] = json!("estimated");
    write(&other);
    let refused = folder.sinew("signal fit o.json -o none.sinew").failed();
    let expected =
        "o.json: there is no covariance \"estimated\" for observations: expected auto, or squared";
    assert!(refused.starts_with(expected), "{refused}");
    other["covariance"] = json!("auto");
    other["observations"] = json!([{ "at": 0, "value": 1 }, { "at": 1, "valeu": 2 }]);
    write(&other);
    let refused = folder.sinew("signal fit o.json -o none.sinew").failed();
    let expected = "o.json: observation 1: expected {\"at\": x, \"value\": y}, ";
    assert!(
        refused.starts_with(expected) && refused.ends_with("found {\"at\":1,\"valeu\":2}"),
        "{refused}"
    );
    other["observations"] = json!([]);
    write(&other);
    assert_eq!(
        folder.sinew("signal fit o.json -o none.sinew").failed(),
        "o.json: there are no observations"
    );
    assert!(!folder.path("none.sinew").exists());
}

#[test]
fn observations_that_contradict_are_named_and_those_that_repeat_are_one() {
    let folder = Folder::new("signal-contradict");
    let fit = |observations: serde_json::Value, more: &str| {
        let mut all = json!({ "observations": observations });
        if !more.is_empty() {
            all["covariance"] = json!(more);
        }
        fs::write(folder.path("o.json"), all.to_string()).unwrap();
        folder.sinew("signal fit o.json -o o.sinew")
    };
    let value = |at: f64, value: f64| json!({ "at": at, "value": value });
    let said = fit(json!([value(0.0, 1.0), value(2.0, 3.0), value(0.0, 1.5)]), "").failed();
    let expected = "o.json: observations 0 and 2 contradict each other: they are of one thing and say 1 and 1.5; \
                    leave one out, or give a noise";
    assert_eq!(said, expected);
    let run = fit(json!([value(0.0, 1.0), value(2.0, 3.0), value(0.0, 1.0), value(3.0, 2.0)]), "");
    let expected = "sinew: warning: o.json: observations that repeat earlier ones, or follow from them, and are left out: 1\n";
    assert_eq!((run.code, run.err.as_str()), (Some(0), expected));
    // The average over both halves is the average over the whole: 1.5, not 4.
    let average = |from: f64, to: f64, y: f64| json!({ "from": from, "to": to, "average": y });
    let halves = json!([
        value(5.0, 0.0),
        value(5.0, 0.0),
        average(0.0, 1.0, 1.0),
        average(1.0, 2.0, 2.0),
        average(0.0, 2.0, 4.0),
    ]);
    for covariance in ["", "squared exponential:1"] {
        let said = fit(halves.clone(), covariance).failed();
        let expected = "o.json: observation 4 contradicts observations 2, 3: they give 1.5 and it says 4; leave one out, \
                        or give a noise";
        assert_eq!(said, expected);
    }
    // So close that a function this smooth can hardly have another value there: not a
    // contradiction.
    let near = json!([value(0.0, 1.0), value(1e-9, 2.0), value(1.0, 1.0)]);
    let said = fit(near, "squared exponential:1").failed();
    let expected = "observation 1 says 2.000000 where earlier ones nearly determine 1.000000: take a shorter length, a \
                    rougher covariance or a noise, or leave `covariance` out";
    assert!(said.contains("ill-conditioned") && said.ends_with(expected), "{said}");
}

#[test]
fn functions_that_are_observed_at_one_place_or_not_at_all_have_a_range() {
    let folder = Folder::new("signal-places");
    for observations in [
        json!([{ "at": 2, "value": 7 }]),
        json!([{ "at": 0, "value": 1 }, { "at": 0, "derivative": -2 }]),
        json!([{ "at": 0, "value": 3 }, { "at": 1, "value": 3 }, { "at": 2, "value": 3 }]),
        json!([{ "from": 0, "to": 1, "average": 2 }]),
    ] {
        fs::write(folder.path("o.json"), json!({ "observations": observations }).to_string())
            .unwrap();
        let found = folder.sinew("signal fit o.json -o o.sinew --json").json();
        assert!(found["f32_error"].as_f64().unwrap() <= 1e-3, "{observations}: {found}");
    }
}
