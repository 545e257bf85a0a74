//! Baked shapes, as the crate `models` writes them.

use ::models::{Pieces, SMALL, Shape, ShapeContent};
use sinew_runtime::format::{Element, SectionKind, Space};
use sinew_runtime::{Model, Skin};
use sinew_trainer::envelope::model::{FileModel, ShapeNumbers, SkinModel};

/// The crate `models` writes equal bytes for equal shapes.
#[test]
fn shapes_are_baked_as_the_maker_of_models_writes_them() {
    const V: usize = 150;
    for (numbers, element) in [
        (ShapeNumbers::F32, Element::F32),
        (ShapeNumbers::F16, Element::F16),
        (ShapeNumbers::I8, Element::I8),
    ] {
        let mut content = ShapeContent::sample(element, 7, V);
        // Steps as the trainer chooses them: the largest number uses all digits.
        for (steps, moved) in content.steps.iter_mut().zip(&mut content.moved) {
            match element {
                Element::I8 => *steps = [0.5, 0.25],
                Element::F16 => *steps = [1.0, 1.0],
                _ => {}
            }
            let most = if element == Element::I8 { 127.0 } else { 1.0 };
            let first = moved.iter_mut().flatten().next();
            first.into_iter().for_each(|numbers| *numbers = [most; 5]);
            for numbers in moved.iter_mut().flatten() {
                // No vertex without a movement, which the file would omit; and no -0, which is read
                // as 0.
                numbers[4] = numbers[4].max(1.0);
                numbers.iter_mut().for_each(|x| *x += 0.0);
            }
            if element == Element::I8 && moved.iter().all(Option::is_none) {
                *steps = [1.0, 1.0];
            }
        }
        let mut pieces = Pieces::loose(Shape { vertices: V, ..SMALL });
        pieces.set_shapes(&content);
        let expected = Model::from_bytes(pieces.bytes()).unwrap();
        let mut skin = SkinModel::from_file(&expected.first::<Skin>().unwrap());
        skin.shapes.numbers = numbers;
        let file = FileModel {
            space: Space::default(),
            envelopes: Vec::new(),
            skins: vec![skin],
            ..FileModel::default()
        };
        let found = Model::from_bytes(file.bake().unwrap()).unwrap();
        for kind in [
            SectionKind::SkinCounts,
            SectionKind::Names,
            SectionKind::Shapes,
            SectionKind::ShapeBlocks,
            SectionKind::ShapeEntries,
            SectionKind::ShapeDeltas,
            SectionKind::ShapeSlopes,
        ] {
            let of = |model: &Model<Vec<u8>>| {
                let mut sections = model.sections();
                let found = sections.find(|section| section.row.kind == kind.number()).unwrap();
                (found.row.element, found.bytes.to_vec())
            };
            assert!(of(&found) == of(&expected), "{kind:?} of {numbers:?}");
        }
    }
}
