//! Writes USD as text: a character of a glTF document as UsdSkel, with the same nodes, keys, skins and meshes.

mod clip;
mod mesh;
mod rig;
mod text;

use ::gltf::Gltf;
use sinew_runtime::format::{Axis, Space};

use self::clip::{Clip, TimeCodes};
use self::rig::{Rig, SKELETON};
use self::text::{Names, Text, matrix, quoted, texts};
use crate::{Error, ErrorKind};

/// Writes a document that [`Document`](super::gltf::write::Document) made, with a skin, as USD.
///
/// - `space`: space of the document; y up and metres where it says nothing.
/// - `rate`: time codes a second.
///
/// # Errors
/// - [`ErrorKind::Unsupported`]: the character stands along an axis other than y and z.
/// - [`ErrorKind::Missing`]: the document has no skin.
/// - [`ErrorKind::Damaged`]: the document cannot be read.
pub(crate) fn write(glb: &[u8], space: &Space, rate: f64) -> Result<String, Error> {
    let up = match space.up {
        None | Some(Axis::Y) => "Y",
        Some(Axis::Z) => "Z",
        Some(up) => {
            return Err(Error::unsupported(format!(
                "the character stands along {}, and USD has y or z up: give --to-up y or --to-up z",
                up.name()
            )));
        }
    };
    let file = Gltf::from_slice(glb).map_err(|error| {
        let message = format!("the glTF document cannot be read: {error}");
        Error::new(ErrorKind::Damaged, message).caused_by(error)
    })?;
    let blob = file.blob.as_deref();
    let arrays = |_: ::gltf::Buffer<'_>| blob;
    let rig = Rig::read(&file, &arrays)
        .ok_or_else(|| Error::missing("the document has no skin under a root node"))?;
    let clips: Vec<_> = file.animations().map(|clip| Clip::read(&clip, &rig, &arrays)).collect();
    let codes = TimeCodes { rate };

    let mut text = Text::new();
    let mut stage = vec![format!("defaultPrim = {}", quoted(&rig.root))];
    if let Some(range) = clips.first().and_then(|clip| codes.range(&clip.times)) {
        let [start, end] = range;
        stage.extend([format!("startTimeCode = {start}"), format!("endTimeCode = {end}")]);
    }
    stage.extend([
        format!("framesPerSecond = {rate}"),
        format!("timeCodesPerSecond = {rate}"),
        format!("metersPerUnit = {}", space.unit.unwrap_or(1.0)),
        format!("upAxis = {}", quoted(up)),
    ]);
    text.stage(&stage);
    text.open(&format!("def SkelRoot {}", quoted(&rig.root)), &[]);
    text.line(&format!("matrix4d xformOp:transform = {}", matrix(&rig.placed)));
    text.line(r#"uniform token[] xformOpOrder = ["xformOp:transform"]"#);
    let mut names = Names::default();
    skeleton(&mut text, &rig, &clips, &codes, &names.new_one(SKELETON));
    mesh::write_all(&mut text, &file, &rig, &arrays, &mut names);
    text.close();
    Ok(text.finish())
}

/// Writes the skeleton and a `SkelAnimation` for each clip; the first is bound.
fn skeleton(text: &mut Text, rig: &Rig, clips: &[Clip], codes: &TimeCodes, name: &str) {
    text.open(&format!("def Skeleton {}", quoted(name)), &[&text::schemas(&["SkelBindingAPI"])]);
    let paths: Vec<&str> = rig.joints.iter().map(|joint| joint.path.as_str()).collect();
    let joints = texts(&paths);
    text.line(&format!("uniform token[] joints = {joints}"));
    let own: Vec<&str> = rig.joints.iter().map(|joint| joint.name.as_str()).collect();
    text.line(&format!("uniform token[] jointNames = {}", texts(&own)));
    for (attribute, matrices) in [
        ("bindTransforms", rig.joints.iter().map(|joint| joint.bind).collect::<Vec<_>>()),
        ("restTransforms", rig.joints.iter().map(|joint| joint.rest.matrix()).collect()),
    ] {
        let all: Vec<String> = matrices.iter().map(matrix).collect();
        text.line(&format!("uniform matrix4d[] {attribute} = [{}]", all.join(", ")));
    }
    let mut names = Names::default();
    let named: Vec<String> = clips.iter().map(|clip| names.new_one(&clip.name)).collect();
    if let Some(first) = named.first() {
        text.line(&format!("rel skel:animationSource = </{}/{name}/{first}>", rig.root));
    }
    for (clip, name) in clips.iter().zip(&named) {
        clip.write(text, &joints, codes, name);
    }
    text.close();
}
