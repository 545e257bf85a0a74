//! Meshes without vertices.

use conformance::backend::{Cpu, Loaded};
use conformance::compare::Mismatch;
use conformance::finding::sound;
use conformance::models::{self, SHAPES};
use conformance::stages::skin::{plain, skinned_by, whole_of};
use conformance::stages::{correction, palette, skin};
use conformance::subject::Subject;

#[test]
fn a_mesh_without_vertices_has_a_palette_and_nothing_to_skin() {
    for shape in SHAPES.into_iter().filter(|shape| shape.vertices == 0) {
        let bytes = models::random(shape);
        let subject = Subject::new("nothing", &bytes, 14);
        let Loaded { envelope, skin: own, .. } = &subject.loaded;
        if shape.predictor.reconstructs() {
            assert_eq!(sound(&palette::body(&Cpu, &subject).unwrap()), Ok(()));
        }
        if shape.predictor.corrects() {
            assert_eq!(sound(&correction::body(&Cpu, &subject).unwrap()), Ok(()));
        }
        let palettes = whole_of(&Cpu, &subject).unwrap().palettes;
        assert!(plain(own).vertices.is_empty());
        assert!(skinned_by(&Cpu, &subject, &palettes).unwrap().positions.is_empty());
        assert_eq!(own.bounds(&palettes[..envelope.palette_len()], 0.0).unwrap(), None);
        let findings = skin::body(&Cpu, &subject).unwrap();
        assert_eq!(sound(&findings), Err(Mismatch::Empty), "it proves nothing");
    }
}
