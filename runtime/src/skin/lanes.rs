//! Tangent coefficients of vertices side by side: what `coefficients` does to one vertex, in the same order, to eight
//! with four influences each.
//!
//! One loop over the lanes holds all of the arithmetic, and no other loop: so a compiler leaves it whole and makes
//! vectors of it, as wide as the target has.

use crate::linear::{Le, Matrix3x4, floats};
use crate::numeric::halves;
use glam::{Mat4, Vec4};

/// Vertices side by side.
pub(super) const LANES: usize = 8;
/// Of them those that are read at once.
pub(super) const QUAD: usize = 4;

/// One number of each vertex.
pub(super) type Lane = [f32; LANES];

/// Four vertices at rest, and what they follow, as they lie in the file.
#[derive(Clone, Copy)]
pub(super) struct Quad<'a> {
    pub(super) positions: &'a [[Le; 3]; QUAD],
    pub(super) normals: &'a [[Le; 3]; QUAD],
    /// Tangents, whose last number does not matter; or, of a skin without, the z of the file's own normals first.
    pub(super) frames: &'a [[Le; 4]; QUAD],
    pub(super) indices: &'a [[[u8; 2]; 4]; QUAD],
    pub(super) weights: &'a [[Le; 4]; QUAD],
    pub(super) coefficients: &'a [[Le; 3]; QUAD],
}

/// Vertices at rest, and what they follow, side by side.
#[repr(align(32))]
pub(super) struct Lanes {
    /// By influence, row and column.
    transforms: [[[Lane; 4]; 3]; 4],
    weights: [Lane; 4],
    positions: [Lane; 3],
    normals: [Lane; 3],
    frames: [Lane; 3],
    /// Of the first three influences.
    coefficients: [[u32; LANES]; 3],
}

/// Vertices in a pose, side by side.
#[repr(align(32))]
pub(super) struct Posed {
    pub(super) positions: [Lane; 3],
    /// Of any length.
    pub(super) normals: [Lane; 3],
    /// Their squared lengths.
    pub(super) squares: Lane,
    /// The images of tangents, of any length.
    pub(super) tangents: [Lane; 3],
}

impl Posed {
    pub(super) const NONE: Self = Self {
        positions: [[0.0; LANES]; 3],
        normals: [[0.0; LANES]; 3],
        squares: [0.0; LANES],
        tangents: [[0.0; LANES]; 3],
    };
}

impl Lanes {
    pub(super) const NONE: Self = Self {
        transforms: [[[[0.0; LANES]; 4]; 3]; 4],
        weights: [[0.0; LANES]; 4],
        positions: [[0.0; LANES]; 3],
        normals: [[0.0; LANES]; 3],
        frames: [[0.0; LANES]; 3],
        coefficients: [[0; LANES]; 3],
    };

    /// Puts four vertices side by side, the first or the second four; `None` stands for an index beyond the palette,
    /// which a loaded skin does not have.
    #[inline(always)]
    pub(super) fn put(&mut self, at: usize, quad: &Quad<'_>, palette: &[Matrix3x4]) -> Option<()> {
        let of = |[a, b, c, d]: [&Matrix3x4; QUAD], row: usize| {
            transposed([a[row], b[row], c[row], d[row]])
        };
        for (k, out) in self.transforms.iter_mut().enumerate() {
            let transform = |vertex: usize| {
                palette.get(usize::from(u16::from_le_bytes(quad.indices[vertex][k])))
            };
            let all = [transform(0)?, transform(1)?, transform(2)?, transform(3)?];
            let [x, y, z] = out;
            set(x, at, of(all, 0));
            set(y, at, of(all, 1));
            set(z, at, of(all, 2));
        }
        let [a, b, c, d] = quad.weights;
        set(&mut self.weights, at, transposed([floats(a), floats(b), floats(c), floats(d)]));
        let [a, b, c, d] = quad.frames;
        set(&mut self.frames, at, transposed([floats(a), floats(b), floats(c), floats(d)]));
        set(&mut self.positions, at, side_by_side(quad.positions));
        set(&mut self.normals, at, side_by_side(quad.normals));
        let [a, b, c, d] = quad.coefficients;
        for (k, out) in self.coefficients.iter_mut().enumerate() {
            let word = |le: &[Le; 3]| u32::from_le_bytes(le[k]);
            if let Some(out) = out.as_chunks_mut().0.get_mut(at) {
                *out = [word(a), word(b), word(c), word(d)];
            }
        }
        Some(())
    }

