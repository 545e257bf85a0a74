//! A model in an artist's file.

mod alone;
mod plays;

use super::{arm, clip, model};
use serde_json::Value;
use sinew_runtime::envelope::Predictor;
use sinew_trainer::Error;
use sinew_trainer::envelope::levels::Level;
use sinew_trainer::examples::{Clip, Examples, JointNames};
use sinew_trainer::export::{ExportInto, Grafted, Playback, by_use, demo_glb};
use std::path::{Path, PathBuf};

/// Exports a model's first skin into a file.
pub(crate) fn export_into(
    model: &[u8],
    examples: &Examples,
    clips: &[Clip],
    levels: &[Level],
    file: &Path,
) -> Result<Grafted, Error> {
    let names = JointNames::default();
    let playback = Playback { model, skin: None, examples, clips, between: false, levels };
    ExportInto { playback, names, file }.run()
}

/// The demo as an artist's file, with a trained model.
struct Character {
    examples: Examples,
    clips: Vec<Clip>,
    glb: Glb,
    model: Vec<u8>,
}

impl Character {
    fn new() -> Self {
        let (examples, clips) = by_use(arm(300));
        let glb = Glb::read(&demo_glb(&examples, &clips).unwrap());
        let model = model(&examples, Predictor::Kernel, 6, 4);
        Self { examples, clips: vec![clip(&clips[0].name, 0, 6), clip("new", 6, 3)], glb, model }
    }

    /// Returns the index of an accessor of the file's mesh.
    fn attribute(&self, name: &str) -> usize {
        let attributes = &self.glb.json["meshes"][0]["primitives"][0]["attributes"];
        attributes[name].as_u64().unwrap() as usize
    }
}

/// JSON and binary chunk of a GLB.
#[derive(Clone)]
pub(crate) struct Glb {
    pub(crate) json: Value,
    pub(crate) bytes: Vec<u8>,
}

impl Glb {
    pub(crate) fn read(bytes: &[u8]) -> Self {
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        let end = 20 + word(12);
        assert_eq!((&bytes[..4], &bytes[end + 4..end + 8]), (&b"glTF"[..], &b"BIN\0"[..]));
        assert_eq!(bytes.len(), word(8));
        let json = serde_json::from_slice(&bytes[20..end]).unwrap();
        Self { json, bytes: bytes[end + 8..][..word(end)].to_vec() }
    }

    pub(crate) fn write(&self) -> Vec<u8> {
        let (mut json, mut bytes) = (self.json.clone(), self.bytes.clone());
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        json["buffers"][0]["byteLength"] = bytes.len().into();
        let mut json = json.to_string().into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut glb = b"glTF\x02\0\0\0".to_vec();
        glb.extend((28 + json.len() as u32 + bytes.len() as u32).to_le_bytes());
        for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &bytes)] {
            glb.extend((chunk.len() as u32).to_le_bytes());
            glb.extend(kind);
            glb.extend(chunk);
        }
        glb
    }

    /// Writes the file for a test and returns its path.
    pub(crate) fn save(&self, test: &str) -> PathBuf {
        let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR"))
            .join(format!("into-{test}-{}.glb", std::process::id()));
        std::fs::write(&path, self.write()).unwrap();
        path
    }

    /// Adds bytes and their view.
    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        let views = self.json["bufferViews"].as_array_mut().unwrap();
        views.push(serde_json::json!({
            "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len(),
        }));
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        views.len() - 1
    }

    /// Returns the bytes of a view.
    pub(crate) fn seen(&self, view: usize) -> &[u8] {
        let view = &self.json["bufferViews"][view];
        let number = |name: &str| view.get(name).map_or(0, |x| x.as_u64().unwrap() as usize);
        &self.bytes[number("byteOffset")..][..number("byteLength")]
    }

    /// Changes the floats of an accessor, row by row.
    pub(crate) fn change(&mut self, accessor: usize, width: usize, change: impl Fn(&mut [f32])) {
        let accessor = &self.json["accessors"][accessor];
        let view = &self.json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let begin = view["byteOffset"].as_u64().unwrap() as usize;
        let len = 4 * width * accessor["count"].as_u64().unwrap() as usize;
        for row in self.bytes[begin..][..len].chunks_mut(4 * width) {
            let mut floats: Vec<f32> =
                row.as_chunks::<4>().0.iter().map(|x| f32::from_le_bytes(*x)).collect();
            change(&mut floats);
            row.copy_from_slice(
                floats.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>().as_slice(),
            );
        }
    }
}
