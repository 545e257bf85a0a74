//! The caller's rest meshes, and the bounding box of a posed skin.

use crate::common::{IDENTITY, apart, bits, palette, random_pose, rest, run, skinned, with_skin};
use models::{Pieces, Rest, Rng, SMALL, Shape, direction, floats};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::SectionKind;
use sinew_runtime::skin::{Bounds, Output};
use sinew_runtime::{Envelope, Matrix3x4, Model, Skin, SkinJob};

const CROWD: Shape = Shape { vertices: 60, joints: 6, proxies: 5, influences: 4, ..SMALL };

/// Another mesh with an equal number of vertices.
struct Mesh {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    tangents: Vec<[f32; 4]>,
}

impl Mesh {
    fn new(vertex_len: usize, seed: u64) -> Self {
        let mut rng = Rng(seed);
        let mut point = || [rng.unit(), rng.unit(), rng.unit()].map(|x| 3.0 * x);
        let positions = (0..vertex_len).map(|_| point()).collect();
        let normals = (0..vertex_len).map(|_| direction(&mut rng)).collect();
        let tangent = |rng: &mut Rng| {
            let [x, y, z] = direction(rng);
            [z, x, y, if rng.unit() < 0.0 { -1.0 } else { 1.0 }]
        };
        Self { positions, normals, tangents: (0..vertex_len).map(|_| tangent(&mut rng)).collect() }
    }

    fn rest(&self) -> Rest<'_> {
        Rest {
            positions: Some(&self.positions),
            normals: Some(&self.normals),
            tangents: Some(&self.tangents),
        }
    }

    /// Stores the mesh in a file.
    fn write(&self, pieces: &mut Pieces) {
        pieces.set_vertices(SectionKind::RestPositions, &floats(self.positions.as_flattened()));
        pieces.set_vertices(SectionKind::RestNormals, &floats(self.normals.as_flattened()));
        pieces.set_vertices(SectionKind::RestTangents, &floats(self.tangents.as_flattened()));
        let boxes = pieces.sections.iter_mut().find(|c| c.kind == SectionKind::RestBoxes.number());
        if let Some(boxes) = boxes {
            let all = [-9.0, -9.0, -9.0, 9.0, 9.0, 9.0f32];
            boxes.bytes = floats(&all.repeat(boxes.bytes.len() / 24));
        }
    }
}

#[test]
fn a_mesh_of_the_callers_has_the_bits_of_a_file_with_that_mesh() {
    let of = |influences, coefficients| Shape { influences, coefficients, ..SMALL };
    let shapes = [of(2, true), of(4, true), of(2, false), of(4, false)];
    for (predictor, shape) in Predictor::ALL.into_iter().flat_map(|p| shapes.map(|s| (p, s))) {
        let mut pieces = Pieces::sample(predictor, shape);
        let model = Model::from_bytes(pieces.bytes()).unwrap();
        let mesh = Mesh::new(SMALL.vertices, 29);
        mesh.write(&mut pieces);
        let baked = Model::from_bytes(pieces.bytes()).unwrap();
        let envelope = model.first::<Envelope>().unwrap();
        let palette = palette(&envelope, &random_pose(&envelope, &mut Rng(5), 0.3));
        let (skin, expected) =
            (model.first::<Skin>().unwrap(), skinned(baked.first::<Skin>().unwrap(), &palette));
        let given = mesh.rest().of(SkinJob::new(skin, &palette));
        assert_eq!(bits(&run(&given)), bits(&expected), "{predictor:?}");
        assert_ne!(run(&given), skinned(skin, &palette), "the file's own mesh is another");
        // Each attribute of the mesh separately, the others from the file. With coefficients the
        // attributes depend on each other.
        let v = skin.vertex_len();
        let own = skinned(skin, &palette);
        let alone = [(0, 0..3 * v), (1, 3 * v..6 * v), (2, 6 * v..10 * v)];
        for (at, range) in alone.into_iter().filter(|_| !shape.coefficients) {
            let mut rest = Rest::default();
            match at {
                0 => rest.positions = mesh.rest().positions,
                1 => rest.normals = mesh.rest().normals,
                _ => rest.tangents = mesh.rest().tangents,
            }
            let mut mixed = own.clone();
            mixed[range.clone()].copy_from_slice(&expected[range]);
            assert_eq!(bits(&run(&rest.of(SkinJob::new(skin, &palette)))), bits(&mixed));
        }
        // Positions without other attributes; and a remap over the vertices.
        let mut positions = vec![f32::NAN; 3 * v];
        let out = Output::new(&mut positions, 3);
        given.clone().positions(out).run().unwrap();
        assert_eq!(bits(&positions), bits(&expected[..3 * v]));
        let remap = [3, 1, 6];
        let remapped = given.clone().remap(&remap);
        let baked = SkinJob::new(baked.first::<Skin>().unwrap(), &palette).remap(&remap);
        assert_eq!(bits(&run(&remapped)), bits(&run(&baked)));
    }
}

