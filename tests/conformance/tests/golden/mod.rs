//! The present bake writes the bytes of the golden files.
//!
//! `SINEW_BLESS=1 cargo test -p conformance golden::` rewrites the files. The golden files of
//! a released version are never rewritten.

mod read_back;
mod refusals;
mod sample;
mod shapes;

use ::models::golden_path;
use sample::{file_model, goldens};
use sinew_trainer::envelope::model::EnvelopeModel;
use sinew_trainer::files;

#[test]
fn bake_writes_the_golden_files() {
    for golden in goldens() {
        let baked = file_model(golden).bake().unwrap();
        let path = golden_path(golden.file);
        if std::env::var_os("SINEW_BLESS").is_some() {
            std::fs::write(&path, &baked).unwrap();
        }
        let file = std::fs::read(&path).unwrap();
        assert!(baked == file, "the baked bytes differ from the golden file of {golden:?}");
        // Controls: the comparison can fail, in each part that only some of the files have.
        let mut other = file_model(golden);
        let envelope = &mut other.envelopes[0];
        if let Some(reconstruction) = &mut envelope.reconstruction {
            reconstruction.c1[(0, 0)] += 1.0 / 64.0;
        } else {
            envelope.groups[0].outputs[(0, 0)] += 1.0 / 64.0;
        }
        assert!(other.bake().unwrap() != file);
        let edits: [fn(&mut EnvelopeModel) -> Option<()>; 4] = [
            |envelope| {
                envelope.places[4].spread[(2, 2)] += 1.0 / 64.0;
                Some(())
            },
            |envelope| {
                envelope.stretch_ranges.as_mut()?[4] += 1.0 / 64.0;
                Some(())
            },
            |envelope| {
                envelope.stretch_ranges.as_ref()?;
                envelope.reconstruction.as_mut()?.keys[4].shear[(5, 11)] += 1.0 / 64.0;
                Some(())
            },
            |envelope| {
                envelope.curves.get_mut(2)?.range[1] += 1.0 / 64.0;
                Some(())
            },
        ];
        let mut edited = 0;
        for edit in edits {
            let mut other = file_model(golden);
            if edit(&mut other.envelopes[0]).is_some() {
                assert!(other.bake().unwrap() != file);
                edited += 1;
            }
        }
        assert_eq!(edited, if golden.stretches { 3 } else { 1 });
    }
}

#[test]
fn files_are_replaced_whole_or_not_at_all() {
    let folder = std::env::temp_dir().join(format!("sinew-golden-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("model.snw");
    for content in [b"old".as_slice(), b"new and longer"] {
        files::write(&path, content).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), content);
    }
    // A folder has the file's name, so the rename fails and must leave nothing behind.
    let taken = folder.join("taken");
    std::fs::create_dir_all(taken.join("full")).unwrap();
    assert!(files::write(&taken, b"x").is_err());
    assert!(files::write(&folder.join("missing/model.snw"), b"x").is_err());
    let mut left = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name());
    assert!(left.all(|name| name == "model.snw" || name == "taken"));
    std::fs::remove_dir_all(&folder).unwrap();
}
