//! Clips as the f32 runtime plays them on a model.

use rayon::prelude::*;
use sinew_runtime::format::Space;
use std::ops::Range;

use super::chains::{self, Chained};
use super::skeleton::times;
use crate::Error;
use crate::envelope::levels::Influences;
use crate::envelope::posed::{Pose, curves_of, influences, palette, rest};
use crate::evaluate::Character;
use crate::examples::{Clip, Examples, Matrix3x4, Skeleton};
use crate::space::Conversion;

/// Radius around a proxy's centre for the choice of its joint, in diagonals.
const REACH: f64 = 0.05;

/// A model and its palettes at the keys of clips, in the model's space; mirrored if that space is left-handed.
pub(super) struct Played<'a> {
    /// The model's envelope and skin, not mirrored.
    pub(super) character: Character<'a>,
    /// The right-handed space.
    pub(super) space: Space,
    /// Conversion from the model's space; `None` if the model is right-handed.
    pub(super) mirror: Option<Conversion>,
    /// Rest positions.
    pub(super) rest: Vec<[f64; 3]>,
    /// The joints.
    pub(super) skeleton: Skeleton,
    /// Key times of each clip, in seconds.
    pub(super) times: Vec<Vec<f32>>,
    /// Maps of the joints at the keys, one clip after another.
    pub(super) poses: Vec<Vec<Matrix3x4>>,
    /// Curves of the envelope at the keys.
    pub(super) curves: Vec<Vec<f64>>,
    /// Palette of each key.
    pub(super) palettes: Vec<Vec<sinew_runtime::Matrix3x4>>,
    /// Influences of the skin's vertices.
    pub(super) influences: Influences,
    /// Centre of the vertices that each proxy moves.
    pub(super) centres: Vec<[f64; 3]>,
    /// Joint that carries each proxy.
    pub(super) carriers: Vec<usize>,
    /// Whether each joint stretches at a key.
    pub(super) stretching: Vec<bool>,
}

impl<'a> Played<'a> {
    /// Predicts every frame of the clips, without mirroring. No joint carries a proxy before [`Self::carry`].
    ///
    /// # Errors
    /// The model is refused or belongs to another character, a clip cannot be played, a joint is mirrored or
    /// hidden, or the runtime refuses a frame.
    pub(super) fn new(
        model: &'a [u8],
        skin: Option<&str>,
        examples: &Examples,
        clips: &[Clip],
    ) -> Result<Self, Error> {
        let character = Character::open(model, skin, examples)?;
        let times = times(clips)?;
        let frames: Vec<usize> =
            clips.iter().flat_map(|clip| clip.first..clip.first + clip.times.len()).collect();
        examples.check_poses(&frames)?;
        let palettes = frames
            .par_iter()
            .map(|&frame| {
                let pose = Pose::of(&character.envelope, examples, frame);
                Ok(palette(&character.envelope, &pose, frame)?.0)
            })
            .collect::<Result<Vec<_>, Error>>()?;
        Ok(Self {
            character,
            space: character.space,
            mirror: None,
            rest: rest(&character.skin),
            skeleton: examples.skeleton.clone(),
            times,
            poses: frames.iter().map(|&frame| examples.pose(frame).to_vec()).collect(),
            curves: frames.iter().map(|&f| curves_of(&character.envelope, examples, f)).collect(),
            palettes,
            influences: influences(&character.skin),
            centres: Vec::new(),
            carriers: Vec::new(),
            stretching: examples.stretching_in(&frames),
        })
    }

    /// Finds the centre of each proxy, and the joint that carries it.
    pub(super) fn carry(&mut self, diagonal: f64) {
        self.centres = self.proxy_centres();
        self.carriers =
            chains::carriers(&self.palettes, &self.poses, &self.centres, REACH * diagonal);
    }

    /// Mirrors everything but the character.
    pub(super) fn turn(&mut self, mirror: &Conversion) {
        self.rest.iter_mut().for_each(|x| *x = mirror.point(*x));
        let turn = |b: &mut Matrix3x4| *b = mirror.transform(b);
        self.skeleton.rest.iter_mut().for_each(turn);
        self.poses.iter_mut().flatten().for_each(turn);
        for b in self.palettes.iter_mut().flatten() {
            // Exact: entries only change places and signs.
            let turned = mirror.transform(&b.map(|row| row.map(f64::from)));
            *b = turned.map(|row| row.map(|x| x as f32));
        }
    }

    /// Returns the index of the first proxy in the palette; joints come before it.
    pub(super) fn first_proxy(&self) -> usize {
        let envelope = &self.character.envelope;
        envelope.palette_len() - envelope.proxy_len()
    }

    /// Lists the joints of the palette that stretch, each at its own origin.
    pub(super) fn stretched(&self) -> impl Iterator<Item = Chained> + '_ {
        let all = (0..self.first_proxy()).filter(|&joint| self.stretching[joint]);
        all.map(|joint| {
            let name = &self.skeleton.names[joint];
            Chained {
                names: [format!("{name}_stretch"), format!("{name}_axes")],
                transform: joint,
                centre: self.skeleton.rest[joint].map(|row| row[3]),
                joint,
            }
        })
    }

    /// Lists the proxies.
    pub(super) fn proxies(&self) -> impl Iterator<Item = Chained> + '_ {
        let all = self.centres.iter().zip(&self.carriers).enumerate();
        all.map(|(number, (&centre, &joint))| Chained {
            names: [format!("proxy_{number}"), format!("proxy_{number}_axes")],
            transform: self.first_proxy() + number,
            centre,
            joint,
        })
    }

    /// Lists the names of the envelope's curves, C.
    pub(super) fn curve_names(&self) -> Vec<&str> {
        let envelope = &self.character.envelope;
        (0..envelope.curve_len()).filter_map(|curve| envelope.curve_name(curve)).collect()
    }

    /// Lists the keys of each clip, as ranges of all keys.
    pub(super) fn clips(&self) -> impl Iterator<Item = Range<usize>> {
        self.times.iter().scan(0, |begin, times| {
            let own = *begin..*begin + times.len();
            *begin = own.end;
            Some(own)
        })
    }

    /// Returns the centre of the vertices that each proxy moves, or of the mesh if the proxy moves none.
    fn proxy_centres(&self) -> Vec<[f64; 3]> {
        let first = self.first_proxy();
        let mut sums = vec![[0.0; 4]; self.character.envelope.proxy_len()];
        let mut all = [0.0; 4];
        for (x, influences) in self.rest.iter().zip(&self.influences) {
            let add = |sum: &mut [f64; 4], weight: f64| {
                for (sum, x) in sum.iter_mut().zip(x.iter().chain([&1.0])) {
                    *sum += weight * x;
                }
            };
            for &(index, weight) in influences {
                if let Some(sum) = index.checked_sub(first).and_then(|proxy| sums.get_mut(proxy)) {
                    add(sum, weight);
                }
            }
            add(&mut all, 1.0);
        }
        let mean = |[x, y, z, weight]: [f64; 4]| [x / weight, y / weight, z / weight];
        sums.into_iter().map(|sum| mean(if sum[3] > 0.0 { sum } else { all })).collect()
    }
}