#[test]
fn a_skin_without_an_envelope_stays_at_rest() {
    let mut pieces = Pieces::loose(SMALL);
    let model = Model::from_bytes(pieces.bytes()).unwrap();
    let skin = model.first::<Skin>().unwrap();
    assert_eq!(skinned(skin, &[]).len(), 10 * SMALL.vertices);
    let still = |found: &[f32], rest: &[f32]| {
        let positions = 3 * SMALL.vertices;
        assert_eq!(found[..positions], rest[..positions]);
        assert!(crate::common::max_difference(found, rest) < 2e-7);
    };
    still(&skinned(skin, &[]), &rest(skin));
    // A job with the caller's mesh equals a job with a file of this mesh.
    let mesh = Mesh::new(SMALL.vertices, 31);
    let given = run(&mesh.rest().of(SkinJob::new(skin, &[])));
    mesh.write(&mut pieces);
    let baked = Model::from_bytes(pieces.bytes()).unwrap();
    still(&given, &rest(baked.first::<Skin>().unwrap()));
    assert_eq!(bits(&given), bits(&skinned(baked.first::<Skin>().unwrap(), &[])));
    let mut out = vec![[f32::NAN; 3]; SMALL.vertices];
    skin.skin_positions(&[], &mut out).unwrap();
    assert_eq!(out.as_flattened(), &rest(skin)[..3 * SMALL.vertices]);
    // The box bounds its vertices, and a widened box bounds the vertices of copies.
    let own = skin.bounds(&[], 0.0).unwrap().unwrap();
    assert!(out.iter().all(|&x| own.contains(x)));
    for axis in 0..3 {
        let of = out.iter().map(|x| x[axis]);
        assert_eq!(own.min[axis], of.clone().fold(f32::MAX, f32::min));
        assert_eq!(own.max[axis], of.fold(f32::MIN, f32::max));
    }
    let wide = skin.bounds(&[], 0.5).unwrap().unwrap();
    assert!(wide.contains(own.max.map(|x| x + 0.5)) && wide.contains(own.min.map(|x| x - 0.5)));
    assert!(!wide.contains(own.max.map(|x| x + 0.501)));
}

#[test]
fn bounds_hold_every_vertex() {
    with_skin(CROWD, |envelope, skin| {
        let mut rng = Rng(23);
        for _ in (0..300).step_by(apart(100)) {
            let palette = palette(&envelope, &random_pose(&envelope, &mut rng, 2.0));
            let mut out = vec![[0.0; 3]; skin.vertex_len()];
            skin.skin_positions(&palette, &mut out).unwrap();
            let bounds = skin.bounds(&palette, 0.0).unwrap().unwrap();
            assert!(out.iter().all(|&x| bounds.contains(x)));
            // Control: the check can fail.
            let top = bounds.max.map(|x| x + 1e-3);
            assert!(!bounds.contains(top) && !bounds.contains([f32::NAN; 3]));
        }
        // Tight for the identity: the box of the mesh itself, up to the slack.
        let identity = vec![IDENTITY; envelope.palette_len()];
        let bounds = skin.bounds(&identity, 0.0).unwrap().unwrap();
        let x = (0..skin.vertex_len()).map(|v| skin.rest_position(v).unwrap()[0]);
        let max = x.fold(f32::MIN, f32::max);
        assert!(bounds.max[0] >= max && bounds.max[0] < max + 1e-4);
    });
}

