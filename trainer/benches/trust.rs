//! Prints errors and confidence on poses unlike the training poses.
//!
//! `cargo bench -p sinew-trainer --bench trust [-- WORD ...]`: prints the rows whose name contains
//! every word.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew_runtime::envelope::Predictor;
use sinew_trainer::envelope::clean::Inliers;
use sinew_trainer::envelope::lbs::poses::Poses;
use sinew_trainer::envelope::s3::ProxyCount;
use sinew_trainer::envelope::{Options, Predict, train};
use sinew_trainer::evaluate::{Baseline, Character, Measured, MeasuredFrame, TrainingRecord};
use sinew_trainer::examples::demo::{DemoOptions, demo};
use sinew_trainer::examples::{Examples, Source, Split, load};
use sinew_trainer::progress::Silent;
use std::collections::BTreeSet;
use std::error::Error;
use std::path::{Path, PathBuf};

/// A model is worse in a frame if its error exceeds that of LBS this many times.
const WORSE: f64 = 1.2;
/// Largest permitted confidence in a frame where the model is worse.
const TRUSTED: f64 = 0.5;
/// Least share of LBS's error that a good model gains.
const GOOD: f64 = 0.5;
/// Confidences below which an engine may distrust a pose.
const THRESHOLDS: [f64; 4] = [0.5, 0.7, 0.8, 0.9];

const SETS: [(&str, &str); 3] = [
    ("mpfb-arm", "mpfb-arm/mpfb_arm.npz"),
    ("dem-bones", "dem-bones/bone.npz"),
    ("mpfb-body", "mpfb-body/mpfb_body.npz"),
];

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    println!(
        "{:<44}{:>7}{:>9}{:>9}{:>7}{:>7}{:>7}{:>7}{:>9}{:>9}",
        "trained on, by",
        "frames",
        "LBS %",
        "model %",
        "x LBS",
        "x p99",
        "worse",
        "conf.",
        "trusted",
        "Spearman"
    );
    let mut all = Vec::new();
    for (set, examples) in scenes()? {
        for (by, options) in predictors(&set) {
            let name = format!("{set}, {by}");
            if words.iter().all(|word| name.contains(word.as_str())) {
                all.extend(row(&name, &examples, &options)?);
            }
        }
    }
    let rotational = |frame: &&Frame| frame.predictor == Predictor::Rotational;
    let (rotational, kernel): (Vec<&Frame>, Vec<&Frame>) = all.iter().partition(rotational);
    for (name, frames) in
        [("all", all.iter().collect()), ("kernel", kernel), ("rotational", rotational)]
    {
        confidence(name, &frames);
    }
    println!(
        "\n{:<44}{:>7}{:>9}{:>9}{:>9}",
        "a frame is broken", "tried", "named", "others", "x error"
    );
    for (set, examples) in sound_sets()? {
        for (how, spoil) in SPOILS {
            let name = format!("broken {set}, {how}");
            if words.iter().all(|word| name.contains(word.as_str())) {
                broken(&name, &examples, spoil)?;
            }
        }
    }
    println!(
        "\n{:<44}{:>9}{:>9}{:>9}{:>9}",
        "copies with noise", "least %", "most %", "most/least", "beyond"
    );
    for (set, examples) in noisy_sets()? {
        for (by, options) in predictors(&set) {
            let name = format!("noise {set}, {by}");
            if words.iter().all(|word| name.contains(word.as_str())) {
                noise(&name, &examples, &options)?;
            }
        }
    }
    Ok(())
}

/// Prints how well the confidence of some frames tells the share of LBS's error that the model gains: rank correlations,
/// errors by confidence, and the rates of thresholds.
fn confidence(name: &str, frames: &[&Frame]) {
    let of = |pick: fn(&Frame) -> (f64, f64)| {
        spearman(&frames.iter().map(|frame| pick(frame)).collect::<Vec<_>>())
    };
    println!(
        "\n{name} frames: Spearman of confidence and the gain {:.2}, of confidence and the share of LBS's error that is \
         gained {:.2}",
        of(|frame| (frame.confidence, frame.lbs - frame.model)),
        of(|frame| (frame.confidence, frame.gained()))
    );
    println!("{:<24}{:>7}{:>9}{:>9}{:>9}", "confidence", "frames", "LBS %", "model %", "worse");
    for (from, to) in [(0.95, 1.01), (0.8, 0.95), (0.5, 0.8), (0.2, 0.5), (0.0, 0.2)] {
        let own: Vec<_> = frames.iter().filter(|f| (from..to).contains(&f.confidence)).collect();
        let rms = |of: fn(&Frame) -> f64| {
            let sum: f64 = own.iter().map(|frame| of(frame).powi(2)).sum();
            (sum / own.len().max(1) as f64).sqrt()
        };
        let worse = own.iter().filter(|frame| frame.is_worse()).count();
        let range = format!("{from} to {:.2}", f64::min(to, 1.0));
        println!(
            "{range:<24}{:>7}{:>9.4}{:>9.4}{worse:>9}",
            own.len(),
            rms(|frame| frame.lbs),
            rms(|frame| frame.model)
        );
    }
    let (good, bad): (Vec<&Frame>, Vec<&Frame>) =
        frames.iter().partition(|frame| frame.gained() >= GOOD);
    println!("{:<24}{:>16}{:>24}", "threshold", "missed, of bad", "false alarms, of good");
    for threshold in THRESHOLDS {
        let missed = bad.iter().filter(|frame| frame.confidence >= threshold).count();
        let alarms = good.iter().filter(|frame| frame.confidence < threshold).count();
        println!(
            "{threshold:<24}{:>16}{:>24}",
            of_all(missed, bad.len()),
            of_all(alarms, good.len())
        );
    }
}

