//! A model owns its bytes in any storage: it can be stored, shared and replaced.

use crate::common::{bits, palette, random_pose, skinned};
use models::{Pieces, Rng};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::{CHECKSUM_OFFSET, FileId, SectionKind};
use sinew_runtime::{Envelope, Model, Skin};
use std::sync::{Arc, Barrier, RwLock};
use std::thread;

/// A sample with names and numbers of its version.
pub(crate) fn version(number: u8) -> Vec<u8> {
    let mut pieces = Pieces::small(Predictor::Kernel);
    pieces.section(SectionKind::Names)[4 * 5] = b'a' + number;
    pieces.set_float(SectionKind::RestBoxes, 0, -3.0 - f32::from(number));
    pieces.bytes()
}

#[test]
fn a_model_is_kept_in_any_bytes() {
    fn evaluated<B: AsRef<[u8]>>(bytes: B) -> Vec<u32> {
        let model = Model::from_bytes(bytes).unwrap();
        let (envelope, skin) = (model.first::<Envelope>().unwrap(), model.first::<Skin>().unwrap());
        let palette = palette(&envelope, &random_pose(&envelope, &mut Rng(5), 0.3));
        bits(&skinned(skin, &palette))
    }
    let bytes = version(0);
    let expected = evaluated(bytes.as_slice());
    assert_eq!(evaluated(bytes.clone()), expected);
    assert_eq!(evaluated(bytes.clone().into_boxed_slice()), expected);
    assert_eq!(evaluated(Arc::<[u8]>::from(bytes.as_slice())), expected);
    assert_eq!(evaluated(std::borrow::Cow::Borrowed(bytes.as_slice())), expected);
    // A copy of a model over shared bytes shares the bytes.
    let model = Model::from_bytes(Arc::<[u8]>::from(bytes)).unwrap();
    let copy = model.clone();
    assert!(Arc::ptr_eq(&model.into_bytes(), &copy.into_bytes()));
}

#[test]
fn a_model_is_replaced_while_another_thread_uses_it() {
    const VERSIONS: u8 = 8;
    let load = |number| Arc::new(Model::from_bytes(version(number)).unwrap());
    let stored: RwLock<Arc<Model<Vec<u8>>>> = RwLock::new(load(0));
    let turn = Barrier::new(2);
    let pose = random_pose(&load(0).first::<Envelope>().unwrap(), &mut Rng(5), 0.3);
    let evaluate = |model: &Model<Vec<u8>>| {
        let (envelope, skin) = (model.first::<Envelope>().unwrap(), model.first::<Skin>().unwrap());
        bits(&skinned(skin, &palette(&envelope, &pose)))
    };
    thread::scope(|scope| {
        let user = scope.spawn(|| {
            for number in 0..VERSIONS {
                let held = stored.read().unwrap().clone();
                let before = evaluate(&held);
                // Now the other thread replaces the model, and drops the old one.
                turn.wait();
                turn.wait();
                assert_eq!(evaluate(&held), before);
                let name = [b'a' + number, b'r', b'm'];
                assert_eq!(held.first::<Envelope>().unwrap().name().as_bytes(), name);
                assert_eq!(Arc::strong_count(&held), 1, "this thread alone still has it");
            }
        });
        for number in 1..=VERSIONS {
            turn.wait();
            *stored.write().unwrap() = load(number);
            turn.wait();
        }
        user.join().unwrap();
    });
    assert_eq!(stored.into_inner().unwrap().first::<Envelope>().unwrap().name(), "irm");
}

#[test]
fn a_layout_opens_only_its_own_file() {
    let (bytes, other) = (version(0), version(1));
    let model = Model::from_bytes(bytes.as_slice()).unwrap();
    let (envelope, skin) = (model.first::<Envelope>().unwrap(), model.first::<Skin>().unwrap());
    let (envelope_layout, skin_layout) = (envelope.layout(), skin.layout());
    assert_eq!((envelope.file(), skin.file()), (model.id(), model.id()));
    assert_eq!(FileId::of(&bytes), Some(model.id()));
    let pose = random_pose(&envelope, &mut Rng(5), 0.3);
    let expected = skinned(skin, &palette(&envelope, &pose));
    let opened = |file: &[u8]| {
        let (envelope, skin) =
            (envelope_layout.open::<Envelope>(file), skin_layout.open::<Skin>(file));
        assert_eq!(envelope.is_some(), skin.is_some());
        Some(skinned(skin?, &palette(&envelope?, &pose)))
    };
    // Equal bytes in another place, as after reloading a file, are the same file.
    assert_eq!(opened(&bytes.clone()).as_ref(), Some(&expected));
    assert_eq!(bytes.len(), other.len());
    assert_eq!(opened(&other), None, "as long, but with other bytes");
    assert_eq!(opened(&bytes[..bytes.len() - 1]), None, "shorter");
    assert_eq!(opened(&[&bytes[..], &[0]].concat()), None, "longer");
    for len in 0..CHECKSUM_OFFSET + 4 {
        assert_eq!(opened(&bytes[..len]), None);
        assert_eq!(FileId::of(&bytes[..len]), None);
    }
    let mut states_another = bytes.clone();
    states_another[CHECKSUM_OFFSET + 3] ^= 1;
    assert_eq!(opened(&states_another), None);
    assert!(envelope_layout.open::<Skin>(&bytes).is_none(), "a part of another kind");
    assert!(skin_layout.open::<Envelope>(&bytes).is_none(), "a part of another kind");
}
