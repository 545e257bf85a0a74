//! Valid and invalid files of objects of key views.

use crate::common::{exercise, file_error};
use models::{KernelContent, LayerContent, Pieces, ViewsContent};
use sinew_runtime::format::{PartRow, SectionKind};
use sinew_runtime::kernel::{Kernel, OutputKind};
use sinew_runtime::views::{
    CLIP_ELEMENTS_MAX, CLIPS_MAX, Element, FITS_MAX, Layer, NO_VERTEX, NOTHING, VIEWS_SECTIONS,
    ViewsCounts,
};
use sinew_runtime::{FileError, FileErrorKind as Kind, KernelMap, Model, Views};

/// Loads an object after two maps and after `edit` has changed its plain lists.
fn with(edit: impl FnOnce(&mut ViewsContent)) -> Result<(), FileError> {
    let mut content = ViewsContent::sample(vec![0, 1], true);
    edit(&mut content);
    let maps = [KernelContent::map("walk", 51), KernelContent::map("jump", 52)];
    let mut pieces = Pieces::kernels(&maps);
    pieces.add_views(&content);
    Model::from_bytes(pieces.bytes()).map(|_| ())
}

/// Loads a transferred object, part 1, after `edit` has changed its bytes.
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
    let parts: Vec<_> = model.all::<Views>().map(|views| views.part()).collect();
    assert_eq!(parts, [7, 9]);
    let views = model.named::<Views>("object").unwrap();
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
    let views = model.first::<Views>().unwrap().layout().open::<Views>(&bytes).unwrap();
    assert_eq!((views.point_len(), views.vertex_len(), views.element_len()), (9, 10, 7));
    assert_eq!((views.view_len(), views.layer_len(), views.order_len()), (3, 2, 9));
    assert_eq!(views.size(), [48, 40]);
    let names = [views.layer_name(0), views.layer_name(1), views.layer_name(2)];
    assert_eq!(names, [Some("body"), Some("mark"), None]);
    let body = Layer {
        first: 0,
        end: 6,
        clip: None,
        has_depth: true,
        is_group: false,
        is_one_sided: true,
    };
    let mark = Layer {
        first: 6,
        end: 7,
        clip: Some(0),
        has_depth: false,
        is_group: true,
        is_one_sided: false,
    };
    assert_eq!([0, 1, 2].map(|layer| views.layer(layer)), [Some(body), Some(mark), None]);
    assert!(views.has_clips() && views.has_groups() && views.has_depth());
    assert_eq!(views.clips(0).count(), 0);
    assert_eq!(views.clips(1).collect::<Vec<_>>(), [0]);
    assert_eq!(views.element(0), Some(Element::Quad([0, 1, 4, 3])));
    assert_eq!(views.element(1), Some(Element::Triangle([1, 2, 5])));
    assert_eq!(views.element(6), Some(Element::Triangle([4, 5, 9])));
    assert_eq!((views.element(7), views.neighbours(7)), (None, None));
    assert_eq!(views.neighbours(0), Some([None, Some(2), Some(3), None]));
    assert_eq!(views.neighbours(6), Some([None; 4]));
    for (at, (place, weights)) in content.vertices.iter().enumerate() {
        let vertex = views.vertex(at).unwrap();
        let found: Vec<_> = vertex.weights().map(|(point, w)| (point as u32, w)).collect();
        assert_eq!((vertex.place(), &found), (*place, weights));
        assert_eq!(vertex.point(), (at < 9).then_some(at));
    }
    assert!(views.vertex(10).is_none());
    for (at, view) in content.views.iter().enumerate() {
        assert_eq!(views.view_name(at), Some(&*view.name));
        for (layer, texture) in view.textures.iter().enumerate() {
            let texture = (*texture != NOTHING).then_some(*texture as usize);
            assert_eq!(views.view_texture(at, layer), texture);
        }
        let (ratio, offsets) = view.deformation.as_ref().unwrap();
        assert_eq!(views.ratio(at), Some(*ratio));
        for (point, offset) in offsets.iter().enumerate() {
            assert_eq!(views.is_visible(at, point), Some(view.visible[point]));
            assert_eq!(views.offset(at, point), Some(*offset));
        }
        for (vertex, texel) in view.texels.iter().enumerate() {
            assert_eq!(views.texel(at, vertex), Some(*texel));
        }
        for (point, reference) in view.references.iter().enumerate() {
            assert_eq!(views.reference(at, point), Some(*reference));
        }
        assert_eq!(
            (views.texel(at, 10), views.reference(at, 9), views.is_visible(at, 9)),
            (None, None, None)
        );
        assert_eq!((views.offset(at, 9), views.view_texture(at, 2)), (None, None));
    }
    assert_eq!((views.view_name(3), views.reference(3, 0), views.ratio(3)), (None, None, None));
    assert_eq!((views.view_texture(3, 0), views.view_texture(1, 1)), (None, None));
    for (at, texture) in content.textures.iter().enumerate() {
        let found = views.texture(at).unwrap();
        assert_eq!(found.size(), [texture.width, texture.height].map(|x| x as usize));
        assert_eq!(found.texels(), texture.texels);
    }
    assert!(views.texture(2).is_none() && views.is_transferred());
    assert_eq!(views.fit().figures(), content.fit);
    let [plain, _] = Pieces::viewed().map(|pieces| Model::from_bytes(pieces.bytes()).unwrap());
    let plain = plain.first::<Views>().unwrap();
    assert!(!plain.is_transferred() && plain.ratio(0).is_none() && plain.offset(0, 0).is_none());
}

