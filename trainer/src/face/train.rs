//! Trains a face: from shapes and a take to a file.

use super::baked::BakedFace;
use super::basis::{Basis, ExampleMeshes};
use super::evaluate::Protocol;
use super::prior::{learned, pairs, slider};
use crate::Error;
use crate::envelope::model::{FileModel, PriorModel, ShapeNumbers};
use crate::formats::{NamedShape, ShapedMesh};
use faer::Mat;
use sinew_runtime::Model;

/// Default tolerance of pins, as a fraction of the face's diagonal.
pub const TOLERANCE: f64 = 5e-4;
/// Least and greatest tolerance of pins. The file holds the square as a positive f32 of at most 1e9.
const TOLERANCES: [f64; 2] = [1e-18, 3e4];
/// Fraction of the example meshes' variance that the default number of shapes keeps.
pub const ENERGY: f64 = 0.999;
/// Bounds of blendshape weights; and of principal components, in standard deviations.
const BOUNDS: ([f64; 2], f64) = ([0.0, 1.0], 3.0);

/// Number of handles whose accuracy the file states.
pub const HANDLES: usize = 8;
/// Measures every 25th frame; takes with fewer than `LEAST` frames are not measured.
const EVERY: usize = 25;
const LEAST: usize = 8 * EVERY;

/// Options of baking.
#[derive(Clone, Debug)]
pub struct Options {
    /// Name of the skin.
    pub name: String,
    /// Tolerance of pins, a length; `None` takes [`TOLERANCE`].
    pub tolerance: Option<f64>,
    /// Number format of deltas.
    pub numbers: ShapeNumbers,
}

/// Creates the file of a face, with a prior learned from frames of weights.
///
/// - `frames`: weights, N x S.
///
/// # Errors
/// [`ErrorKind::Value`](crate::ErrorKind::Value): a file cannot hold the tolerance of pins.
pub fn of_take(basis: &Basis, frames: &[Vec<f64>], options: &Options) -> Result<FileModel, Error> {
    let deltas: Vec<_> = basis.mesh.shapes.iter().map(|shape| shape.deltas.clone()).collect();
    let pairs = pairs(&basis.names(), &deltas);
    let bounds = vec![BOUNDS.0; deltas.len()];
    let prior = learned(frames, bounds, &pairs, options.tolerance(basis)?);
    Ok(file(basis, prior, options))
}

/// Finds shapes in example meshes, by principal components (S0 Eq. 8), and their prior. The mean mesh becomes the
/// neutral mesh. A shape at weight 1 has an RMS displacement of one unit of length.
///
/// - `rank`: number of shapes; `None` keeps [`ENERGY`].
///
/// # Errors
/// [`ErrorKind::Value`](crate::ErrorKind::Value): the meshes have fewer components, or a file cannot hold the tolerance
/// of pins.
pub fn of_meshes(
    meshes: &ExampleMeshes,
    rank: Option<usize>,
    options: &Options,
) -> Result<(Basis, FileModel), Error> {
    let (n, len) = (meshes.positions.len(), meshes.mesh.positions.len());
    let mean = |vertex: usize| -> [f64; 3] {
        let sum = |axis: usize| meshes.positions.iter().map(|mesh| mesh[vertex][axis]).sum::<f64>();
        [0, 1, 2].map(|axis| sum(axis) / n as f64)
    };
    let mean: Vec<[f64; 3]> = (0..len).map(mean).collect();
    let centred = Mat::from_fn(3 * len, n, |row, at| {
        meshes.positions[at][row / 3][row % 3] - mean[row / 3][row % 3]
    });
    let svd = centred.thin_svd().map_err(|_| wrong_rank(rank.unwrap_or(1), 0))?;
    // N meshes have N - 1 components.
    let energies: Vec<f64> =
        svd.S().column_vector().iter().take(n - 1).map(|s| s * s / n as f64).collect();
    let least = 1e-12 * energies.first().copied().unwrap_or(0.0);
    let most = energies.iter().filter(|energy| **energy > least).count();
    let total: f64 = energies.iter().sum();
    let mut kept = 0.0;
    let needed = energies.iter().take_while(|energy| {
        let before = kept;
        kept += **energy;
        before < ENERGY * total
    });
    let rank = rank.unwrap_or(needed.count()).max(1);
    if rank > most {
        return Err(wrong_rank(rank, most));
    }
    let size = (len as f64).sqrt();
    let shape = |mode: usize| {
        let column = svd.U().col(mode);
        let deltas =
            (0..len).map(|vertex| [0, 1, 2].map(|axis| size * column[3 * vertex + axis])).collect();
        NamedShape { name: format!("mode {mode}"), deltas }
    };
    let shapes = (0..rank).map(shape).collect();
    let mesh = ShapedMesh { positions: mean, shapes, ..meshes.mesh.clone() };
    let basis = Basis { mesh, ..Basis::default() };
    let deviations: Vec<f64> = energies[..rank].iter().map(|x| x.sqrt() / size).collect();
    let bounds = deviations.iter().map(|d| [-BOUNDS.1 * d, BOUNDS.1 * d]).collect();
    let mut prior = slider(bounds, options.tolerance(&basis)?);
    prior.name = "prior".to_owned();
    prior.covariance =
        Mat::from_fn(rank, rank, |i, j| if i == j { deviations[i].powi(2) } else { 0.0 });
    prior.fit.frames = n as f32;
    let model = file(&basis, prior, options);
    Ok((basis, model))
}

