//! The rest shape: sections lofted from the midline of the chest to the fingertips; and smooth functions that have the
//! same bits on every CPU, as they use libm.

use nalgebra::{Matrix3, Vector3};

/// Joints from the root outward; each joint's parent is the previous joint.
pub(super) const JOINTS: [&str; 7] =
    ["chest", "clavicle", "upper_arm", "upper_arm_twist", "forearm", "forearm_twist", "hand"];

/// Positions along the arm, in metres from the shoulder.
pub(super) const ELBOW: f64 = 0.26;
pub(super) const WRIST: f64 = 0.485;
const TIP: f64 = 0.662;
pub(super) const SHOULDER: Vector3<f64> = Vector3::new(SHOULDER_AT[0], SHOULDER_AT[1], 0.0);
const SHOULDER_AT: [f64; 2] = [0.175, 1.41];
/// Slope of the arm below the horizontal: cosine and sine of 15 degrees.
const SLOPE: (f64, f64) = (0.965_925_826_289_068_3, 0.258_819_045_102_520_8);

/// Ratio of vertices along the skin to vertices around it, for nearly square faces.
const ASPECT: f64 = 2.4;
/// Least numbers of vertices around and along that still show the shape.
const LEAST: (usize, usize) = (10, 20);

/// A point of the rest skin.
pub(super) struct Point {
    /// Position in space.
    pub(super) position: Vector3<f64>,
    /// Position along the arm, in metres from the shoulder, negative on the chest.
    pub(super) along: f64,
    /// Direction around the section, (up, front), a unit vector.
    pub(super) around: (f64, f64),
}

/// The rest mesh.
pub(super) struct Skin {
    /// V points.
    pub(super) points: Vec<Point>,
    /// T triangles, outward.
    pub(super) triangles: Vec<[usize; 3]>,
    /// V texture coordinates: the arm seen from the fingertips, which has no seam.
    pub(super) uv: Vec<[f64; 2]>,
}

/// Returns the direction of the arm at rest.
pub(super) fn arm() -> Vector3<f64> {
    Vector3::new(SLOPE.0, -SLOPE.1, 0.0)
}

/// Returns the upward direction across the arm, which spans the arm's sections with z.
pub(super) fn above() -> Vector3<f64> {
    Vector3::new(SLOPE.1, SLOPE.0, 0.0)
}

/// Returns the rest origins of the joints.
pub(super) fn origins() -> [Vector3<f64>; 7] {
    [
        Vector3::new(-0.06, 1.2, 0.0),
        Vector3::new(0.0, 1.43, 0.03),
        SHOULDER,
        SHOULDER + arm() * (0.5 * ELBOW),
        SHOULDER + arm() * ELBOW,
        SHOULDER + arm() * (0.5 * (ELBOW + WRIST)),
        SHOULDER + arm() * WRIST,
    ]
}

impl Skin {
    /// Lofts a skin of about `vertices` vertices: rings of a grid, closed by one vertex at the tip.
    pub(super) fn new(vertices: usize) -> Self {
        let around_len = ((vertices as f64 / ASPECT).sqrt().round() as usize).max(LEAST.0);
        let along_len = (vertices.saturating_sub(1) / around_len).max(LEAST.1);
        let mut points = Vec::with_capacity(along_len * around_len + 1);
        let mut uv = Vec::with_capacity(points.capacity());
        for ring in 0..along_len {
            // Half a step remains for the cap.
            let part = ring as f64 / (along_len as f64 - 0.5);
            for step in 0..around_len {
                let turn = step as f64 / around_len as f64 * std::f64::consts::TAU;
                let around = (libm::cos(turn), libm::sin(turn));
                let point = point((SECTIONS.len() - 1) as f64 * part, around);
                points.push(point);
                let radius = 0.5 * (1.0 - part);
                uv.push([0.5 + radius * around.0, 0.5 + radius * around.1]);
            }
        }
        points.push(Point { position: SHOULDER + arm() * TIP, along: TIP, around: (0.0, 0.0) });
        uv.push([0.5, 0.5]);
        Self { triangles: triangles(along_len, around_len), points, uv }
    }
}

