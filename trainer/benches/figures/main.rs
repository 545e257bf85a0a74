//! Prints the figures of FIGURES.md: errors on the data sets, training times, memory, scaling.
//!
//! `cargo bench -p sinew-trainer --bench figures [-- SECTION ...]`, where a section is `lbs`,
//! `proxies`, `full`, `errors`, `ranges`, `painted`, `poses`, `settings`, `import`, `time` or
//! `scaling`. Sets that are missing in `../shared/data` are skipped, and their names are printed.

mod full;
mod painted;

use faer::Mat;
use full::Full;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use sinew_runtime::envelope::Predictor;
use sinew_trainer::check::check;
use sinew_trainer::envelope::lbs::poses::{Poses, trajectories};
use sinew_trainer::envelope::lbs::targets::Targets;
use sinew_trainer::envelope::lbs::training::Training;
use sinew_trainer::envelope::lbs::weights;
use sinew_trainer::envelope::s3::surface::Surface;
use sinew_trainer::envelope::s3::{self, merge};
use sinew_trainer::envelope::s3::{ProxyCount, proxies};
use sinew_trainer::envelope::{Options, Predict, train};
use sinew_trainer::evaluate::{Evaluation, Frames, evaluate};
use sinew_trainer::examples::demo::{DemoOptions, demo};
use sinew_trainer::examples::{Examples, Importance, Source, Split, load, npz};
use sinew_trainer::export::{by_use, demo_glb};
use sinew_trainer::formats::save_pc2;
use sinew_trainer::numeric::basis;
use sinew_trainer::progress::Silent;
use sinew_trainer::settings::Settings;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const SETS: [(&str, &str); 3] = [
    ("mpfb-arm", "mpfb-arm/mpfb_arm.npz"),
    ("dem-bones", "dem-bones/bone.npz"),
    ("mpfb-body", "mpfb-body/mpfb_body.npz"),
];

type Section = fn() -> Result<(), Box<dyn Error>>;

fn main() -> Result<(), Box<dyn Error>> {
    let wanted: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let sections: [(&str, Section); 11] = [
        ("lbs", lbs),
        ("proxies", proxies_alone),
        ("full", full),
        ("errors", errors),
        ("ranges", ranges),
        ("painted", painted::painted),
        ("poses", poses),
        ("settings", settings),
        ("import", import),
        ("time", time),
        ("scaling", scaling),
    ];
    for (name, print) in sections {
        if wanted.is_empty() || wanted.iter().any(|w| w == name) {
            println!("== {name}");
            print()?;
        }
    }
    Ok(())
}

/// Prints the error of LBS as in reports, K = 4, and of dense weights fitted to all frames for
/// their error only.
fn lbs() -> Result<(), Box<dyn Error>> {
    for (name, examples) in sets()? {
        let percent = |rms: f64| 100.0 * rms / examples.diagonal();
        let fitted = weights::baseline(&examples);
        let held_out = examples.frames_of(Split::HeldOut);
        let poses = Poses::new(&examples, &held_out);
        let moved = trajectories(&examples, &held_out, &poses);
        let targets = Targets {
            rest: &examples.rest,
            weights: &fitted,
            trajectories: &moved,
            importance: Importance::UNIFORM,
        };
        println!("{name}: K = 4, held out {:.4} %", percent(targets.rms(&poses.stacked())));
        if name == "dem-bones" {
            let all: Vec<usize> = (0..examples.frame_len()).collect();
            let poses = Poses::new(&examples, &all);
            let moved = trajectories(&examples, &all, &poses);
            let (dense, _) =
                weights::fit(&examples.rest, &moved, &poses, examples.joint_len(), None);
            let targets = Targets {
                rest: &examples.rest,
                weights: &dense,
                trajectories: &moved,
                importance: Importance::UNIFORM,
            };
            println!("{name}: dense, all frames, RMSE {:.7}", targets.rms(&poses.stacked()));
        }
    }
    Ok(())
}