/// Writes a count, the count of all, and their ratio in %.
fn of_all(count: usize, all: usize) -> String {
    format!("{count}/{all} {:.1} %", 100.0 * count as f64 / all.max(1) as f64)
}

/// Copies of a set, and the amplitude of their noise as a share of the diagonal.
const COPIES: u64 = 10;
const NOISE: f64 = 1e-6;

/// Loads the leg's walk, with a quarter held out and its stretch outside the trained range, and
/// dem-bones unchanged.
fn noisy_sets() -> Result<Vec<(String, Examples)>, Box<dyn Error>> {
    let mut sets = Vec::new();
    if let Some(path) = found("leg/leg.npz") {
        let mut examples = load(&Source::file(&path))?.examples;
        examples.split[66..].fill(Split::Extreme);
        examples.hold_out(0.25)?;
        sets.push(("leg walk".to_owned(), examples));
    }
    if let Some(path) = found("dem-bones/bone.npz") {
        sets.push(("dem-bones".to_owned(), load(&Source::file(&path))?.examples));
    }
    Ok(sets)
}

/// Trains on copies with noise, and on a copy rounded to the digits of a text file; prints the
/// spread of the errors.
fn noise(name: &str, examples: &Examples, options: &Options) -> Result<(), Box<dyn Error>> {
    let splits = [Split::HeldOut, Split::Extreme];
    let mut errors = [Vec::new(), Vec::new()];
    let mut taken = BTreeSet::new();
    for copy in 0..=COPIES {
        let mut noisy = examples.clone();
        let mut random = ChaCha8Rng::seed_from_u64(copy);
        // Uniform noise of this size has an RMS length of the same size; the last copy is rounded
        // instead.
        let size = NOISE * examples.diagonal();
        for x in noisy.vertices.iter_mut().flatten() {
            *x = match copy {
                COPIES => (*x * 1e6).round() / 1e6,
                _ => *x + random.random_range(-size..=size),
            };
        }
        let trained = train(&noisy, options, &Silent)?;
        let chosen = trained.report.chosen();
        taken.insert(format!("{} {}", chosen.predictor, chosen.proxies));
        let character = Character::open(&trained.model, None, examples)?;
        for (split, errors) in splits.into_iter().zip(&mut errors) {
            let frames = examples.frames_of(split);
            if !frames.is_empty() {
                errors.push(Measured::model(&character, examples, &frames)?.errors().rms_percent);
            }
        }
    }
    let [within, beyond] = errors.map(|mut errors| {
        errors.sort_by(f64::total_cmp);
        errors
    });
    let ratio = |errors: &[f64]| errors.last().zip(errors.first()).map_or(f64::NAN, |(a, b)| a / b);
    let (least, most) = (within[0], within[within.len() - 1]);
    println!("{name:<44}{least:>9.4}{most:>9.4}{:>9.3}{:>9.3}", ratio(&within), ratio(&beyond));
    println!("    within {within:.4?}\n    beyond {beyond:.4?}\n    taken: {taken:?}");
    Ok(())
}

/// Damages the mesh of a frame, given the previous frame's mesh and the diagonal.
type Spoil = fn(&mut [[f64; 3]], &[[f64; 3]], f64);

const SPOILS: [(&str, Spoil); 3] = [
    ("moved", |mesh, _, diagonal| mesh.iter_mut().for_each(|x| x[1] += 0.2 * diagonal)),
    ("exploded", |mesh, _, diagonal| {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        // Uniform noise of this size has an RMS length of 5 % of the diagonal.
        let size = 0.05 * diagonal;
        mesh.iter_mut().flatten().for_each(|x| *x += random.random_range(-size..=size));
    }),
    ("a frame late", |mesh, before, _| mesh.copy_from_slice(before)),
];

