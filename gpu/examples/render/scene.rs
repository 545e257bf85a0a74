//! The scene: six arms of the demo character, each bent further than the last.

use crate::Result;
use sinew_gpu::layout::{Batch, DeviceLimits, Plan, SkinBatch};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::{Envelope, LocalTransform, Matrix3x4, Model, Skin, model_space_pose};
use sinew_trainer::envelope::s3::ProxyCount;
use sinew_trainer::envelope::{Options, Predict, train};
use sinew_trainer::examples::demo::{DemoOptions, demo};
use sinew_trainer::progress::Silent;

/// Size of the picture in pixels.
pub(crate) const WIDTH: u32 = 960;
pub(crate) const HEIGHT: u32 = 540;
/// Number of arms.
pub(crate) const INSTANCES: usize = 6;
/// Arms in a row; rows go from back to front.
const COLUMNS: usize = 3;
/// The host's shader, preceded by the declarations of params and blob, which every stage binds and
/// the host's shader reads as well. Entry points `vertex` and `fragment`; group 0: params, blob,
/// palettes, camera.
pub(crate) const SHADER: &str = concat!(
    include_str!("../../../shaders/params.wgsl"),
    include_str!("../../../shaders/blob.wgsl"),
    include_str!("host.wgsl")
);
/// Position of the camera; the shader's highlights use the same constant.
const EYE: [f32; 3] = [1.18, 4.35, 2.75];
/// The background, linear.
pub(crate) const BACKGROUND: [f64; 4] = [0.80, 0.82, 0.85, 1.0];

/// The scene that both APIs draw.
pub(crate) struct Scene {
    pub(crate) model: Model<Vec<u8>>,
    /// Three vertex numbers a face.
    pub(crate) indices: Vec<u32>,
    /// The poses of all instances, one after the other.
    pub(crate) poses: Vec<f32>,
    /// The camera's uniform block: world to clip space, by columns.
    pub(crate) camera: [f32; 16],
}

impl Scene {
    /// Trains a small demo character and poses it.
    pub(crate) fn new() -> Result<Self> {
        let examples = demo(&DemoOptions { vertices: 2000, poses: 80, held_out: 0, seed: 1 });
        let options = Options {
            predictor: Predict::Only(Predictor::Kernel),
            proxies: Some(ProxyCount::Fixed(24)),
            ..Options::default()
        };
        let model = Model::from_bytes(train(&examples, &options, &Silent)?.model)?;
        let indices = examples.triangles.as_flattened().iter().map(|index| *index as u32).collect();
        let mut poses = Vec::new();
        let envelope = model.first::<Envelope>().ok_or("no envelope")?;
        for n in 0..INSTANCES {
            let pose = pose(&envelope, n as f32 / (INSTANCES - 1) as f32)?;
            let (row, column) = (n / COLUMNS, n % COLUMNS);
            let placed = [0.92 * column as f32, 0.0, 0.66 * row as f32];
            poses.extend(pose.iter().flat_map(|matrix| moved(matrix, placed)).flatten());
        }
        Ok(Self { model, indices, poses, camera: camera() })
    }

    /// Plans all instances' palettes. No stage skins a vertex, but the params tell the host's
    /// shader the places of the skin's arrays.
    pub(crate) fn plan(&self, limits: &DeviceLimits) -> Result<Plan> {
        let envelope = self.model.first::<Envelope>().ok_or("no envelope")?;
        let skin = self.model.first::<Skin>().ok_or("no skin")?;
        let skin = Some(SkinBatch { vertices: 0..0, ..SkinBatch::new(&skin) });
        let batch = Batch { confidences: None, skin, ..Batch::palettes(&envelope, INSTANCES) };
        Ok(Plan::new(&self.model, &envelope, &batch, limits)?)
    }
}

/// Bends elbow and wrist and raises the arm; `amount` is 0 to 1.
fn pose(envelope: &Envelope<'_>, amount: f32) -> Result<Vec<Matrix3x4>> {
    // The arm points 15 degrees below the x axis, and bends about the direction at a right angle
    // below it.
    let (sine, cosine) = 15_f32.to_radians().sin_cos();
    let (along, under) = ([cosine, -sine, 0.0], [-sine, -cosine, 0.0]);
    let local = envelope.rest_locals().enumerate().map(|(joint, rest)| {
        let (axis, degrees) = match envelope.joint_name(joint) {
            Some("upper_arm") => ([0.0, 0.0, 1.0], 12.0),
            Some("forearm") => (under, 4.0 + 108.0 * amount),
            Some("forearm_twist") => (along, 35.0 * amount),
            Some("hand") => (under, 30.0 * amount),
            _ => ([1.0, 0.0, 0.0], 0.0),
        };
        let (sine, cosine) = (0.5_f32 * degrees).to_radians().sin_cos();
        // The arm's rest frames are not rotated.
        let [x, y, z] = axis.map(|a| a * sine);
        LocalTransform { rotation: [x, y, z, cosine], ..rest }
    });
    let local: Vec<_> = local.collect();
    let mut out = vec![[[0.0; 4]; 3]; local.len()];
    model_space_pose(envelope, &local, &mut out)?;
    Ok(out)
}

/// Translates a joint's skinning matrix, and with it all vertices that follow the joint.
fn moved(matrix: &Matrix3x4, by: [f32; 3]) -> Matrix3x4 {
    let [x, y, z] = *matrix;
    let row = |[a, b, c, d]: [f32; 4], by: f32| [a, b, c, d + by];
    [row(x, by[0]), row(y, by[1]), row(z, by[2])]
}

/// Returns the camera's matrix: a view of the arms from above and in front.
fn camera() -> [f32; 16] {
    let eye = EYE;
    let target = [1.18, 1.33, 0.46];
    let forward = unit(sub(target, eye));
    let right = unit(cross(forward, [0.0, 1.0, 0.0]));
    let up = cross(right, forward);
    let (near, far) = (0.5, 20.0);
    let y = 1.0 / (12.6_f32.to_radians()).tan();
    let x = y * HEIGHT as f32 / WIDTH as f32;
    let depth = far / (near - far);
    // Rows of the view, scaled; clip z from 0 at the near plane to 1 at the far one.
    let row = |axis: [f32; 3], scale: f32| {
        [axis[0] * scale, axis[1] * scale, axis[2] * scale, -dot(axis, eye) * scale]
    };
    let back = forward.map(|x| -x);
    let [zx, zy, zz, zw] = row(back, depth);
    let rows = [row(right, x), row(up, y), [zx, zy, zz, zw + near * depth], row(back, -1.0)];
    let mut columns = [0.0; 16];
    for (r, row) in rows.iter().enumerate() {
        for (c, value) in row.iter().enumerate() {
            columns[4 * c + r] = *value;
        }
    }
    columns
}

fn sub(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [0, 1, 2].map(|i| a[i] - b[i])
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [0, 1, 2].map(|i| a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3])
}

fn unit(v: [f32; 3]) -> [f32; 3] {
    v.map(|x| x / dot(v, v).sqrt())
}
