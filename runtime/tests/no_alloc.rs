//! Loading and evaluating allocate nothing.
#![allow(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod common;

use common::{Builder, SMALL, random_pose};
use sinew_runtime::envelope::{Attribute, Buffer, SkinJob};
use sinew_runtime::format::Predictor;
use sinew_runtime::{LocalTransform, Model, model_space_pose};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: every call goes to the system's allocator unchanged; counting touches a plain cell.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        // SAFETY: the caller's promise is passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise is passed on.
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn allocations(work: impl FnOnce()) -> usize {
    let before = ALLOCATIONS.with(Cell::get);
    work();
    ALLOCATIONS.with(Cell::get) - before
}

#[test]
fn nothing_is_allocated() {
    Predictor::ALL.into_iter().for_each(evaluate);
}

fn evaluate(predictor: Predictor) {
    let bytes = Builder::of(predictor, SMALL).bytes();
    let envelope = Model::from_bytes(&bytes).unwrap().envelope().unwrap();
    let v = envelope.vertex_len();
    let mut pose = random_pose(&envelope, &mut common::Rng(1), 0.5);
    let local = vec![
        LocalTransform { rotation: [0.0, 0.0, 0.6, 0.8], translation: [0.0; 3] };
        envelope.joint_len()
    ];
    let mut workspace = vec![0.0; envelope.workspace_len()];
    let mut palette = vec![common::IDENTITY; envelope.palette_len()];
    let (mut a, mut b) = (vec![0.0; 6 * v], vec![0.0; 4 * v]);
    let count = allocations(|| {
        let envelope = Model::from_bytes(&bytes).unwrap().envelope_named("arm").unwrap();
        model_space_pose(&envelope, &local, &mut pose).unwrap();
        let confidence = envelope.palette(&pose, &mut workspace, &mut palette).unwrap();
        assert!(confidence.is_finite());
        assert_eq!(envelope.group(0).is_some(), predictor.corrects());
        envelope.bounds(&palette).unwrap();
        SkinJob {
            envelope,
            palette: &palette,
            vertices: 0..v,
            positions: Some(Attribute { buffer: Buffer::A, offset: 0, stride: 6 }),
            normals: Some(Attribute { buffer: Buffer::A, offset: 3, stride: 6 }),
            tangents: Some(Attribute { buffer: Buffer::B, offset: 0, stride: 4 }),
            out_a: &mut a,
            out_b: &mut b,
        }
        .run()
        .unwrap();
        assert!(Model::from_bytes(&bytes[1..]).is_err());
    });
    assert_eq!(count, 0);
}

#[test]
fn the_counter_counts() {
    assert_eq!(allocations(|| drop(std::hint::black_box(vec![1u8]))), 1);
}
