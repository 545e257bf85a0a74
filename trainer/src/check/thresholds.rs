//! Where a finding begins: every threshold of a check, with its reason.

/// Distances of the mesh from the origin, in diagonals, that are told of and warned of. A vertex
/// 2^k diagonals away has k of the 24 bits of an f32 for its place instead of the mesh: 3 bits are
/// seldom seen, 7 leave a hundred-thousandth of the diagonal.
pub const FAR: (f64, f64) = (8.0, 128.0);

/// A mesh near rest may differ from the rest mesh by this count of steps of single precision: both are rounded, and so are the maps.
pub const ROUNDED: f64 = 4.0;

/// Height of a character in metres: from a toy to a giant, less than a power of ten.
pub const TALL: (f64, f64) = (0.3, 3.0);

/// A mesh that stands this near to zero on an axis, as a share of its extent, stands on the ground.
pub const GROUND: f64 = 0.02;

/// Scale and axes are tried where one joint a vertex leaves more than this, in diagonals; bending
/// alone leaves a third of that.
pub const MISPLACED: f64 = 0.05;

/// Another scale, other axes or a shift are named where they leave this share of the error.
pub const RIGHTED: f64 = 0.3;

/// A joint is near rest below this angle: what a skin does beyond LBS grows with the bend, and at
/// 15° is a small part of what it is at 60°.
pub const NEAR_REST: f64 = 15.0;

/// Near rest, LBS must err by less than this share of what it errs by in all poses.
pub const REST_ERROR: f64 = 0.6;

/// What is less than this, in diagonals RMS, is no fault of a mesh: the error of good models.
pub const VISIBLE: f64 = 3e-4;

/// A joint that turns by less than this, in degrees, is still: a hundred times what single
/// precision leaves.
pub const STILL: f64 = 0.05;

/// A singular value of a joint's map that is off by more than this is told as a scale.
pub const SCALED: f64 = 1e-4;

/// A joint moves a vertex from this weight on: less is what a fit leaves of noise.
pub const IDLE: f64 = 0.01;

/// Vertices that share a place are warned of from this share of all: texture seams need fewer.
pub const LOOSE: f64 = 0.5;

/// A triangle has collapsed where it keeps less than this share of its area.
pub const COLLAPSED: f64 = 0.01;

/// Cosine of the angle between a triangle and where its joints take it, or its neighbour, from which
/// it is turned over: 120°, more than any bulge.
pub const FLIPPED: f64 = -0.5;

/// Triangles that are turned over or collapsed in a frame are warned of from this share of all: the
/// folds of armpits and groins stay below.
pub const MANY: f64 = 0.2;

/// A clip's meshes are not of its joints where LBS that is fitted to it alone errs by more than this, in diagonals, and so
/// many times as much as in the best clip: on real sets cut into clips of 6 to 24 frames it errs by 1.3 % at most.
pub const WRONG_CLIP: (f64, f64) = (0.05, 5.0);

/// Clips are unlike where LBS errs by more than this, in diagonals, with weights that are fitted to all, and so many times
/// as much as with weights for each: on the same sets it errs 1.25 times as much at most.
pub const UNLIKE_CLIPS: (f64, f64) = (0.005, 1.6);

/// Poses are one where every joint agrees within this angle, in degrees.
pub const SAME_POSE: f64 = 0.5;

/// Meshes of one pose contradict each other where what LBS leaves differs by more than this share
/// of its RMS error: no map of the pose could follow both.
pub const CONTRADICTION: f64 = 0.5;

/// Meshes belong to the frame beside theirs where LBS then leaves less than this share.
pub const SHIFTED: f64 = 0.7;

/// Fewest frames of a clip on which a shift is tried: weights are fitted to them.
pub const SHIFT_FRAMES: usize = 12;

/// Most frames that meshes may be late or early: a larger shift of a walk may be its next step.
pub const SHIFTS: isize = 5;

/// Cost of a change of the shift, in frames of mean error: shorter runs are single wrong frames.
pub const SHIFT_RUN: f64 = 3.0;

/// A frame bends a joint beyond training where no training frame is nearer, in degrees: three times
/// the spacing at which a kernel map still follows a muscle.
pub const BEYOND: f64 = 15.0;

/// A joint moves a lot from this angle on, in degrees: below, LBS is right anyhow.
pub const MUCH: f64 = 30.0;

/// A joint is bent where it is at more than this share of its largest angle.
pub const BENT: f64 = 0.5;

/// Fewer distinct poses of a joint than this are few: ends, middle and two between.
pub const FEW: usize = 5;

/// Poses of a joint are distinct that are further apart than this share of its largest angle.
pub const DISTINCT: f64 = 0.1;

/// Poses may be left out together while those that stay predict none of them worse than this share
/// of the RMS error at which all poses predict each other. Measured on held-out frames of models
/// trained without them: 0 % more on mpfb-arm (37 of 180 poses), 2 % on dem-bones (222 of 300).
pub const REDUNDANT: f64 = 0.5;

/// What is less than this share of LBS's RMS error need not be predicted: in an animation the
/// neighbours of a frame predict it so well that half of their error is next to nothing.
pub const NEGLIGIBLE: f64 = 0.005;

/// A pose stands alone where the others miss it by more than this many times the RMS over all poses.
pub const ISOLATED: f64 = 1.5;

/// A slide of a joint by a diagonal counts as much as this angle in degrees: the weight that pose
/// features give it.
pub const SLIDE: f64 = 120.0;

/// Painted weights mislead from this multiple of the RMS error of fitted weights on: bones on the wrong mesh leave more, an
/// artist's weights less.
pub const MISLEADS: f64 = 3.0;