/// Number of frames of a set that are damaged, one at a time.
const SPOILED: usize = 12;

/// Loads the undamaged sets, the two clips of the leg, and the demo of few poses.
fn sound_sets() -> Result<Vec<(String, Examples)>, Box<dyn Error>> {
    let mut sets: Vec<(String, Examples)> =
        scenes()?.into_iter().filter(|(name, _)| name.starts_with("leg")).collect();
    for (name, file) in SETS {
        if let Some(path) = found(file) {
            sets.push((name.to_owned(), load(&Source::file(&path))?.examples));
        }
    }
    sets.push(("demo".to_owned(), demo(&DemoOptions { poses: 12, ..DemoOptions::default() })));
    Ok(sets)
}

/// Damages training frames one at a time; counts how often the damaged frame is detected, and how many other frames are
/// detected.
fn broken(name: &str, examples: &Examples, spoil: Spoil) -> Result<(), Box<dyn Error>> {
    let (frames, len) = (examples.frames_of(Split::Train), examples.vertex_len());
    let (mut named, mut others) = (0, Vec::new());
    let (mut missed, mut worst) = (Vec::new(), 1.0_f64);
    for k in 0..SPOILED {
        let frame = frames[1 + k * (frames.len() - 1) / SPOILED];
        let mut spoiled = examples.clone();
        let before = examples.frame(frame - 1).to_vec();
        spoil(&mut spoiled.vertices[frame * len..(frame + 1) * len], &before, examples.diagonal());
        let sound = Inliers::new(&spoiled, &Silent)?;
        let left_out = sound.left_out();
        let is_named = left_out.iter().any(|out| out.frame == frame);
        named += usize::from(is_named);
        if !is_named {
            missed.push(frame);
            worst = worst.max(harm(&spoiled, frame)?);
        }
        others.extend(left_out.iter().map(|out| out.frame).filter(|other| *other != frame));
    }
    println!(
        "{name:<44}{SPOILED:>7}{named:>9}{:>9}{worst:>9.3}  not named: {missed:?}, others: {others:?}",
        others.len()
    );
    Ok(())
}

/// Returns the ratio of two errors: of a model trained with a damaged frame, and of a model trained
/// without the frame. The error is on held-out frames, or on training frames if there are none. If
/// the frame is detected, both models are the same.
fn harm(spoiled: &Examples, frame: usize) -> Result<f64, Box<dyn Error>> {
    let mut without = spoiled.clone();
    without.split[frame] = Split::Extreme;
    let held_out = spoiled.frames_of(Split::HeldOut);
    let frames = if held_out.is_empty() { without.frames_of(Split::Train) } else { held_out };
    let options = fixed(Predictor::Kernel, 40);
    let error = |examples: &Examples| -> Result<f64, Box<dyn Error>> {
        let model = train(examples, &options, &Silent)?.model;
        let character = Character::open(&model, None, examples)?;
        Ok(Measured::model(&character, examples, &frames)?.errors().rms)
    };
    Ok(error(spoiled)? / error(&without)?)
}

/// Loads sets whose held-out frames are outside the trained range.
fn scenes() -> Result<Vec<(String, Examples)>, Box<dyn Error>> {
    let mut scenes = Vec::new();
    for (clip, own) in [("walk", 0..66), ("stretch", 66..122)] {
        let Some(path) = found("leg/leg.npz") else { continue };
        let mut examples = load(&Source::file(&path))?.examples;
        let round = |x: f64| (x * 1e6).round() / 1e6;
        examples.vertices.iter_mut().for_each(|x| *x = x.map(round));
        examples.split.fill(Split::HeldOut);
        examples.split[own].fill(Split::Train);
        scenes.push((format!("leg {clip}"), examples));
    }
    for (name, file) in SETS {
        let Some(path) = found(file) else { continue };
        let examples = load(&Source::file(&path))?.examples;
        let trained = examples.frames_of(Split::Train);
        for third in 0..3 {
            let mut part = examples.clone();
            let own = third * trained.len() / 3..(third + 1) * trained.len() / 3;
            let out = (0..trained.len()).filter(|place| !own.contains(place));
            out.for_each(|place| part.split[trained[place]] = Split::Extreme);
            scenes.push((format!("{name} third {}", third + 1), part));
        }
        scenes.push((format!("{name} whole"), examples.clone()));
        if name == "mpfb-arm" {
            let frames: Vec<usize> = (0..examples.frame_len()).collect();
            let poses = Poses::new(&examples, &frames);
            let mut every = examples.clone();
            for joint in 1..examples.joint_len() {
                let angles = |frame: &usize| poses.angle(*frame, joint).norm();
                let mut sorted: Vec<f64> = trained.iter().map(angles).collect();
                sorted.sort_by(f64::total_cmp);
                let bent = sorted[3 * sorted.len() / 4];
                let mut part = examples.clone();
                for frame in &trained {
                    if angles(frame) > bent {
                        part.split[*frame] = Split::HeldOut;
                        every.split[*frame] = Split::HeldOut;
                    }
                }
                let joint = &examples.skeleton.names[joint];
                scenes.push((format!("mpfb-arm less {joint}"), part));
            }
            scenes.push(("mpfb-arm less every".to_owned(), every));
        }
    }
    Ok(scenes)
}

