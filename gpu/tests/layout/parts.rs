//! Files of several parts: a batch is of one envelope and of a skin that follows it.

#[path = "../../examples/bandwidth/model.rs"]
mod model;

use sinew_gpu::layout::{Batch, DeviceLimits, LayoutError, Plan, Resource, SkinBatch};
use sinew_runtime::Model;

#[test]
fn a_skin_that_follows_another_envelope_or_none_is_refused() {
    let mut parts = model::file_model(5);
    parts.envelopes.push(parts.envelopes[0].clone());
    let mut second = parts.skins[0].clone();
    (second.name, second.envelope) = ("second".to_owned(), Some(1));
    let mut none = parts.skins[0].clone();
    (none.name, none.envelope, none.influences) = ("none".to_owned(), None, Vec::new());
    parts.skins.extend([second, none]);
    let model = Model::from_bytes(parts.bake().unwrap()).unwrap();
    let envelopes: Vec<_> = model.envelopes().collect();
    let planned = |envelope: usize, skin: &str| {
        let skin = SkinBatch::new(&model.skin_named(skin).unwrap());
        let batch = Batch { skin: Some(skin), ..Batch::palettes(&envelopes[envelope], 2) };
        Plan::new(&model, &envelopes[envelope], &batch, &DeviceLimits::DOWNLEVEL)
    };
    let refused = |expected, found| LayoutError::OtherEnvelope { expected, found };
    assert_eq!(planned(0, "second").unwrap_err(), refused(0, Some(1)));
    assert_eq!(planned(1, "spiral").unwrap_err(), refused(1, Some(0)));
    assert_eq!(planned(0, "none").unwrap_err(), refused(0, None));

    // Each skin is found where it lies, with the same numbers of the same envelope.
    let [first, second] = [planned(0, "spiral").unwrap(), planned(1, "second").unwrap()];
    let words = |plan: &Plan, name: &str| {
        let params = plan.chunks()[0].params().to_vec();
        let at = params.iter().find(|(own, _)| *own == name).unwrap().1 as usize;
        model.blob()[4 * at..][..4 * 15].to_vec()
    };
    for name in ["rest_positions", "rest_normals", "influence_weights", "groups", "corrections"] {
        assert_eq!(words(&first, name), words(&second, name), "{name}");
    }
    assert_ne!(first.params(), second.params());
    assert_eq!(first.bytes(Resource::Out), second.bytes(Resource::Out));
}