/// Splits every quad of the grid along its first diagonal, and closes the last ring.
fn triangles(along_len: usize, around_len: usize) -> Vec<[usize; 3]> {
    let mut triangles = Vec::with_capacity((2 * along_len - 1) * around_len);
    for ring in 0..along_len {
        for step in 0..around_len {
            let next = (step + 1) % around_len;
            let (a, b) = (ring * around_len + step, ring * around_len + next);
            if ring + 1 == along_len {
                triangles.push([a, b, along_len * around_len]);
            } else {
                let (c, d) = (b + around_len, a + around_len);
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    triangles
}

fn point(place: f64, around: (f64, f64)) -> Point {
    let section = Section::at(place);
    let along = section.along;
    let [up, down, front, back] = section.extent;
    let height = around.0 * if around.0 > 0.0 { up } else { down };
    let depth = around.1 * if around.1 > 0.0 { front } else { back };
    let upward = Vector3::y().lerp(&above(), section.turned).normalize();
    let [x, y] = section.centre;
    let mut position = Vector3::new(x, y, depth) + upward * height;
    // The thumb: a lobe drawn out of the upper edge of the palm.
    let thumb = bell(along, WRIST + 0.05, 0.022) * bell(1.0 - around.0, 0.0, 0.16);
    position += (above() * 0.045 + arm() * 0.035 + Vector3::z() * 0.02) * thumb;
    Point { position, along, around }
}

/// A section of the loft.
#[derive(Clone, Copy)]
struct Section {
    along: f64,
    /// Centre, x and y.
    centre: [f64; 2],
    /// Share of the turn from the plane of the chest's midline (0) to across the arm (1).
    turned: f64,
    /// Half extents up, down, front and back.
    extent: [f64; 4],
}

impl Section {
    /// Interpolates the table at `place`, counted in sections, with a cubic through its rows.
    fn at(place: f64) -> Self {
        let last = SECTIONS.len() - 1;
        let from = (place as usize).min(last - 1);
        let x = place - from as f64;
        let rows = [from.saturating_sub(1), from, from + 1, (from + 2).min(last)];
        let blend = |value: &dyn Fn(&Section) -> f64| {
            let [before, a, b, after] = rows.map(|row| value(&SECTIONS[row]));
            let (leaving, arriving) = (0.5 * (b - before), 0.5 * (after - a));
            let bend = leaving + arriving - 2.0 * (b - a);
            a + x * (leaving + x * ((b - a) - leaving - bend + x * bend))
        };
        Self {
            along: blend(&|section| section.along),
            centre: [0, 1].map(|axis| blend(&|section| section.centre[axis])),
            turned: blend(&|section| section.turned),
            extent: [0, 1, 2, 3].map(|side| blend(&|section| section.extent[side])),
        }
    }
}

const fn chest(along: f64, centre: [f64; 2], turned: f64, extent: [f64; 4]) -> Section {
    Section { along, centre, turned, extent }
}

/// A section centred on the arm's axis.
const fn limb(along: f64, extent: [f64; 4]) -> Section {
    let centre = [SHOULDER_AT[0] + SLOPE.0 * along, SHOULDER_AT[1] - SLOPE.1 * along];
    Section { along, centre, turned: 1.0, extent }
}

const SECTIONS: [Section; 22] = [
    chest(-0.24, [-0.060, 1.372], 0.0, [0.105, 0.135, 0.096, 0.094]),
    chest(-0.18, [0.000, 1.372], 0.0, [0.107, 0.136, 0.100, 0.096]),
    chest(-0.12, [0.058, 1.374], 0.1, [0.105, 0.134, 0.104, 0.098]),
    chest(-0.07, [0.107, 1.381], 0.35, [0.098, 0.124, 0.096, 0.093]),
    chest(-0.02, [0.156, 1.400], 0.8, [0.090, 0.105, 0.084, 0.085]),
    limb(0.027, [0.084, 0.086, 0.074, 0.082]),
    limb(0.072, [0.082, 0.079, 0.066, 0.083]),
    limb(0.117, [0.070, 0.066, 0.058, 0.080]),
    limb(0.162, [0.061, 0.060, 0.054, 0.076]),
    limb(0.203, [0.056, 0.056, 0.049, 0.069]),
    limb(0.234, [0.054, 0.054, 0.045, 0.061]),
    limb(0.26, [0.054, 0.053, 0.043, 0.057]),
    limb(0.288, [0.056, 0.054, 0.045, 0.057]),
    limb(0.324, [0.058, 0.054, 0.048, 0.056]),
    limb(0.36, [0.055, 0.052, 0.047, 0.052]),
    limb(0.405, [0.048, 0.043, 0.040, 0.043]),
    limb(0.45, [0.040, 0.037, 0.032, 0.030]),
    limb(0.485, [0.032, 0.031, 0.023, 0.022]),
    limb(0.531, [0.044, 0.043, 0.021, 0.019]),
    limb(0.585, [0.048, 0.046, 0.017, 0.014]),
    limb(0.634, [0.040, 0.037, 0.012, 0.010]),
    limb(0.661, [0.013, 0.013, 0.006, 0.004]),
];

/// Returns the rotation about `vector` by its length in radians (Rodrigues).
pub(super) fn rotation(vector: &Vector3<f64>) -> Matrix3<f64> {
    let angle = vector.norm();
    if angle < 1e-12 {
        return Matrix3::identity() + vector.cross_matrix();
    }
    let cross = (vector / angle).cross_matrix();
    Matrix3::identity() + cross * libm::sin(angle) + cross * cross * (1.0 - libm::cos(angle))
}

/// Rises from 0 below `from` to 1 above `to` with a continuous derivative.
pub(super) fn ramp(value: f64, from: f64, to: f64) -> f64 {
    let x = ((value - from) / (to - from)).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// Falls from 1 at `centre` to 0 far away; 0.5 at a distance of `width`.
pub(super) fn bell(value: f64, centre: f64, width: f64) -> f64 {
    let x = (value - centre) / width;
    libm::exp2(-x * x)
}
