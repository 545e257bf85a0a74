//! The head of ICT FaceKit, driven by a captured performance: the first half trains, the second
//! half tests.

use crate::face::{head, loaded, trained};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew_runtime::prior::{Anchor, Pin, PinJob, Temporal};
use sinew_trainer::face::baked::BakedFace;
use sinew_trainer::face::evaluate::{DRAWS, Gram, Protocol, roughness};
use sinew_trainer::face::train::sliders;
use std::ops::Range;

/// Half of the take, and the vertices of the narrow face.
const HALF: usize = 2015;
const FACE: Range<usize> = 0..6706;

#[test]
fn a_few_handles_reach_the_promised_errors() {
    let Some((basis, take)) = head() else { return };
    assert_eq!((take.frames.len(), basis.landmarks.len()), (4030, 68));
    assert_eq!(take.skipped.len(), 10, "{:?}", take.skipped);
    let model = trained(&basis, &take.frames[..HALF]);
    let [slider, slider_mean] = sliders(&model).unwrap();
    let face = loaded(&model);
    let evaluation = Protocol {
        face: BakedFace::open(&face).unwrap(),
        slider: BakedFace::open(&slider).unwrap(),
        slider_mean: BakedFace::open(&slider_mean).unwrap(),
        landmarks: &basis.landmarks,
        vertices: FACE,
        chosen_on: take.pick(&(0..HALF), 20, 25).unwrap(),
        frames: take.pick(&(HALF..4030), 20, 25).unwrap(),
        lost_frames: 0,
    }
    .run(&[3, 5, 8, 12])
    .unwrap();
    for (handles, row) in &evaluation.handles {
        let [of_zero, of_mean] = if *handles < 8 { [0.55, 0.70] } else { [0.42, 0.60] };
        assert!(row.slider < row.nothing, "{handles}: {row:?}");
        assert!(row.prior <= of_zero * row.slider, "{handles}: {row:?}");
        assert!(row.prior <= of_mean * row.slider_mean, "{handles}: {row:?}");
        assert!(row.bounded <= 1.05 * row.prior, "{handles}: {row:?}");
        assert_eq!(row.methods["bounded"].outside, 0.0);
        assert!(row.methods["prior"].outside > 0.0, "without bounds some leave them");
    }
    // The error without pins must equal a sum over the file's arrays.
    let nothing = evaluation.handles[&3].nothing;
    let rms = rms_of_vertices(&basis, &take.pick(&(HALF..4030), 20, 25).unwrap());
    assert!((nothing - rms).abs() < 1e-4 * rms, "{nothing}, {rms}");
}

/// Measures the RMS displacement of the face over frames, by vertex.
fn rms_of_vertices(basis: &sinew_trainer::face::basis::Basis, frames: &[&[f64]]) -> f64 {
    let mut sum = 0.0;
    for frame in frames {
        for vertex in FACE {
            for axis in 0..3 {
                let moved = basis.mesh.shapes.iter().zip(*frame);
                let moved: f64 = moved.map(|(shape, z)| z * shape.deltas[vertex][axis]).sum();
                sum += moved * moved;
            }
        }
    }
    (sum / (frames.len() * FACE.len()) as f64).sqrt()
}

