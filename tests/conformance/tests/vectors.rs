//! The vectors for other backends: equal bytes every time, equal to the runtime's outputs, and fit
//! to check a foreign implementation.

use conformance::backend::Loaded;
use conformance::vectors::{Folder, VectorError, write};
use sinew_runtime::filter::Samples;
use sinew_runtime::skin::Output as Attribute;
use sinew_runtime::{Filter, KernelMap, Matrix3x4, Model, ShapesJob, Skin};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Returns an unused path for one test.
fn place(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("vectors").join(name);
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    path
}

fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut out = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            out.extend(files(&path));
        } else {
            out.insert(path.clone(), fs::read(path).unwrap());
        }
    }
    out
}

fn floats(path: PathBuf) -> Vec<f32> {
    let bytes = fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    bytes.as_chunks::<4>().0.iter().map(|le| f32::from_le_bytes(*le)).collect()
}

fn cases(folder: &Path) -> Vec<PathBuf> {
    let mut out: Vec<_> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    out.retain(|path| path.is_dir());
    out.sort();
    out
}

/// Lists the cases whose names start with `start`.
fn named(folder: &Path, start: &str) -> Vec<PathBuf> {
    let is_it = |case: &PathBuf| case.file_name().unwrap().to_str().unwrap().starts_with(start);
    cases(folder).into_iter().filter(is_it).collect()
}

/// Lists the cases of an envelope and its skin.
fn skinned(folder: &Path) -> Vec<PathBuf> {
    let others = ["kernel-", "shapes-", "filter-"].map(|start| named(folder, start)).concat();
    cases(folder).into_iter().filter(|case| !others.contains(case)).collect()
}

fn json(case: &Path) -> serde_json::Value {
    serde_json::from_slice(&fs::read(case.join("case.json")).unwrap()).unwrap()
}

#[test]
fn the_bytes_are_equal_every_time_and_not_too_many() {
    let [one, two] = ["one", "two"].map(place);
    write(&one).unwrap();
    write(&two).unwrap();
    let (first, second) = (files(&one), files(&two));
    assert!(first.values().eq(second.values()) && first.len() == second.len());
    let bytes: usize = first.values().map(Vec::len).sum();
    assert!(first.len() > 300 && (1_000_000..20_000_000).contains(&bytes), "{bytes}");
}

#[test]
fn nothing_is_overwritten_and_nothing_is_left_half_written() {
    let taken = place("taken");
    fs::create_dir(&taken).unwrap();
    fs::write(taken.join("mine"), "mine").unwrap();
    assert!(matches!(write(&taken), Err(VectorError::NotEmpty(_))));
    assert_eq!(files(&taken).len(), 1);
    assert!(matches!(write(&taken.join("mine")), Err(VectorError::Io { .. })), "it is a file");

    let given_up = place("given-up");
    let folder = Folder::create(&given_up).unwrap();
    folder.write("case/file", b"half").unwrap();
    drop(folder);
    assert!(!given_up.exists());
    let beside = fs::read_dir(given_up.parent().unwrap()).unwrap();
    let is_left = |name: String| name.starts_with("given-up");
    assert!(!beside.map(|entry| entry.unwrap().file_name().into_string().unwrap()).any(is_left));

    // An empty folder is accepted.
    fs::create_dir(&given_up).unwrap();
    write(&given_up).unwrap();
    assert!(given_up.join("README.md").is_file());
}

#[test]
fn arrays_have_their_shapes_and_tolerances_are_numbers() {
    let out = place("shapes");
    write(&out).unwrap();
    let (mut total, mut exact) = (0, 0);
    let skinned = skinned(&out);
    for case in cases(&out) {
        let description = json(&case);
        let mut lens = BTreeMap::new();
        for array in description["arrays"].as_array().unwrap() {
            let shape = array["shape"].as_array().unwrap().iter();
            let len: u64 = shape.map(|len| len.as_u64().unwrap()).product();
            let found = floats(case.join(array["file"].as_str().unwrap()));
            assert_eq!(found.len() as u64, len, "{array} of {}", case.display());
            assert!(array["type"] == "u32" || found.iter().all(|x| x.is_finite()));
            lens.insert(array["name"].as_str().unwrap().to_owned(), len);
        }
        for stage in description["stages"].as_array().unwrap() {
            for input in stage["inputs"].as_array().unwrap() {
                assert!(lens.contains_key(input.as_str().unwrap()), "{stage}");
            }
            for output in stage["outputs"].as_array().unwrap() {
                let found = floats(case.join(output["tolerance"].as_str().unwrap()));
                let len = lens[output["array"].as_str().unwrap()];
                assert_eq!(found.len() as u64, len, "{output} of {}", case.display());
                // Far from the origin positions are some hundreds, and u times that is 1e-5. Far
                // from its data a kernel with a fifth power has values of millions.
                let values =
                    floats(case.join(format!("{}.f32", output["array"].as_str().unwrap())));
                let most = values.iter().fold(0.0f32, |most, x| most.max(x.abs()));
                let most = if skinned.contains(&case) { 2.01 } else { 1e-3 * most };
                assert!(found.iter().all(|x| (0.0..most).contains(x)), "{output}");
                total += found.len();
                exact += found.iter().filter(|x| **x == 0.0).count();
            }
        }
    }
    assert!(total > 100_000 && exact < total / 2, "{exact} of {total} leave nothing open");
}