fn wrong_rank(rank: usize, most: usize) -> Error {
    Error::value(format!("rank {rank}: the meshes have {most} principal components"))
}

/// Measures the accuracy with [`HANDLES`] landmarks on the last quarter of the frames and records the errors in the
/// file. The measured prior is learned from the other frames. Measures nothing if landmarks or frames are too few.
///
/// # Errors
/// Errors of the protocol and of baking.
pub fn measure(
    model: &mut FileModel,
    basis: &Basis,
    frames: &[Vec<f64>],
    options: &Options,
) -> Result<(), Error> {
    let cut = frames.len() - frames.len() / 4;
    if basis.landmarks.len() < HANDLES || frames.len() < LEAST {
        return Ok(());
    }
    let own = of_take(basis, &frames[..cut], options)?;
    let [slider, slider_mean] = sliders(&own)?;
    let own = Model::from_bytes(own.bake()?)?;
    let face = BakedFace::open(&own)?;
    let every = |frames: &'_ [Vec<f64>]| -> Vec<Vec<f64>> {
        frames.iter().step_by(EVERY).cloned().collect()
    };
    let (training, held_out) = (every(&frames[..cut]), every(&frames[cut..]));
    let evaluation = Protocol {
        face,
        slider: BakedFace::open(&slider)?,
        slider_mean: BakedFace::open(&slider_mean)?,
        landmarks: &basis.landmarks,
        vertices: face.skin.ranges().next().map_or(0..basis.vertex_len(), |(_, range)| range),
        chosen_on: training.iter().map(Vec::as_slice).collect(),
        frames: held_out.iter().map(Vec::as_slice).collect(),
        lost_frames: 0,
    }
    .run(&[HANDLES])?;
    for (prior, row) in model.priors.iter_mut().zip(evaluation.handles.values()) {
        prior.fit.error = row.prior as f32;
        prior.fit.slider_error = row.slider as f32;
    }
    Ok(())
}

/// Bakes two copies of a file with the prior of the slider norm (Lewis and Anjyo 2010): around 0, and around the
/// learned mean.
///
/// # Errors
/// Errors of baking.
pub fn sliders(model: &FileModel) -> Result<[Model<Vec<u8>>; 2], Error> {
    let with = |keeps_mean: bool| -> Result<_, Error> {
        let mut model = model.clone();
        for prior in &mut model.priors {
            let own = slider(prior.bounds.clone(), 1.0);
            let mean = if keeps_mean { prior.mean.clone() } else { own.mean.clone() };
            *prior = PriorModel { mean, fit: prior.fit, skin: prior.skin, ..own };
        }
        Ok(Model::from_bytes(model.bake()?)?)
    };
    Ok([with(false)?, with(true)?])
}

fn file(basis: &Basis, prior: PriorModel, options: &Options) -> FileModel {
    FileModel {
        space: basis.mesh.space,
        envelopes: Vec::new(),
        skins: vec![basis.skin(&options.name, options.numbers)],
        priors: vec![prior],
        records: Vec::new(),
    }
}