/// Whether the box for an offset holds every vertex of the caller's posed mesh.
fn holds(skin: Skin<'_>, palette: &[Matrix3x4], mesh: &[[f32; 3]], offset: f32) -> bool {
    let rest = Rest { positions: Some(mesh), ..Rest::default() };
    let mut out = vec![f32::NAN; 3 * mesh.len()];
    let positions = Output::new(&mut out, 3);
    rest.of(SkinJob::new(skin, palette)).positions(positions).run().unwrap();
    let bounds: Bounds = skin.bounds(palette, offset).unwrap().unwrap();
    out.as_chunks::<3>().0.iter().all(|&x| bounds.contains(x))
}

/// Largest distance between a mesh and the skin's along any axis, rounded up.
fn offset(skin: Skin<'_>, mesh: &[[f32; 3]]) -> f32 {
    let own = (0..skin.vertex_len()).flat_map(|vertex| skin.rest_position(vertex).unwrap());
    let apart = own.zip(mesh.as_flattened()).map(|(a, b)| (f64::from(a) - f64::from(*b)).abs());
    let most = apart.fold(0.0, f64::max);
    let rounded = most as f32;
    if f64::from(rounded) < most { rounded.next_up() } else { rounded }
}

#[test]
fn bounds_hold_every_vertex_of_an_offset_mesh() {
    let loose = Model::from_bytes(Pieces::loose(CROWD).bytes()).unwrap();
    with_skin(CROWD, |envelope, skin| {
        let mut rng = Rng(37);
        let mut beyond = 0;
        for i in (0..400).step_by(apart(100)) {
            let scale = [1e-6, 1e-3, 0.1, 1.0, 30.0][i % 5];
            let turn = [0.0, 0.3, 2.0][i % 3];
            let palette = palette(&envelope, &random_pose(&envelope, &mut rng, turn));
            let moved = |x: f32, rng: &mut Rng| {
                // Often the full offset: the corners of the box of offsets.
                let by = rng.unit();
                x + scale * if by.abs() > 0.5 { by.signum() } else { by }
            };
            for (skin, palette) in
                [(skin, palette.as_slice()), (loose.first::<Skin>().unwrap(), &[])]
            {
                let mesh = (0..skin.vertex_len())
                    .map(|vertex| skin.rest_position(vertex).unwrap().map(|x| moved(x, &mut rng)));
                let mesh = mesh.collect::<Vec<_>>();
                let offset = offset(skin, &mesh);
                assert!(holds(skin, palette, &mesh, offset), "{scale} {turn}");
                beyond += usize::from(!holds(skin, palette, &mesh, 0.0));
            }
        }
        // Control: without the offset some vertices lie outside.
        assert!(cfg!(miri) || beyond > 400, "{beyond}");
    });
}

#[test]
fn bounds_for_too_small_an_offset_do_not_hold() {
    let loose = Model::from_bytes(Pieces::loose(CROWD).bytes()).unwrap();
    with_skin(CROWD, |envelope, skin| {
        let identity = vec![IDENTITY; envelope.palette_len()];
        for (skin, palette) in [(skin, identity.as_slice()), (loose.first::<Skin>().unwrap(), &[])]
        {
            for axis in 0..3 {
                let along = |by: f32| {
                    let mesh = (0..skin.vertex_len()).map(|vertex| {
                        let mut x = skin.rest_position(vertex).unwrap();
                        x[axis] += by;
                        x
                    });
                    mesh.collect::<Vec<_>>()
                };
                for by in [0.5, -0.5, 8.0, -8.0] {
                    assert!(holds(skin, palette, &along(by), by.abs()));
                    assert!(!holds(skin, palette, &along(by), 0.99 * by.abs()), "{axis} {by}");
                }
            }
        }
    });
}