/// Returns options for one predictor and a number of helpers.
fn fixed(predictor: Predictor, proxies: usize) -> Options {
    Options {
        predictor: Predict::Only(predictor),
        proxies: Some(ProxyCount::Fixed(proxies)),
        ..Options::default()
    }
}

fn predictors(set: &str) -> Vec<(String, Options)> {
    let counts: &[usize] = if set.starts_with("leg") { &[20, 80] } else { &[40] };
    let mut rows = Vec::new();
    for &count in counts {
        for only in Predictor::ALL {
            rows.push((format!("{} {count}", only.name()), fixed(only, count)));
        }
    }
    rows.push(("auto".to_owned(), Options::default()));
    rows
}

/// A measured frame: errors are RMS, in % of the diagonal.
struct Frame {
    predictor: Predictor,
    confidence: f64,
    lbs: f64,
    model: f64,
}

impl Frame {
    fn is_worse(&self) -> bool {
        self.model > WORSE * self.lbs
    }

    /// Returns the share of LBS's error that the model gains, negative if the model is worse.
    fn gained(&self) -> f64 {
        1.0 - self.model / self.lbs
    }
}

/// Measures one training; returns its frames.
fn row(name: &str, examples: &Examples, options: &Options) -> Result<Vec<Frame>, Box<dyn Error>> {
    let model = match train(examples, options, &Silent) {
        Ok(trained) => trained.model,
        Err(error) => {
            println!("{name:<44}{error}");
            return Ok(Vec::new());
        }
    };
    let frames = examples.frames_of(Split::HeldOut);
    let character = Character::open(&model, None, examples)?;
    let predictor = character.envelope.predictor();
    let baseline: Baseline = TrainingRecord::of(&model, &character, examples).baseline(examples);
    let measured = Measured::model(&character, examples, &frames)?;
    let lbs = Measured::lbs(&baseline, examples, &frames);
    let (ours, theirs) = (measured.errors(), lbs.errors());
    let frame = |(place, frame): (usize, &MeasuredFrame)| {
        let [model, lbs] = [&measured, &lbs].map(|m| m.errors_in(place).rms_percent);
        Frame { predictor, confidence: frame.confidence, lbs, model }
    };
    let all: Vec<Frame> = measured.frames.iter().enumerate().map(frame).collect();
    let worse: Vec<f64> = all.iter().filter(|f| f.is_worse()).map(|f| f.confidence).collect();
    let trusted = worse.iter().filter(|confidence| **confidence > TRUSTED).count();
    let most = worse.iter().copied().fold(f64::NAN, f64::max);
    let gains: Vec<(f64, f64)> = all.iter().map(|f| (f.confidence, f.lbs - f.model)).collect();
    println!(
        "{name:<44}{:>7}{:>9.4}{:>9.4}{:>7.2}{:>7.2}{:>7}{most:>7.2}{trusted:>9}{:>9.2}",
        frames.len(),
        theirs.rms_percent,
        ours.rms_percent,
        ours.rms / theirs.rms,
        ours.p99_percent / theirs.p99_percent,
        worse.len(),
        spearman(&gains),
    );
    Ok(all)
}

/// Returns the rank correlation (Spearman) of pairs.
fn spearman(pairs: &[(f64, f64)]) -> f64 {
    let ranks = |of: &dyn Fn(&(f64, f64)) -> f64| -> Vec<f64> {
        let values: Vec<f64> = pairs.iter().map(of).collect();
        let below = |x: f64| values.iter().filter(|y| **y < x).count() as f64;
        let alike = |x: f64| values.iter().filter(|y| **y == x).count() as f64;
        values.iter().map(|&x| below(x) + 0.5 * (alike(x) - 1.0)).collect()
    };
    let (a, b) = (ranks(&|pair| pair.0), ranks(&|pair| pair.1));
    let mean = (pairs.len() as f64 - 1.0) / 2.0;
    let product = |a: &[f64], b: &[f64]| -> f64 {
        a.iter().zip(b).map(|(a, b)| (a - mean) * (b - mean)).sum()
    };
    product(&a, &b) / (product(&a, &a) * product(&b, &b)).sqrt()
}

fn found(file: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data").join(file);
    let there = path.exists();
    if !there {
        println!("{file} is not in ../shared/data: left out");
    }
    there.then_some(path)
}
