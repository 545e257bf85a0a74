//! Skinning of eight vertices at a time, with four influences and tangent coefficients each.
//!
//! The operations and their order are those of [`Vertex`](super::normals::Vertex), so the bits are equal.

use super::normals::Frame;
use crate::lanes::Register;
use crate::linear::{Le, Matrix3x4, cross, dot, floats};
use crate::numeric::sqrt;
use core::ops::Range;
use core::slice;
use glam::{Mat4, Vec4};

/// Vertices in a batch.
pub(super) const EIGHT: usize = 8;
/// Vertices in one 4 x 4 transpose.
const FOUR: usize = 4;

/// One number of each of the eight vertices.
#[derive(Clone, Copy)]
#[repr(align(32))]
struct Lane([f32; EIGHT]);

/// Eight vertices in the layout of the file: one row for each vertex.
#[derive(Clone, Copy)]
pub(super) struct Rows<'a> {
    pub(super) positions: &'a [[Le; 3]; EIGHT],
    pub(super) normals: &'a [[Le; 3]; EIGHT],
    /// `None` if the skin has no rest tangents.
    pub(super) tangents: Option<&'a [[Le; 4]; EIGHT]>,
    pub(super) indices: &'a [[[u8; 2]; 4]; EIGHT],
    pub(super) weights: &'a [[Le; 4]; EIGHT],
    /// g and h of the first three influences, as two f16.
    pub(super) coefficients: &'a [[Le; 3]; EIGHT],
}

/// Eight vertices and their transforms, one lane for each number.
pub(super) struct Columns {
    /// Indexed by influence, row and column.
    transforms: [[[Lane; 4]; 3]; 4],
    weights: [Lane; 4],
    positions: [Lane; 4],
    normals: [Lane; 4],
    tangents: [Lane; 4],
    coefficients: [[u32; EIGHT]; 3],
}

/// Eight posed vertices.
pub(super) struct Posed {
    /// One row for each vertex; the fourth number is unused.
    pub(super) positions: [[f32; 4]; EIGHT],
    /// One row for each vertex; the fourth number is unused. A normal has length 1 if its squared length is normal.
    pub(super) normals: [[f32; 4]; EIGHT],
    /// Squared lengths of the normals before their division.
    pub(super) squared_lengths: [f32; EIGHT],
}

impl Posed {
    pub(super) const NONE: Self = Self {
        positions: [[0.0; 4]; EIGHT],
        normals: [[0.0; 4]; EIGHT],
        squared_lengths: [0.0; EIGHT],
    };
}

impl Columns {
    pub(super) const NONE: Self = {
        const ZERO: Lane = Lane([0.0; EIGHT]);
        Self {
            transforms: [[[ZERO; 4]; 3]; 4],
            weights: [ZERO; 4],
            positions: [ZERO; 4],
            normals: [ZERO; 4],
            tangents: [ZERO; 4],
            coefficients: [[0; EIGHT]; 3],
        }
    };

    /// Reads eight vertices and their transforms.
    ///
    /// `None` if an index is beyond the palette. Loading checks the indices, so the file's bytes must have changed
    /// since.
    #[inline(always)]
    pub(super) fn read(&mut self, rows: &Rows<'_>, palette: &[Matrix3x4]) -> Option<()> {
        for half in 0..EIGHT / FOUR {
            let indices = four(rows.indices, half)?;
            for (k, [x, y, z]) in self.transforms.iter_mut().enumerate() {
                let transform = |vertex: usize| {
                    palette.get(usize::from(u16::from_le_bytes(indices[vertex][k])))
                };
                let (a, b, c, d) = (transform(0)?, transform(1)?, transform(2)?, transform(3)?);
                set(x, half, [a[0], b[0], c[0], d[0]]);
                set(y, half, [a[1], b[1], c[1], d[1]]);
                set(z, half, [a[2], b[2], c[2], d[2]]);
            }
            set_fours(&mut self.weights, half, four(rows.weights, half)?);
            set_threes(&mut self.positions, half, four(rows.positions, half)?);
            set_threes(&mut self.normals, half, four(rows.normals, half)?);
            if let Some(tangents) = rows.tangents {
                set_fours(&mut self.tangents, half, four(tangents, half)?);
            }
        }
        let [a, b, c] = &mut self.coefficients;
        for ((([x, y, z], a), b), c) in rows.coefficients.iter().zip(a).zip(b).zip(c) {
            (*a, *b, *c) = (u32::from_le_bytes(*x), u32::from_le_bytes(*y), u32::from_le_bytes(*z));
        }
        Some(())
    }

