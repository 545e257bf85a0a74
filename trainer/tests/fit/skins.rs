//! Models of several skins, of one skin, and of none.

use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::{PartKind, SectionKind};
use sinew_runtime::{Envelope, Matrix3x4, Model, Skin};
use sinew_trainer::envelope::levels::Level;
use sinew_trainer::envelope::s3::ProxyCount;
use sinew_trainer::envelope::{FileSkins, Options, Predict, Trained, train};
use sinew_trainer::evaluate::{Frames, evaluate};
use sinew_trainer::examples::demo::{DemoOptions, demo};
use sinew_trainer::examples::{Examples, Split};
use sinew_trainer::formats::Mesh;
use sinew_trainer::progress::Silent;
use std::collections::BTreeMap;

fn arm(vertices: usize) -> Examples {
    demo(&DemoOptions { vertices, poses: 20, held_out: 6, seed: 4 })
}

fn level(name: &str, vertices: usize) -> Level {
    let Examples { rest, triangles, engine, .. } = arm(vertices);
    Level {
        name: name.to_owned(),
        mesh: Mesh { positions: rest, triangles, engine },
        is_placed: false,
    }
}

fn options(meshes: FileSkins) -> Options {
    Options {
        predictor: Predict::Only(Predictor::Kernel),
        proxies: Some(ProxyCount::Fixed(6)),
        meshes,
        ..Options::default()
    }
}

fn trained(examples: &Examples, levels: &[Level]) -> Trained {
    train(examples, &options(FileSkins::Skins(levels.to_vec())), &Silent).unwrap()
}

/// Returns the sections of one part: kind and content.
fn sections(model: &Model<&[u8]>, part: usize) -> BTreeMap<u16, Vec<u8>> {
    let own = model.sections().filter(|section| usize::from(section.row.part) == part);
    own.map(|section| (section.row.kind, section.bytes.to_vec())).collect()
}

/// Returns the bytes of a part's sections.
fn bytes(model: &Model<&[u8]>, part: usize) -> usize {
    sections(model, part).values().map(Vec::len).sum()
}

fn palette(model: &Model<&[u8]>, pose: &[Matrix3x4]) -> Vec<Matrix3x4> {
    let envelope = model.first::<Envelope>().unwrap();
    let mut scratch = vec![0.0; envelope.scratch_len()];
    let mut palette = vec![Matrix3x4::default(); envelope.palette_len()];
    envelope.palette(pose, &[], &mut scratch, &mut palette).unwrap();
    palette
}

fn skinned(model: &Model<&[u8]>, skin: &str, palette: &[Matrix3x4]) -> Vec<[u32; 3]> {
    let skin = model.named::<Skin>(skin).unwrap();
    let mut positions = vec![[0.0; 3]; skin.vertex_len()];
    skin.skin_positions(palette, &mut positions).unwrap();
    positions.into_iter().map(|x| x.map(f32::to_bits)).collect()
}

#[test]
fn one_palette_drives_three_skins_as_three_files_do() {
    let examples = arm(500);
    let (lod1, lod2) = (level("lod1", 300), level("lod2", 200));
    let all = trained(&examples, &[lod1.clone(), lod2.clone()]);
    assert_eq!(all.levels.iter().map(|l| l.name.as_str()).collect::<Vec<_>>(), ["lod1", "lod2"]);
    assert!(all.levels.iter().all(|level| level.far == 0 && level.fitted_percent < 1.0));
    let model = Model::from_bytes(all.model.as_slice()).unwrap();
    let names: Vec<&str> = model.all::<Skin>().map(|skin| skin.name()).collect();
    assert_eq!(names, ["skin", "lod1", "lod2"]);
    assert!(model.all::<Skin>().all(|skin| skin.has_tangents()));
    let poses: Vec<Vec<Matrix3x4>> = (0..examples.frame_len())
        .map(|f| examples.pose(f).iter().map(|m| m.map(|row| row.map(|x| x as f32))).collect())
        .collect();

    // Files of one level each, next to the mesh that the level follows, and a file of that mesh
    // alone.
    let single = trained(&examples, &[]);
    let alone = Model::from_bytes(single.model.as_slice()).unwrap();
    let envelope = sections(&alone, 0);
    assert_eq!(sections(&model, 0), envelope, "the envelope does not depend on what follows it");
    let files = [lod1, lod2].map(|level| trained(&examples, &[level]).model);
    let files = files.each_ref().map(|file| Model::from_bytes(file.as_slice()).unwrap());
    for (name, file) in names.iter().zip([&alone, &files[0], &files[1]]) {
        let part = |model: &Model<&[u8]>| model.named::<Skin>(name).unwrap().part();
        assert_eq!(sections(&model, part(&model)), sections(file, part(file)), "{name}");
        for pose in &poses {
            let (one, other) = (palette(&model, pose), palette(file, pose));
            assert_eq!(skinned(&model, name, &one), skinned(file, name, &other), "{name}");
        }
    }

    // The file is larger than that of the largest skin by the other meshes: their sections, their
    // rows in the tables, and less than 16 bytes of alignment per section.
    let others: usize = [2, 3].map(|part| bytes(&model, part)).iter().sum();
    let rows = model.sections().count() - alone.sections().count();
    let grown = all.model.len() - single.model.len();
    let least = others + 16 * rows + 2 * 4;
    assert!((least..least + 16 * (rows + 2)).contains(&grown), "{grown} {least}");
}

