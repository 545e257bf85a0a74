//! Pins on a posed skin: rows act on M U, where M is the vertex's transform.

use super::common::*;
use sinew_runtime::prior::{Anchor, Pin, PinJob, Pins};
use sinew_runtime::skin::{Output, ShapesJob, SkinJob};
use sinew_runtime::{Envelope, Matrix3x4, Model, Prior, Skin};
use sinew_trainer::envelope::model::{EnvelopeModel, FileModel, SkinModel};
use sinew_trainer::face::prior::slider;
use std::path::Path;

/// Makes a palette of transforms that rotate, stretch and shift.
fn palette(len: usize) -> Vec<Matrix3x4> {
    let mut numbers = Numbers::new(5);
    let mut row = |i: usize| {
        let [a, b, c, d] = [(); 4].map(|()| 0.4 * numbers.next() as f32);
        let mut row = [a, b, c, 5.0 * d];
        row[i] += 1.0;
        row
    };
    (0..len).map(|_| [0, 1, 2].map(&mut row)).collect()
}

#[test]
fn a_pinned_vertex_goes_where_the_pin_is_and_the_pose_stays() {
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/golden/shapes-11-f32.snw");
    let bytes = std::fs::read(golden).unwrap();
    let golden = Model::from_bytes(&bytes).unwrap();
    let bounds = vec![[0.0, 1.0]; golden.first::<Skin>().unwrap().shape_len()];
    let file = FileModel {
        envelopes: golden
            .all::<Envelope>()
            .map(|envelope| EnvelopeModel::from_file(&envelope))
            .collect(),
        skins: golden.all::<Skin>().map(|skin| SkinModel::from_file(&skin)).collect(),
        priors: vec![slider(bounds, 0.01)],
        ..FileModel::default()
    };
    let file = file.bake().unwrap();
    let model = Model::from_bytes(&file).unwrap();
    let (prior, skin) = (model.first::<Prior>().unwrap(), model.first::<Skin>().unwrap());
    let palette = palette(skin.palette_len());
    let (v, n) = (skin.vertex_len(), skin.shape_len());
    let posed = |weights: &[f32]| {
        let mut rest = vec![[0.0f32; 3]; v];
        let positions = Output::new(rest.as_flattened_mut(), 3);
        ShapesJob::new(skin, weights).positions(positions).run().unwrap();
        let mut posed = vec![[0.0f32; 3]; v];
        SkinJob::new(skin, &palette)
            .rest_positions(&rest)
            .positions(Output::new(posed.as_flattened_mut(), 3))
            .run()
            .unwrap();
        posed
    };
    let now = vec![0.25f32; n];
    let before = posed(&now);
    for (vertex, x) in before.iter().enumerate() {
        let place = skin.place(vertex as u32, &palette, &now).unwrap();
        assert!((0..3).all(|i| (place[i] - x[i]).abs() < 1e-5), "{vertex}: {place:?} {x:?}");
    }
    // Vertices that several shapes move: two coordinates of one vertex, all of another.
    let moved = |vertex: usize| skin.deltas_of(vertex).count();
    let busy: Vec<usize> = (0..v).filter(|vertex| moved(*vertex) >= 4).collect();
    let [a, b] = [busy[2], busy[busy.len() - 1]];
    let mut pins = Pins::<2>::new();
    let target = |x: [f32; 3], by: [f32; 3]| [0, 1, 2].map(|i| x[i] + by[i]);
    let goals = [target(before[a], [0.05, -0.04, 0.06]), target(before[b], [0.03, 0.0, -0.02])];
    pins.add(Pin::new(a as u32, goals[0])).unwrap();
    pins.add(Pin::new(b as u32, goals[1]).masked([true, false, true])).unwrap();
    let mut scratch = vec![0.0; prior.counts().pin_scratch_len(5)];
    let mut weights = now.clone();
    let job = PinJob {
        palette: &palette,
        anchor: Anchor::Current,
        beta: 1e-10,
        is_bounded: false,
        ..PinJob::new(prior, skin, pins.list())
    };
    let edit = job.run(&mut scratch, &mut weights).unwrap();
    assert!(edit.norm > 0.0 && edit.unreachable_len == 0);
    let after = posed(&weights);
    let off = |x: f32, y: f32| (x - y).abs();
    assert!((0..3).all(|i| off(after[a][i], goals[0][i]) < 1e-4), "{:?} {goals:?}", after[a]);
    assert!([0, 2].iter().all(|&i| off(after[b][i], goals[1][i]) < 1e-4));
    // Control: rows of the rest pose miss the targets.
    let mut other = now.clone();
    let identity = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    let rest = vec![identity; palette.len()];
    PinJob { palette: &rest, ..job }.run(&mut scratch, &mut other).unwrap();
    assert!((0..3).any(|i| off(posed(&other)[a][i], goals[0][i]) > 1e-2));
}
