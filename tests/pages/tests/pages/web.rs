//! "A web page": its module and its script in a browser, against the native runtime.

use crate::math::{diagonal, farthest, rest};
use crate::shown::web::Character;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use models::cells;
use pages::arm;
use pages::browser::{browser, said};
use pages::build::{cargo, emptied, write};
use pages::{blocks, read, repository};
use sinew_runtime::skin::Output;
use sinew_runtime::{Envelope, Model, Skin, SkinJob};
use sinew_trainer::examples::Clip;
use sinew_trainer::export::{Export, Placement, Playback};
use sinew_trainer::formats::appearance::Appearance;
use std::path::Path;

const TARGET: &str = env!("CARGO_TARGET_TMPDIR");

/// Target folders of the modules.
const NESTED: &str = concat!(env!("CARGO_TARGET_TMPDIR"), "/../nested/pages");

/// Name of the joint that the page turns.
const JOINT: &str = "upper_arm";

/// The frame of the clip that the page shows.
const PLAYED: usize = 5;

/// Rise of the arm's box when the joint turns, divided by the box's diagonal.
const RAISED: f32 = 0.15;

/// Builds the page's module.
fn module(name: &str, flags: &str, level: &str) -> Vec<u8> {
    let folder = emptied(Path::new(TARGET), name);
    let runtime = repository().join("runtime");
    let manifest = format!(
        "[package]\nname = \"game\"\nversion = \"0.1.0\"\nedition = \"2024\"\n\n[lib]\ncrate-type = [\"cdylib\"]\n
[dependencies]\nsinew-runtime = {{ path = {runtime:?} }}\n\n[profile.release]\nopt-level = {level}\n\n[workspace]\n"
    );
    write(&folder.join("Cargo.toml"), &manifest);
    write(&folder.join("src/lib.rs"), &blocks(&read("runtime/WEB.md"), "rust").concat());
    // One target folder per build, kept between runs.
    let target = Path::new(NESTED).join(name);
    let wasm = "wasm32-unknown-unknown";
    let flags = format!("target.{wasm}.rustflags=[{flags}]");
    cargo(&folder, &target, &["build", "-q", "--release", "--target", wasm, "--config", &flags]);
    std::fs::read(target.join(wasm).join("release/game.wasm")).unwrap()
}

/// Summarises a frame as the page does: confidence, box, hash of all bits.
fn look(confidence: f32, floats: &[f32]) -> (f32, [f32; 6], u32) {
    let extent = |c: usize| {
        let all = floats.iter().skip(c).step_by(6);
        [all.clone().copied().fold(f32::MAX, f32::min), all.copied().fold(f32::MIN, f32::max)]
    };
    let [x, y, z] = [0, 1, 2].map(extent);
    let bytes = floats.iter().flat_map(|value| value.to_le_bytes());
    let hash = bytes
        .fold(0x811c_9dc5, |hash: u32, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193));
    (confidence, [x[0], x[1], y[0], y[1], z[0], z[1]], hash)
}

/// Parses the page's summary of a frame.
fn read_look(line: &str) -> (f32, [f32; 6], u32) {
    let fields: Vec<&str> = line.split(' ').skip(1).collect();
    let number = |i: usize| fields[i].parse::<f64>().unwrap() as f32;
    (number(0), [1, 2, 3, 4, 5, 6].map(number), fields[7].parse().unwrap())
}

/// Makes the file of the page's clip: the arm with all of its frames.
fn exported() -> Vec<u8> {
    let export = Export {
        playback: Playback {
            model: &arm::FILE,
            skin: None,
            examples: &arm::EXAMPLES,
            clips: &[whole()],
            between: false,
            levels: &[],
        },
        appearance: &Appearance::default(),
        placement: Placement::AsModel,
    };
    export.run().unwrap().glb
}

fn whole() -> Clip {
    Clip::regular("all".to_owned(), 0, arm::EXAMPLES.frame_len())
}

/// Computes the expected summary of the clip's frame from the frame's skinning matrices.
fn played(model: &Model<&[u8]>) -> (f32, [f32; 6], u32) {
    let (envelope, skin) = (model.first::<Envelope>().unwrap(), model.first::<Skin>().unwrap());
    let mut palette = vec![[[0.0; 4]; 3]; envelope.palette_len()];
    let mut scratch = vec![0.0; envelope.scratch_len()];
    let pose = arm::pose(&arm::EXAMPLES, PLAYED);
    let confidence = envelope.palette(&pose, &[], &mut scratch, &mut palette).unwrap();
    let mut vertices = vec![0.0; 6 * skin.vertex_len()];
    let floats = cells(&mut vertices);
    SkinJob::new(skin, &palette)
        .positions(Output::shared(floats, 6))
        .normals(Output::shared(&floats[3..], 6))
        .run()
        .unwrap();
    look(confidence, &vertices)
}

