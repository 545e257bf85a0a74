//! Skins a character on the CPU: loads a model, bends its joints, and prints the mesh's box.
//!
//!     cargo run --example host -- MODEL

use sinew_runtime::skin::Output;
use sinew_runtime::{Envelope, Model, Skin, SkinJob, matrix::IDENTITY, model_space_pose};
use std::error::Error;

/// Floats of a vertex: position and normal.
const STRIDE: usize = 6;

fn main() -> Result<(), Box<dyn Error>> {
    // Once for each file: the model owns the bytes, and its views cost nothing.
    let path = std::env::args().nth(1).ok_or("usage: host MODEL")?;
    let model = Model::from_bytes(std::fs::read(path)?)?;
    let envelope = model.first::<Envelope>().ok_or("the file has no envelope")?;
    let skin = model.first::<Skin>().ok_or("the file has no skin")?;
    let (joints, vertices) = (envelope.joint_len(), skin.vertex_len());
    println!("{}: {vertices} vertices, {joints} joints", envelope.name());

    // Once for each character: all lengths are known.
    let rest: Vec<_> = envelope.rest_locals().collect();
    let mut pose = vec![IDENTITY; joints];
    let curves = vec![0.0; envelope.curve_len()];
    let mut scratch = vec![0.0; envelope.scratch_len()];
    let mut palette = vec![IDENTITY; envelope.palette_len()];
    let mut floats = vec![0.0; STRIDE * vertices];

    for turn in [0.0, 0.1, 0.2] {
        // Each frame: the animation's frames of the joints, each relative to its parent.
        let mut local = rest.clone();
        local.iter_mut().skip(1).for_each(|joint| joint.rotation[2] += turn);
        model_space_pose(&envelope, &local, &mut pose)?;
        if cfg!(debug_assertions) {
            envelope.check_pose(&pose, &curves)?;
        }
        let confidence = envelope.palette(&pose, &curves, &mut scratch, &mut palette)?;
        // An engine whose own shader skins stops here, and uploads the palette.
        let [positions, normals] = Output::interleaved(&mut floats, STRIDE, [0, 3]);
        SkinJob::new(skin, &palette).positions(positions).normals(normals).run()?;
        let bounds = skin.bounds(&palette, 0.0)?.ok_or("the skin has no vertices")?;
        let [x, y, z] = bounds.max;
        println!("{turn:.1}: up to {x:.3} {y:.3} {z:.3}, confidence {confidence:.2}");
    }
    Ok(())
}
