//! Priors: descriptions, results with the runtime's bits, and refused calls.

use crate::handles::{Loaded, NONE, done, get, name};
use models::Pieces;
use sinew_capi::*;
use sinew_runtime::prior::{Anchor, Temporal};
use sinew_runtime::{Model, Pin, PinJob, Pins, Prior, Skin};
use std::ptr::{null, null_mut};

#[test]
fn a_prior_has_the_runtimes_description_and_bits() {
    let file = Pieces::face().bytes();
    let (loaded, model) = (Loaded::new(&file), Model::from_bytes(&*file).unwrap());
    let (expected, skin) = (model.first::<Prior>().unwrap(), model.first::<Skin>().unwrap());
    let opened = loaded.open::<sinew_prior>(sinew_part_kind::Prior, None, 0).unwrap();
    let prior = opened.handle;
    // SAFETY: an open prior and a structure to be written.
    let info = get(|out| unsafe { sinew_prior_describe(prior, out, NONE) });
    assert_eq!(name(info.name, info.name_len), "prior");
    assert_eq!((info.part, info.skin_part, info.shape_len), (1, 0, 8));
    assert_eq!((info.symmetry_len, info.cancel_len), (1, 1));
    let fit = [info.beta, info.frames, info.error, info.slider_error];
    assert_eq!(fit, expected.fit().figures());
    let scratch_len = info.scratch_len + 6 * info.scratch_len_each;
    assert_eq!(scratch_len, expected.counts().pin_scratch_len(6));

    let own = loaded.skin(None, 0).unwrap();
    let start = [0.25f32; 8];
    let pins = [2u32, 7].map(|vertex| {
        let mut place = [f32::NAN; 3];
        // SAFETY: an open skin, no palette, weights with their length, and room for a position.
        done(unsafe {
            sinew_skin_place(own.handle, vertex, null(), 0, start.as_ptr(), 8, &raw mut place, NONE)
        });
        assert_eq!(Some(place), skin.place(vertex, &[], &start));
        Pin::new(vertex, place.map(|x| x + 0.125)).with_stiffness(1.5)
    });
    let mut list = Pins::<2>::new();
    pins.iter().for_each(|pin| list.add(*pin).unwrap());
    let last = [0.5f32; 8];
    let run = PinJob {
        anchor: Anchor::Mean,
        temporal: Some(Temporal { weights: &last, stiffness: 3.0 }),
        symmetry: 2.0,
        cancels: true,
        ..PinJob::new(expected, skin, list.list())
    };
    let mut weights = start;
    let edit = run.run(&mut vec![0.0; scratch_len], &mut weights).unwrap();

    let given = pins.map(|Pin { vertex, rows, target, stiffness }| sinew_pin {
        vertex,
        rows,
        target,
        stiffness,
    });
    let (mut scratch, mut found) = (vec![0.0; scratch_len], start);
    let job = sinew_pin_job {
        prior,
        skin: own.handle,
        palette: null(),
        palette_len: 0,
        pins: given.as_ptr(),
        pins_len: 2,
        is_from_mean: 1,
        is_bounded: 1,
        cancels: 1,
        beta: info.beta,
        symmetry: 2.0,
        temporal: 3.0,
        last_weights: last.as_ptr(),
        last_len: 8,
        scratch: scratch.as_mut_ptr(),
        scratch_len,
        weights: found.as_mut_ptr(),
        weights_len: 8,
    };
    let mut result = sinew_edit { norm: 0.0, unreachable_len: 9, round_len: 0, is_least: 0 };
    // SAFETY: a job of open handles and arrays with their lengths, and a structure to be written.
    done(unsafe { sinew_pins_solve(&raw const job, &raw mut result, NONE) });
    assert_eq!(found, weights);
    assert_ne!(found, start);
    let expected =
        (edit.norm, edit.unreachable_len as u32, edit.round_len, u32::from(edit.is_least));
    assert_eq!((result.norm, result.unreachable_len, result.round_len, result.is_least), expected);

    let before = found;
    let refused = |edit: &dyn Fn(&mut sinew_pin_job)| {
        let mut other = job;
        edit(&mut other);
        // SAFETY: as above, except for the field that the call refuses.
        unsafe { sinew_pins_solve(&raw const other, null_mut(), NONE) }
    };
    assert_eq!(refused(&|job| job.prior = null()), sinew_status::Null);
    assert_eq!(refused(&|job| job.palette_len = 1), sinew_status::Null);
    assert_eq!(refused(&|job| job.weights_len = 7), sinew_status::Length);
    assert_eq!(refused(&|job| job.scratch_len -= 1), sinew_status::TooShort);
    assert_eq!(refused(&|job| job.beta = 0.0), sinew_status::OutOfRange);
    assert_eq!(refused(&|job| job.last_weights = job.weights), sinew_status::Overlap);
    assert_eq!(found, before);
}
