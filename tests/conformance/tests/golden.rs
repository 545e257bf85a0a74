//! The present bake writes the bytes of the golden files.
//!
//! `SINEW_BLESS=1 cargo test -p conformance golden::` rewrites the files. The golden files of
//! a released version are never rewritten.
use ::models::{
    GOLDEN_NAMES, GOLDEN_STRETCH_NAMES, Pieces, SMALL, Shape, ShapeContent, golden_path,
};
use faer::{Mat, MatRef};
use nalgebra::SMatrix;
use sinew_runtime::envelope::{Certificate, GroupConfidence, GroupKernel, Predictor};
use sinew_runtime::format::{ALIGNMENT, Axis, Element, Handedness, SectionKind, Space};
use sinew_runtime::{Envelope, Model, Skin};
use sinew_trainer::Error;
use sinew_trainer::envelope::model::{
    Curve, EnvelopeModel, Feature, FeatureOrder, FileModel, Group, Input, Key, Reconstruction,
    ShapeNumbers, Shapes, Shear, SkinModel,
};
use sinew_trainer::examples::Skeleton;
use sinew_trainer::files;
use sinew_trainer::regression::confidence::MapConfidence;
use sinew_trainer::regression::map::KernelMap;

/// Pseudo-random multiples of 1/64 in [-1, 1), which f32 holds exactly.
struct Dyadic(u32);

impl Dyadic {
    fn next(&mut self, scale: f64) -> f64 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let unit = f64::from(self.0 >> 25) / 64.0 - 1.0;
        unit * scale
    }

    fn list(&mut self, len: usize, scale: f64) -> Vec<f64> {
        (0..len).map(|_| self.next(scale)).collect()
    }

    /// Draws a matrix, row by row.
    fn matrix<const N: usize>(&mut self, scale: f64) -> SMatrix<f64, N, N> {
        SMatrix::from_row_slice(&self.list(N * N, scale))
    }

    /// Draws a matrix, row by row.
    fn dense(&mut self, rows: usize, columns: usize, scale: f64) -> Mat<f64> {
        MatRef::from_row_major_slice(&self.list(rows * columns, scale), rows, columns).to_owned()
    }
}

/// A golden envelope.
#[derive(Clone, Copy, Debug)]
struct Golden {
    predictor: Predictor,
    /// Whether joints stretch. Curves then move a kernel envelope.
    stretches: bool,
    /// Name of the file.
    file: &'static str,
}

const RIGID: Golden =
    Golden { predictor: Predictor::Kernel, stretches: false, file: GOLDEN_NAMES[1] };

fn goldens() -> impl Iterator<Item = Golden> {
    let names = [(false, GOLDEN_NAMES), (true, GOLDEN_STRETCH_NAMES)].into_iter();
    names.flat_map(|(stretches, files)| {
        let files = Predictor::ALL.into_iter().zip(files);
        files.map(move |(predictor, file)| Golden { predictor, stretches, file })
    })
}

