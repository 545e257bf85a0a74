//! Files of objects of key views that must load, and those that must not.

use crate::common::{exercise, file_error};
use models::{KernelContent, Pieces, ViewsContent};
use sinew_runtime::format::{PartRow, SectionKind};
use sinew_runtime::kernel::{Kernel, OutputKind};
use sinew_runtime::views::{Element, NO_POINT, VIEWS_SECTIONS};
use sinew_runtime::{FileError, FileErrorKind as Kind, Model};

/// Loads an object that `edit` has changed in plain lists, after two maps.
fn with(edit: impl FnOnce(&mut ViewsContent)) -> Result<(), FileError> {
    let mut content = ViewsContent::sample(vec![0, 1], true);
    edit(&mut content);
    let maps = [KernelContent::map("walk", 51), KernelContent::map("jump", 52)];
    let mut pieces = Pieces::kernels(&maps);
    pieces.add_views(&content);
    Model::from_bytes(pieces.bytes()).map(|_| ())
}

/// Loads a transferred object, part 1, with bytes that `edit` has changed.
fn edited(edit: impl FnOnce(&mut Pieces)) -> Result<(), FileError> {
    let [_, mut pieces] = Pieces::viewed();
    edit(&mut pieces);
    Model::from_bytes(pieces.bytes()).map(|_| ())
}

fn error(kind: Kind, section: SectionKind, index: u32) -> FileError {
    FileError { part: Some(1), section: Some(section), index, ..file_error(kind) }
}

#[test]
fn sound_files_load_beside_other_parts() {
    for pieces in Pieces::viewed() {
        exercise(&pieces.bytes()).unwrap();
    }
    let mut several = Pieces::several();
    let [first, second] = Pieces::viewed();
    several.append(first);
    several.append(second);
    several.sections.reverse();
    let bytes = several.bytes();
    exercise(&bytes).unwrap();
    let model = Model::from_bytes(bytes.as_slice()).unwrap();
    let parts: Vec<_> = model.all_views().map(|views| views.part()).collect();
    assert_eq!(parts, [7, 9]);
    let views = model.views_named("object").unwrap();
    let names: Vec<_> = (0..3).map_while(|map| model.map_of(&views, map)).collect();
    assert_eq!(names.iter().map(|map| map.name()).collect::<Vec<_>>(), ["walk", "jump"]);
    assert_eq!((views.map_part(1), views.map_part(2)), (Some(6), None));
}

#[test]
fn accessors_give_what_was_written() {
    let content = ViewsContent::sample(vec![0], true);
    let [_, pieces] = Pieces::viewed();
    let bytes = pieces.bytes();
    let model = Model::from_bytes(bytes.as_slice()).unwrap();
    let views = model.views().unwrap().layout().open(&bytes).unwrap();
    assert_eq!((views.point_len(), views.element_len(), views.view_len()), (9, 6, 3));
    assert_eq!(views.element(0), Some(Element::Quad([0, 1, 4, 3])));
    assert_eq!(views.element(1), Some(Element::Triangle([1, 2, 5])));
    assert_eq!(views.element(6), None);
    for (at, view) in content.views.iter().enumerate() {
        assert_eq!(views.view_name(at), Some(&*view.name));
        assert_eq!(views.view_texture(at), Some(view.texture as usize));
        let (ratio, offsets) = view.deformation.as_ref().unwrap();
        assert_eq!(views.ratio(at), Some(*ratio));
        for (point, offset) in offsets.iter().enumerate() {
            assert_eq!(views.reference(at, point), Some(view.references[point]));
            assert_eq!(views.is_visible(at, point), Some(view.visible[point]));
            assert_eq!(views.offset(at, point), Some(*offset));
        }
        assert_eq!((views.reference(at, 9), views.is_visible(at, 9)), (None, None));
    }
    assert_eq!((views.view_name(3), views.reference(3, 0), views.ratio(3)), (None, None, None));
    for (at, texture) in content.textures.iter().enumerate() {
        let found = views.texture(at).unwrap();
        assert_eq!(found.size(), [texture.width, texture.height].map(|x| x as usize));
        assert_eq!(found.texels(), texture.texels);
    }
    assert!(views.texture(2).is_none() && views.is_transferred());
    assert_eq!(views.fit().figures(), content.fit);
    let [plain, _] = Pieces::viewed().map(|pieces| Model::from_bytes(pieces.bytes()).unwrap());
    let plain = plain.views().unwrap();
    assert!(!plain.is_transferred() && plain.ratio(0).is_none() && plain.offset(0, 0).is_none());
}

