//! Scenes, targets and importance on the command line.

use crate::cli::common::{Folder, write_arrays};
use half::f16;
use serde_json::json;
use std::fs;
use std::io::Write;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// Makes a folder with the demo's rig and point cache.
fn rig(test: &str) -> Folder {
    let folder = Folder::new(test);
    folder.sinew("export-demo . --vertices 200 --poses 20 --held-out 5").done();
    folder
}

#[test]
fn files_that_do_not_fit_a_scene_are_refused_by_name() {
    let folder = rig("misfits");
    let pc2 = folder.read("demo.pc2");
    fs::write(folder.path("cut.pc2"), &pc2[..pc2.len() - 4]).unwrap();
    fs::write(folder.path("fewer.pc2"), frames(&pc2, 24)).unwrap();
    let mut nan = pc2.clone();
    let place = 32 + 12 * (3 * vertex_len(&pc2) + 7);
    nan[place..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
    fs::write(folder.path("nan.pc2"), nan).unwrap();
    let glb = folder.read("demo.glb");
    fs::write(folder.path("cut.glb"), &glb[..glb.len() / 2]).unwrap();
    fs::write(folder.path("two.txt"), "1 2").unwrap();
    fs::write(folder.path("notes.doc"), "notes").unwrap();
    fs::write(folder.path("rig.blend"), "BLENDER").unwrap();
    fs::write(folder.path("rig.usdz"), "PK\x03\x04").unwrap();
    fs::write(folder.path("old.abc"), b"\x89HDF\r\n\x1a\n").unwrap();
    fs::write(folder.path("other.pc2"), "Ogawa").unwrap();
    folder.sinew("demo --vertices 200 --poses 8 --held-out 3 --predictor kernel -o .").done();
    for (arguments, expected) in [
        ("demo.glb --targets cut.pc2", "cut.pc2: should have "),
        (
            "demo.glb --targets nan.pc2",
            "nan.pc2: its vertices are not finite in frame 3 (train 3), at vertex 7: export the meshes",
        ),
        ("cut.glb", "cut.glb: is cut short: expected at least "),
        (
            "demo.glb --targets demo.pc2 --hold-out-clip train --hold-out-clip held-out",
            "demo.glb: every frame of 25 is held out or extreme: none is left to train",
        ),
        ("demo.glb --targets none.pc2", "none.pc2: cannot be read: "),
        ("demo.glb --targets notes.doc", "notes.doc: expected a file that ends in .abc, .pc2, "),
        (
            "rig.blend",
            "rig.blend: is a Blender scene, which is not read: write examples of it by `blender ",
        ),
        ("demo.glb --targets rig.usdz", "rig.usdz: is USD, which is not read: export the scene"),
        ("demo.glb --targets old.abc", "old.abc: is Alembic in an HDF5 container"),
        ("demo.glb --targets other.pc2", "other.pc2: holds what a .abc file holds"),
        ("old.abc", "old.abc: holds posed meshes, but no joints to learn from: give the scene"),
        ("demo.pc2", "demo.pc2: holds posed meshes, but no joints to learn from: give the scene"),
        (
            "demo.glb --targets fewer.pc2 --clip train",
            "fewer.pc2: holds 24 meshes, the scene's clips have 20 frames (train: 20): export both",
        ),
        ("demo.glb --clip run", "demo.glb: has no clip run, there are: train, held-out"),
        (
            "demo.glb --targets demo.pc2 --hold-out-clip run",
            "demo.glb: has no clip run, there are: train, held-out",
        ),
        ("demo.npz --targets demo.pc2", "demo.npz: --targets goes with a scene"),
        ("demo.npz --fps 30", "demo.npz: --fps goes with a scene"),
        ("demo.npz --clip run", "demo.npz: has no clip run, there are: demo"),
        ("demo.npz --importance two.txt", "two.txt: rest has "),
        ("demo.npz --importance none.npy", "none.npy: cannot be read: "),
    ] {
        let error = folder.sinew(&format!("train {arguments} -o new.sinew")).failed();
        assert!(error.starts_with(expected), "{arguments}: {error}");
    }
    assert!(!folder.path("new.sinew").exists());
}

#[test]
fn a_frame_that_is_not_finite_is_named_in_every_format() {
    let folder = rig("not-finite");
    let mut pc2 = folder.read("demo.pc2");
    let len = vertex_len(&pc2);
    for place in 0..3 * len {
        pc2[32 + 4 * place..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
    }
    fs::write(folder.path("bad.pc2"), &pc2).unwrap();
    let (words, _) = pc2[32..].as_chunks::<4>();
    let mut mdd = [25_u32, len as u32].map(u32::to_be_bytes).concat();
    mdd.resize(8 + 4 * 25, 0);
    words.iter().for_each(|&word| mdd.extend(f32::from_le_bytes(word).to_be_bytes()));
    fs::write(folder.path("bad.mdd"), mdd).unwrap();
    let numbers: Vec<f64> = words.iter().map(|&word| f32::from_le_bytes(word).into()).collect();
    fs::create_dir(folder.path("poses")).unwrap();
    for (frame, points) in numbers.chunks(3 * len).enumerate() {
        let lines = points.chunks(3).map(|x| format!("v {} {} {}\n", x[0], x[1], x[2]));
        let mesh: String = lines.chain(["f 1 2 3\n".to_owned()]).collect();
        fs::write(folder.path(&format!("poses/p{}.obj", frame + 1)), mesh).unwrap();
    }
    write_arrays(&folder.path("bad.npz"), &[("vertices", &[25, len as u64, 3], &numbers)]);
    let fault = "its vertices are not finite in frame 0 (train 0), at vertex 0: export the meshes";
    for (targets, expected) in [("bad.pc2", fault), ("bad.mdd", fault), ("bad.npz", fault)] {
        let train = format!("train demo.glb --targets {targets} -o new.sinew");
        let line = folder.sinew(&train).failed();
        assert!(line.starts_with(&format!("{targets}: {expected}")), "{line}");
    }
    let line = folder.sinew("train demo.glb --targets poses -o new.sinew").failed();
    assert!(line.starts_with("poses/p1.obj: line 1 is no vertex, "), "{line}");
    // Posed meshes without joints are not examples.
    let line = folder.sinew("train bad.npz -o new.sinew").failed();
    let expected =
        "bad.npz: holds posed meshes, but no joints to learn from: give the scene with the joints";
    assert!(line.starts_with(expected) && line.ends_with("this file as --targets"), "{line}");
}

#[test]
fn half_precision_is_read_as_the_numbers_that_it_holds() {
    let folder = rig("half");
    let pc2 = folder.read("demo.pc2");
    let (words, _) = pc2[32..].as_chunks::<4>();
    let halves = words.iter().map(|&word| f16::from_f32(f32::from_le_bytes(word)));
    let halves: Vec<f16> = halves.collect();
    let numbers: Vec<f64> = halves.iter().map(|&half| half.into()).collect();
    let shape = [25, vertex_len(&pc2) as u64, 3];
    write_arrays(&folder.path("half.npz"), &[("vertices", &shape, &halves)]);
    write_arrays(&folder.path("double.npz"), &[("vertices", &shape, &numbers)]);
    let check = |targets: &str| {
        folder.sinew(&format!("check demo.glb --targets {targets} --json")).done().out
    };
    assert_eq!(check("half.npz"), check("double.npz"));
}

#[test]
fn damaged_archives_are_reported_in_our_words() {
    let folder = rig("archives");
    write_arrays(&folder.path("cut.npz"), &[("vertices", &[2, 3, 3], &[0.0; 18])]);
    let whole = folder.read("cut.npz");
    for len in [1, 40, whole.len() - 30, whole.len() - 1] {
        fs::write(folder.path("cut.npz"), &whole[..len]).unwrap();
        let line = folder.sinew("train demo.glb --targets cut.npz -o new.sinew").failed();
        let expected = format!(
            "cut.npz: is no whole .npz archive: its {len} bytes do not end with the archive's directory; write it, or \
             copy it, again"
        );
        assert_eq!(line, expected);
    }
    for (header, fault) in [
        (
            "{'descr': '<f8', 'fortran_order': `, 'shape': (2,)}\n",
            "its header is not that of an .npy array of numbers or text",
        ),
        ("{'descr'", "it ends in its header"),
    ] {
        let mut zip = ZipWriter::new(fs::File::create(folder.path("bad.npz")).unwrap());
        zip.start_file("vertices.npy", SimpleFileOptions::DEFAULT).unwrap();
        zip.write_all(b"\x93NUMPY\x01\0\x34\0").unwrap();
        zip.write_all(header.as_bytes()).unwrap();
        zip.finish().unwrap();
        let line = folder.sinew("train demo.glb --targets bad.npz -o new.sinew").failed();
        let expected = format!(
            "bad.npz: array vertices is damaged: {fault}; write the file, or copy it, again"
        );
        assert_eq!(line, expected);
    }
}

#[test]
fn targets_and_importance_are_inputs_too() {
    let folder = rig("inputs");
    let before = folder.read("demo.pc2");
    let error = folder.sinew("train demo.glb --targets demo.pc2 -o demo.pc2").failed();
    assert!(error.contains("cannot write demo.pc2: it is an input"), "{error}");
    assert_eq!(folder.read("demo.pc2"), before);

    let examples = "demo.glb --targets demo.pc2 --importance all.txt --hold-out-clip held-out";
    fs::write(folder.path("all.txt"), "1 ".repeat(vertices(&folder))).unwrap();
    let fit = "--predictor kernel --proxies 4";
    folder.sinew(&format!("train {examples} {fit} -o a.sinew --record a.json")).done();
    let record: serde_json::Value = serde_json::from_slice(&folder.read("a.json")).unwrap();
    let inputs = record["inputs"].as_array().unwrap().iter();
    let inputs: Vec<_> = inputs.map(|input| input["file"].as_str().unwrap()).collect();
    assert_eq!(inputs, ["demo.glb", "demo.pc2", "all.txt"]);
    assert_eq!(record["held_out_frames"].as_array().unwrap().len(), 5);
}

/// Targets of all clips also work for one clip.
#[test]
fn the_meshes_of_a_clip_are_cut_out_of_those_of_all() {
    let folder = rig("cut");
    fs::write(folder.path("train.pc2"), frames(&folder.read("demo.pc2"), 20)).unwrap();
    let train = "train demo.glb --clip train --predictor kernel --proxies 4";
    folder.sinew(&format!("{train} --targets train.pc2 -o own.sinew")).done();
    let run = folder.sinew(&format!("{train} --targets demo.pc2 -o cut.sinew"));
    let expected = "sinew: note: demo.glb: the targets hold all 25 frames of all clips; the 20 frames of train \
                    are used\n";
    assert_eq!((run.code, run.err.as_str()), (Some(0), expected));
    assert!(folder.read("cut.sinew") == folder.read("own.sinew"), "the same meshes");
    let eval = "eval cut.sinew demo.glb --targets demo.pc2 --quiet --json";
    let of = |clip: &str| folder.sinew(&format!("{eval} --clip {clip}")).json();
    for (clip, frames, read) in [("train", 20, 20), ("held-out", 5, 0)] {
        let found = of(clip);
        assert_eq!((&found["frames"], &found["read"]), (&json!(frames), &json!(read)), "{clip}");
    }
    let run = folder.sinew("check demo.glb --targets demo.pc2 --clip held-out");
    assert!(run.err.contains("the 5 frames of held-out are used"), "{}", run.err);
}

#[test]
fn targets_that_are_forgotten_are_asked_for() {
    let folder = rig("forgotten");
    let fit = "--predictor kernel --proxies 4";
    folder.sinew(&format!("train demo.glb --targets demo.pc2 {fit} -o a.sinew")).done();
    let asked = "demo.glb: no shapes move and no targets are given: the meshes are the scene's own linear blend skinning, \
                 and the model has learned others; give those as --targets, as in training";
    for command in ["eval a.sinew demo.glb", "report a.sinew demo.glb --quick -o a.html"] {
        assert_eq!(folder.sinew(command).failed(), asked);
        folder.sinew(&format!("{command} --targets demo.pc2")).done();
    }
    // A model trained without importance does not ask for importance.
    folder.sinew(&format!("train demo.glb {fit} -o plain.sinew -q")).done();
    let run = folder.sinew("eval plain.sinew demo.glb");
    assert!(run.code == Some(0) && run.err.contains("there is nothing to learn"), "{}", run.err);
}

#[test]
fn a_check_counts_its_findings() {
    let folder = rig("counted");
    for (options, expected) in
        [("", [1, 0]), ("--quiet", [0, 0]), ("--clip train --targets demo.pc2", [0, 1])]
    {
        let run = folder.sinew(&format!("check demo.glb {options}"));
        let count = |kind: &str| run.err.matches(&format!("{kind}: demo.glb: ")).count();
        assert_eq!(["warning", "note"].map(count), expected, "{}", run.err);
        let found = |kind: &str| {
            let found = count(kind) + run.out.matches(&format!("\n  {kind}: ")).count();
            format!("{found} {kind}{}", if found == 1 { "" } else { "s" })
        };
        let [warnings, notes] = ["warning", "note"].map(found);
        assert!(run.out.contains(&format!("\n{warnings}, {notes}, ")), "{}", run.out);
    }
}

/// Returns a point cache with only the first frames.
fn frames(pc2: &[u8], len: usize) -> Vec<u8> {
    let mut cut = pc2[..32 + 12 * vertex_len(pc2) * len].to_vec();
    cut[28..32].copy_from_slice(&(len as u32).to_le_bytes());
    cut
}

fn vertices(folder: &Folder) -> usize {
    vertex_len(&folder.read("demo.pc2"))
}

fn vertex_len(pc2: &[u8]) -> usize {
    u32::from_le_bytes(pc2[16..20].try_into().unwrap()) as usize
}
