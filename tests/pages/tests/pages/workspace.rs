//! Builds the runtime inside another workspace.

use pages::build::{cargo, copy, emptied, write};
use pages::{blocks, read};
use std::path::{Path, PathBuf};

const TARGET: &str = env!("CARGO_TARGET_TMPDIR");

/// Target folder of both engines.
const NESTED: &str = concat!(env!("CARGO_TARGET_TMPDIR"), "/../nested/engine");

/// Code that an engine adds to the ten lines of the README.
const MAIN: &str = "
fn main() {
    let model = load(include_bytes!(\"../arm.snw\").to_vec()).unwrap();
    let (envelope, skin) = (model.first::<Envelope>().unwrap(), model.first::<Skin>().unwrap());
    let mut pose = vec![[[0.0; 4]; 3]; envelope.joint_len()];
    for joint in &mut pose {
        *joint = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 5.0]];
    }
    let mut scratch = vec![0.0; envelope.scratch_len()];
    let mut palette = vec![[[0.0; 4]; 3]; envelope.palette_len()];
    let mut positions = vec![[0.0; 3]; skin.vertex_len()];
    frame(&model, &pose, &mut scratch, &mut palette, &mut positions).unwrap();
    let rest = skin.rest_position(0).unwrap();
    println!(\"{:.3}\", positions[0][2] - rest[2]);
    println!(\"{}\", load(include_bytes!(\"../kernel.snw\").to_vec()).err().unwrap());
}
";

/// What that code prints. The engine has the default features.
const PRINTED: &str = "5.000\npart 0: needs the feature `kernel`, which this build lacks\n";

/// Prints the palettes and the confidence of poses with a turned, a hidden and a mirrored joint, or why a file is refused.
const RESULTS: &str = "
use sinew_runtime::{Envelope, Model, Skin};

fn main() {
    for path in std::env::args().skip(1) {
        let model = match Model::from_bytes(std::fs::read(path).unwrap()) {
            Ok(model) => model,
            Err(error) => {
                println!(\"{error}\");
                continue;
            }
        };
        let (envelope, skin) = (model.first::<Envelope>().unwrap(), model.first::<Skin>().unwrap());
        for (joint, map) in [0, 1, 2].into_iter().flat_map(|joint| {
            let hidden = |by: f32| [[by, 0.0, 0.0], [0.0, by.abs(), 0.0], [0.0, 0.0, by.abs()]];
            let turned = [[0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]];
            [turned, hidden(0.0), hidden(0.05), hidden(-1.0)].map(|map| (joint, map))
        }) {
            let rest = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
            let mut pose = vec![rest; envelope.joint_len()];
            pose[joint] = map.map(|[x, y, z]| [x, y, z, 0.0]);
            let mut scratch = vec![0.0; envelope.scratch_len()];
            let mut palette = vec![[[0.0; 4]; 3]; envelope.palette_len()];
            let mut positions = vec![[0.0; 3]; skin.vertex_len()];
            let confidence = envelope.palette(&pose, &[], &mut scratch, &mut palette).unwrap();
            skin.skin_positions(&palette, &mut positions).unwrap();
            println!(\"{confidence} {palette:?} {positions:?}\");
        }
    }
}
";

/// A workspace that leaves out the copy of the runtime.
const ALONE: &str = "[workspace]\nresolver = \"3\"\nmembers = [\"game\"]\nexclude = [\"sinew\"]\n";

/// Makes an engine as a workspace, with a game that uses the runtime in another folder. The engine
/// lies outside our workspace, at a place specific to this checkout.
fn engine(name: &str, workspace: &str) -> PathBuf {
    let place =
        std::env::temp_dir().join(format!("sinew-pages{}", TARGET.replace(['/', '\\', ':'], "-")));
    let engine = emptied(&place, name);
    write(&engine.join("Cargo.toml"), workspace);
    let game = "[package]\nname = \"game\"\nversion = \"0.1.0\"\nedition = \"2021\"\n
[dependencies]\nsinew-runtime = { path = \"../sinew/runtime\" }\n";
    write(&engine.join("game/Cargo.toml"), game);
    write(
        &engine.join("game/src/main.rs"),
        &(blocks(&read("runtime/README.md"), "rust")[0].to_owned() + MAIN),
    );
    for (golden, name) in [(models::GOLDEN_NAMES[0], "arm.snw"), ("kernel-11.snw", "kernel.snw")] {
        std::fs::copy(models::golden_path(golden), engine.join("game").join(name)).unwrap();
    }
    engine
}

#[test]
fn the_repository_may_stand_inside_another_workspace() {
    let engine = engine("engine", "[workspace]\nresolver = \"3\"\nmembers = [\"game\"]\n");
    let sinew = engine.join("sinew");
    copy(&["Cargo.toml", "runtime/Cargo.toml", "runtime/README.md", "runtime/src"], &sinew);
    copy(
        &["runtime/benches", "tests/models/Cargo.toml", "tests/models/src", "tests/golden"],
        &sinew,
    );
    assert_eq!(cargo(&engine, Path::new(NESTED), &["run", "-q", "-p", "game"]), PRINTED);
}

#[test]
fn the_runtime_alone_may_stand_where_the_workspace_leaves_it_out() {
    let engine = engine("engine-alone", ALONE);
    copy(&["runtime/Cargo.toml", "runtime/README.md", "runtime/src"], &engine.join("sinew"));
    assert_eq!(cargo(&engine, Path::new(NESTED), &["run", "-q", "-p", "game"]), PRINTED);
}

#[test]
fn no_feature_changes_a_result() {
    let engine = engine("engine-features", ALONE);
    copy(&["runtime/Cargo.toml", "runtime/README.md", "runtime/src"], &engine.join("sinew"));
    write(&engine.join("game/src/main.rs"), RESULTS);
    let golden = |name: &str| models::golden_path(name).display().to_string();
    let results = |features: &str, names: &[&str]| {
        let game = "[package]\nname = \"game\"\nversion = \"0.1.0\"\nedition = \"2024\"\n
[dependencies]\nsinew-runtime = { path = \"../sinew/runtime\"";
        write(&engine.join("game/Cargo.toml"), &format!("{game}, {features} }}\n"));
        let names: Vec<String> = names.iter().map(|name| golden(name)).collect();
        let run = ["run", "-q", "-p", "game", "--"];
        let run: Vec<&str> = run.into_iter().chain(names.iter().map(String::as_str)).collect();
        cargo(&engine, Path::new(NESTED), &run)
    };
    let none = "default-features = false";
    let all = "features = [\"filter\", \"prior\", \"raster\", \"record\"]";
    let expected = results(all, &models::GOLDEN_NAMES);
    assert_eq!(expected.lines().filter(|line| line.starts_with("0 ")).count(), 18, "hidden joints");
    assert_eq!(results(none, &models::GOLDEN_NAMES), expected);
    // A build refuses a file for which it lacks a feature, and names the feature.
    let lacks =
        |name: &str| format!("part 0: needs the feature `{name}`, which this build lacks\n");
    let trs = models::GOLDEN_KIND_NAMES[0];
    assert_eq!(results(none, &["kernel-11.snw"]), lacks("kernel"));
    // The file has all three.
    for (features, lacked) in
        [("", "stretch"), ("\"stretch\"", "curves"), ("\"stretch\", \"curves\"", "trs")]
    {
        assert_eq!(results(&format!("{none}, features = [{features}]"), &[trs]), lacks(lacked));
    }
}

/// Pages whose code a reader copies.
const PAGES: [&str; 3] = ["README.md", "runtime/README.md", "runtime/ENGINE.md"];

#[test]
fn the_code_of_the_pages_and_the_host_program_need_no_internals() {
    let engine = engine("engine-pages", ALONE);
    copy(&["runtime/Cargo.toml", "runtime/README.md", "runtime/src"], &engine.join("sinew"));
    let game = "[package]\nname = \"game\"\nversion = \"0.1.0\"\nedition = \"2024\"\n
[dependencies]\nrayon = \"1\"\nsinew-runtime = { path = \"../sinew/runtime\", \
                features = [\"filter\", \"prior\", \"raster\"] }\n";
    write(&engine.join("game/Cargo.toml"), game);
    let pages = PAGES.map(read);
    let code = pages.iter().flat_map(|page| blocks(page, "rust"));
    let code: Vec<String> = code
        .enumerate()
        .map(|(number, block)| format!("#[allow(dead_code)]\nmod block_{number} {{\n{block}}}\n"))
        .collect();
    assert!(code.len() > 20, "{} blocks", code.len());
    write(&engine.join("game/src/lib.rs"), &code.concat());
    write(&engine.join("game/src/main.rs"), &read("runtime/examples/host.rs"));
    let run = ["run", "-q", "-p", "game", "--", "game/arm.snw"];
    let found = cargo(&engine, Path::new(NESTED), &run);
    assert!(found.contains("\n0.0: up to "), "{found}");
}

#[test]
fn standalone_packages_match_the_workspace() {
    let workspace = read("Cargo.toml");
    let table = |text: &str, name: &str| -> Vec<String> {
        let own = text.split_once(&format!("[{name}]\n")).map_or("", |(_, rest)| rest);
        own.lines().take_while(|line| !line.starts_with('[')).map(str::to_owned).collect()
    };
    let lines = |text: &str, name: &str| -> Vec<String> {
        table(text, name).into_iter().filter(|line| line.contains(" = ")).collect()
    };
    let mut compared = 0;
    for path in ["runtime/Cargo.toml", "runtime/capi/Cargo.toml", "tests/models/Cargo.toml"] {
        let own = read(path);
        assert!(!own.contains("workspace = true"), "{path} inherits");
        let package = lines(&own, "package");
        let all = lines(&workspace, "workspace.package");
        assert_eq!(all.len(), 4);
        for line in all {
            assert!(package.contains(&line), "{path} lacks {line}");
        }
        for lints in ["rust", "clippy"] {
            let all = lines(&workspace, &format!("workspace.lints.{lints}"));
            assert_eq!(lines(&own, &format!("lints.{lints}")), all, "{path}");
        }
        for dependency in lines(&own, "dependencies") {
            let name = dependency.split(' ').next().unwrap();
            let shared = lines(&workspace, "workspace.dependencies");
            let Some(line) = shared.iter().find(|line| line.starts_with(&format!("{name} = ")))
            else {
                continue;
            };
            if !line.contains("path = ") {
                assert_eq!(dependency, *line, "{path}");
                compared += 1;
            }
        }
    }
    assert!(compared > 0);
}