/// Returns options for one predictor and a number of helpers.
fn fixed(predictor: Predictor, proxies: usize) -> Options {
    Options {
        predictor: Predict::Only(predictor),
        proxies: Some(ProxyCount::Fixed(proxies)),
        ..Options::default()
    }
}

/// Prints the error of the proxies on the training frames of dem-bones, without prediction.
fn proxies_alone() -> Result<(), Box<dyn Error>> {
    for (name, examples) in sets()?.into_iter().filter(|set| set.0 == "dem-bones") {
        let Training { unit, rest, triangles, trajectories, .. } =
            Training::new(&examples, &Silent)?;
        let basis = basis::basis(&trajectories);
        let surface = Surface::new(&rest, triangles, &trajectories, &basis, Importance::UNIFORM);
        let tree = merge::MergeTree::build(&surface, || ());
        for count in [10, 20, 30] {
            let options =
                s3::RotationalOptions { proxies: ProxyCount::Fixed(count), ..Default::default() };
            let fitted = proxies::fit(&surface, &tree, &Mat::zeros(0, 0), &options, &Silent)?;
            println!("{name}: P = {}, RMSE {:.5}", fitted.maps.ncols() / 4, unit * fitted.rms);
        }
    }
    Ok(())
}

/// Prints errors of the published method without reduction: one predictor per triangle, all
/// vertices reconstructed.
fn full() -> Result<(), Box<dyn Error>> {
    for (name, examples) in sets()?.into_iter().filter(|set| set.0 != "mpfb-body") {
        for fraction in [0.05, 0.25, 0.5, 0.75] {
            let full = Full::fit(&examples, fraction)?;
            let percent = 100.0 * full.rms(Full::reconstruct) / examples.diagonal();
            println!("{name}: {:.0} % near-rigid, held out {percent:.4} %", 100.0 * fraction);
        }
    }
    Ok(())
}

/// Prints errors of the baked models in the f32 runtime, of each predictor and of the automatic
/// choice.
fn errors() -> Result<(), Box<dyn Error>> {
    println!(
        "{:<12}{:<24}{:>4}{:>3}  {:<10}{:>8}{:>8}{:>8}{:>8}{:>8}{:>10}{:>10}{:>7}{:>11}{:>9}{:>9}",
        "set",
        "predictor",
        "P",
        "K",
        "split",
        "LBS %",
        "model %",
        "p99 %",
        "max %",
        "LBS °",
        "normals °",
        "median °",
        "p99 °",
        "confidence",
        "bytes",
        "CV/this"
    );
    let mut sets = sets()?;
    sets.push(("demo", demo(&DemoOptions::default())));
    sets.push(("demo of 12", demo(&DemoOptions { poses: 12, ..DemoOptions::default() })));
    for (name, examples) in sets {
        let large = examples.vertex_len() > 5_000;
        let proxies = if large { 60 } else { 40 };
        let [rotational, kernel] = Predictor::ALL.map(|only| fixed(only, proxies));
        let mut rows = vec![
            ("published", Options { predictor: Predict::Published, ..rotational.clone() }),
            ("unrefined", Options { refine: false, ..rotational.clone() }),
            ("rotational", rotational),
            ("kernel", kernel),
            ("kernel, P chosen", Options::default()),
        ];
        if large {
            let more = Options { influences: 6, ..fixed(Predictor::Kernel, 120) };
            rows.push(("kernel", more));
        }
        if name == "mpfb-arm" {
            for budget in [60_000, 100_000, 160_000] {
                rows.push((
                    "kernel, budget",
                    Options { budget: Some(budget), ..Options::default() },
                ));
            }
        }
        for (row, options) in rows {
            let trained = train(&examples, &options, &Silent)?;
            let validated = trained.report.chosen().validated_rms.unwrap_or(f64::NAN);
            for split in [Split::HeldOut, Split::Extreme] {
                if !examples.frames_of(split).is_empty() {
                    let found = evaluate(&trained.model, None, &examples, Frames::Of(split))?;
                    error_row(name, row, options.influences, &found, 100.0 * validated);
                }
            }
        }
    }
    Ok(())
}

