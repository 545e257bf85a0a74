//! Where a skin is written: ranges, strides, buffers, single attributes, remaps. The bits never
//! change.

use crate::common::{IDENTITY, bits, palette, random_pose, run, skinned, with_skin};
use models::{Rng, SMALL, Shape, cells};
use sinew_runtime::skin::Output;
use sinew_runtime::{CallErrorKind, Envelope, Skin, SkinJob};

#[test]
fn ranges_strides_and_buffers_change_places_only() {
    for influences in [2, 4] {
        with_skin(Shape { influences, ..SMALL }, ranges_strides_and_buffers);
    }
}

fn ranges_strides_and_buffers(envelope: Envelope<'_>, skin: Skin<'_>) {
    let palette = palette(&envelope, &random_pose(&envelope, &mut Rng(5), 0.3));
    let v = skin.vertex_len();
    let whole = skinned(skin, &palette);
    // Interleaved in one buffer: a gap, position, a gap, normal. Tangents are in another buffer.
    // Two jobs, as in a job system.
    let (mut a, mut b) = (vec![-7.0; 1 + 8 * v], vec![-7.0; 4 * v]);
    for vertices in [0..3, 3..v] {
        let a = cells(&mut a[8 * vertices.start..][..1 + 8 * vertices.len()]);
        SkinJob::new(skin, &palette)
            .positions(Output::shared(&a[1..], 8))
            .normals(Output::shared(&a[5..], 8))
            .tangents(Output::new(&mut b[4 * vertices.start..4 * vertices.end], 4))
            .vertices(vertices)
            .run()
            .unwrap();
    }
    assert_eq!(a[0], -7.0);
    for vertex in 0..v {
        let a = &a[1 + 8 * vertex..][..8];
        assert_eq!(a[..3], whole[3 * vertex..][..3]);
        assert_eq!(a[3], -7.0);
        assert_eq!(a[4..7], whole[3 * (v + vertex)..][..3]);
    }
    assert_eq!(b, whole[6 * v..]);

    let mut positions = vec![[0.0; 3]; v];
    skin.skin_positions(&palette, &mut positions).unwrap();
    assert_eq!(positions.as_flattened(), &whole[..3 * v]);
}

#[test]
fn a_vertex_fits_in_one_buffer() {
    with_skin(SMALL, |envelope, skin| {
        let palette = palette(&envelope, &random_pose(&envelope, &mut Rng(5), 0.3));
        let v = skin.vertex_len();
        let whole = skinned(skin, &palette);
        let of = |at: usize, len: usize| &whole[at..][..len];
        let mut out = vec![-7.0; 12 * v];
        let [tangents, positions, normals] = Output::interleaved(&mut out, 12, [8, 0, 4]);
        let job = SkinJob::new(skin, &palette).positions(positions).normals(normals);
        job.tangents(tangents).run().unwrap();
        for (i, vertex) in out.chunks(12).enumerate() {
            let (normal, tangent) = (of(3 * (v + i), 3), of(6 * v + 4 * i, 4));
            let expected = [of(3 * i, 3), &[-7.0], normal, &[-7.0], tangent].concat();
            assert_eq!(vertex, expected);
        }
        // An offset beyond the buffer.
        let [positions] = Output::interleaved(&mut out[..3], 12, [4]);
        let error = SkinJob::new(skin, &palette).positions(positions).run().unwrap_err();
        assert_eq!((error.kind, error.found), (CallErrorKind::TooShort, 0));
    });
}

#[test]
fn each_attribute_alone_has_the_same_bits() {
    with_skin(SMALL, |envelope, skin| {
        let palette = palette(&envelope, &random_pose(&envelope, &mut Rng(5), 0.3));
        let v = skin.vertex_len();
        let whole = bits(&skinned(skin, &palette));
        for (start, len) in [(0, 3), (3 * v, 3), (6 * v, 4)] {
            let mut out = vec![f32::NAN; len * v];
            let (alone, own) = (SkinJob::new(skin, &palette), Output::new(&mut out, len));
            let alone = match start / v {
                0 => alone.positions(own),
                3 => alone.normals(own),
                _ => alone.tangents(own),
            };
            alone.run().unwrap();
            assert_eq!(bits(&out), whole[start..start + len * v]);
        }
    });
}

#[test]
fn no_vertex_and_one_vertex() {
    with_skin(Shape { vertices: 0, ..SMALL }, |envelope, skin| {
        let palette = palette(&envelope, &vec![IDENTITY; envelope.joint_len()]);
        skin.skin_positions(&palette, &mut []).unwrap();
        assert_eq!(skin.bounds(&palette, 0.0), Ok(None));
        assert_eq!(skin.bounds(&palette, 1.0), Ok(None));
        assert!(skinned(skin, &palette).is_empty());
    });
    let one = Shape {
        vertices: 1,
        joints: 1,
        proxies: 1,
        influences: 1,
        tangents: false,
        coefficients: false,
        ..SMALL
    };
    with_skin(one, |envelope, skin| {
        let palette = palette(&envelope, &[IDENTITY]);
        let mut out = [[0.0; 3]];
        skin.skin_positions(&palette, &mut out).unwrap();
        assert_eq!(Some(out[0]), skin.rest_position(0));
    });
}

#[test]
fn a_remap_gives_the_bits_of_the_vertices_that_it_names() {
    for influences in [2, 4] {
        with_skin(Shape { influences, ..SMALL }, |envelope, skin| {
            let palette = palette(&envelope, &random_pose(&envelope, &mut Rng(5), 0.3));
            // Repeated, reversed and missing vertices, and more entries than the mesh has vertices.
            let remap = [6, 0, 0, 5, 4, 6, 1, 1, 3, 0, 6];
            let remapped = SkinJob::new(skin, &palette).vertices(0..remap.len()).remap(&remap);
            let (found, n) = (run(&remapped), remap.len());
            let (whole, v) = (skinned(skin, &palette), skin.vertex_len());
            for (i, vertex) in remap.into_iter().map(|vertex| vertex as usize).enumerate() {
                for (len, of_found, of_whole) in [(3, 0, 0), (3, 3 * n, 3 * v), (4, 6 * n, 6 * v)] {
                    let found = &found[of_found + len * i..][..len];
                    let expected = &whole[of_whole + len * vertex..][..len];
                    assert_eq!(bits(found), bits(expected), "{vertex}");
                }
                // Single vertices, by a range of the mesh.
                let alone = run(&SkinJob::new(skin, &palette).vertices(vertex..vertex + 1));
                assert_eq!(bits(&alone[..3]), bits(&found[3 * i..][..3]));
                assert_eq!(bits(&alone[3..6]), bits(&found[3 * (n + i)..][..3]));
            }
            // The range counts entries of the remap.
            let part = run(&remapped.clone().vertices(3..5));
            assert_eq!(part[..6], found[9..15]);
            // Positions without normals have a separate loop.
            let mut positions = vec![f32::NAN; 3 * n];
            let out = Output::new(&mut positions, 3);
            remapped.positions(out).run().unwrap();
            assert_eq!(bits(&positions), bits(&found[..3 * n]));
        });
    }
}
