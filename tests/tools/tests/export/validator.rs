//! The Khronos validator reports no errors and no warnings.

use super::{arm, clip, export, model};
use serde_json::Value;
use sinew_runtime::envelope::Predictor;
use sinew_trainer::envelope::levels::Level;
use sinew_trainer::export::{Placement, by_use, demo_glb};
use sinew_trainer::formats::Mesh;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

const PACKAGE: &str = "gltf-validator";
const VERSION: &str = "2.0.0-dev.3.10";

const SCRIPT: &str = "const [folder, file] = process.argv.slice(1);\
    require(folder).validateBytes(new Uint8Array(require('fs').readFileSync(file)))\
    .then(report => console.log(JSON.stringify(report.issues)));";

/// Returns the validator's folder; downloads the validator once.
fn validator() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let prefix = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{PACKAGE}-{VERSION}"));
        let folder = prefix.join("node_modules").join(PACKAGE);
        if !folder.join("index.js").exists() {
            let mut npm = Command::new("npm");
            npm.args(["install", "--no-audit", "--no-fund", "--prefix"]).arg(&prefix);
            let installed = npm.arg(format!("{PACKAGE}@{VERSION}")).output();
            let installed = installed.expect("npm is needed: install Node.js 18 or newer with npm");
            let said = String::from_utf8_lossy(&installed.stderr).into_owned();
            assert!(installed.status.success(), "npm cannot install {PACKAGE}@{VERSION}: {said}");
        }
        folder
    })
}

/// Validates a file; returns the numbers of errors and warnings, and the full report.
fn issues(name: &str, glb: &[u8]) -> (u64, u64, Value) {
    let folder = validator();
    let file =
        Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{}.glb", std::process::id()));
    std::fs::write(&file, glb).unwrap();
    let node = Command::new("node").args(["-e", SCRIPT, "--"]).arg(folder).arg(&file).output();
    let node = node.expect("node is needed: install Node.js 18 or newer");
    std::fs::remove_file(file).unwrap();
    assert!(node.status.success(), "{}", String::from_utf8_lossy(&node.stderr));
    let issues: Value = serde_json::from_slice(&node.stdout).unwrap();
    let count = |severity: &str| issues[severity].as_u64().unwrap();
    (count("numErrors"), count("numWarnings"), issues)
}

/// Asserts that the validator reports no errors and no warnings.
#[track_caller]
pub(crate) fn valid(name: &str, glb: &[u8]) {
    let (errors, warnings, issues) = issues(name, glb);
    assert_eq!((errors, warnings), (0, 0), "{name}: {issues:#}");
}

#[test]
fn exports_of_every_predictor_are_valid() {
    let (examples, coarse) = (arm(400), arm(250));
    let clips = [clip("a", 0, 12), clip("b", 12, 1)];
    let mesh = Mesh { positions: coarse.rest, triangles: coarse.triangles, engine: None };
    let levels = [Level { name: "lod1".to_owned(), mesh, is_placed: false }];
    for predictor in Predictor::ALL {
        for (proxies, influences) in [(8, 4), (20, 7)] {
            let model = model(&examples, predictor, proxies, influences);
            let exported =
                export(&model, None, &examples, &clips, &levels, Placement::AsModel).unwrap();
            valid(&format!("{}-{influences}", predictor.name()), &exported.glb);
        }
    }
}

/// Unused vertices have no normal, which glTF does not allow.
#[test]
fn a_mesh_with_a_vertex_in_no_triangle_is_valid() {
    let mut examples = arm(250);
    let last = examples.vertex_len() - 1;
    examples.triangles.retain(|triangle| !triangle.contains(&last));
    let model = model(&examples, Predictor::Kernel, 4, 4);
    let exported =
        export(&model, None, &examples, &[clip("a", 0, 3)], &[], Placement::AsModel).unwrap();
    valid("unused", &exported.glb);
}

#[test]
fn the_demo_s_rig_is_valid() {
    let (examples, clips) = by_use(arm(400));
    valid("rig", &demo_glb(&examples, &clips).unwrap());
}

#[test]
fn a_file_that_is_wrong_is_found_out() {
    let (examples, clips) = by_use(arm(250));
    let mut glb = demo_glb(&examples, &clips).unwrap();
    let at = glb.windows(4).position(|bytes| bytes == b"VEC3").unwrap();
    glb[at + 3] = b'2';
    assert!(issues("wrong", &glb).0 > 0);
}