#[test]
fn a_palette_alone_is_the_same_palette_without_a_mesh() {
    let examples = arm(400);
    let with = trained(&examples, &[]);
    let without = train(&examples, &options(FileSkins::PaletteAlone), &Silent).unwrap();
    let models = [&with.model, &without.model].map(|m| Model::from_bytes(m.as_slice()).unwrap());
    let kinds: Vec<u16> = models[1].parts().map(|row| row.kind).collect();
    assert_eq!(kinds, [PartKind::Envelope, PartKind::Record].map(PartKind::number));
    assert!(models[1].first::<Skin>().is_none());
    let mesh = [SectionKind::RestPositions, SectionKind::InfluenceWeights].map(SectionKind::number);
    assert!(models[1].sections().all(|section| !mesh.contains(&section.row.kind)));
    assert_eq!(sections(&models[0], 0), sections(&models[1], 0));
    let saved = with.model.len() - without.model.len();
    assert!(saved >= bytes(&models[0], 1), "{saved}");
    for skin in [None, Some("lod1")] {
        let refused = evaluate(&without.model, skin, &examples, Frames::All).unwrap_err();
        assert_eq!(
            refused.to_string(),
            "the model holds a palette alone, without a skin to measure or to play: train one without --no-skin for that"
        );
    }
}

#[test]
fn a_skin_is_measured_by_name_against_its_own_mesh() {
    let (examples, coarse) = (arm(500), arm(300));
    let model = trained(&examples, &[level("lod1", 300)]).model;
    let held_out = Frames::Of(Split::HeldOut);
    let found = evaluate(&model, Some("skin"), &examples, held_out).unwrap();
    let first = evaluate(&model, None, &examples, held_out).unwrap();
    assert_eq!(found.errors, first.errors);
    // The coarse arm has different flesh.
    let lod = evaluate(&model, Some("lod1"), &coarse, held_out).unwrap();
    assert!(lod.vertices == coarse.vertex_len() && lod.errors.rms_percent < 1.0);
    let refused = evaluate(&model, Some("lod1"), &examples, held_out).unwrap_err().to_string();
    let expected = format!(
        "the model has {} vertices, the examples have {}: give examples of the file that training had, with its texture's \
         seams where that has them",
        coarse.vertex_len(),
        examples.vertex_len()
    );
    assert_eq!(refused, expected);
    let refused = evaluate(&model, Some("lod9"), &examples, held_out).unwrap_err().to_string();
    assert_eq!(refused, "the model holds no skin called lod9; it has: skin, lod1");
}

#[test]
fn skins_that_cannot_be_are_refused() {
    let examples = arm(200);
    let train = |levels: &[Level]| {
        let refused = train(&examples, &options(FileSkins::Skins(levels.to_vec())), &Silent);
        refused.err().unwrap().to_string()
    };
    let refused = train(&[level("lod1", 200), level("lod1", 200)]);
    assert!(refused.starts_with("two skins have the name lod1: "), "{refused}");
    let refused = train(&[level("skin", 200)]);
    assert!(refused.starts_with("two skins have the name skin: "), "{refused}");
    let mut far = level("far", 200);
    far.mesh.positions.iter_mut().flatten().for_each(|x| *x *= 1e6);
    let refused = train(&[far]);
    let end = "in any axes and unit: export it in the rest pose of the examples";
    assert!(refused.starts_with("mesh far is ") && refused.ends_with(end), "{refused}");
}

#[test]
fn a_budget_covers_every_skin() {
    let examples = arm(300);
    let levels = [level("lod1", 200)];
    let all = trained(&examples, &levels).model.len();
    let budget = |bytes| {
        let meshes = FileSkins::Skins(levels.to_vec());
        train(&examples, &Options { budget: Some(bytes), ..options(meshes) }, &Silent)
    };
    let within = budget(all).unwrap();
    assert!(within.model.len() <= all);
    let model = Model::from_bytes(within.model.as_slice()).unwrap();
    assert!(model.all::<Skin>().all(|skin| skin.has_coefficients()));
    // Enough for the mesh without a correction, but not for the further mesh.
    let own = trained(&examples, &[]).model.len();
    let model = Model::from_bytes(within.model.as_slice()).unwrap();
    let least = bytes(&model, 1);
    assert!(least < own);
    let refused = budget(least + 1000).err().unwrap().to_string();
    let expected =
        format!("a budget of {} bytes is too small: skeleton and mesh alone take ", least + 1000);
    assert!(refused.starts_with(&expected), "{refused}");
}

#[test]
fn joined_meshes_keep_their_names_and_vertices() {
    let mut examples = arm(300);
    let len = examples.vertex_len();
    examples.ranges = vec![("sleeve".to_owned(), 0..120), ("hand".to_owned(), 120..len)];
    examples.validate().unwrap();
    let model = trained(&examples, &[]).model;
    let model = Model::from_bytes(model.as_slice()).unwrap();
    let ranges: Vec<_> = model.first::<Skin>().unwrap().ranges().collect();
    assert_eq!(ranges, [("sleeve", 0..120), ("hand", 120..len)]);
    // A range that overlaps the previous range, one beyond the mesh, and one that ends before it
    // starts.
    for ranges in [[(0, 120), (119, len)], [(0, 120), (120, len + 1)], [(0, 120), (125, 124)]] {
        examples.ranges =
            ranges.map(|(start, end)| ("x".to_owned(), std::ops::Range { start, end })).to_vec();
        assert!(examples.validate().is_err(), "{:?}", examples.ranges);
    }
}
