//! Folders, examples and runs of the `sinew` binary for tests.

use npyz::{AutoSerialize, Deserialize, NpyFile, WriteOptions, WriterBuilder};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use zip::write::SimpleFileOptions;
use zip::{ZipArchive, ZipWriter};

/// Training frames of the demo that every test uses.
pub(crate) const TRAINING: usize = 40;
/// Held-out frames of the demo.
pub(crate) const HELD_OUT: usize = 12;
/// Proxies of the demo's model.
pub(crate) const PROXIES: usize = 4;

/// A separate folder for one test, removed at the end.
pub(crate) struct Folder(PathBuf);

impl Folder {
    pub(crate) fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("sinew-cli-{}-{test}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    /// Makes a folder with the demo's `demo.npz`, `demo.json` and `demo.sinew`.
    pub(crate) fn with_demo(test: &str) -> Self {
        let folder = Self::new(test);
        for (name, bytes) in demo() {
            fs::write(folder.path(name), bytes).unwrap();
        }
        folder
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Reads a GIF: its pictures, and the delay of each in hundredths of a second.
    pub(crate) fn gif(&self, name: &str) -> Vec<(Vec<u8>, u16)> {
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let bytes = self.read(name);
        let mut reader = options.read_info(&bytes[..]).unwrap();
        let size = (reader.width(), reader.height());
        let mut out = Vec::new();
        while let Some(frame) = reader.read_next_frame().unwrap() {
            assert_eq!(((frame.width, frame.height), (frame.left, frame.top)), (size, (0, 0)));
            out.push((frame.buffer.to_vec(), frame.delay));
        }
        out
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap()
    }

    pub(crate) fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&self.read(name)).unwrap()
    }

