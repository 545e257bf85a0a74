//! Compiles and runs C and C++: with this machine's compilers, and on a Cortex-M4F.

mod cortex;
mod host;
mod linked;
mod parts;

use models::Rng;
use sinew_runtime::envelope::Trs;
use sinew_runtime::skin::Output;
use sinew_runtime::{Envelope, LocalTransform, Model, Skin, SkinJob, model_space_pose};
use std::path::{Path, PathBuf};
use std::process::Command;

const STRICT: [&str; 4] = ["-Wall", "-Wextra", "-Wpedantic", "-Werror"];

/// Programs that print hashes of all bits.
const BITS_C: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/compiled/bits.c");
const BITS_CPP: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/compiled/bits.cpp");

/// Returns the path of a program in `runtime/examples`.
fn example(name: &str) -> PathBuf {
    package().join("../examples").join(name)
}

fn package() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../runtime/capi"))
}

/// Returns the `block`-th block of a language in the README, counted from 0.
fn readme(language: &str, block: usize) -> String {
    let readme = std::fs::read_to_string(package().join("README.md")).unwrap();
    let code = readme.split(&format!("```{language}\n")).nth(1 + block).unwrap();
    code.split_once("```").unwrap().0.to_owned()
}

/// Creates this package's folder under the target folder.
fn scratch() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("capi");
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Runs a command to its end and returns its standard output.
fn output(command: &mut Command, install: &str) -> String {
    let program = command.get_program().to_string_lossy().into_owned();
    let done = command.output();
    let done = done.unwrap_or_else(|error| panic!("{program}: {error}; install {install}"));
    let (out, err) = (String::from_utf8_lossy(&done.stdout), String::from_utf8_lossy(&done.stderr));
    assert!(done.status.success(), "{command:?}: {}\n{out}\n{err}", done.status);
    out.into_owned()
}

/// Builds the static and the shared library for this machine and returns their folder.
fn libraries() -> PathBuf {
    cargo(&["rustc", "--crate-type", "staticlib,cdylib"]).join("embed")
}

/// Builds the static library for a bare target.
fn bare_library(target: &str) -> PathBuf {
    cargo(&["rustc", "--crate-type", "staticlib", "--target", target])
        .join(target)
        .join("embed/libsinew_capi.a")
}

/// Runs cargo in a separate target folder, because the folder of the tests is locked while they run.
fn cargo(arguments: &[&str]) -> PathBuf {
    let folder = scratch().join("target");
    let mut cargo = Command::new(env!("CARGO"));
    cargo.current_dir(package()).args(arguments);
    cargo.args(["--package", "sinew-capi", "--lib", "--profile", "embed", "--locked"]);
    let rustup = "the target: rustup target add thumbv7em-none-eabihf";
    output(cargo.arg("--target-dir").arg(&folder), rustup);
    folder
}

/// Computes the output of `bits.c` and `bits.cpp` with the runtime, and their random numbers.
fn printed(file: &[u8], poses: usize) -> String {
    let model = Model::from_bytes(file).unwrap();
    let (envelope, skin) = (model.first::<Envelope>().unwrap(), model.first::<Skin>().unwrap());
    let (v, j, p) = (skin.vertex_len(), envelope.joint_len(), envelope.palette_len());
    let stride = if skin.has_tangents() { 10 } else { 6 };
    let mut scratch = vec![0.0; envelope.scratch_len()];
    let mut curves = vec![0.0; envelope.curve_len()];
    let (mut pose, mut palette) = (vec![[[0.0; 4]; 3]; j], vec![[[0.0; 4]; 3]; p]);
    let mut bones = vec![Trs::IDENTITY; envelope.proxy_len()];
    let mut vertices = vec![0.0; stride * v];
    let (mut random, mut bits, mut least) = (Rng(2007), 0xcbf2_9ce4_8422_2325, 1.0f32);
    let mut bounds = None;
    for i in 0..poses {
        let turn = [0.01, 0.3, 1.0, 8.0][i % 4];
        let turned = |mut local: LocalTransform| {
            local.rotation.iter_mut().take(3).for_each(|x| *x += random.unit() * turn);
            local
        };
        let local: Vec<_> = envelope.rest_locals().map(turned).collect();
        curves.iter_mut().for_each(|curve| *curve = random.unit() * turn);
        model_space_pose(&envelope, &local, &mut pose).unwrap();
        let confidence =
            envelope.palette_trs(&pose, &curves, &mut scratch, &mut palette, &mut bones).unwrap();
        let [positions, normals, tangents] = Output::interleaved(&mut vertices, stride, [0, 3, 6]);
        SkinJob::new(skin, &palette)
            .positions(positions)
            .normals(normals)
            .tangents(Some(tangents).filter(|_| skin.has_tangents()))
            .run()
            .unwrap();
        let found = skin.bounds(&palette, 0.0).unwrap().unwrap();
        least = least.min(confidence);
        hash(&mut bits, palette.as_flattened().as_flattened());
        for (helper, bone) in bones.iter().enumerate() {
            let centre = envelope.helper_centre(helper).unwrap();
            hash(&mut bits, &[bone.translation, bone.scale, centre].concat());
            hash(&mut bits, &bone.rotation);
        }
        hash(&mut bits, &[confidence]);
        hash(&mut bits, &vertices);
        hash(&mut bits, &[found.min, found.max].concat());
        bounds = Some(found);
    }
    let ([a, b, c], [d, e, f]) = bounds.map(|b| (b.min, b.max)).unwrap();
    format!(
        "model       {}: {v} vertices, {j} joints, {p} transforms\n\
         bounds      {a:.6} {b:.6} {c:.6} to {d:.6} {e:.6} {f:.6}\n\
         confidence  {least:.6} at least\n\
         hash        {bits:016x}\n",
        envelope.name()
    )
}

/// FNV-1a over the bits of floats.
fn hash(state: &mut u64, values: &[f32]) {
    for byte in values.iter().flat_map(|value| value.to_bits().to_le_bytes()) {
        *state = (*state ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    }
}