/// Opens the page with a module; compares its summaries with the native runtime, and prints its
/// frames per second.
fn opened(browser: &str, name: &str, module: &[u8]) {
    let model = Model::from_bytes(arm::FILE.as_slice()).unwrap();
    let (envelope, skin) = (model.first::<Envelope>().unwrap(), model.first::<Skin>().unwrap());
    let joint = (0..envelope.joint_len()).find(|&j| envelope.joint_name(j) == Some(JOINT)).unwrap();

    // Runs the page's code natively.
    let mut character = Character::new(arm::FILE.clone()).unwrap();
    let at_rest = look(character.frame().unwrap(), character.vertices());
    let own = rest(&skin);
    let size = diagonal(&own);
    let found: Vec<_> = character.vertices().chunks_exact(6).map(|v| [v[0], v[1], v[2]]).collect();
    assert!(farthest(&found, &own, size) < 1e-5, "it stands at rest");
    let (sin, cos) = 0.6_f64.sin_cos();
    character.turn(joint, [0.0, 0.0, sin as f32, cos as f32]);
    let turned = look(character.frame().unwrap(), character.vertices());
    assert!(at_rest.0 > 0.999 && turned.0 > 0.5, "{} {}", at_rest.0, turned.0);
    assert!(turned.1[3] - at_rest.1[3] > RAISED * size, "{:?} {:?}", at_rest.1, turned.1);

    let script = blocks(&read("runtime/WEB.md"), "js").concat();
    let page = include_str!("web.html");
    let time = whole().times[PLAYED] + 1e-3;
    let page = page.replace("BLOCK", &script).replace("JOINT", JOINT);
    let page = page.replace("TIME", &time.to_string());
    let glb = exported();
    let files = [
        ("/", "text/html; charset=utf-8", page.as_bytes()),
        ("/game.wasm", "application/wasm", module),
        ("/arm.snw", "application/octet-stream", arm::FILE.as_slice()),
        ("/arm.glb", "model/gltf-binary", &glb),
    ];
    let said = said(browser, &[], &files);
    let line = |what: &str| {
        let found = said.lines().find(|line| line.starts_with(what));
        found.unwrap_or_else(|| panic!("{name}: no {what} in {said}"))
    };
    let picture = STANDARD.decode(line("picture").split(' ').nth(1).unwrap()).unwrap();
    std::fs::write(Path::new(TARGET).join(format!("{name}.png")), picture).unwrap();
    assert_eq!(read_look(line("rest")), at_rest, "{name}");
    assert_eq!(read_look(line("turned")), turned, "{name}");
    let (confidence, found, _) = read_look(line("played"));
    let (expected_confidence, expected, _) = played(&model);
    assert!((confidence - expected_confidence).abs() < 1e-3, "{confidence} {expected_confidence}");
    let apart = |(a, b): (&f32, &f32)| (a - b).abs();
    let most = found.iter().zip(&expected).map(apart).fold(0.0, f32::max);
    assert!(most < 1e-4 * size, "{found:?} {expected:?}");
    let from_rest = expected.iter().zip(&at_rest.1).map(apart).fold(0.0, f32::max);
    assert!(from_rest > RAISED * size, "the clip moves it: {expected:?}");
    assert_eq!(line("curves"), "curves 0", "{name}: the arm has none");
    assert_eq!(line("refused"), "refused -1 0 true", "{name}");
    assert_eq!(line("closed"), "closed NaN", "{name}");
    let rate: u32 = line("rate").split(' ').nth(1).unwrap().parse().unwrap();
    println!("web: {name}, {} bytes, {} vertices: {rate} frames a second", module.len(), own.len());
}

const SIMD: &str = "'-C', 'target-feature=+simd128'";

/// With the page's settings, without SIMD, and optimised for size.
#[test]
fn every_build_of_the_page_draws_what_the_native_runtime_skins() {
    let Some(browser) = browser() else { return };
    for (name, flags, level) in
        [("web", SIMD, "3"), ("web-plain", "", "3"), ("web-small", SIMD, "'z'")]
    {
        opened(browser, name, &module(name, flags, level));
    }
}
