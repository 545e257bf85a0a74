//! Which joints and curves move in each pose, and how far.

use super::ranges::upwards;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::cmp::Reverse;

/// Joints, then curves.
pub(super) struct Movers<'a> {
    /// Freedoms of each mover, none if it keeps still: whether the range begins, and whether it ends, at rest.
    pub(super) rests: &'a [Vec<[bool; 2]>],
    /// Parent of each joint, J.
    pub(super) parents: &'a [Option<usize>],
    /// Number of curves.
    pub(super) curves: usize,
}

/// Places of all freedoms in their ranges.
pub(super) struct Plan {
    /// Places from 0 to 1, by frame and freedom; `None` at rest.
    pub(super) frames: Vec<Vec<Option<f64>>>,
    /// Number of frames in which movers move alone, and in which pairs do.
    pub(super) alone: usize,
    pub(super) paired: usize,
}

/// Plans `frame_len` frames: at most a third for movers alone, at most a third for pairs, and the rest for all movers.
pub(super) fn plan(movers: &Movers<'_>, frame_len: usize, seed: u64) -> Plan {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let all: Vec<usize> = (0..movers.rests.len()).filter(|&mover| movers.moves(mover)).collect();
    let alone: Vec<Vec<usize>> = all.iter().map(|&mover| vec![mover]).collect();
    let mut pairs = movers.pairs();
    shuffle(&mut pairs, &mut random);
    let steps = movers.steps();
    let third = frame_len / 3;
    // Two frames reach both ends of a range.
    let alone = spread(&alone, third, 2, &steps);
    let paired = spread(&pairs, third, 1, &steps);
    let together = vec![all.clone(); frame_len - alone.len() - paired.len()];

    let mut frames = vec![vec![None; movers.rests.iter().map(Vec::len).sum()]; frame_len];
    let mut before = 0;
    for block in [&alone, &paired, &together] {
        let mut freedom = 0;
        for (mover, rests) in movers.rests.iter().enumerate() {
            let moved: Vec<usize> =
                (0..block.len()).filter(|&frame| block[frame].contains(&mover)).collect();
            for &rests in rests {
                for (&frame, place) in moved.iter().zip(strata(moved.len(), rests, &mut random)) {
                    frames[before + frame][freedom] = Some(place);
                }
                freedom += 1;
            }
        }
        before += block.len();
    }
    Plan { frames, alone: alone.len(), paired: paired.len() }
}

impl Movers<'_> {
    fn moves(&self, mover: usize) -> bool {
        !self.rests[mover].is_empty()
    }

    /// Lists the pairs of movers that are neighbours: a joint and its parent, and every two curves.
    fn pairs(&self) -> Vec<Vec<usize>> {
        let joint_len = self.parents.len();
        let joints = (0..joint_len).filter_map(|joint| Some(vec![self.parents[joint]?, joint]));
        let curves = joint_len..joint_len + self.curves;
        let curves = curves.clone().flat_map(|a| (joint_len..a).map(move |b| vec![b, a]));
        let moves = |pair: &Vec<usize>| pair.iter().all(|&mover| self.moves(mover));
        joints.chain(curves).filter(moves).collect()
    }

    /// Returns the number of steps through the hierarchy between any two movers. A curve may move any skin, so it is a
    /// neighbour of every mover.
    fn steps(&self) -> Vec<Vec<usize>> {
        let lines: Vec<Vec<usize>> =
            (0..self.parents.len()).map(|joint| upwards(joint, self.parents).collect()).collect();
        let between = |a: usize, b: usize| {
            let (Some(own), Some(other)) = (lines.get(a), lines.get(b)) else {
                return usize::from(a != b);
            };
            let meet = |(up, joint): (usize, &usize)| {
                Some(up + other.iter().position(|above| above == joint)?)
            };
            own.iter().enumerate().find_map(meet).unwrap_or(usize::MAX)
        };
        let movers = 0..self.rests.len();
        movers.clone().map(|a| movers.clone().map(|b| between(a, b)).collect()).collect()
    }
}

/// Gives each set of movers its own frames, at least `each`. If frames are too few, sets that are far apart share
/// frames. Returns the movers of each frame, at most `frame_len`.
fn spread(
    sets: &[Vec<usize>],
    frame_len: usize,
    each: usize,
    steps: &[Vec<usize>],
) -> Vec<Vec<usize>> {
    let count = sets.len().min(frame_len / each);
    if count == 0 {
        return Vec::new();
    }
    let mut shared: Vec<Vec<usize>> = vec![Vec::new(); count];
    // Steps from each mover to the nearest one that a frame moves.
    let mut gaps = vec![vec![usize::MAX; steps.len()]; count];
    for set in sets {
        let gap = |place: usize| set.iter().map(|&mover| gaps[place][mover]).min();
        let farthest = (0..count)
            .max_by_key(|&place| (gap(place), Reverse(shared[place].len()), Reverse(place)));
        let Some(place) = farthest else { continue };
        for &mover in set {
            let nearer = gaps[place].iter_mut().zip(&steps[mover]);
            nearer.for_each(|(gap, steps)| *gap = (*gap).min(*steps));
        }
        shared[place].extend(set);
    }
    shared.iter().flat_map(|set| vec![set.clone(); frame_len / count]).collect()
}

/// Returns `len` evenly spaced numbers from 0 to 1 in random order; a random number if `len` is 1.
///
/// - `rests`: whether 0, and whether 1, is the rest pose. Other frames show the rest pose, so it is left out.
fn strata(len: usize, rests: [bool; 2], random: &mut ChaCha8Rng) -> Vec<f64> {
    let [first, last] = rests.map(usize::from);
    let steps = (len + first + last).saturating_sub(1);
    if steps == 0 {
        return (0..len).map(|_| random.random()).collect();
    }
    let mut places: Vec<f64> =
        (first..len + first).map(|place| place as f64 / steps as f64).collect();
    shuffle(&mut places, random);
    places
}

/// Puts items in random order.
fn shuffle<T>(items: &mut [T], random: &mut ChaCha8Rng) {
    for last in (1..items.len()).rev() {
        items.swap(last, random.random_range(0..=last as u64) as usize);
    }
}