    /// Computes the posed vertices.
    ///
    /// - `by_tangent`: whether the frame is made of the rest tangents.
    /// - `side`: side of the palette, 1 or -1.
    #[inline(always)]
    pub(super) fn pose(&self, by_tangent: bool, side: f32, out: &mut Posed) {
        let (x, n) = (three(&self.positions), three(&self.normals));
        let frame = if by_tangent {
            Frame::of_tangent(n, three(&self.tangents))
        } else {
            Frame::of_normal(n, n[2])
        };
        let [a, b, c] = self.coefficients;
        let ([g0, h0], [g1, h1], [g2, h2]) =
            (Register::halves(a), Register::halves(b), Register::halves(c));
        let coefficients = ([g0, g1, g2], [h0, h1, h2]);
        let [px, ux, vx] = self.coordinate::<0>(x, &frame, coefficients);
        let [py, uy, vy] = self.coordinate::<1>(x, &frame, coefficients);
        let [pz, uz, vz] = self.coordinate::<2>(x, &frame, coefficients);
        rows([px, py, pz], &mut out.positions);
        let normal = cross([ux, uy, uz], [vx, vy, vz]);
        let square = dot(normal, normal);
        let scale = Register::from(side) / sqrt(square);
        let [nx, ny, nz] = normal;
        rows([nx * scale, ny * scale, nz * scale], &mut out.normals);
        out.squared_lengths = square.to_array();
    }

    /// Computes one coordinate of the posed positions and of the two posed directions of the frame.
    #[inline(always)]
    fn coordinate<const ROW: usize>(
        &self,
        x: [Register; 3],
        frame: &Frame<Register>,
        (g, h): ([Register; 3], [Register; 3]),
    ) -> [Register; 3] {
        let [p, q, r, s] = &self.transforms;
        let last = moved(&s[ROW], x);
        let apart = [moved(&p[ROW], x) - last, moved(&q[ROW], x) - last, moved(&r[ROW], x) - last];
        let linear = [self.entry::<ROW, 0>(), self.entry::<ROW, 1>(), self.entry::<ROW, 2>()];
        [
            dot(linear, x) + self.entry::<ROW, 3>(),
            dot(linear, frame.g) + dot(g, apart),
            dot(linear, frame.h) + dot(h, apart),
        ]
    }

    /// Returns an entry of the blended transforms.
    #[inline(always)]
    fn entry<const ROW: usize, const COLUMN: usize>(&self) -> Register {
        let [p, q, r, s] = &self.transforms;
        let [w0, w1, w2, w3] = &self.weights;
        let sum = Register::from(0.0) + register(&p[ROW][COLUMN]) * register(w0);
        let sum = sum + register(&q[ROW][COLUMN]) * register(w1);
        let sum = sum + register(&r[ROW][COLUMN]) * register(w2);
        sum + register(&s[ROW][COLUMN]) * register(w3)
    }
}

/// Lists an attribute of a range of vertices in batches of eight; the last few vertices are left out.
pub(super) fn eights<'a, T>(
    all: &'a [T],
    range: &Range<usize>,
) -> Option<slice::Iter<'a, [T; EIGHT]>> {
    Some(all.get(range.clone())?.as_chunks().0.iter())
}

#[inline(always)]
fn register(lane: &Lane) -> Register {
    Register::from(lane.0)
}

/// Returns one coordinate of the vertices, moved by a row of their transforms.
#[inline(always)]
fn moved([a, b, c, d]: &[Lane; 4], [x, y, z]: [Register; 3]) -> Register {
    register(a) * x + register(b) * y + register(c) * z + register(d)
}

#[inline(always)]
fn three([x, y, z, _]: &[Lane; 4]) -> [Register; 3] {
    [register(x), register(y), register(z)]
}

/// Returns four of the eight vertices: half 0 or half 1.
#[inline(always)]
fn four<T>(eight: &[T; EIGHT], half: usize) -> Option<&[T; FOUR]> {
    eight.as_chunks().0.get(half)
}

/// Writes four numbers of four vertices into one half of the lanes.
#[inline(always)]
fn set(lanes: &mut [Lane; 4], half: usize, rows: [[f32; 4]; FOUR]) {
    let columns = transposed(rows);
    for (lane, column) in lanes.iter_mut().zip(columns) {
        if let Some(out) = lane.0.as_chunks_mut().0.get_mut(half) {
            *out = column;
        }
    }
}

#[inline(always)]
fn set_fours(lanes: &mut [Lane; 4], half: usize, [a, b, c, d]: &[[Le; 4]; FOUR]) {
    set(lanes, half, [floats(a), floats(b), floats(c), floats(d)]);
}

#[inline(always)]
fn set_threes(lanes: &mut [Lane; 4], half: usize, [a, b, c, d]: &[[Le; 3]; FOUR]) {
    let of = |le: &[Le; 3]| {
        let [x, y, z] = floats(le);
        [x, y, z, 0.0]
    };
    set(lanes, half, [of(a), of(b), of(c), of(d)]);
}

/// Transposes three numbers of each vertex into one row for each vertex.
#[inline(always)]
fn rows([x, y, z]: [Register; 3], out: &mut [[f32; 4]; EIGHT]) {
    let (x, y, z) = (x.to_array(), y.to_array(), z.to_array());
    for (half, out) in out.as_chunks_mut::<FOUR>().0.iter_mut().enumerate() {
        if let (Some(x), Some(y), Some(z)) = (four(&x, half), four(&y, half), four(&z, half)) {
            *out = transposed([*x, *y, *z, *z]);
        }
    }
}

#[inline(always)]
fn transposed([a, b, c, d]: [[f32; 4]; FOUR]) -> [[f32; FOUR]; 4] {
    let [a, b, c, d] =
        [Vec4::from_array(a), Vec4::from_array(b), Vec4::from_array(c), Vec4::from_array(d)];
    Mat4::from_cols(a, b, c, d).transpose().to_cols_array_2d()
}
