//! Clips as the f32 runtime plays them on a model.

use rayon::prelude::*;
use sinew_runtime::Envelope;
use sinew_runtime::format::{Handedness, Space};

use super::between::{Between, Key};
use super::proxies;
use super::skeleton::{check_clips, key_times};
use crate::Error;
use crate::envelope::levels::Influences;
use crate::envelope::posed::{influences, palette, rest};
use crate::evaluate::Character;
use crate::examples::{Clip, Examples, Matrix3x4, Skeleton};
use crate::space::{Conversion, SpaceRequest};

/// Radius around a proxy's centre for the choice of its joint, in diagonals.
const REACH: f64 = 0.05;

/// A model and its palettes at the keys of clips.
pub(super) struct Played<'a> {
    /// The model's envelope and skin.
    pub(super) character: Character<'a>,
    /// Key times of each clip, in seconds.
    pub(super) times: Vec<Vec<f32>>,
    /// Maps of the joints at the keys, one clip after another.
    poses: Vec<Vec<Matrix3x4>>,
    /// Palette of each key.
    pub(super) palettes: Vec<Vec<sinew_runtime::Matrix3x4>>,
    /// Influences of the skin's vertices.
    pub(super) influences: Influences,
}

/// The played clips in the model's space, mirrored if the space is left-handed.
pub(super) struct RightHanded {
    /// The right-handed space.
    pub(super) space: Space,
    /// Conversion from the model's space; `None` if the model is right-handed.
    pub(super) mirror: Option<Conversion>,
    /// Rest positions.
    pub(super) rest: Vec<[f64; 3]>,
    /// The joints.
    pub(super) skeleton: Skeleton,
    /// Poses of the joints at each key.
    pub(super) poses: Vec<Vec<Matrix3x4>>,
    /// Palette of each key.
    pub(super) palettes: Vec<Vec<sinew_runtime::Matrix3x4>>,
    /// Centre of the vertices that each proxy moves.
    pub(super) centres: Vec<[f64; 3]>,
    /// Joint that carries each proxy.
    pub(super) carriers: Vec<usize>,
}

impl<'a> Played<'a> {
    /// Predicts every frame of the clips and, with `between`, the keys that the motion between frames needs.
    ///
    /// # Errors
    /// The model is refused or belongs to another character, a clip cannot be played, a joint is not rigid, or the
    /// runtime refuses a frame.
    pub(super) fn new(
        model: &'a [u8],
        skin: Option<&str>,
        examples: &Examples,
        clips: &[Clip],
        between: bool,
    ) -> Result<Self, Error> {
        let character = Character::open(model, skin, examples)?;
        check_clips(clips)?;
        let times = clips.iter().map(key_times).collect::<Result<Vec<_>, _>>()?;
        let frames: Vec<usize> =
            clips.iter().flat_map(|clip| clip.first..clip.first + clip.times.len()).collect();
        examples.check_rigid_in(&frames)?;
        let palettes = frames
            .par_iter()
            .map(|&frame| Ok(palette(&character.envelope, examples.pose(frame), frame)?.0))
            .collect::<Result<Vec<_>, Error>>()?;
        let poses = frames.iter().map(|&frame| examples.pose(frame).to_vec()).collect();
        let influences = influences(&character.skin);
        let mut played = Self { character, times, poses, palettes, influences };
        if between {
            played.fill(examples, clips)?;
        }
        Ok(played)
    }

    /// Adds keys where the motion of helpers is not even between keys.
    fn fill(&mut self, examples: &Examples, clips: &[Clip]) -> Result<(), Error> {
        let Character { envelope, skin, .. } = &self.character;
        let (rest, diagonal) = (rest(skin), examples.diagonal());
        let centres = centres(envelope, &rest, &self.influences);
        let carriers = proxies::carriers(&self.palettes, &self.poses, &centres, REACH * diagonal);
        let mesh = (&rest[..], &self.influences);
        let proxies = (&centres[..], &carriers[..]);
        let between = Between::new(&examples.skeleton, proxies, mesh, self.first_proxy(), diagonal);
        let (mut times, mut poses, mut palettes) = (Vec::new(), Vec::new(), Vec::new());
        for ((own, clip), keys) in self.times.iter().zip(clips).zip(self.clips()) {
            let known = self.poses[keys.clone()].iter().zip(&self.palettes[keys]);
            let key = |(&time, (pose, palette)): (&f32, (&Vec<_>, &Vec<_>))| Key {
                time,
                pose: pose.clone(),
                palette: palette.clone(),
            };
            let keys = own.iter().zip(known).map(key).collect();
            let predict = |pose: &[Matrix3x4]| {
                palette(envelope, pose, clip.first).map(|(palette, _)| palette)
            };
            let keys = between.refine(keys, predict)?;
            times.push(keys.iter().map(|key| key.time).collect());
            for key in keys {
                poses.push(key.pose);
                palettes.push(key.palette);
            }
        }
        (self.times, self.poses, self.palettes) = (times, poses, palettes);
        Ok(())
    }

    /// Converts the clips to a right-handed space.
    ///
    /// # Errors
    /// The model's space is impossible.
    pub(super) fn right_handed(&self, examples: &Examples) -> Result<RightHanded, Error> {
        let Character { envelope, skin, space } = &self.character;
        let hand = SpaceRequest { handedness: Some(Handedness::Right), ..SpaceRequest::default() };
        let (space, mirror) = Conversion::to(*space, &hand)?;
        let (mut rest, mut skeleton) = (rest(skin), examples.skeleton.clone());
        let (mut poses, mut palettes) = (self.poses.clone(), self.palettes.clone());
        if let Some(mirror) = &mirror {
            rest.iter_mut().for_each(|x| *x = mirror.point(*x));
            let turn = |b: &mut Matrix3x4| *b = mirror.transform(b);
            skeleton.rest.iter_mut().for_each(turn);
            poses.iter_mut().flatten().for_each(turn);
            for b in palettes.iter_mut().flatten() {
                // Exact: entries only change places and signs.
                let turned = mirror.transform(&b.map(|row| row.map(f64::from)));
                *b = turned.map(|row| row.map(|x| x as f32));
            }
        }
        let centres = centres(envelope, &rest, &self.influences);
        let radius = REACH * examples.diagonal();
        let carriers = proxies::carriers(&palettes, &poses, &centres, radius);
        Ok(RightHanded { space, mirror, rest, skeleton, poses, palettes, centres, carriers })
    }

    /// Returns the index of the first proxy in the palette; joints come before it.
    pub(super) fn first_proxy(&self) -> usize {
        let envelope = &self.character.envelope;
        envelope.palette_len() - envelope.proxy_len()
    }

    /// Lists the keys of each clip, as ranges of all keys.
    pub(super) fn clips(&self) -> impl Iterator<Item = std::ops::Range<usize>> {
        self.times.iter().scan(0, |begin, times| {
            let own = *begin..*begin + times.len();
            *begin = own.end;
            Some(own)
        })
    }
}

/// Returns the centre of the vertices that each proxy moves, or of the mesh if the proxy moves none.
fn centres(envelope: &Envelope<'_>, rest: &[[f64; 3]], influences: &Influences) -> Vec<[f64; 3]> {
    let first = envelope.palette_len() - envelope.proxy_len();
    let mut sums = vec![[0.0; 4]; envelope.proxy_len()];
    let mut all = [0.0; 4];
    for (x, influences) in rest.iter().zip(influences) {
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
