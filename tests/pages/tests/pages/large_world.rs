//! "Far from the origin": what a pose loses there, and what does not.

use crate::math::{palette, product, skinned};
use crate::shown::place::place;
use pages::arm;
use sinew_runtime::{Matrix3x4, Model};

/// How far the arm stands away, in metres, and how far off its skin then is, RMS in metres: as the page says.
const FAR: [(f32, f32); 3] = [(1e3, 7e-5), (1e4, 1e-3), (1e5, 8e-3)];

#[test]
fn a_far_pose_costs_what_the_page_says_and_a_camera_beside_it_nothing() {
    let model = Model::from_bytes(arm::FILE.as_slice()).unwrap();
    let envelope = model.envelope().unwrap();
    let pose = arm::pose(&arm::EXAMPLES, 36);
    let (near, _) = palette(&envelope, &pose);
    let expected = skinned(&model, &near);
    let world = |distance: f32| -> Matrix3x4 {
        [[1.0, 0.0, 0.0, distance], [0.0, 1.0, 0.0, distance], [0.0, 0.0, 1.0, 0.0]]
    };
    let rms = |found: &[[f32; 3]], distance: f32| {
        let off = |(found, own): (&[f32; 3], &[f32; 3])| {
            let distance = f64::from(distance);
            let own = own.map(f64::from);
            let own = [own[0] + distance, own[1] + distance, own[2]];
            (0..3).map(|c| (f64::from(found[c]) - own[c]).powi(2)).sum::<f64>()
        };
        let all = found.iter().zip(&expected).map(off).sum::<f64>();
        (all / expected.len() as f64).sqrt() as f32
    };
    for (distance, said) in FAR {
        let far: Vec<_> = pose.iter().map(|matrix| product(&world(distance), matrix)).collect();
        let (far, confidence) = palette(&envelope, &far);
        let off = rms(&skinned(&model, &far), distance);
        println!("far: {distance:e} m: {off:.1e} m, confidence {confidence:.3}");
        assert!((0.5 * said..1.5 * said).contains(&off) && confidence > 0.99, "{off}");
    }
    // A camera 2 m away, as far out as the arm itself.
    let mut placed = near.clone();
    place(&world(2.0), &mut placed);
    let off = rms(&skinned(&model, &placed), 2.0);
    println!("far: beside the camera {off:.1e} m");
    assert!(off < 1e-6, "{off}");
}