#[test]
fn each_count_is_checked() {
    let section = SectionKind::ViewsCounts;
    let count = |at: usize, value: u32| edited(|pieces| pieces.set_word(section, at, value));
    for at in [0, 2, 3, 4, 5] {
        let empty = FileError { expected: 1, ..error(Kind::Empty, section, at as u32) };
        assert_eq!(count(at, 0), Err(empty));
    }
    for at in 0..5 {
        let most =
            FileError { expected: 65_535, found: 65_536, ..error(Kind::Limit, section, at as u32) };
        assert_eq!(count(at, 65_536), Err(most));
    }
    assert_eq!(count(5, u32::MAX).unwrap_err().kind, Kind::Limit);
    for (at, section, [expected, found]) in [
        (0, SectionKind::References, [240, 216]),
        (1, SectionKind::Elements, [56, 48]),
        (2, SectionKind::Names, [20, 33]),
        (3, SectionKind::Maps, [8, 4]),
        (4, SectionKind::Textures, [36, 24]),
        (5, SectionKind::Texels, [736, 732]),
    ] {
        let was = [9, 6, 3, 1, 2, 183][at];
        let refused = count(at, was + 1).unwrap_err();
        if section == SectionKind::Names {
            // Longer by a name, they are long enough: the masks are not.
            assert_eq!(
                (refused.kind, refused.section),
                (Kind::Length, Some(SectionKind::ViewTextures))
            );
            continue;
        }
        assert_eq!(refused, FileError { expected, found, ..error(Kind::Length, section, 0) });
    }
    // More than any file holds.
    assert_eq!(
        edited(|pieces| {
            pieces.set_word(section, 0, 65_535);
            pieces.set_word(section, 2, 65_535);
        })
        .unwrap_err()
        .kind,
        Kind::Length
    );
}

#[test]
fn each_section_is_required_and_has_its_length() {
    for section in VIEWS_SECTIONS {
        let is_it =
            |content: &models::Content| (content.part, content.kind) == (1, section.number());
        let missing = edited(|pieces| pieces.sections.retain(|content| !is_it(content)));
        let is_optional = section == SectionKind::Deformations;
        assert_eq!(
            missing,
            if is_optional { Ok(()) } else { Err(error(Kind::Missing, section, 0)) }
        );
        let longer = edited(|pieces| pieces.section_of(1, section).extend([0; 4]));
        let refused = longer.unwrap_err();
        let kind = if section == SectionKind::Names { Kind::Invalid } else { Kind::Length };
        assert_eq!((refused.kind, refused.section), (kind, Some(section)));
    }
}

#[test]
fn each_float_is_checked() {
    for section in [SectionKind::References, SectionKind::Deformations, SectionKind::ViewsFit] {
        for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 2.0e9] {
            let refused = edited(|pieces| pieces.set_float(section, 3, value));
            assert_eq!(refused, Err(error(Kind::Float, section, 3)), "{section:?} {value}");
        }
    }
    let negative = edited(|pieces| pieces.set_float(SectionKind::ViewsFit, 0, -1.0));
    assert_eq!(negative, Err(error(Kind::Float, SectionKind::ViewsFit, 0)));
}