fn error_row(set: &str, row: &str, influences: usize, found: &Evaluation, validated: f64) {
    println!(
        "{set:<12}{row:<24}{:>4}{influences:>3}  {:<10}{:>8.4}{:>8.4}{:>8.4}{:>8.4}{:>8.2}{:>10.2}{:>10.2}\
         {:>7.2}{:>11.3}{:>9}{:>9.2}",
        found.proxies,
        found.split,
        found.lbs.rms_percent,
        found.errors.rms_percent,
        found.errors.p99_percent,
        found.errors.max_percent,
        found.lbs.normal_rms_degrees,
        found.errors.normal_rms_degrees,
        found.errors.normal_median_degrees,
        found.errors.normal_p99_degrees,
        found.confidence.least,
        found.model_bytes,
        validated / found.errors.rms_percent
    );
}

/// Prints errors on poses outside the trained range of mpfb-arm. First the poses of joints other
/// than the joint that the first frames rotate; then, for each joint, its top quartile of angles.
fn ranges() -> Result<(), Box<dyn Error>> {
    for (_, mut examples) in sets()?.into_iter().filter(|set| set.0 == "mpfb-arm") {
        let frames: Vec<usize> = (0..examples.frame_len()).collect();
        let poses = Poses::new(&examples, &frames);
        let measured = |examples: &Examples, what: &str| -> Result<(), Box<dyn Error>> {
            let model = train(examples, &Options::default(), &Silent)?.model;
            let found = evaluate(&model, None, examples, Frames::Of(Split::HeldOut))?;
            println!(
                "{what}: LBS {:.4} %, {} {:.4} %, confidence {:.3} on average, {:.3} at the least",
                found.lbs.rms_percent,
                found.predictor,
                found.errors.rms_percent,
                found.confidence.mean,
                found.confidence.least
            );
            Ok(())
        };
        let few = trained_on_first(&examples, 12);
        measured(&few, "beyond 12 frames that turn the collarbone alone")?;
        for joint in 1..examples.joint_len() {
            let angles: Vec<f64> = frames.iter().map(|&i| poses.angle(i, joint).norm()).collect();
            let mut sorted = angles.clone();
            sorted.sort_by(f64::total_cmp);
            let bent = sorted[3 * sorted.len() / 4];
            let split = |angle: &f64| if *angle > bent { Split::HeldOut } else { Split::Train };
            examples.split = angles.iter().map(split).collect();
            let (from, to) = (bent.to_degrees(), sorted[sorted.len() - 1].to_degrees());
            let joint = &examples.skeleton.names[joint];
            measured(&examples, &format!("{joint:<14} beyond {from:>3.0} of {to:>3.0} °"))?;
        }
    }
    Ok(())
}

/// Tests the advice of `check` on mpfb-arm's training poses: prints the held-out error without the
/// redundant poses, without the isolated poses, and without as many random poses.
fn poses() -> Result<(), Box<dyn Error>> {
    for (name, examples) in sets()?.into_iter().filter(|set| set.0 == "mpfb-arm") {
        let clips = [];
        let Some(found) = check(&examples, &clips, &Silent)?.predicted else { continue };
        let error = |left_out: &[usize]| -> Result<f64, Box<dyn Error>> {
            let fewer = examples.without(left_out);
            let model = train(&fewer, &fixed(Predictor::Kernel, 40), &Silent)?.model;
            Ok(evaluate(&model, None, &fewer, Frames::Of(Split::HeldOut))?.errors.rms_percent)
        };
        println!("{name}: {:.4} % with all training poses", error(&[])?);
        let redundant: Vec<usize> = found.redundant.iter().map(|name| name.frame).collect();
        let isolated: Vec<usize> =
            found.isolated.iter().map(|isolated| isolated.frame.frame).collect();
        for (what, named) in [("redundant", redundant), ("isolated", isolated)] {
            println!("without {} that are {what}: {:.4} %", named.len(), error(&named)?);
            let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(1);
            for _ in 0..5 {
                let mut all = examples.frames_of(Split::Train);
                all.shuffle(&mut random);
                println!("without as many at random: {:.4} %", error(&all[..named.len()])?);
            }
        }
    }
    Ok(())
}