/// Makes a model of an envelope and its skin: 24 vertices, 5 joints, 5 proxies, 4 influences; the
/// root is joint 3. An envelope of kernels that stretches has 3 curves.
fn file_model(golden: Golden) -> FileModel {
    let Golden { predictor, stretches, .. } = golden;
    let mut dyadic = Dyadic(7);
    let (v, j, p, root) = (24, 5, 5, 3);
    let curves = [("smile", [-1.0, 1.0]), ("blink", [0.0, 1.0]), ("jaw/open", [-0.5, 1.0])];
    let curves = curves.map(|(name, range)| Curve { name: name.to_owned(), range });
    let curves = curves.into_iter().filter(|_| stretches && predictor.corrects());
    let curves: Vec<_> = curves.collect();
    let order = FeatureOrder { joint_len: j, stretches };
    let feature_len = order.index(Feature::Curve(curves.len()));
    let rest_frames = (0..j).map(|joint| {
        let x = joint as f64;
        [[0.0, -1.0, 0.0, x], [1.0, 0.0, 0.0, 0.5], [0.0, 0.0, 1.0, 0.0]]
    });
    let axis = |i: usize| [0, 1, 2].map(|c| if i % 3 == c { 1.0 } else { 0.0 });
    let tangent = |i: usize| {
        let [x, y, z] = axis(i + 1);
        [x, y, z, if i.is_multiple_of(2) { 1.0 } else { -1.0 }]
    };
    let palette_len = if predictor == Predictor::Kernel { j + p } else { p };
    let influences = (0..v).map(|vertex| match vertex % 3 {
        0 => vec![(vertex % palette_len, 1.0)],
        1 => vec![(vertex % palette_len, 0.75), ((vertex + 1) % palette_len, 0.25)],
        _ => (0..4).map(|slot| ((vertex + slot) % palette_len, 0.25)).collect(),
    });
    let keys = (0..p).map(|l| Key {
        joint: l % j,
        twist: dyadic.matrix(0.5),
        residual: (l % 2 == 1).then(|| ((l + 2) % j, dyadic.matrix(0.25))),
        shear: {
            let turns = dyadic.matrix::<6>(0.125);
            let strains = if stretches { dyadic.matrix::<6>(0.125) } else { SMatrix::zeros() };
            Shear::from_fn(|r, c| if c < 6 { turns[(r, c)] } else { strains[(r, c - 6)] })
        },
    });
    let keys = keys.collect();
    let c1 = dyadic.dense(4 * p, 3 * p, 0.25);
    let mut c2 = dyadic.dense(4 * p, 4 * j, 0.25);
    // The sums of rows make the rest pose exact: c1 I + c2 rest = [I | 0].
    for row in 0..4 * p {
        for c in 0..3 {
            let of_c1 = c1.row(row).iter().skip(c).step_by(3).sum::<f64>();
            let of_c2 = c2.row(row).iter().skip(c).step_by(4).sum::<f64>();
            c2[(row, 4 * root + c)] -= of_c1 + of_c2 - if row % 4 == c { 1.0 } else { 0.0 };
        }
    }
    // Two, one and two proxies; odd sizes; the two predictors together have all four kernels.
    let first = usize::from(predictor.number());
    let groups = [(2, 5, 13, 3), (1, 9, 7, 11), (2, 3, 17, 1)].into_iter().enumerate();
    let mut end = 0;
    let groups = groups.map(|(g, (proxies, d, n, rank))| {
        end += proxies;
        let mut input = |i: usize| {
            // From the end, each group of an envelope that stretches has a curve and a strain.
            let index = match stretches {
                true => feature_len - 1 - (32 * i + g) % feature_len,
                false => (7 * i + 12 * g) % feature_len,
            };
            Input { feature: order.feature(index), weight: 0.75 - dyadic.next(0.25) }
        };
        Group {
            joint: 2 * g,
            proxies: end - proxies..end,
            inputs: (0..d).map(&mut input).collect(),
            map: KernelMap {
                kernel: GroupKernel::ALL[(first + g) % 4],
                centres: dyadic.dense(n, d, 1.0).transpose().to_owned(),
                coefficients: dyadic.dense(rank + 2, n + d, 0.25),
                confidence: MapConfidence {
                    len: 2,
                    reach: 4.0,
                    linear: 0.25,
                    signal: 8.0,
                    noise: 16.0,
                },
            },
            outputs: dyadic.dense(12 * proxies, rank, 0.25),
        }
    });
    let groups = if predictor.corrects() { groups.collect() } else { Vec::new() };
    let reconstruction = Reconstruction { keys, c1, c2 };
    let skin = SkinModel {
        name: "golden skin".to_owned(),
        envelope: Some(0),
        rest_positions: (0..v).map(|_| [(); 3].map(|()| dyadic.next(2.0))).collect(),
        rest_normals: (0..v).map(axis).collect(),
        rest_tangents: Some((0..v).map(tangent).collect()),
        influences: influences.collect(),
        tangent_coefficients: None,
        normal_errors: None,
        ranges: vec![("body".to_owned(), 0..20), ("eyes".to_owned(), 20..24)],
        shapes: Shapes::default(),
    };
    let envelope = EnvelopeModel {
        name: "golden".to_owned(),
        skeleton: Skeleton {
            names: ["hand", "elbow", "shoulder", "hip", "tail"].map(str::to_owned).to_vec(),
            parents: vec![Some(1), Some(2), Some(3), None, Some(3)],
            rest: rest_frames.collect(),
            ..Skeleton::default()
        },
        reconstruction: predictor.reconstructs().then_some(reconstruction),
        groups,
        pose_ranges: vec![2.0, 1.0, 0.75, 0.0, 1.25],
        pose_gaps: vec![0.0, 0.125, 0.0, 0.0, 0.0625],
        stretch_ranges: stretches.then(|| vec![0.25, 0.125, 0.25, 0.0, 0.25]),
        curves,
        certificate: Certificate {
            diagonal: 4.0,
            training_rms: 0.125,
            same_clips_rms: 0.25,
            lbs_training_rms: 0.5,
            correction_error: if predictor.corrects() { 0.0625 } else { 0.0 },
            base_training_rms: if predictor.corrects() { 0.375 } else { 0.125 },
            other_clip_rms: predictor.corrects().then_some(0.4375),
        },
    };
    let space = Space {
        up: Some(Axis::Y),
        forward: Some(Axis::Z),
        handedness: Handedness::Right,
        unit: Some(1.0),
    };
    FileModel { space, envelopes: vec![envelope], skins: vec![skin], ..FileModel::default() }
}