#[test]
fn each_count_is_checked() {
    let section = SectionKind::ViewsCounts;
    let count = |at: usize, value: u32| edited(|pieces| pieces.set_word(section, at, value));
    for at in [0, 4, 5, 6, 7, 8, 9, 10] {
        let empty = FileError { expected: 1, ..error(Kind::Empty, section, at as u32) };
        assert_eq!(count(at, 0), Err(empty));
    }
    let limit = |at: usize, expected: u32| {
        let most = FileError { expected, ..error(Kind::Limit, section, at as u32) };
        assert_eq!(count(at, expected + 1), Err(FileError { found: expected + 1, ..most }));
    };
    [0, 1, 3, 4, 5, 6, 7, 9, 10].into_iter().for_each(|at| limit(at, 65_535));
    limit(2, u32::MAX / 12);
    limit(8, u32::MAX / 4);
    let counts = [9, 10, 12, 7, 2, 3, 1, 2, 183, 48, 40];
    for (at, section, [expected, found]) in [
        (0, SectionKind::References, [240, 216]),
        (1, SectionKind::Vertices, [132, 120]),
        (2, SectionKind::VertexWeights, [156, 144]),
        (3, SectionKind::Elements, [64, 56]),
        // Longer by one name, the section of names is long enough.
        (4, SectionKind::Layers, [36, 24]),
        (5, SectionKind::ViewTextures, [32, 24]),
        (6, SectionKind::Maps, [8, 4]),
        (7, SectionKind::Textures, [36, 24]),
        (8, SectionKind::Texels, [736, 732]),
    ] {
        let refused = count(at, counts[at] + 1).unwrap_err();
        assert_eq!(refused, FileError { expected, found, ..error(Kind::Length, section, 0) });
    }
    assert_eq!((count(9, 65_535), count(10, 1)), (Ok(()), Ok(())));
    // Names of the part, of key views and of layers. One name more needs only its end.
    let least = ViewsCounts::from_words(counts).section_bytes(SectionKind::Names);
    assert_eq!(least, Some(24));
    // More than any file holds.
    assert_eq!(
        edited(|pieces| {
            pieces.set_word(section, 0, 65_535);
            pieces.set_word(section, 5, 65_535);
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
            let refused = edited(|pieces| pieces.set_float(section, 2, value));
            assert_eq!(refused, Err(error(Kind::Float, section, 2)), "{section:?} {value}");
        }
    }
    // Places, beside words that are not floats.
    for at in [13, 14] {
        let section = SectionKind::Vertices;
        let refused = edited(|pieces| pieces.set_float(section, at, f32::NAN));
        assert_eq!(refused, Err(error(Kind::Float, section, at as u32)));
        let refused = edited(|pieces| pieces.set_float(section, at, -2.0e9));
        assert_eq!(refused, Err(error(Kind::Float, section, at as u32)));
    }
    // Weights; the index counts the floats.
    for (at, index) in [(1, 0), (4, 2), (35, 23)] {
        let section = SectionKind::VertexWeights;
        for value in [f32::NAN, f32::NEG_INFINITY, 2.0e9] {
            let refused = edited(|pieces| pieces.set_float(section, at, value));
            assert_eq!(refused, Err(error(Kind::Float, section, index)));
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
        Err(FileError { expected: 25, found: 24, ..error(Kind::Mismatch, section, 0) })
    );
    let mixed = beside(|map| map.outputs.swap(8, 9));
    assert_eq!(mixed, Err(error(Kind::Invalid, section, 0)));
    let turned = beside(|map| {
        let (_, row) = &mut map.outputs[0];
        (row.kind, row.neutral) = (OutputKind::Rotation, [0.0, 0.0, 0.0, 1.0]);
    });
    assert_eq!(turned, Err(error(Kind::Invalid, section, 0)));
    let mut pieces = Pieces::kernels(&[KernelContent::plain(Kernel::Linear, [1, 1, 25])]);
    pieces.add_views(&ViewsContent::sample(vec![0], false));
    let numbers = Model::from_bytes(pieces.bytes()).map(|_| ());
    assert_eq!(numbers, Err(error(Kind::Invalid, section, 0)));
}

#[test]
fn layers_have_the_elements_that_follow_each_other() {
    let section = SectionKind::Layers;
    let end = |at: usize, value: u32| edited(|pieces| pieces.set_word(section, 3 * at, value));
    // A layer may be empty.
    assert_eq!((end(0, 7), end(0, 0)), (Ok(()), Ok(())));
    assert_eq!(end(0, 8), Err(error(Kind::Invalid, section, 1)));
    for found in [6, 8, u32::MAX] {
        let sum = FileError { expected: 7, found, ..error(Kind::Mismatch, section, 2) };
        assert_eq!(end(1, found), Err(sum));
    }
    let part = Some(2);
    assert_eq!(with(|content| content.layers[0].flags = Layer::DEPTH), Ok(()));
    for flags in [8, 9, 1 << 31] {
        let unknown = with(|content| content.layers[1].flags = flags);
        assert_eq!(unknown, Err(FileError { part, ..error(Kind::Invalid, section, 1) }));
    }
}

#[test]
fn no_layer_clips_itself() {
    let section = SectionKind::Layers;
    let part = Some(2);
    for (layer, clip) in [(0, 2), (1, 2), (1, NOTHING - 1)] {
        let found = with(|content| content.layers[layer].clip = clip);
        let index = error(Kind::Index, section, 3 * layer as u32 + 1);
        assert_eq!(found, Err(FileError { part, expected: 2, found: clip, ..index }));
    }
    let at = |index| Err(FileError { part, ..error(Kind::Invalid, section, index) });
    assert_eq!(with(|content| content.layers[0].clip = 0), at(0));
    assert_eq!(with(|content| content.layers[1].clip = 1), at(1));
    assert_eq!(with(|content| content.layers[0].clip = 1), at(0));
    assert_eq!(with(|content| content.layers[1].clip = NOTHING), Ok(()));
    // A chain in which each layer is clipped by the layer before.
    let chain = |len: usize| clipped(6, &(1..len as u32 - 1).collect::<Vec<_>>());
    assert_eq!(chain(CLIPS_MAX + 1), Ok(()));
    let longer = error(Kind::Invalid, section, CLIPS_MAX as u32 + 1);
    assert_eq!(chain(CLIPS_MAX + 2), Err(longer));
}

#[test]
fn clipping_elements_are_limited() {
    // The first layer clips the second too.
    let most = CLIP_ELEMENTS_MAX / 32;
    assert_eq!(clipped(most, &[0; 31]), Ok(()));
    let longer = error(Kind::Invalid, SectionKind::Layers, 32);
    assert_eq!(clipped(most + 1, &[0; 31]), Err(longer));
}

#[test]
fn elements_times_key_views_are_limited() {
    let loaded = |element_len: usize, view_len: usize| {
        with(|content| {
            let layer = &mut content.layers[0];
            layer.elements.resize(element_len, [0, 1, 4, NO_VERTEX]);
            layer.neighbours.resize(element_len, [NO_VERTEX; 4]);
            content.layers.iter_mut().for_each(|layer| layer.clip = NOTHING);
            let last = content.views.last().cloned().unwrap();
            content.views.resize(view_len, last);
        })
    };
    let others: usize = ViewsContent::sample(vec![0], true).layers[1..]
        .iter()
        .map(|layer| layer.elements.len())
        .sum();
    let most = FITS_MAX / 1024;
    // The file's maps have fewer scores than views.
    assert_eq!(loaded(1024 - others, most).unwrap_err().kind, Kind::Mismatch);
    let values = [most as u32, most as u32 + 1];
    let refused = FileError {
        part: Some(2),
        expected: values[0],
        found: values[1],
        ..error(Kind::Limit, SectionKind::ViewsCounts, 5)
    };
    assert_eq!(loaded(1024 - others, most + 1), Err(refused));
}

/// Loads the sample with `element_len` elements in the first layer, and with a further layer for
/// each entry of `clips`, its clipping layer.
fn clipped(element_len: usize, clips: &[u32]) -> Result<(), FileError> {
    let (mut content, mut map) =
        (ViewsContent::sample(vec![0], false), KernelContent::map("walk", 51));
    content.layers[0].elements.resize(element_len, [0, 1, 4, NO_VERTEX]);
    content.layers[0].neighbours.resize(element_len, [NO_VERTEX; 4]);
    for (number, clip) in clips.iter().enumerate() {
        let (elements, neighbours) = (Vec::new(), Vec::new());
        let (name, clip) = (number.to_string(), *clip);
        content.layers.push(LayerContent { name, elements, neighbours, clip, flags: 0 });
        content.views.iter_mut().for_each(|view| view.textures.push(NOTHING));
        for _ in 0..2 {
            map.outputs.extend(map.outputs.last().cloned());
            map.coefficients.extend(map.coefficients.last().cloned());
        }
    }
    let mut pieces = Pieces::kernels(&[map]);
    pieces.add_views(&content);
    Model::from_bytes(pieces.bytes()).map(|_| ())
}

#[test]
fn vertices_stand_by_points() {
    let section = SectionKind::Vertices;
    let end = |at: usize, value: u32| edited(|pieces| pieces.set_word(section, 3 * at, value));
    // A vertex may have no weights.
    assert_eq!((end(0, 2), end(0, 0)), (Ok(()), Ok(())));
    assert_eq!(end(0, 3), Err(error(Kind::Invalid, section, 1)));
    for found in [11, 13, u32::MAX] {
        let sum = FileError { expected: 12, found, ..error(Kind::Mismatch, section, 10) };
        assert_eq!(end(9, found), Err(sum));
    }
    for (weight, point) in [(0, 9), (2, u32::MAX)] {
        let found = with(|content| content.vertices[9].1[weight].0 = point);
        let index = error(Kind::Index, SectionKind::VertexWeights, 27 + 3 * weight as u32);
        assert_eq!(found, Err(FileError { part: Some(2), expected: 9, found: point, ..index }));
    }
}

#[test]
fn elements_are_of_vertices_and_of_each_once() {
    let section = SectionKind::Elements;
    let part = Some(2);
    for (corner, vertex) in [(0, 10), (1, NO_VERTEX), (2, 300), (3, 10)] {
        let found = with(|content| content.layers[0].elements[5][corner] = vertex);
        let index = error(Kind::Index, section, 20 + corner as u32);
        assert_eq!(found, Err(FileError { part, expected: 10, found: vertex.into(), ..index }));
    }
    let found = with(|content| content.layers[1].elements[0][1] = 10);
    let index = error(Kind::Index, section, 25);
    assert_eq!(found, Err(FileError { part, expected: 10, found: 10, ..index }));
    for (element, [a, b]) in [(0, [0, 1]), (0, [1, 3]), (1, [2, 0]), (5, [0, 3])] {
        let found = with(|content| {
            let elements = &mut content.layers[0].elements;
            elements[element][a] = elements[element][b];
        });
        let again = FileError { part, ..error(Kind::Invalid, section, element as u32) };
        assert_eq!(found, Err(again));
    }
    let none = with(|content| {
        for layer in &mut content.layers {
            layer.elements.clear();
            layer.neighbours.clear();
        }
    });
    assert_eq!(none, Ok(()));
}

#[test]
fn neighbours_are_elements() {
    let at =
        |edge: usize, other: u16| with(|content| content.layers[0].neighbours[2][edge] = other);
    for (edge, other) in [(0, 7), (1, 300), (3, NO_VERTEX - 1)] {
        let index = error(Kind::Index, SectionKind::Neighbours, 8 + edge as u32);
        let refused = FileError { part: Some(2), expected: 7, found: other.into(), ..index };
        assert_eq!(at(edge, other), Err(refused));
    }
    assert_eq!((at(1, NO_VERTEX), at(1, 6)), (Ok(()), Ok(())));
}

#[test]
fn key_views_are_of_textures_and_masks_of_points() {
    let part = Some(2);
    for texture in [2, NOTHING - 1] {
        let found = with(|content| content.views[1].textures[1] = texture);
        let index = error(Kind::Index, SectionKind::ViewTextures, 3);
        assert_eq!(found, Err(FileError { part, expected: 2, found: texture, ..index }));
    }
    assert_eq!(with(|content| content.views[2].textures[0] = NOTHING), Ok(()));
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
    let counts = error(Kind::Mismatch, SectionKind::ViewsCounts, 8);
    assert_eq!(sum, Err(FileError { part, expected: 174, found: 183, ..counts }));
}

#[test]
fn a_reader_that_does_not_know_the_kind_leaves_it_alone() {
    // A reader without the feature sees a part of an unknown kind that is not required.
    let [_, mut pieces] = Pieces::viewed();
    pieces.parts[1] = PartRow { kind: 9, flags: 0 };
    let bytes = pieces.bytes();
    let model = Model::from_bytes(bytes.as_slice()).unwrap();
    assert!(model.first::<Views>().is_none() && model.all::<KernelMap>().count() == 1);
}