#[test]
fn skins_equal_the_runtimes() {
    let out = place("runtime");
    write(&out).unwrap();
    let mut values = 0;
    for case in skinned(&out) {
        let bytes = fs::read(case.join("model.snw")).unwrap();
        let Loaded { envelope, skin, .. } = Loaded::new(&bytes);
        let read = |name: &str| floats(case.join(name));
        let palettes = read("palette.f32");
        let palettes: &[Matrix3x4] = palettes.as_chunks::<4>().0.as_chunks().0;
        let mut skins = Vec::new();
        for palette in palettes.chunks(envelope.palette_len()) {
            let mut positions = vec![[f32::NAN; 3]; skin.vertex_len()];
            skin.skin_positions(palette, &mut positions).unwrap();
            skins.extend(positions.into_flattened());
        }
        assert_eq!(skins, read("positions.f32"), "{}", case.display());
        values += skins.len();
    }
    assert!(values > 10_000, "{values}");
}

#[test]
fn outputs_of_kernels_equal_the_runtimes() {
    let out = place("kernels");
    write(&out).unwrap();
    let all = named(&out, "kernel-");
    // One of each kernel, and a servo.
    assert_eq!(all.len(), 16);
    for case in all {
        let model = Model::from_bytes(fs::read(case.join("model.snw")).unwrap()).unwrap();
        let kernel = model.first::<KernelMap>().unwrap();
        let [queries, outputs, confidences] =
            ["query", "output", "confidence"].map(|name| floats(case.join(format!("{name}.f32"))));
        let mut found = vec![f32::NAN; kernel.result_len()];
        let mut scratch = vec![0.0; kernel.counts().scratch_len()];
        let rows = queries.chunks(kernel.query_len()).zip(outputs.chunks(found.len()));
        for ((query, expected), confidence) in rows.zip(confidences) {
            assert_eq!(kernel.evaluate(query, &mut scratch, &mut found), Ok(confidence));
            assert_eq!(found, expected, "{}", case.display());
        }
    }
}

#[test]
fn signals_equal_the_runtimes() {
    let out = place("signals");
    write(&out).unwrap();
    let all = named(&out, "filter-");
    assert_eq!(all.len(), 4);
    for case in all {
        let model = Model::from_bytes(fs::read(case.join("model.snw")).unwrap()).unwrap();
        let counts = &json(&case)["counts"];
        let [signal_len, sample_len, lane_len] =
            ["signals", "samples", "lanes"].map(|name| counts[name].as_u64().unwrap() as usize);
        let [samples, fine] =
            ["sample", "fine"].map(|name| floats(case.join(format!("{name}.f32"))));
        let mut found = vec![f32::NAN; fine.len()];
        let shape = Samples { signal_len, sample_len, lane_len };
        model.first::<Filter>().unwrap().apply(shape, &samples, &mut found).unwrap();
        assert_eq!(found, fine, "{}", case.display());
    }
}

/// Runs the example script.
fn check(folder: &Path) -> Output {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/vectors.py");
    let run = Command::new("python3").arg(script).arg(folder).output();
    run.expect("python3 is installed")
}

#[test]
fn a_foreign_skin_is_checked_by_them() {
    let out = place("foreign");
    write(&out).unwrap();
    let right = check(&out);
    let text = String::from_utf8_lossy(&right.stdout);
    assert!(right.status.success(), "{text}{}", String::from_utf8_lossy(&right.stderr));
    println!("{text}");
    // Each case has a line, and some deviate.
    assert!(text.lines().count() == skinned(&out).len() && text.contains(" 0.2"), "{text}");

    let spoiled = out.join("character-kernel/positions.f32");
    let original = fs::read(&spoiled).unwrap();
    let tolerances = floats(out.join("character-kernel/positions.tolerance.f32"));
    let place = 4 * 1000;
    let value = f32::from_le_bytes(original[place..place + 4].try_into().unwrap());
    for wrong in [value + 2.0 * tolerances[1000], f32::NAN] {
        let mut bytes = original.clone();
        bytes[place..place + 4].copy_from_slice(&wrong.to_le_bytes());
        fs::write(&spoiled, bytes).unwrap();
        assert!(!check(&out).status.success(), "{wrong} passes");
    }
    fs::write(&spoiled, &original[..original.len() - 4]).unwrap();
    assert!(!check(&out).status.success(), "a value too few passes");
    fs::write(&spoiled, original).unwrap();
    assert!(check(&out).status.success());
    assert!(!check(&place_of_nothing()).status.success(), "nothing passes");
}

fn place_of_nothing() -> PathBuf {
    let path = place("nothing");
    fs::create_dir(&path).unwrap();
    path
}

#[test]
fn shaped_meshes_equal_the_runtimes() {
    let out = place("faces");
    write(&out).unwrap();
    let all = named(&out, "shapes-");
    assert_eq!(all.len(), 4);
    for case in all {
        let model = Model::from_bytes(fs::read(case.join("model.snw")).unwrap()).unwrap();
        let skin = model.first::<Skin>().unwrap();
        let read = |array: &str| floats(case.join(format!("{array}.f32")));
        let (weights, positions) = (read("weight"), read("positions"));
        let faces = weights.chunks(skin.shape_len()).zip(positions.chunks(3 * skin.vertex_len()));
        for (weights, positions) in faces {
            let mut found = vec![f32::NAN; positions.len()];
            let to = Some(Attribute::new(&mut found, 3));
            let (vertices, normals, tangents) = (0..skin.vertex_len(), None, None);
            ShapesJob::new(skin, weights)
                .vertices(vertices)
                .positions(to)
                .normals(normals)
                .tangents(tangents)
                .run()
                .unwrap();
            assert_eq!(found, positions);
        }
        assert_eq!(case.join("tangents.tolerance.f32").exists(), skin.has_tangents());
    }
}