/// Trains with a third and with three times of each setting, and prints the held-out error relative
/// to that of the default: kernel, 40 helpers.
fn settings() -> Result<(), Box<dyn Error>> {
    let mut sets = sets()?;
    for seed in 1..4 {
        let options = DemoOptions { poses: 60, seed, ..DemoOptions::default() };
        sets.push((["demo 1", "demo 2", "demo 3"][seed as usize - 1], demo(&options)));
    }
    let error = |examples: &Examples, settings: &Settings| -> Result<f64, Box<dyn Error>> {
        let options = Options { settings: settings.clone(), ..fixed(Predictor::Kernel, 40) };
        let model = train(examples, &options, &Silent)?.model;
        Ok(evaluate(&model, None, examples, Frames::Of(Split::HeldOut))?.errors.rms_percent)
    };
    let names: String = sets.iter().map(|(name, _)| format!("{name:>18}")).collect();
    println!("{:<16}{:>8}{names}", "", "");
    let mut usual = Vec::new();
    for (_, examples) in &sets {
        usual.push(error(examples, &Settings::default())?);
    }
    let row: String = usual.iter().map(|error| format!("{error:>16.4} %")).collect();
    println!("{:<16}{:>8}{row}", "as set", "");
    for (number, (name, value)) in Settings::default().numbers().into_iter().enumerate() {
        let mut cells = String::new();
        for ((_, examples), usual) in sets.iter().zip(&usual) {
            let of = |factor: f64| -> Result<f64, Box<dyn Error>> {
                let mut settings = Settings::default();
                *settings.numbers()[number].1 *= factor;
                Ok(error(examples, &settings)? / usual)
            };
            cells += &format!("{:>10.2}{:>8.2}", of(1.0 / 3.0)?, of(3.0)?);
        }
        println!("{name:<16}{value:>8.0e}{cells}");
    }
    Ok(())
}

/// Times reading the body's examples from every file format.
fn import() -> Result<(), Box<dyn Error>> {
    let Some((name, examples)) = sets()?.pop() else { return Ok(()) };
    let (examples, clips) = by_use(examples);
    let folder = std::env::temp_dir().join(format!("sinew-import-{}", std::process::id()));
    let shapes = folder.join("shapes");
    std::fs::create_dir_all(&shapes)?;
    let [scene, points, arrays] =
        ["body.glb", "body.pc2", "body.npz"].map(|name| folder.join(name));
    std::fs::write(&scene, demo_glb(&examples, &clips)?)?;
    save_pc2(&points, examples.vertex_len(), &examples.vertices)?;
    npz::save_npz(&arrays, &examples, &clips)?;
    let face = |t: &[usize; 3]| format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
    let faces: String = examples.triangles.iter().map(face).collect();
    for frame in 0..examples.frame_len() {
        let vertex = |[x, y, z]: &[f64; 3]| format!("v {x:.6} {y:.6} {z:.6}\n");
        let text = examples.frame(frame).iter().map(vertex).collect::<String>() + &faces;
        std::fs::write(shapes.join(format!("pose_{frame}.obj")), text)?;
    }
    println!("{name}: {} vertices x {} frames", examples.vertex_len(), examples.frame_len());
    for (what, file, targets) in [
        (".npz", &arrays, None),
        (".glb with .pc2", &scene, Some(&points)),
        (".glb with .npz", &scene, Some(&arrays)),
        (".glb with .obj", &scene, Some(&shapes)),
        (".glb alone, its own LBS", &scene, None),
    ] {
        let start = Instant::now();
        let targets = targets.map(PathBuf::as_path);
        let loaded = load(&Source { targets, ..Source::file(file) })?.examples;
        let seconds = start.elapsed().as_secs_f64();
        println!("{what:<26}{seconds:.2} s, {} frames", loaded.frame_len());
    }
    std::fs::remove_dir_all(folder)?;
    Ok(())
}