    /// Poses the vertices.
    ///
    /// - `BY_TANGENT`: whether the frames are of tangents.
    #[inline(always)]
    #[allow(clippy::needless_range_loop, reason = "many arrays, walked side by side")]
    pub(super) fn pose<const BY_TANGENT: bool>(&self, out: &mut Posed) {
        for i in 0..LANES {
            let of = |lanes: &[Lane; 3]| [lanes[0][i], lanes[1][i], lanes[2][i]];
            let (x, n, t) = (of(&self.positions), of(&self.normals), of(&self.frames));
            let [u, v] = if BY_TANGENT { frame_of_tangent(n, t) } else { frame_of_normal(n, t[0]) };
            let pairs = [
                halves(self.coefficients[0][i]),
                halves(self.coefficients[1][i]),
                halves(self.coefficients[2][i]),
            ];
            let [[g0, h0], [g1, h1], [g2, h2]] = pairs;
            let (g, h) = ([g0, g1, g2], [h0, h1, h2]);
            let [a, b, c, d] = &self.weights;
            let w = [a[i], b[i], c[i], d[i]];
            let [px, ux, vx, gx, hx] = row::<0>(&self.transforms, i, w, [x, u, v, g, h]);
            let [py, uy, vy, gy, hy] = row::<1>(&self.transforms, i, w, [x, u, v, g, h]);
            let [pz, uz, vz, gz, hz] = row::<2>(&self.transforms, i, w, [x, u, v, g, h]);
            let [nx, ny, nz] = cross([ux, uy, uz], [vx, vy, vz]);
            out.positions[0][i] = px;
            out.positions[1][i] = py;
            out.positions[2][i] = pz;
            out.normals[0][i] = nx;
            out.normals[1][i] = ny;
            out.normals[2][i] = nz;
            out.squares[i] = nx * nx + ny * ny + nz * nz;
            let _ = (gx, hx, gy, hy, gz, hz);
        }
    }
}

/// Computes one coordinate: of the position, of the images of u and v, and of what g and h add.
#[inline(always)]
fn row<const R: usize>(
    transforms: &[[[Lane; 4]; 3]; 4],
    i: usize,
    [w0, w1, w2, w3]: [f32; 4],
    [x, u, v, g, h]: [[f32; 3]; 5],
) -> [f32; 5] {
    let [p, q, r, s] = transforms;
    let (p, q, r, s) = (&p[R], &q[R], &r[R], &s[R]);
    let a = 0.0 + p[0][i] * w0 + q[0][i] * w1 + r[0][i] * w2 + s[0][i] * w3;
    let b = 0.0 + p[1][i] * w0 + q[1][i] * w1 + r[1][i] * w2 + s[1][i] * w3;
    let c = 0.0 + p[2][i] * w0 + q[2][i] * w1 + r[2][i] * w2 + s[2][i] * w3;
    let d = 0.0 + p[3][i] * w0 + q[3][i] * w1 + r[3][i] * w2 + s[3][i] * w3;
    let last = s[0][i] * x[0] + s[1][i] * x[1] + s[2][i] * x[2] + s[3][i];
    let d0 = p[0][i] * x[0] + p[1][i] * x[1] + p[2][i] * x[2] + p[3][i] - last;
    let d1 = q[0][i] * x[0] + q[1][i] * x[1] + q[2][i] * x[2] + q[3][i] - last;
    let d2 = r[0][i] * x[0] + r[1][i] * x[1] + r[2][i] * x[2] + r[3][i] - last;
    let along = g[0] * d0 + g[1] * d1 + g[2] * d2;
    let across = h[0] * d0 + h[1] * d1 + h[2] * d2;
    [
        a * x[0] + b * x[1] + c * x[2] + d,
        a * u[0] + b * u[1] + c * u[2] + along,
        a * v[0] + b * v[1] + c * v[2] + across,
        along,
        across,
    ]
}

#[inline(always)]
fn frame_of_tangent(n: [f32; 3], t: [f32; 3]) -> [[f32; 3]; 2] {
    let v = cross(n, t);
    [cross(v, n), v]
}

#[inline(always)]
fn frame_of_normal([x, y, z]: [f32; 3], up: f32) -> [[f32; 3]; 2] {
    let side = 1.0f32.copysign(up);
    let (sided, share) = (side * x, x / (side + z));
    let u = [1.0 - sided * share, -(side * y * share), -sided];
    [u, cross([x, y, z], u)]
}

#[inline(always)]
fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Puts columns into the first or the second four of their lanes.
#[inline(always)]
fn set<const N: usize>(lanes: &mut [Lane; N], at: usize, columns: [[f32; QUAD]; 4]) {
    for (lane, column) in lanes.iter_mut().zip(columns) {
        if let Some(out) = lane.as_chunks_mut().0.get_mut(at) {
            *out = column;
        }
    }
}

#[inline(always)]
fn side_by_side([a, b, c, d]: &[[Le; 3]; QUAD]) -> [[f32; QUAD]; 4] {
    let of = |le: &[Le; 3]| {
        [f32::from_le_bytes(le[0]), f32::from_le_bytes(le[1]), f32::from_le_bytes(le[2]), 0.0]
    };
    transposed([of(a), of(b), of(c), of(d)])
}

#[inline(always)]
fn transposed([a, b, c, d]: [[f32; 4]; QUAD]) -> [[f32; QUAD]; 4] {
    let [a, b, c, d] =
        [Vec4::from_array(a), Vec4::from_array(b), Vec4::from_array(c), Vec4::from_array(d)];
    Mat4::from_cols(a, b, c, d).transpose().to_cols_array_2d()
}