impl Options {
    fn tolerance(&self, basis: &Basis) -> Result<f64, Error> {
        let found = self.tolerance.unwrap_or_else(|| TOLERANCE * basis.diagonal());
        let [least, most] = TOLERANCES;
        match (least..=most).contains(&found) {
            true => Ok(found),
            false => Err(Error::value(format!(
                "tolerance of pins {found:e}: expected {least:e} to {most:e}; the default is {TOLERANCE} of the \
                 face's diagonal: give a tolerance, or scale the face"
            ))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn options() -> Options {
        Options { name: "face".to_owned(), tolerance: None, numbers: ShapeNumbers::F32 }
    }

    /// Creates meshes of three points that move by two patterns; the first pattern is twice as large.
    fn meshes() -> ExampleMeshes {
        let patterns =
            [[[1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0; 3]], [[0.0; 3], [0.0, 1.0, 0.0], [0.0; 3]]];
        let amounts = [[2.0, 0.0], [-2.0, 0.0], [0.0, 1.0], [0.0, -1.0]];
        let at = |amount: [f64; 2]| -> Vec<[f64; 3]> {
            let point = |vertex: usize| {
                [0, 1, 2].map(|axis| {
                    let moved: f64 = (0..2).map(|p| amount[p] * patterns[p][vertex][axis]).sum();
                    5.0 * vertex as f64 + moved
                })
            };
            (0..3).map(point).collect()
        };
        let positions: Vec<_> = amounts.map(at).into();
        let mesh = ShapedMesh { positions: positions[0].clone(), ..ShapedMesh::default() };
        ExampleMeshes { mesh, positions }
    }

    #[test]
    fn components_match_the_patterns_of_motion() {
        let (basis, model) = of_meshes(&meshes(), Some(2), &options()).unwrap();
        assert_eq!(basis.mesh.positions[2], [10.0; 3]);
        let first = &basis.mesh.shapes[0].deltas;
        // RMS of 1 over three vertices; the third does not move.
        let each = 1.5_f64.sqrt();
        assert!(
            (first[0][0].abs() - each).abs() < 1e-12 && (first[1][0] - first[0][0]).abs() < 1e-12
        );
        assert!(first[2].iter().all(|x| x.abs() < 1e-12));
        // Variance of a pattern: its mean square over meshes, averaged over vertices.
        let prior = &model.priors[0];
        assert!((prior.covariance[(0, 0)] - 2.0 * 4.0 * 2.0 / 4.0 / 3.0).abs() < 1e-12);
        assert!((prior.covariance[(1, 1)] - 2.0 / 4.0 / 3.0).abs() < 1e-12);
        assert_eq!(prior.mean, [0.0; 2]);
    }

    /// The diagonal of a face with one vertex is 0.
    #[test]
    fn a_face_without_extent_needs_a_tolerance() {
        let shape = NamedShape { name: "up".to_owned(), deltas: vec![[0.0, 1.0, 0.0]] };
        let of = |positions: Vec<[f64; 3]>| {
            let deltas = vec![[0.0, 1.0, 0.0]; positions.len()];
            let shapes = vec![NamedShape { deltas, ..shape.clone() }];
            Basis {
                mesh: ShapedMesh { positions, shapes, ..ShapedMesh::default() },
                ..Basis::default()
            }
        };
        let one = of(vec![[1.0, 2.0, 3.0]]);
        let error = of_take(&one, &[], &options()).unwrap_err().to_string();
        assert_eq!(
            error,
            "tolerance of pins 0e0: expected 1e-18 to 3e4; the default is 0.0005 of the face's diagonal: \
             give a tolerance, or scale the face"
        );
        let stated = Options { tolerance: Some(0.01), ..options() };
        Model::from_bytes(of_take(&one, &[], &stated).unwrap().bake().unwrap()).unwrap();
        for (size, is_right) in [(1e-16, false), (1e-12, true), (1e7, true), (1e8, false)] {
            let found = of_take(&of(vec![[0.0; 3], [size, 0.0, 0.0]]), &[], &options());
            assert_eq!(found.is_ok(), is_right, "{size}");
            if let Ok(model) = found {
                Model::from_bytes(model.bake().unwrap()).unwrap();
            }
        }
    }

    #[test]
    fn too_high_a_rank_is_refused_and_energy_sets_the_default() {
        let error = of_meshes(&meshes(), Some(3), &options()).unwrap_err().to_string();
        assert_eq!(error, "rank 3: the meshes have 2 principal components");
        let (basis, _) = of_meshes(&meshes(), None, &options()).unwrap();
        assert_eq!(basis.mesh.shapes.len(), 2);
    }
}