#[test]
fn bake_writes_the_golden_files() {
    for golden in goldens() {
        let baked = file_model(golden).bake().unwrap();
        let path = golden_path(golden.file);
        if std::env::var_os("SINEW_BLESS").is_some() {
            std::fs::write(&path, &baked).unwrap();
        }
        let file = std::fs::read(&path).unwrap();
        assert!(baked == file, "the baked bytes differ from the golden file of {golden:?}");
        // Controls: the comparison can fail, in each part that only some of the files have.
        let mut other = file_model(golden);
        let envelope = &mut other.envelopes[0];
        if let Some(reconstruction) = &mut envelope.reconstruction {
            reconstruction.c1[(0, 0)] += 1.0 / 64.0;
        } else {
            envelope.groups[0].outputs[(0, 0)] += 1.0 / 64.0;
        }
        assert!(other.bake().unwrap() != file);
        let edits: [fn(&mut EnvelopeModel) -> Option<()>; 3] = [
            |envelope| {
                envelope.stretch_ranges.as_mut()?[4] += 1.0 / 64.0;
                Some(())
            },
            |envelope| {
                envelope.stretch_ranges.as_ref()?;
                envelope.reconstruction.as_mut()?.keys[4].shear[(5, 11)] += 1.0 / 64.0;
                Some(())
            },
            |envelope| {
                envelope.curves.get_mut(2)?.range[1] += 1.0 / 64.0;
                Some(())
            },
        ];
        let mut edited = 0;
        for edit in edits {
            let mut other = file_model(golden);
            if edit(&mut other.envelopes[0]).is_some() {
                assert!(other.bake().unwrap() != file);
                edited += 1;
            }
        }
        assert_eq!(edited, if golden.stretches { 2 } else { 0 });
    }
}

#[test]
fn baked_parts_are_read_back() {
    goldens().for_each(read_back);
}

fn read_back(golden: Golden) {
    let parts = file_model(golden);
    let bytes = parts.bake().unwrap();
    let model = Model::from_bytes(bytes.as_slice()).unwrap();
    assert_eq!(model.space(), parts.space);
    for section in model.sections() {
        let offset = section.bytes.as_ptr().addr() - bytes.as_ptr().addr();
        assert!(offset.is_multiple_of(ALIGNMENT), "sections are aligned in the file");
    }
    read_back_envelope(&parts.envelopes[0], model.envelope_named("golden").unwrap());
    let skin = model.skin_named("golden skin").unwrap();
    read_back_skin(&parts.skins[0], skin);
    assert_eq!(model.envelope_of(&skin).map(|found| found.part()), Some(0));
}

fn read_back_envelope(parts: &EnvelopeModel, envelope: Envelope<'_>) {
    assert_eq!(envelope.parent(0), Some(1));
    assert_eq!(envelope.joint_name(3), Some("hip"));
    assert_eq!(envelope.evaluation_order().collect::<Vec<_>>(), [3, 2, 4, 1, 0]);
    // The inverse of a quarter turn about z at (x, 0.5, 0).
    let inverse = [[0.0, 1.0, 0.0, -0.5], [-1.0, 0.0, 0.0, 2.0], [0.0, 0.0, 1.0, 0.0]];
    assert_eq!(envelope.inverse_bind(2), Some(inverse));
    assert_eq!(envelope.predictor(), parts.predictor());
    assert_eq!(envelope.certificate(), parts.certificate);
    read_back_groups(parts, envelope);
    read_back_movements(parts, envelope);
    for (l, key) in parts.keys().iter().enumerate() {
        let found = envelope.key(l).unwrap();
        assert_eq!(found.joint, key.joint);
        assert_eq!(wide(found.twist), key.twist);
        assert_eq!(wide(found.shear), key.shear.fixed_columns::<6>(0).into_owned());
        let strains = parts.stretch_ranges.as_ref();
        let strains = strains.map(|_| key.shear.fixed_columns::<6>(6).into_owned());
        assert_eq!(found.stretch.map(wide), strains);
        assert_eq!(found.residual.map(|(j, m)| (j, wide(m))), key.residual);
    }
    let base = parts.reconstruction.as_ref();
    for (row, column) in (0..20).flat_map(|row| (0..20).map(move |column| (row, column))) {
        let c1 = base.filter(|_| column < 15).map(|base| base.c1[(row, column)]);
        let c2 = base.map(|base| base.c2[(row, column)]);
        assert_eq!(envelope.c1(row, column).map(f64::from), c1);
        assert_eq!(envelope.c2(row, column).map(f64::from), c2);
    }
}