#[test]
fn maps_are_kernels_that_give_what_the_object_takes() {
    let section = SectionKind::Maps;
    let of = |part| FileError {
        part: Some(2),
        index: 1,
        expected: 3,
        found: part,
        ..error(Kind::Index, section, 1)
    };
    for part in [2, 3, 65_536, u32::MAX] {
        assert_eq!(with(|content| content.maps[1] = part), Err(of(part)));
    }
    let beside = |edit: fn(&mut KernelContent)| {
        let mut map = KernelContent::map("walk", 51);
        edit(&mut map);
        let mut pieces = Pieces::kernels(&[map]);
        pieces.add_views(&ViewsContent::sample(vec![0], false));
        Model::from_bytes(pieces.bytes()).map(|_| ())
    };
    assert_eq!(beside(|_| {}), Ok(()));
    let fewer = beside(|map| {
        map.outputs.pop();
        map.coefficients.pop();
    });
    assert_eq!(
        fewer,
        Err(FileError { expected: 21, found: 20, ..error(Kind::Mismatch, section, 0) })
    );
    let mixed = beside(|map| map.outputs.swap(8, 9));
    assert_eq!(mixed, Err(error(Kind::Invalid, section, 0)));
    let turned = beside(|map| {
        let (_, row) = &mut map.outputs[0];
        (row.kind, row.neutral) = (OutputKind::Rotation, [0.0, 0.0, 0.0, 1.0]);
    });
    assert_eq!(turned, Err(error(Kind::Invalid, section, 0)));
    let mut pieces = Pieces::kernels(&[KernelContent::plain(Kernel::Linear, [1, 1, 21])]);
    pieces.add_views(&ViewsContent::sample(vec![0], false));
    let numbers = Model::from_bytes(pieces.bytes()).map(|_| ());
    assert_eq!(numbers, Err(error(Kind::Invalid, section, 0)));
}

#[test]
fn elements_are_of_points_and_of_each_once() {
    let section = SectionKind::Elements;
    let part = Some(2);
    for (corner, point) in [(0, 9), (1, NO_POINT), (2, 300), (3, 9)] {
        let found = with(|content| content.elements[5][corner] = point);
        let index = error(Kind::Index, section, 20 + corner as u32);
        assert_eq!(found, Err(FileError { part, expected: 9, found: point.into(), ..index }));
    }
    for (element, [a, b]) in [(0, [0, 1]), (0, [1, 3]), (1, [2, 0]), (5, [0, 3])] {
        let found = with(|content| content.elements[element][a] = content.elements[element][b]);
        let again = FileError { part, ..error(Kind::Invalid, section, element as u32) };
        assert_eq!(found, Err(again));
    }
    assert_eq!(with(|content| content.elements.clear()), Ok(()));
}

#[test]
fn key_views_are_of_textures_and_masks_of_points() {
    let part = Some(2);
    let found = with(|content| content.views[1].texture = 2);
    let index = error(Kind::Index, SectionKind::ViewTextures, 1);
    assert_eq!(found, Err(FileError { part, expected: 2, found: 2, ..index }));
    let found = with(|content| content.views[2].visible.extend([false, true]));
    assert_eq!(found, Err(FileError { part, ..error(Kind::Invalid, SectionKind::ViewMasks, 2) }));
}

#[test]
fn textures_have_texels_of_their_own() {
    let section = SectionKind::Textures;
    let part = Some(2);
    for edit in [
        |content: &mut ViewsContent| content.textures[1].width = 0,
        |content: &mut ViewsContent| content.textures[1].height = 0,
        |content: &mut ViewsContent| content.textures[1].width = 65_536,
        |content: &mut ViewsContent| content.textures[1].height = u32::MAX,
    ] {
        assert_eq!(with(edit), Err(FileError { part, ..error(Kind::Invalid, section, 1) }));
    }
    let gap = with(|content| content.textures[0].height = 9);
    let mismatch =
        FileError { part, expected: 108, found: 120, ..error(Kind::Mismatch, section, 1) };
    assert_eq!(gap, Err(mismatch));
    let sum = with(|content| content.textures[1].width = 6);
    let counts = error(Kind::Mismatch, SectionKind::ViewsCounts, 5);
    assert_eq!(sum, Err(FileError { part, expected: 174, found: 183, ..counts }));
}

#[test]
fn a_reader_that_does_not_know_the_kind_leaves_it_alone() {
    // As a reader without the feature sees it: a part of a kind that it does not know, which need not be known.
    let [_, mut pieces] = Pieces::viewed();
    pieces.parts[1] = PartRow { kind: 9, flags: 0 };
    let bytes = pieces.bytes();
    let model = Model::from_bytes(bytes.as_slice()).unwrap();
    assert!(model.views().is_none() && model.kernels().count() == 1);
}