/// Times training as a whole process: load, fit, bake, write.
fn time() -> Result<(), Box<dyn Error>> {
    for (name, file) in SETS {
        let Some(path) = found(file) else { continue };
        let proxies = if name == "mpfb-body" { "60" } else { "40" };
        for predictor in ["rotational", "kernel"] {
            let model =
                std::env::temp_dir().join(format!("sinew-figures-{}.sinew", std::process::id()));
            let mut train = vec!["train".to_owned(), path.to_string_lossy().into_owned()];
            train.extend(["-o".to_owned(), model.to_string_lossy().into_owned()]);
            train.extend(["--predictor", predictor].map(str::to_owned));
            if predictor != "auto" {
                train.extend(["--helpers", proxies].map(str::to_owned));
            }
            let run = measure(&train)?;
            std::fs::remove_file(&model)?;
            println!("{name}, {predictor}: {:.1} s, {} MB", run.seconds, run.peak >> 20);
        }
    }
    Ok(())
}

/// Prints time and peak memory relative to the vertex array in f64, for the demo's arm in several
/// sizes.
fn scaling() -> Result<(), Box<dyn Error>> {
    println!("{:>9}{:>7}{:>9}{:>9}{:>16}", "vertices", "poses", "s", "MB", "x vertex array");
    let mut times = Vec::new();
    for (vertices, poses) in
        [(5_000, 100), (20_000, 100), (80_000, 100), (20_000, 50), (20_000, 200)]
    {
        let held_out = 1;
        let arguments = [
            "demo",
            "--vertices",
            &vertices.to_string(),
            "--poses",
            &poses.to_string(),
            "--held-out",
            &held_out.to_string(),
            "--helpers",
            "60",
            "--predictor",
            "rotational",
        ]
        .map(str::to_owned);
        let run = measure(&arguments)?;
        let array = (vertices * (poses + held_out) * 24) as f64;
        println!(
            "{vertices:>9}{poses:>7}{:>9.2}{:>9}{:>16.2}",
            run.seconds,
            run.peak >> 20,
            run.peak as f64 / array
        );
        if poses == 100 {
            times.push((vertices as f64, run.seconds));
        }
    }
    if let (Some(first), Some(last)) = (times.first(), times.last()) {
        let exponent = (last.1 / first.1).ln() / (last.0 / first.0).ln();
        println!("time grows as V^{exponent:.2} from {} to {} vertices", first.0, last.0);
    }
    Ok(())
}

struct Run {
    seconds: f64,
    /// Peak resident memory in bytes.
    peak: usize,
}

/// Runs `sinew` quietly and measures its peak memory.
fn measure(arguments: &[String]) -> Result<Run, Box<dyn Error>> {
    let start = Instant::now();
    let mut child = Command::new(env!("CARGO_BIN_EXE_sinew"))
        .args(arguments)
        .arg("--quiet")
        .stdout(Stdio::null())
        .spawn()?;
    let status = PathBuf::from(format!("/proc/{}/status", child.id()));
    let mut peak = 0;
    loop {
        // The kernel keeps the high-water mark, so the last reading before the end is the peak.
        peak = peak.max(high_water_mark(&status));
        if let Some(exit) = child.try_wait()? {
            let seconds = start.elapsed().as_secs_f64();
            return if exit.success() {
                Ok(Run { seconds, peak })
            } else {
                Err("sinew failed".into())
            };
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn high_water_mark(status: &Path) -> usize {
    let text = std::fs::read_to_string(status).unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kilobytes = line.and_then(|rest| rest.split_whitespace().next()?.parse::<usize>().ok());
    kilobytes.unwrap_or(0) * 1024
}

/// Returns the examples with only the first `count` training frames.
fn trained_on_first(examples: &Examples, count: usize) -> Examples {
    examples.without(&examples.frames_of(Split::Train)[count..])
}

fn sets() -> Result<Vec<(&'static str, Examples)>, Box<dyn Error>> {
    let mut all = Vec::new();
    for (name, file) in SETS {
        match found(file) {
            Some(path) => all.push((name, npz::load(&path)?.examples)),
            None => println!("{name}: not found in ../shared/data"),
        }
    }
    Ok(all)
}

fn found(file: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data").join(file);
    path.exists().then_some(path)
}
