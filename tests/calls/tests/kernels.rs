//! Kernels: descriptions, results with the runtime's bits, and refused calls.

use crate::handles::{Kernel, Loaded, NONE, done, get, name, unwritten};
use models::{KernelContent, Pieces, Rng};
use sinew_capi::*;
use sinew_runtime::{KernelMap, Model};

/// Runs a test on two kernels of a file, each opened through C and by the runtime.
fn each(test: impl Fn(&Kernel, KernelMap<'_>)) {
    let every = KernelContent::every(sinew_runtime::kernel::Kernel::Matern32);
    let file = Pieces::kernels(&[KernelContent::servo(), every]).bytes();
    let (loaded, model) = (Loaded::new(&file), Model::from_bytes(&*file).unwrap());
    for (index, expected) in model.all::<KernelMap>().enumerate() {
        test(&loaded.kernel(None, index).unwrap(), expected);
    }
}

/// A function that computes numbers from a query.
type Call = unsafe extern "C" fn(
    *const sinew_kernel,
    *const f32,
    usize,
    *mut f32,
    usize,
    *mut f32,
    usize,
    *mut sinew_error,
) -> sinew_status;

fn run(
    kernel: &Kernel,
    call: Call,
    query: &[f32],
    scratch_len: usize,
    len: usize,
) -> Result<Vec<f32>, sinew_error> {
    let (mut scratch, mut out) = (vec![f32::NAN; scratch_len], vec![f32::NAN; len]);
    let mut error = unwritten();
    let (at, room, out_error) = (scratch.as_mut_ptr(), out.as_mut_ptr(), &raw mut error);
    let (k, q) = (kernel.handle, query.as_ptr());
    // SAFETY: an open kernel and three arrays with their lengths, and a structure to be written.
    match unsafe { call(k, q, query.len(), at, scratch_len, room, len, out_error) } {
        sinew_status::Ok => Ok(out),
        status => {
            assert!(error.status == status && out.iter().all(|x| x.is_nan()));
            Err(error)
        }
    }
}

fn evaluate(kernel: &Kernel, query: &[f32]) -> (Vec<f32>, f32) {
    let info = kernel.info();
    let (mut scratch, mut out) =
        (vec![f32::NAN; info.scratch_len], vec![f32::NAN; info.result_len]);
    let mut confidence = f32::NAN;
    let (k, q, c) = (kernel.handle, query.as_ptr(), &raw mut confidence);
    let (at, room) = (scratch.as_mut_ptr(), out.as_mut_ptr());
    let lens = (info.scratch_len, info.result_len);
    // SAFETY: an open kernel, three arrays with their lengths, one value to be written.
    done(unsafe { sinew_kernel_evaluate(k, q, query.len(), at, lens.0, room, lens.1, c, NONE) });
    (out, confidence)
}

#[test]
fn kernels_are_described() {
    each(|found, expected| {
        let (info, counts, fit) = (found.info(), expected.counts(), expected.fit());
        assert_eq!(name(info.name, info.name_len), expected.name());
        assert_eq!(info.part as usize, expected.part());
        assert_eq!(info.kernel, u32::from(expected.rule().kernel.number()));
        assert_eq!(
            [info.input_len, info.output_len],
            [counts.input_len, counts.output_len].map(|x| x as usize)
        );
        assert_eq!(
            [info.query_len, info.result_len],
            [expected.query_len(), expected.result_len()]
        );
        assert_eq!(info.value_len, counts.value_len as usize);
        assert_eq!(info.scratch_len, counts.scratch_len());
        assert_eq!(info.jacobian_scratch_len, counts.jacobian_scratch_len());
        assert_eq!(info.variance_scratch_len, counts.variance_scratch_len());
        assert_eq!(info.has_variance == 1, expected.has_variance());
        let own = info.fit;
        let figures =
            [own.rms_residual, own.left_out_rms, own.rounding_error, own.reciprocal_condition];
        assert_eq!(figures, fit.figures());
        for (i, input) in expected.inputs().enumerate() {
            // SAFETY: an open kernel and one structure to be written.
            let found = get(|out| unsafe { sinew_kernel_input(found.handle, i, out, NONE) });
            assert_eq!(Some(name(found.name, found.name_len)), expected.input_name(i));
            assert_eq!(found.kind, u32::from(input.kind.number()));
            assert_eq!(found.number_len, input.kind.number_len());
        }
        for (o, output) in expected.outputs().enumerate() {
            // SAFETY: the same.
            let found = get(|out| unsafe { sinew_kernel_output(found.handle, o, out, NONE) });
            assert_eq!(Some(name(found.name, found.name_len)), expected.output_name(o));
            assert_eq!(found.kind, u32::from(output.kind.number()));
            assert_eq!(found.number_len, output.kind.number_len());
        }
    });
}

#[test]
fn evaluation_has_the_bits_of_the_runtime() {
    each(|found, expected| {
        let (counts, info) = (expected.counts(), found.info());
        let mut random = Rng(9);
        for _ in 0..10 {
            let query: Vec<f32> = (0..info.query_len).map(|_| random.unit()).collect();
            let mut scratch = vec![0.0; info.jacobian_scratch_len.max(info.variance_scratch_len)];
            let mut out = vec![0.0; info.result_len];
            let confidence = expected.evaluate(&query, &mut scratch, &mut out).unwrap();
            assert_eq!(evaluate(found, &query), (out.clone(), confidence));
            assert_eq!(evaluate(&found.moved(), &query), (out, confidence));
            let (m, r) = (info.value_len, info.query_len);
            let mut out = vec![0.0; m * r];
            expected.jacobian(&query, &mut scratch, &mut out).unwrap();
            let len = counts.jacobian_scratch_len();
            assert_eq!(run(found, sinew_kernel_jacobian, &query, len, m * r).unwrap(), out);
            let mut out = vec![0.0; m];
            let by_rust =
                expected.variance(&query, &mut scratch, &mut out).map_err(sinew_error::from);
            let by_c = run(found, sinew_kernel_variance, &query, counts.variance_scratch_len(), m);
            assert_eq!(by_c, by_rust.map(|()| out));
        }
    });
}

#[test]
fn kernels_are_opened_by_name_and_number_and_refused() {
    let file = Pieces::kernels(&[KernelContent::servo(), KernelContent::servo()]).bytes();
    let mut model = Loaded::new(&file);
    assert_eq!(model.kernel(Some("servo"), 1).unwrap().info().part, 1);
    for (name, index) in [(None, 2), (Some("arm"), 0), (Some("servo"), 2)] {
        assert_eq!(model.kernel(name, index).err(), Some(sinew_status::NotFound), "{name:?}");
    }
    let kernel = model.kernel(None, 0).unwrap();
    let info = kernel.info();
    assert_eq!((info.query_len, info.has_variance), (6, 0));
    let refused = |query: &[f32]| {
        run(&kernel, sinew_kernel_jacobian, query, info.jacobian_scratch_len, 6).unwrap_err()
    };
    let plain = sinew_error {
        status: sinew_status::ZeroRotation,
        argument: sinew_argument::Query,
        part: SINEW_NO_PART,
        section: 0,
        index: 2,
        expected: 0,
        found: 0,
    };
    assert_eq!(refused(&[0.5, 0.5, 0.0, 0.0, 0.0, 0.0]), plain);
    let not_finite = sinew_error { status: sinew_status::NonFinite, index: 1, ..plain };
    assert_eq!(refused(&[0.5, f32::NAN, 0.0, 0.0, 0.0, 0.0]), not_finite);
    let length =
        sinew_error { status: sinew_status::Length, index: 0, expected: 6, found: 1, ..plain };
    assert_eq!(refused(&[0.5]), length);
    let mut error = plain;
    let mut out = std::mem::MaybeUninit::uninit();
    for (call, argument) in [
        (sinew_kernel_input as unsafe extern "C" fn(_, _, _, _) -> _, sinew_argument::Input),
        (sinew_kernel_output, sinew_argument::Output),
    ] {
        // SAFETY: an open kernel and two structures to be written.
        let status = unsafe { call(kernel.handle, 9, out.as_mut_ptr(), &raw mut error) };
        let most = if argument == sinew_argument::Input { 2 } else { 0 };
        let (expected_status, index) = (sinew_status::OutOfRange, 0);
        let expected_error = sinew_error {
            status: expected_status,
            argument,
            index,
            expected: most,
            found: 9,
            ..plain
        };
        assert_eq!((status, error), (expected_status, expected_error));
    }
    // Loads another file into the model's memory.
    let other =
        Pieces::kernels(&[KernelContent::plain(sinew_runtime::kernel::Kernel::Cubic, [1, 1, 1])]);
    let other = other.bytes();
    done(model.load(&other));
    let stale = refused(&[0.5; 6]);
    assert_eq!((stale.status, stale.argument), (sinew_status::Stale, sinew_argument::Kernel));
}