    /// Lists the names in the folder, in order.
    pub(crate) fn list(&self) -> Vec<String> {
        let name = |entry: std::io::Result<fs::DirEntry>| entry.unwrap().file_name();
        let mut names: Vec<String> = fs::read_dir(&self.0)
            .unwrap()
            .map(|entry| name(entry).to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    /// Runs `sinew` in the folder, with arguments separated by spaces.
    pub(crate) fn sinew(&self, arguments: &str) -> Run {
        self.run(self.command(arguments))
    }

    pub(crate) fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_sinew"));
        command.args(arguments.split_whitespace()).current_dir(&self.0);
        command
    }

    pub(crate) fn run(&self, mut command: Command) -> Run {
        let output = command.output().unwrap();
        let err = String::from_utf8(output.stderr).unwrap();
        // On a slow machine, the command sometimes reports its progress.
        let lines = err.split_inclusive('\n').filter(|line| !line.starts_with("sinew: working: "));
        Run {
            code: output.status.code(),
            out: String::from_utf8(output.stdout).unwrap(),
            err: lines.collect(),
        }
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Result of a run.
#[derive(Debug)]
pub(crate) struct Run {
    pub(crate) code: Option<i32>,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl Run {
    /// Asserts success without text on standard error.
    #[track_caller]
    pub(crate) fn done(self) -> Self {
        assert_eq!((self.code, self.err.as_str()), (Some(0), ""), "{}", self.out);
        self
    }

    /// Returns the output with wrapped lines joined.
    pub(crate) fn unwrapped(&self) -> String {
        self.out.replace("\n    ", " ")
    }

    #[track_caller]
    pub(crate) fn json(self) -> Value {
        serde_json::from_str(&self.done().out).unwrap()
    }

    /// Asserts exit status 1, no output and one line of error; returns the line without its prefix.
    #[track_caller]
    pub(crate) fn failed(self) -> String {
        assert_eq!((self.code, self.out.as_str()), (Some(1), ""), "{}", self.err);
        let line = self.err.strip_prefix("sinew: ").and_then(|line| line.strip_suffix('\n'));
        let line = line.unwrap_or_else(|| panic!("{}", self.err));
        assert!(!line.contains('\n') && !line.ends_with('.'), "{line}");
        line.to_owned()
    }
}

/// Returns the files of a small demo, made once.
fn demo() -> &'static [(&'static str, Vec<u8>)] {
    static DEMO: OnceLock<Vec<(&str, Vec<u8>)>> = OnceLock::new();
    DEMO.get_or_init(|| {
        let folder = Folder::new("demo");
        let sizes = format!("--poses {TRAINING} --held-out {HELD_OUT} --proxies {PROXIES}");
        folder.sinew(&format!("demo --vertices 300 {sizes} -o .")).done();
        ["demo.npz", "demo.json", "demo.sinew"].map(|name| (name, folder.read(name))).into()
    })
}

/// The demo's examples as arrays, to read and to change.
pub(crate) struct Set {
    pub(crate) reals: BTreeMap<&'static str, (Vec<u64>, Vec<f64>)>,
    pub(crate) wholes: BTreeMap<&'static str, (Vec<u64>, Vec<i64>)>,
    pub(crate) json: Value,
}

impl Set {
    /// Reads the demo's arrays.
    pub(crate) fn demo() -> Self {
        let names = ["rest", "vertices", "bone_transforms", "joint_world_rest", "fps"];
        let reals = names.map(|name| (name, demo_array(name))).into();
        let (shape, split) = demo_array::<u8>("split");
        let split = (shape, split.into_iter().map(i64::from).collect());
        let json = serde_json::from_slice(&demo()[1].1).unwrap();
        Self {
            reals,
            wholes: BTreeMap::from([("tris", demo_array("tris")), ("split", split)]),
            json,
        }
    }

    pub(crate) fn vertex_len(&self) -> usize {
        self.reals["rest"].0[0] as usize
    }

    pub(crate) fn joint_len(&self) -> usize {
        self.reals["bone_transforms"].0[1] as usize
    }

    /// Lists the frames with a code of the split.
    pub(crate) fn frames(&self, code: i64) -> Vec<usize> {
        let split = &self.wholes["split"].1;
        (0..split.len()).filter(|&frame| split[frame] == code).collect()
    }

    /// Keeps the first `len` items of an array of numbers.
    pub(crate) fn cut(&mut self, array: &str, len: u64) {
        let (shape, numbers) = self.reals.get_mut(array).unwrap();
        numbers.truncate(numbers.len() / shape[0] as usize * len as usize);
        shape[0] = len;
    }

    /// Writes `X.npz` and, unless the JSON is null, `X.json`.
    pub(crate) fn write(&self, npz: &Path) {
        let mut zip = ZipWriter::new(fs::File::create(npz).unwrap());
        for (name, (shape, numbers)) in &self.reals {
            write_array(&mut zip, name, shape, numbers);
        }
        for (name, (shape, numbers)) in &self.wholes {
            write_array(&mut zip, name, shape, numbers);
        }
        zip.finish().unwrap();
        if self.json != json!(null) {
            fs::write(npz.with_extension("json"), self.json.to_string()).unwrap();
        }
    }
}

/// Writes an archive of arrays, given by name, shape and numbers.
pub(crate) fn write_arrays<T: AutoSerialize + Copy>(npz: &Path, arrays: &[(&str, &[u64], &[T])]) {
    let mut zip = ZipWriter::new(fs::File::create(npz).unwrap());
    for (name, shape, numbers) in arrays {
        write_array(&mut zip, name, shape, numbers);
    }
    zip.finish().unwrap();
}

/// Reads an array of the demo: shape and numbers.
fn demo_array<T: Deserialize>(name: &str) -> (Vec<u64>, Vec<T>) {
    read_array(&demo()[0].1, name)
}

/// Reads an array of an archive: shape and numbers.
pub(crate) fn read_array<T: Deserialize>(npz: &[u8], name: &str) -> (Vec<u64>, Vec<T>) {
    let mut zip = ZipArchive::new(Cursor::new(npz)).unwrap();
    let array = NpyFile::new(zip.by_name(&format!("{name}.npy")).unwrap()).unwrap();
    (array.shape().to_vec(), array.into_vec().unwrap())
}

fn write_array<T: AutoSerialize + Copy>(
    zip: &mut ZipWriter<fs::File>,
    name: &str,
    shape: &[u64],
    numbers: &[T],
) {
    zip.start_file(format!("{name}.npy"), SimpleFileOptions::DEFAULT).unwrap();
    let options = WriteOptions::new().default_dtype().shape(shape);
    let mut array = options.writer(zip).begin_nd().unwrap();
    array.extend(numbers.iter().copied()).unwrap();
    array.finish().unwrap();
}

/// Reads an npy file of f32: shape and numbers.
pub(crate) fn read_npy(bytes: &[u8]) -> (Vec<u64>, Vec<f32>) {
    let file = NpyFile::new(bytes).unwrap();
    assert_eq!(file.dtype().descr(), "'<f4'");
    (file.shape().to_vec(), file.into_vec().unwrap())
}
