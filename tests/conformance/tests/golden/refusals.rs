//! Parts that do not fit each other, or that the runtime refuses.

use super::sample::{Golden, RIGID, file_model};
use sinew_runtime::envelope::Predictor;
use sinew_trainer::Error;
use sinew_trainer::envelope::model::{Curve, EnvelopeModel, Feature, SkinModel};

#[test]
fn parts_that_do_not_fit_are_refused() {
    let refused_of = |predictor, edit: &dyn Fn(&mut EnvelopeModel, &mut SkinModel)| {
        let mut model = file_model(Golden { predictor, ..RIGID });
        edit(&mut model.envelopes[0], &mut model.skins[0]);
        model.bake().unwrap_err()
    };
    let refused =
        |edit: &dyn Fn(&mut EnvelopeModel, &mut SkinModel)| refused_of(Predictor::Kernel, edit);
    let length = |what: &str, expected: usize, found: usize| {
        format!("{what}: expected {expected} elements, found {found}")
    };
    let c1 = refused_of(Predictor::Rotational, &|p, _| {
        p.reconstruction.as_mut().unwrap().c1.truncate(19, 15)
    });
    assert_eq!(c1.message(), length("rows of c1", 20, 19));
    let c2 = refused_of(Predictor::Rotational, &|p, _| {
        p.reconstruction.as_mut().unwrap().c2.truncate(20, 19)
    });
    assert_eq!(c2.message(), length("columns of c2", 20, 19));
    let centres = refused(&|p, _| p.groups[1].map.centres.truncate(8, 7));
    assert_eq!(centres.message(), length("coordinates of a group's centres", 9, 8));
    let coefficients = refused(&|p, _| p.groups[1].map.coefficients.truncate(13, 2));
    assert_eq!(coefficients.message(), length("columns of a group's coefficients", 16, 2));
    let outputs = refused(&|p, _| p.groups[1].outputs.truncate(2, 11));
    assert_eq!(outputs.message(), length("rows of a group's outputs", 12, 2));
    let ranges = refused(&|p, _| p.stretch_ranges = Some(vec![0.25; 4]));
    assert_eq!(ranges.message(), length("stretch ranges", 5, 4));
    let gap = refused(&|p, _| p.groups[1].proxies = 3..4);
    assert_eq!(gap.message(), length("helpers before a group", 2, 3));
    let joint = refused(&|p, _| p.groups[0].joint = 70_000);
    assert_eq!(joint.message(), "joint of a group: 70000 does not fit the file");
    let normals = refused(&|_, s| s.rest_normals.truncate(1));
    assert_eq!(normals.message(), length("rest normals", 24, 1));
    let cycle = refused(&|p, _| p.skeleton.parents[2] = Some(0));
    assert_eq!(cycle.message(), "joint 0 does not descend from the root");
    let frame = refused(&|p, _| p.skeleton.rest[1] = [[0.0; 4]; 3]);
    assert_eq!(frame.message(), "the rest frame of joint 1 cannot be inverted");
    let weights = refused(&|_, s| s.influences[7].clear());
    // The sum of no numbers is -0.
    assert_eq!(weights.message(), "the weights of vertex 7 sum to -0, expected 1");
    let index = refused(&|_, s| s.influences[7] = vec![(70_000, 1.0)]);
    assert_eq!(index.message(), "palette index: 70000 does not fit the file");
    let envelope = refused(&|_, s| s.envelope = Some(1));
    assert_eq!(envelope.message(), "skin 0 follows envelope 1, of 1");
    let influences = refused(&|_, s| s.envelope = None);
    assert_eq!(influences.message(), length("influences", 0, 24));
    let is_by_runtime =
        |error: Error| error.message().starts_with("the runtime refuses the baked model: ");
    for edit in [
        (|p, _| p.reconstruction.as_mut().unwrap().c2[(0, 9)] = f64::NAN)
            as fn(&mut EnvelopeModel, &mut SkinModel),
        |_, s| s.influences[7] = vec![(5, 1.0)],
        |p, _| p.reconstruction.as_mut().unwrap().keys[0].joint = 9,
        |p, _| p.curves = vec![curve([0.0, 1.0])],
    ] {
        assert!(is_by_runtime(refused_of(Predictor::Rotational, &edit)));
    }
    for edit in [
        (|p, _| p.groups[0].joint = 5) as fn(&mut EnvelopeModel, &mut SkinModel),
        |p, _| {
            p.groups.truncate(2);
            p.places.truncate(3);
        },
        |p, _| p.groups[0].inputs[0].feature = Feature::Curve(0),
        |p, _| p.stretch_ranges = Some(vec![-1.0; 5]),
        |p, _| p.curves = vec![curve([1.0, 0.0])],
        |p, _| p.groups[0].outputs[(0, 0)] = 1e7,
        |p, _| p.groups[0].map.confidence.reach = 0.0,
        |_, s| s.rest_positions[3][1] = 1e300,
        |_, s| s.rest_normals[3] = [0.0, 1.1, 0.0],
        |_, s| s.ranges[1].1 = 19..24,
    ] {
        assert!(is_by_runtime(refused(&edit)));
    }
}

fn curve(range: [f64; 2]) -> Curve {
    Curve { name: "curve".to_owned(), range }
}
