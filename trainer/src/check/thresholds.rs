//! The thresholds of all findings, each with its reason.

/// Distances of the mesh from the origin, in diagonals, that give a note and a warning. A vertex 2^k diagonals away
/// uses k of the 24 bits of an f32 for the distance. A loss of 3 bits is rarely visible, a loss of 7 leaves 1e-5 of the
/// diagonal.
pub const FAR: (f64, f64) = (8.0, 128.0);

/// Allowed difference of a mesh near rest from the rest mesh, in steps of single precision. Both meshes and the maps
/// are rounded.
pub const ROUNDED: f64 = 4.0;

/// Usual heights of a character in metres, from a toy to a giant: less than a power of ten, to separate the usual units.
pub const TALL: (f64, f64) = (0.3, 3.0);

/// A mesh stands on the ground if its lowest coordinate is nearer to zero than this share of its extent.
pub const GROUND: f64 = 0.02;

/// Error of one joint a vertex, in diagonals, above which other scales and axes are tried. Bending alone causes a third
/// of this error.
pub const MISPLACED: f64 = 0.05;

/// Another scale, other axes or a shift are reported if they reduce the error below this share.
pub const REMEDIED: f64 = 0.3;

/// A joint is near rest below this angle, in degrees. Deviations from LBS grow with the bend; at 15° they are a small
/// part of those at 60°.
pub const NEAR_REST: f64 = 15.0;

/// Largest error of LBS near rest, as a share of its error in all poses.
pub const REST_ERROR: f64 = 0.6;

/// RMS error in diagonals below which a mesh counts as right: good models have this error.
pub const VISIBLE: f64 = 3e-4;

/// Angle in degrees below which a joint counts as still: a hundred times the rounding of single precision.
pub const STILL: f64 = 0.05;

/// Spread of the singular values of a joint's map below which the joint is scaled evenly.
pub const SCALED: f64 = 1e-4;

/// Least weight with which a joint moves a vertex; smaller weights are noise of a fit.
pub const IDLE: f64 = 0.01;

/// Least share of all vertices for a warning about vertices with a common position; texture seams need fewer.
pub const LOOSE: f64 = 0.5;

/// Share of its rest area below which a triangle counts as collapsed.
pub const COLLAPSED: f64 = 0.01;

/// Cosine of the angle above which a triangle counts as turned over, against its neighbour or the direction given by
/// its joints. The angle is 120°, more than any bulge.
pub const FLIPPED: f64 = -0.5;

/// Least share of collapsed or turned triangles in a frame for a warning. Folds of armpits and groins stay below.
pub const MANY: f64 = 0.2;

/// Meshes of a clip are wrong if LBS fitted to the clip alone has a larger error than this, in diagonals, and this
/// multiple of the error in the best clip. On real sets cut into clips of 6 to 24 frames the error is at most 1.3 %.
pub const WRONG_CLIP: (f64, f64) = (0.05, 5.0);

/// Clips are unlike if LBS with common weights has a larger error than this, in diagonals, and this multiple of the
/// error with weights for each clip. On the same sets the multiple is at most 1.25.
pub const UNLIKE_CLIPS: (f64, f64) = (0.005, 1.6);

/// Angle in degrees within which all joints of two poses must agree to be the same pose.
pub const SAME_POSE: f64 = 0.5;

/// Meshes of the same pose contradict each other if their LBS residuals differ by more than this share of the RMS
/// error: no function of the pose fits both.
pub const CONTRADICTION: f64 = 0.5;

/// Meshes belong to another frame if the error of LBS there falls below this share.
pub const SHIFTED: f64 = 0.7;

/// Fewest frames of a clip for a search of shifts, which fits weights to the frames.
pub const SHIFT_FRAMES: usize = 12;

/// Largest delay or lead in frames. A larger shift of a walk may be its next step.
pub const SHIFTS: isize = 5;

/// Cost of a change of the shift, in frames of mean error. A shorter run is a single wrong frame.
pub const SHIFT_RUN: f64 = 3.0;

/// Distance of the nearest training frame, in degrees, above which a frame is outside a joint's trained range. The
/// distance is three times the spacing at which a kernel map still follows a muscle.
pub const OUTSIDE_RANGE: f64 = 15.0;

/// Distance of a value from a curve's trained range, as a share of the range, above which a frame is outside.
pub const OUTSIDE_CURVE: f64 = 0.1;

/// Angle in degrees that weighs as much as a curve's whole range. Poses of one curve value then agree within 0.6 % of
/// the range.
pub const CURVE: f64 = 90.0;

/// The poses do not explain the skin if frames predicted by the others have more than this share of the error of LBS. The
/// share is at most 0.26 on the real sets, and 0.76 on `curves` without its curves.
pub const UNEXPLAINED: f64 = 0.5;

/// Angle in degrees above which a joint moves a lot. Below this angle LBS is accurate.
pub const LARGE_BEND: f64 = 30.0;

/// Share of its largest angle above which a joint counts as bent.
pub const BENT: f64 = 0.5;

/// Fewest distinct poses that a joint needs: the ends, the middle and two between.
pub const ENOUGH_POSES: usize = 5;

/// Distance between distinct poses of a joint, as a share of its largest angle.
pub const DISTINCT: f64 = 0.1;

/// Poses may be left out together if the remaining poses predict each with at most this share of the RMS error at which
/// all poses predict each other. On held-out frames, models trained without them had 0 % more error on mpfb-arm (37 of
/// 180 poses) and 2 % more on dem-bones (222 of 300).
pub const REDUNDANT: f64 = 0.5;

/// Share of LBS's RMS error that need not be predicted. In an animation the neighbours predict a frame so well that
/// half of their error is almost zero.
pub const NEGLIGIBLE: f64 = 0.005;

/// A pose is isolated if the others predict it with more than this multiple of the RMS error over all poses.
pub const ISOLATED: f64 = 1.5;

/// Angle in degrees that weighs as much as a slide of a joint by one diagonal, as in pose features.
pub const SLIDE: f64 = 120.0;

/// Painted weights are wrong from this multiple of the RMS error of fitted weights on. Bones on the wrong mesh have
/// more, an artist's weights less.
pub const MISLEADS: f64 = 3.0;
