//! A prior of a real take: ICT FaceKit driven by ARKit weights, by the protocol of METHOD §5.1.

use super::common::*;
use models::shared;
use sinew_runtime::prior::{Anchor, Pin};
use sinew_trainer::envelope::model::{Shapes, SkinModel};
use sinew_trainer::face::prior::{learned, pairs, slider};
use sinew_trainer::face::source::{Source, read};
use sinew_trainer::face::take;

/// One vertex of the head in this many is in the face of this test.
const EVERY: usize = 16;

#[test]
fn a_prior_of_one_half_of_a_take_beats_the_slider_norm_on_the_other() {
    let (Some(head), Some(take)) =
        (shared("ict-facekit/ict_head.npz"), shared("arkit-rom/alex_rom_3.csv"))
    else {
        return;
    };
    let Source::Shapes(basis) = read(&head).unwrap() else { panic!("a face with shapes") };
    let names = basis.names();
    let take = take::read(&take, &names).unwrap();
    let face_len = 6706;
    let kept: Vec<usize> = (0..face_len).step_by(EVERY).collect();
    let pick = |all: &[[f64; 3]]| -> Vec<[f64; 3]> { kept.iter().map(|v| all[*v]).collect() };
    let skin = SkinModel {
        name: "face".to_owned(),
        envelope: None,
        rest_positions: pick(&basis.mesh.positions),
        rest_normals: vec![[0.0, 0.0, 1.0]; kept.len()],
        rest_tangents: None,
        influences: Vec::new(),
        tangent_coefficients: None,
        normal_errors: None,
        ranges: Vec::new(),
        shapes: Shapes {
            deltas: basis.mesh.shapes.iter().map(|shape| pick(&shape.deltas)).collect(),
            slopes: vec![vec![[0.0; 2]; kept.len()]; names.len()],
            names: names.clone(),
            ..Shapes::default()
        },
    };
    let pairs = pairs(&names, &skin.shapes.deltas);
    let of = |pair: [usize; 2]| pair.map(|shape| names[shape].as_str());
    let cancelling: Vec<_> = pairs.cancelling.iter().map(|pair| of(*pair)).collect();
    assert_eq!(cancelling, [["jawLeft", "jawRight"], ["mouthLeft", "mouthRight"]]);
    assert!(pairs.mirrored.iter().any(|pair| of(*pair) == ["eyeBlink_L", "eyeBlink_R"]));
    let half = take.frames.len() / 2;
    let (first, second) = take.frames.split_at(half);
    let bounds = vec![[0.0, 1.0]; names.len()];
    let prior = learned(first, bounds.clone(), &pairs, 0.02);
    let faces = [Face::of(skin.clone(), prior), Face::of(skin, slider(bounds, 0.02))];
    let neutral = vec![0.0; names.len()];
    // Handles far apart, the same in every frame.
    let handles: Vec<u32> = (0..8).map(|i| (i * kept.len() / 8 + 11) as u32).collect();
    let (mut errors, mut frames, mut outside) = ([0.0f64; 3], 0, 0);
    for weights in second.iter().skip(20).step_by(100) {
        let truth = faces[0].moved(weights);
        let pins: Vec<Pin> =
            handles.iter().map(|&v| Pin::new(v, truth[v as usize].map(|x| x as f32))).collect();
        let cases =
            [(0, false, Anchor::Mean), (1, false, Anchor::Current), (0, true, Anchor::Mean)];
        for (error, (face, is_bounded, anchor)) in errors.iter_mut().zip(cases) {
            let (found, edit) = faces[face]
                .solve(&pins, &neutral, |job| (job.anchor, job.is_bounded) = (anchor, is_bounded))
                .unwrap();
            assert!(edit.is_least && edit.round_len < 40, "{edit:?}");
            let is_in = |w: &f64| (0.0..=1.0).contains(w);
            outside += usize::from(!is_bounded && !found.iter().all(is_in));
            assert!(!is_bounded || found.iter().all(is_in));
            let apart = faces[face].moved(&found);
            let each = apart
                .iter()
                .zip(&truth)
                .map(|(a, b)| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>());
            *error += each.sum::<f64>() / kept.len() as f64;
        }
        frames += 1;
    }
    let [prior, slider, bounded] = errors.map(|sum| (sum / f64::from(frames)).sqrt());
    println!("{frames} frames: prior {prior:.4}, slider {slider:.4}, bounded {bounded:.4} cm");
    assert!(prior < 0.6 * slider, "{prior} {slider}");
    assert!(bounded < 1.05 * prior, "{bounded} {prior}");
    assert!(outside > 0, "bounds are needed");
}