#[test]
fn shapes_that_a_take_never_used_can_move() {
    let Some((basis, mut take)) = head() else { return };
    let shape = |name: &str| basis.names().iter().position(|own| own == name).unwrap();
    let [left, right] = ["jawLeft", "jawRight"].map(shape);
    for frame in &mut take.frames[..HALF] {
        (frame[left], frame[right]) = (0.0, 0.0);
    }
    let model = loaded(&trained(&basis, &take.frames[..HALF]));
    let face = BakedFace::open(&model).unwrap();
    let gram = Gram::new(&face, FACE);
    let mut truth = vec![0.0; basis.mesh.shapes.len()];
    truth[left] = 1.0;
    let options = PinJob { is_bounded: false, ..face.edit() };
    let dragged = |vertices: &[usize]| -> Vec<f64> {
        let pin =
            |&vertex: &usize| Pin::new(vertex as u32, face.place(vertex, &truth).map(|x| x as f32));
        let pins: Vec<Pin> = vertices.iter().map(pin).collect();
        let mut weights = vec![0.0; truth.len()];
        face.solve(&pins, &options, &mut Vec::new(), &mut weights).unwrap();
        weights.into_iter().map(f64::from).collect()
    };
    let rest = vec![0.0; truth.len()];
    let nothing = gram.mean_square(&rest, &truth).sqrt();
    assert!((0.25..0.35).contains(&nothing), "{nothing}");
    let mut sum = 0.0;
    for draw in 0..DRAWS {
        let handles = drawn(&basis.landmarks, 8, draw);
        sum += gram.mean_square(&dragged(&handles), &truth).sqrt() / DRAWS as f64;
    }
    assert!(sum <= 0.15, "{sum}");
    let apart = |a: [f64; 3], b: [f64; 3]| {
        (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt()
    };
    let way = |vertex: usize| apart(face.place(vertex, &truth), face.place(vertex, &rest));
    let farthest = (0..face.skin.vertex_len()).max_by(|a, b| way(*a).total_cmp(&way(*b))).unwrap();
    let weights = dragged(&[farthest]);
    let left_over = apart(face.place(farthest, &weights), face.place(farthest, &truth));
    assert!(left_over <= 0.1 * way(farthest), "{left_over} of {}", way(farthest));
}

#[test]
fn a_track_with_noise_is_followed_smoothly() {
    let Some((basis, take)) = head() else { return };
    let model = loaded(&trained(&basis, &take.frames[..HALF]));
    let face = BakedFace::open(&model).unwrap();
    let gram = Gram::new(&face, FACE);
    let landmarks = drawn(&basis.landmarks, 12, 0);
    let mut random = ChaCha8Rng::seed_from_u64(1);
    // Normal numbers by Box and Muller.
    let mut noise = || {
        let [u, v]: [f64; 2] = [random.random(), random.random()];
        0.1 * (-2.0 * (1.0 - u).ln()).sqrt() * (std::f64::consts::TAU * v).cos()
    };
    let observed: Vec<Vec<Pin>> = take.frames[HALF..]
        .iter()
        .map(|frame| {
            let pin = |&vertex: &usize| {
                let place = face.place(vertex, frame);
                Pin::new(vertex as u32, place.map(|x| (x + noise()) as f32))
            };
            landmarks.iter().map(pin).collect()
        })
        .collect();
    let solved = |plain: bool| -> Vec<Vec<f64>> {
        let mut last: Vec<f32> =
            (0..face.skin.shape_len()).filter_map(|shape| face.prior.mean(shape)).collect();
        let mut scratch = Vec::new();
        let mut out = Vec::new();
        for pins in &observed {
            let mut weights = last.clone();
            let own = PinJob { anchor: Anchor::Mean, beta: 0.01, ..face.edit() };
            let options = match plain {
                true => own,
                false => PinJob {
                    temporal: Some(Temporal { weights: &last, stiffness: 50.0 }),
                    symmetry: 0.1,
                    cancels: true,
                    ..own
                },
            };
            face.solve(pins, &options, &mut scratch, &mut weights).unwrap();
            last.clone_from(&weights);
            out.push(weights.into_iter().map(f64::from).collect());
        }
        out
    };
    let rms = |frames: &[Vec<f64>]| {
        let squares = frames.iter().zip(&take.frames[HALF..]).map(|(a, b)| gram.mean_square(a, b));
        (squares.sum::<f64>() / frames.len() as f64).sqrt()
    };
    let (plain, tracked) = (solved(true), solved(false));
    let [of_plain, of_tracked] = [&plain, &tracked].map(|frames| (rms(frames), roughness(frames)));
    assert!(of_tracked.0 <= of_plain.0, "{of_tracked:?}, {of_plain:?}");
    assert!(of_tracked.1 <= 0.5 * of_plain.1, "{of_tracked:?}, {of_plain:?}");
    let pairs: Vec<[usize; 2]> = face.prior.cancel_pairs().collect();
    assert_eq!(pairs.len(), 2, "the jaw and the mouth");
    let both = |frames: &[Vec<f64>]| {
        let least = frames.iter().flat_map(|w| pairs.iter().map(|[a, b]| w[*a].min(w[*b])));
        least.fold(0.0, f64::max)
    };
    assert!(both(&tracked) <= 0.01, "{}", both(&tracked));
    assert!(both(&plain) > 0.01, "without it some are");
}

/// Draws some of the landmarks.
fn drawn(landmarks: &[usize], count: usize, draw: u64) -> Vec<usize> {
    let mut random = ChaCha8Rng::seed_from_u64(draw);
    let mut left = landmarks.to_vec();
    (0..count).map(|_| left.swap_remove(random.random_range(0..left.len()))).collect()
}