/// Compares the ranges of stretches, and the curves.
fn read_back_movements(parts: &EnvelopeModel, envelope: Envelope<'_>) {
    assert_eq!(envelope.stretches(), parts.stretch_ranges.is_some());
    for joint in 0..parts.joint_len() {
        let range = parts.stretch_ranges.as_ref().map_or(0.0, |ranges| ranges[joint]);
        assert_eq!(envelope.stretch_range(joint).map(f64::from), Some(range));
    }
    assert_eq!(envelope.curve_len(), parts.curves.len());
    for (index, curve) in parts.curves.iter().enumerate() {
        assert_eq!(envelope.curve_name(index), Some(&*curve.name));
        assert_eq!(
            envelope.curve_range(index).map(|range| range.map(f64::from)),
            Some(curve.range)
        );
    }
}

fn wide<const N: usize>(rows: [[f32; N]; N]) -> SMatrix<f64, N, N> {
    SMatrix::from_fn(|r, c| f64::from(rows[r][c]))
}

fn read_back_skin(parts: &SkinModel, skin: Skin<'_>) {
    let ranges = skin.ranges().map(|(name, range)| (name.to_owned(), range));
    assert_eq!(ranges.collect::<Vec<_>>(), parts.ranges);
    assert_eq!(skin.vertex_len(), parts.rest_positions.len());
    for (vertex, influences) in parts.influences.iter().enumerate() {
        let found = skin.influences(vertex).filter(|(_, weight)| *weight > 0.0);
        let found = found.map(|(index, weight)| (index, f64::from(weight)));
        assert_eq!(&found.collect::<Vec<_>>(), influences);
        let wide = |x: [f32; 3]| x.map(f64::from);
        assert_eq!(skin.rest_position(vertex).map(wide), Some(parts.rest_positions[vertex]));
        assert_eq!(skin.rest_normal(vertex).map(wide), Some(parts.rest_normals[vertex]));
        let tangent = skin.rest_tangent(vertex).map(|t| t.map(f64::from));
        assert_eq!(tangent, parts.rest_tangents.as_ref().map(|tangents| tangents[vertex]));
    }
}

fn read_back_groups(parts: &EnvelopeModel, envelope: Envelope<'_>) {
    let order = parts.feature_order();
    assert_eq!(envelope.group_len(), parts.groups.len());
    for (joint, [x, y, z]) in parts.skeleton.rest.iter().enumerate() {
        let origin = envelope.origin(joint).map(|o| o.map(f64::from));
        assert_eq!(origin, (!parts.groups.is_empty()).then_some([x[3], y[3], z[3]]));
    }
    for (found, group) in envelope.groups().zip(&parts.groups) {
        let KernelMap { kernel, centres, coefficients, confidence } = &group.map;
        let dense = |like: &Mat<f64>, entry: &dyn Fn(usize, usize) -> Option<f32>| {
            Mat::from_fn(like.nrows(), like.ncols(), |r, c| f64::from(entry(r, c).unwrap()))
        };
        assert_eq!((found.joint, found.kernel), (group.joint, *kernel));
        assert_eq!(found.proxies, group.proxies);
        let GroupConfidence { reach, linear, signal, noise } = found.confidence;
        let read = MapConfidence {
            len: found.certainty_len(),
            reach: reach.into(),
            linear: linear.into(),
            signal: signal.into(),
            noise: noise.into(),
        };
        assert_eq!(read, *confidence);
        for (i, &Input { feature, weight }) in group.inputs.iter().enumerate() {
            assert_eq!(found.input(i), Some((order.index(feature), weight as f32)));
        }
        assert_eq!(&dense(centres, &|i, k| found.centre(k, i)), centres);
        // Every kernel is 1 at the centre, and falls from there.
        let falls = |k| found.rest(k).is_some_and(|rest| (0.0..1.0).contains(&rest));
        assert!((0..centres.ncols()).all(falls));
        assert_eq!(&dense(coefficients, &|r, c| found.coefficient(r, c)), coefficients);
        assert_eq!(&dense(&group.outputs, &|r, c| found.output(r, c)), &group.outputs);
    }
}

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
        let mut skin = SkinModel::from_file(&expected.skin().unwrap());
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

fn curve(range: [f64; 2]) -> Curve {
    Curve { name: "curve".to_owned(), range }
}

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
        |p, _| p.groups.truncate(2),
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

#[test]
fn files_are_replaced_whole_or_not_at_all() {
    let folder = std::env::temp_dir().join(format!("sinew-golden-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("model.snw");
    for content in [b"old".as_slice(), b"new and longer"] {
        files::write(&path, content).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), content);
    }
    // A folder has the file's name, so the rename fails and must leave nothing behind.
    let taken = folder.join("taken");
    std::fs::create_dir_all(taken.join("full")).unwrap();
    assert!(files::write(&taken, b"x").is_err());
    assert!(files::write(&folder.join("missing/model.snw"), b"x").is_err());
    let mut left = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name());
    assert!(left.all(|name| name == "model.snw" || name == "taken"));
    std::fs::remove_dir_all(&folder).unwrap();
}
