/* Sinew: evaluates baked models of how skin moves. Made by cbindgen of runtime/capi/src; do not edit.
 *
 * Objects: a model is a loaded file, an envelope predicts a palette, a skin is a mesh that follows one,
 * a kernel is a function of a few numbers, a prior says how weights of shapes belong together, views
 * are a drawn object between its key views, a filter makes a signal finer. They lie in memory of the caller, who asks for its size
 * (sinew_*_bytes) or takes an array of SINEW_*_WORDS uintptr_t. Nothing is allocated and nothing has to
 * be freed. The file's bytes must stay, unchanged, while a model of them is in use; a model's memory must
 * stay for as long as its parts are used, but may be loaded again: calls then refuse what was opened
 * before, with STALE, and with NOT_LOADED if it was filled with zeros.
 *
 * Calls: every function that can fail returns a sinew_status, and writes what went wrong to its last
 * argument unless that is null. When a call fails it has written nothing else but scratch. Statuses are
 * named in these comments without their prefix SINEW_STATUS_.
 *
 * Pointers: one that is null, misaligned, or that overlaps what it must not, is a status. What no
 * library can see remains the caller's: that a pointer and its length describe memory of the
 * caller, that a handle points to memory at least as large as the object, and that nobody else writes
 * to what a call reads, or uses what it writes, while it runs. Where the error goes is not compared
 * with the rest. An array of length 0 may be null.
 *
 * Threads: the library has no state. Every function may run at any time on any thread. Models and
 * their parts never change but by loading or opening in their memory, and are shared freely;
 * scratch and outputs belong to one call at a time.
 *
 * Floats: binary32, rounded to nearest, subnormals kept. With that the results have the same bits
 * on every CPU.
 */

#ifndef SINEW_H
#define SINEW_H

#include <stddef.h>
#include <stdint.h>

/// Version of the ABI that this header describes; `sinew_abi_version` returns the library's.
///
/// It grows when a function, a structure or the meaning of a number changes.
#define SINEW_ABI_VERSION 9

/// Stands for no part.
#define SINEW_NO_PART UINT32_MAX

/// Elements of a `uintptr_t` array that holds a model on every target:
/// `uintptr_t memory[SINEW_MODEL_WORDS]`.
#define SINEW_MODEL_WORDS 192

/// Elements of a `uintptr_t` array that holds an envelope on every target:
/// `uintptr_t memory[SINEW_ENVELOPE_WORDS]`.
#define SINEW_ENVELOPE_WORDS 48

/// Stands for no joint: the parent of the root.
#define SINEW_NO_JOINT UINT32_MAX

/// Stands in a joint map for a joint that the skeleton lacks: it moves as its parent does.
#define SINEW_FOLDED UINT32_MAX

/// Elements of a `uintptr_t` array that holds a kernel on every target:
/// `uintptr_t memory[SINEW_KERNEL_WORDS]`.
#define SINEW_KERNEL_WORDS 48

/// Elements of a `uintptr_t` array that holds a skin on every target:
/// `uintptr_t memory[SINEW_SKIN_WORDS]`.
#define SINEW_SKIN_WORDS 48

/// Elements of a `uintptr_t` array that holds a filter on every target:
/// `uintptr_t memory[SINEW_FILTER_WORDS]`.
#define SINEW_FILTER_WORDS 48

/// Elements of a `uintptr_t` array that holds a prior on every target:
/// `uintptr_t memory[SINEW_PRIOR_WORDS]`.
#define SINEW_PRIOR_WORDS 48

/// The most pins of a job.
#define SINEW_PINS_MAX 64

/// Elements of a `uintptr_t` array that holds views on every target: `uintptr_t memory[SINEW_VIEWS_WORDS]`.
#define SINEW_VIEWS_WORDS 48

/// What a call came to. 1 to 99: the call is wrong, from 50 on in what only C can get wrong. From 100
/// on: the file is.
///
/// `sinew_error` tells more: what an entry names as index, expected and found.
enum sinew_status
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// Done.
    SINEW_STATUS_OK = 0,
    /// An array whose length must be exact has another. Expected, found: lengths in its own elements.
    SINEW_STATUS_LENGTH = 1,
    /// An array is too short. Expected: the least length; found: its length.
    SINEW_STATUS_TOO_SHORT = 2,
    /// A joint's transform, or a number of a query, is not finite. Index: the joint, of several poses counted
    /// through all; or the number. Of outputs, derivatives and variances: one would not be finite, for the
    /// query is too far out.
    SINEW_STATUS_NON_FINITE = 3,
    /// A quaternion has no direction: it is zero, or too small or too large to square. Index: the joint, or
    /// the input.
    SINEW_STATUS_ZERO_ROTATION = 4,
    /// A joint, a vertex, a range of vertices, an input, an output or a distance is none that there may be.
    /// Index: which element, of a range its start; expected: the most; found: what it is, of a range its
    /// end.
    SINEW_STATUS_OUT_OF_RANGE = 5,
    /// A stride is shorter than its attribute. Expected: floats of the attribute; found: the stride.
    SINEW_STATUS_STRIDE = 6,
    /// The skin has no such attribute, or the kernel no variance.
    SINEW_STATUS_NO_ATTRIBUTE = 7,
    /// The envelope's predictor has no such stage. Found: the predictor.
    SINEW_STATUS_NO_STAGE = 8,
    /// A job has nothing to write to.
    SINEW_STATUS_NO_OUTPUT = 9,
    /// The skeleton lacks the root, which can follow no other joint. Index: the root.
    SINEW_STATUS_NO_ROOT = 10,
    /// The skeleton has a joint under a name of another prefix, case or separators. Index: the joint; found: the place
    /// of the skeleton's name.
    SINEW_STATUS_OTHER_NAME = 11,
    /// The skeleton has the root alone of several joints. Expected, found: joints.
    SINEW_STATUS_NO_JOINTS = 12,
    /// A pointer is null.
    SINEW_STATUS_NULL = 50,
    /// A pointer is not aligned for what it points to. Expected: bytes of alignment; found: bytes
    /// beyond the last multiple of it.
    SINEW_STATUS_MISALIGNED = 51,
    /// An array would reach beyond the address space. Found: its length.
    SINEW_STATUS_TOO_LONG = 52,
    /// Memory to be written, which the argument names, overlaps other memory of the call, or an object
    /// or the file that the call reads.
    SINEW_STATUS_OVERLAP = 53,
    /// A handle points to no loaded object of its kind; of an envelope, a skin or a kernel also: its model
    /// is loaded no more, and then the argument is the model.
    SINEW_STATUS_NOT_LOADED = 54,
    /// The model of an envelope, a skin or a kernel has been loaded again, with another file: open it anew.
    SINEW_STATUS_STALE = 55,
    /// The file holds no such envelope, skin, kernel or section. Of a section part and section tell which.
    SINEW_STATUS_NOT_FOUND = 56,
    /// The skin has no vertices, and so no bounds.
    SINEW_STATUS_NO_VERTICES = 57,
    /// Not a model: expected and found are the first four bytes, the first the least significant.
    SINEW_STATUS_FILE_NOT_A_MODEL = 100,
    /// Written in a version of the format that this library does not know. Expected, found.
    SINEW_STATUS_FILE_VERSION = 101,
    /// The file contradicts itself. Index 1 or 2: the part or the section table has no whole rows, and expected and
    /// found are bytes of a row and of the table; 3: they are the alignment of the blob, which follows zeros, and its place; 4: they are bytes of the file.
    SINEW_STATUS_FILE_MALFORMED = 102,
    /// The file was changed after it was written. Expected, found: its CRC-32.
    SINEW_STATUS_FILE_CHECKSUM = 103,
    /// More of something than the limits or the format allow. Without a section index 0 is bytes of the
    /// file, 1 parts, 2 sections; else it is a count of the section. Expected: the most; found.
    SINEW_STATUS_FILE_LIMIT = 104,
    /// Something that this library does not know: feature bits; flags or the kind of a part or of a
    /// section; an element type, a predictor, a kernel, a reserved number that is not 0. Found: the
    /// number.
    SINEW_STATUS_FILE_UNSUPPORTED = 105,
    /// A section names a part that is not there. Index: its row; expected: how many there are; found:
    /// the part.
    SINEW_STATUS_FILE_PART_INDEX = 106,
    /// A section does not start on the alignment. Index: its row; expected: the alignment; found: its offset.
    SINEW_STATUS_FILE_ALIGNMENT = 107,
    /// A section starts before the one listed before it ends. Index: its row; expected: that end; found: its offset.
    SINEW_STATUS_FILE_OVERLAP = 108,
    /// A section reaches beyond the blob. Index: its row; expected: bytes of the blob; found: its end.
    SINEW_STATUS_FILE_BOUNDS = 109,
    /// A part has two sections of one kind. Index: the second's row.
    SINEW_STATUS_FILE_DUPLICATE = 110,
    /// A part lacks the section.
    SINEW_STATUS_FILE_MISSING = 111,
    /// A section that the part, as its counts describe it, does not have.
    SINEW_STATUS_FILE_UNEXPECTED = 112,
    /// A section's length does not follow from the part's counts. Expected, found: bytes.
    SINEW_STATUS_FILE_LENGTH = 113,
    /// There is none of what there must be at least one. Index: the count, or the group.
    SINEW_STATUS_FILE_EMPTY = 114,
    /// A float is out of its range or not finite. Index: which of the section.
    SINEW_STATUS_FILE_FLOAT = 115,
    /// An index points beyond its target. Index: its place; expected: what it must be below; found.
    SINEW_STATUS_FILE_INDEX = 116,
    /// A number does not follow from the rest of the file. Index: its place; expected, found.
    SINEW_STATUS_FILE_MISMATCH = 117,
    /// An element breaks a rule of its section, which FORMAT.md states. Index: the element.
    SINEW_STATUS_FILE_INVALID = 118,
    /// The file ends early. Expected, found: bytes of the section. Without a section they are bytes of the file, and
    /// index is the place of its end: 0 the head, 1 the part table, 2 the section table, 3 the padding, 4 the blob.
    SINEW_STATUS_FILE_TRUNCATED = 119,
    /// A byte of the space is one that no space has. Index: which; found: the byte.
    SINEW_STATUS_FILE_SPACE = 120,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum sinew_status sinew_status;
#else
typedef int32_t sinew_status;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// The argument that an error is about; from 50 on those that only C has.
enum sinew_argument
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// No single one.
    SINEW_ARGUMENT_CALL = 0,
    /// Skinning matrices of the joints.
    SINEW_ARGUMENT_POSE = 1,
    /// Local transforms of the joints.
    SINEW_ARGUMENT_LOCAL = 2,
    /// Scratch; lengths in floats.
    SINEW_ARGUMENT_SCRATCH = 3,
    /// The palette; lengths in transforms.
    SINEW_ARGUMENT_PALETTE = 4,
    /// Confidences.
    SINEW_ARGUMENT_CONFIDENCES = 5,
    /// A stage's columns of the joints' transforms; no function of this library takes it.
    SINEW_ARGUMENT_RELATIVE = 6,
    /// A stage's rotation vectors; no function of this library takes it.
    SINEW_ARGUMENT_ROTATIONS = 7,
    /// A stage's columns of gradients; no function of this library takes it.
    SINEW_ARGUMENT_GRADIENTS = 8,
    /// A stage's pose features; no function of this library takes it.
    SINEW_ARGUMENT_FEATURES = 9,
    /// The range of vertices, or their places.
    SINEW_ARGUMENT_VERTICES = 10,
    /// The vertices that stand for others.
    SINEW_ARGUMENT_REMAP = 11,
    /// The caller's rest positions, or how far they are from the file's.
    SINEW_ARGUMENT_REST_POSITIONS = 12,
    /// The caller's rest normals.
    SINEW_ARGUMENT_REST_NORMALS = 13,
    /// The caller's rest tangents.
    SINEW_ARGUMENT_REST_TANGENTS = 14,
    /// Positions written; lengths in floats.
    SINEW_ARGUMENT_POSITIONS = 15,
    /// Normals written; lengths in floats.
    SINEW_ARGUMENT_NORMALS = 16,
    /// Tangents written; lengths in floats.
    SINEW_ARGUMENT_TANGENTS = 17,
    /// Numbers of a kernel's query.
    SINEW_ARGUMENT_QUERY = 18,
    /// Numbers of a kernel's outputs.
    SINEW_ARGUMENT_OUTPUTS = 19,
    /// Derivatives of a kernel's values.
    SINEW_ARGUMENT_JACOBIAN = 20,
    /// Variances of a kernel's values.
    SINEW_ARGUMENT_VARIANCES = 21,
    /// Weights of shapes.
    SINEW_ARGUMENT_SHAPE_WEIGHTS = 22,
    /// A prior, or a number that says how much a term counts beside it.
    SINEW_ARGUMENT_PRIOR = 23,
    /// Pins.
    SINEW_ARGUMENT_PINS = 24,
    /// Control points.
    SINEW_ARGUMENT_POINTS = 25,
    /// Visibilities of control points.
    SINEW_ARGUMENT_VISIBILITY = 26,
    /// Scores of key views.
    SINEW_ARGUMENT_SCORES = 27,
    /// Pixels of a picture.
    SINEW_ARGUMENT_PIXELS = 28,
    /// Depths of pixels.
    SINEW_ARGUMENT_DEPTHS = 29,
    /// Samples of signals.
    SINEW_ARGUMENT_SAMPLES = 30,
    /// Names of the joints of the caller's skeleton.
    SINEW_ARGUMENT_NAMES = 31,
    /// Which joint of the caller's skeleton moves each joint, or the joints' parents.
    SINEW_ARGUMENT_JOINTS = 32,
    /// Frames of the joints of the caller's skeleton.
    SINEW_ARGUMENT_WORLD = 33,
    /// The matrix of the root.
    SINEW_ARGUMENT_ROOT = 34,
    /// Opacities and orders of layers.
    SINEW_ARGUMENT_LAYERS = 35,
    /// What layers that clip leave of pixels.
    SINEW_ARGUMENT_CLIPS = 36,
    /// Pixels of a layer that is drawn by itself.
    SINEW_ARGUMENT_GROUP = 37,
    /// Memory for an object; lengths in bytes.
    SINEW_ARGUMENT_MEMORY = 50,
    /// The file; lengths in bytes.
    SINEW_ARGUMENT_FILE = 51,
    /// Limits.
    SINEW_ARGUMENT_LIMITS = 52,
    /// A model.
    SINEW_ARGUMENT_MODEL = 53,
    /// An envelope.
    SINEW_ARGUMENT_ENVELOPE = 54,
    /// A skin.
    SINEW_ARGUMENT_SKIN = 55,
    /// A name; lengths in bytes.
    SINEW_ARGUMENT_NAME = 56,
    /// The number of a joint.
    SINEW_ARGUMENT_JOINT = 57,
    /// The number of a named range.
    SINEW_ARGUMENT_RANGE = 58,
    /// The part and kind of a section.
    SINEW_ARGUMENT_SECTION = 59,
    /// A skin job.
    SINEW_ARGUMENT_JOB = 60,
    /// Palette indices of influences.
    SINEW_ARGUMENT_INDICES = 61,
    /// Weights of influences.
    SINEW_ARGUMENT_WEIGHTS = 62,
    /// Evaluation order of the joints.
    SINEW_ARGUMENT_ORDER = 63,
    /// Where a result goes.
    SINEW_ARGUMENT_RESULT = 64,
    /// Where a second result goes.
    SINEW_ARGUMENT_SECOND_RESULT = 65,
    /// A kernel.
    SINEW_ARGUMENT_KERNEL = 66,
    /// The number of a kernel's input.
    SINEW_ARGUMENT_INPUT = 67,
    /// The number of a kernel's output.
    SINEW_ARGUMENT_OUTPUT = 68,
    /// The number of a shape; how samples lie.
    SINEW_ARGUMENT_SHAPE = 69,
    /// Views.
    SINEW_ARGUMENT_VIEWS = 70,
    /// The number of a map.
    SINEW_ARGUMENT_MAP = 71,
    /// A filter.
    SINEW_ARGUMENT_FILTER = 72,
    /// A level of evaluation.
    SINEW_ARGUMENT_LEVEL = 73,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum sinew_argument sinew_argument;
#else
typedef uint32_t sinew_argument;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// A direction along an axis.
enum sinew_axis
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// The file does not say.
    SINEW_AXIS_UNKNOWN = 0,
    /// Along x.
    SINEW_AXIS_X = 1,
    /// Against x.
    SINEW_AXIS_MINUS_X = 2,
    /// Along y.
    SINEW_AXIS_Y = 3,
    /// Against y.
    SINEW_AXIS_MINUS_Y = 4,
    /// Along z.
    SINEW_AXIS_Z = 5,
    /// Against z.
    SINEW_AXIS_MINUS_Z = 6,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum sinew_axis sinew_axis;
#else
typedef uint32_t sinew_axis;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// Which way the third axis points, seen from the first two.
enum sinew_handedness
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// x cross y is z.
    SINEW_HANDEDNESS_RIGHT = 1,
    /// x cross y is -z.
    SINEW_HANDEDNESS_LEFT = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum sinew_handedness sinew_handedness;
#else
typedef uint32_t sinew_handedness;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// How an envelope predicts its palette.
enum sinew_predictor
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// Rotational regression: the palette is P proxies.
    SINEW_PREDICTOR_ROTATIONAL = 1,
    /// The palette is the J joints, then P helpers that kernel maps move.
    SINEW_PREDICTOR_KERNEL = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum sinew_predictor sinew_predictor;
#else
typedef uint32_t sinew_predictor;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// The likely mistake of a pose that is none of the skeleton's.
enum sinew_pose_fault_kind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// None: the pose is one of the skeleton's.
    SINEW_POSE_FAULT_KIND_NONE = 0,
    /// A matrix is not finite.
    SINEW_POSE_FAULT_KIND_NON_FINITE = 2,
    /// A matrix mirrors.
    SINEW_POSE_FAULT_KIND_MIRRORED = 3,
    /// A matrix scales by `factor` along all axes.
    SINEW_POSE_FAULT_KIND_SCALED = 4,
    /// A matrix scales along axes by different factors, or shears.
    SINEW_POSE_FAULT_KIND_STRETCHED = 5,
    /// The matrices' rotations are transposed, and their translations may be lost.
    SINEW_POSE_FAULT_KIND_TRANSPOSED = 6,
    /// Lengths are in another unit: `factor` of them make one of the model's.
    SINEW_POSE_FAULT_KIND_UNITS = 7,
    /// The pose is in other axes of the same handedness, `axes`.
    SINEW_POSE_FAULT_KIND_AXES = 8,
    /// The pose is in axes of the other handedness, `axes`.
    SINEW_POSE_FAULT_KIND_HANDEDNESS = 9,
    /// A joint is off the place to which its parent carries it, and no mistake about the whole pose explains it.
    SINEW_POSE_FAULT_KIND_APART = 10,
    /// No frame was written: a matrix is zero, or all gathered frames are the identity.
    SINEW_POSE_FAULT_KIND_UNSET = 11,
    /// The matrices are the joints' frames: the inverse bind matrices were not applied.
    SINEW_POSE_FAULT_KIND_FRAMES = 12,
    /// The inverse bind matrices were applied twice.
    SINEW_POSE_FAULT_KIND_BOUND_TWICE = 13,
    /// Each matrix, or each gathered frame, is in the space of the joint's parent.
    SINEW_POSE_FAULT_KIND_LOCAL = 14,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum sinew_pose_fault_kind sinew_pose_fault_kind;
#else
typedef uint32_t sinew_pose_fault_kind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// How much of an envelope is evaluated.
enum sinew_level
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// What the correction starts from: the joints, or the reconstruction. Of a kernel envelope this is next to
    /// nothing, of a rotational one all; `sinew_certificate.base_training_rms` is its error.
    SINEW_LEVEL_JOINTS = 1,
    /// Everything: what `sinew_envelope_palette` computes.
    SINEW_LEVEL_FULL = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum sinew_level sinew_level;
#else
typedef uint32_t sinew_level;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// Predicts a palette of transforms from the J joints of a pose. It points to its model: where that
/// has been loaded again with another file, or is loaded no more, every call refuses the envelope.
typedef struct sinew_envelope sinew_envelope;

/// Weights that make a signal finer. It points to its model: where that has been loaded again with another file,
/// or is loaded no more, every call refuses the filter.
typedef struct sinew_filter sinew_filter;

/// A function from named inputs to named outputs. It points to its model: where that has been loaded again
/// with another file, or is loaded no more, every call refuses the kernel.
typedef struct sinew_kernel sinew_kernel;

/// A loaded file: what was found in its bytes, which must stay where they are and as they are while
/// the model is in use. Its memory may be loaded again at any time that no call uses it, with the same
/// file or another, and filled with zeros it is loaded no more; it needs no other end. Its envelopes,
/// skins and kernels point to it: it must stay in its place, and outlive them.
typedef struct sinew_model sinew_model;

/// How the weights of a skin's shapes belong together. It points to its model: where that has been loaded again
/// with another file, or is loaded no more, every call refuses the prior.
typedef struct sinew_prior sinew_prior;

/// A mesh of V vertices that follows an envelope's palette, or stays at rest if it follows none. It
/// points to its model: where that has been loaded again with another file, or is loaded no more,
/// every call refuses the skin.
typedef struct sinew_skin sinew_skin;

/// A drawn object between its key views. It points to its model: where that has been loaded again with another
/// file, or is loaded no more, every call refuses the views.
typedef struct sinew_views sinew_views;

/// The most of everything that a file may hold. All work, of loading and of evaluating, grows with
/// these counts and with nothing else.
typedef struct sinew_limits {
    /// Bytes of the file.
    uint32_t file_bytes;
    /// Parts of the file.
    uint16_t parts;
    /// Sections of the file.
    uint16_t sections;
    /// Vertices of a skin.
    uint32_t vertices;
    /// Joints of an envelope.
    uint32_t joints;
    /// Proxies of an envelope.
    uint32_t proxies;
    /// Influences of a vertex.
    uint32_t influences;
    /// Shapes of a skin.
    uint32_t shapes;
} sinew_limits;

/// What went wrong; written only when a call returns another status than `SINEW_STATUS_OK`.
///
/// Each status says which of the last three fields it fills; the others are 0.
typedef struct sinew_error {
    /// What the call returned.
    sinew_status status;
    /// The argument that it is about.
    sinew_argument argument;
    /// The part of the file, or `SINEW_NO_PART`.
    uint32_t part;
    /// The section's number in FORMAT.md; 0 if it is about none.
    uint32_t section;
    /// Which element.
    size_t index;
    /// What should have been there: an exact value, the least or the most, as the status says.
    size_t expected;
    /// What was there.
    size_t found;
} sinew_error;

/// What a file holds, and the space of its numbers: of its rest meshes, of the poses that it takes and
/// of what it gives.
typedef struct sinew_model_info {
    /// Parts, known to the library or not.
    size_t part_len;
    /// Envelopes.
    size_t envelope_len;
    /// Skins.
    size_t skin_len;
    /// Kernels.
    size_t kernel_len;
    /// Where a character's head is.
    sinew_axis up;
    /// Where a character looks.
    sinew_axis forward;
    /// The axes' handedness.
    sinew_handedness handedness;
    /// Metres of a unit of length; 0 if the file does not say.
    float unit;
} sinew_model_info;

/// A section of the file, known to the library or not, by its number in FORMAT.md.
typedef struct sinew_section {
    /// Where it starts, in bytes from the blob's start; a multiple of 16.
    uint32_t offset;
    /// Its length in bytes.
    uint32_t bytes;
} sinew_section;

/// What the fit was measured to reach, in the units of the file.
typedef struct sinew_certificate {
    /// Diagonal of the rest pose's box.
    float diagonal;
    /// RMS error over vertices and training frames.
    float training_rms;
    /// Forecast of the RMS error on more frames of the training clips.
    float same_clips_rms;
    /// RMS error of linear blend skinning over vertices and training frames.
    float lbs_training_rms;
    /// The farthest that single precision may move a vertex through the correction; 0 without one.
    float correction_error;
    /// RMS error over vertices and training frames of `SINEW_LEVEL_JOINTS`.
    float base_training_rms;
    /// Forecast of the RMS error on another clip; negative if training had one clip.
    float other_clip_rms;
} sinew_certificate;

/// What an envelope is made of: every length that its calls need.
typedef struct sinew_envelope_info {
    /// Its name: UTF-8 in the file's bytes, not ended by a zero.
    const char *name;
    /// Bytes of the name.
    size_t name_len;
    /// Its number among the file's parts.
    uint32_t part;
    /// How it predicts.
    sinew_predictor predictor;
    /// J, joints: skinning matrices of a pose.
    size_t joint_len;
    /// P, proxies or helpers.
    size_t proxy_len;
    /// Transforms of the palette.
    size_t palette_len;
    /// Floats of scratch that `sinew_envelope_palette` needs.
    size_t scratch_len;
    /// The joint without a parent.
    uint32_t root;
    /// Which skeleton it is: what `sinew_skeleton_hash` gives of its names and parents.
    uint32_t skeleton_hash;
    /// What the fit was measured to reach.
    struct sinew_certificate certificate;
} sinew_envelope_info;

/// A rigid or affine transform, as three rows of four: `y[r] = rows[r][0..2] . x + rows[r][3]`.
typedef struct sinew_matrix {
    /// The rows.
    float rows[3][4];
} sinew_matrix;

/// A joint's frame in its parent's.
typedef struct sinew_local_transform {
    /// Quaternion x, y, z, w; it is normalised by the call.
    float rotation[4];
    /// Origin in the parent's frame, in the units of the model.
    float translation[3];
} sinew_local_transform;

/// A joint.
typedef struct sinew_joint {
    /// Its name: UTF-8 in the file's bytes, not ended by a zero.
    const char *name;
    /// Bytes of the name.
    size_t name_len;
    /// Its parent, or `SINEW_NO_JOINT`.
    uint32_t parent;
    /// The largest angle that it turned in training against its parent, in radians.
    float pose_range;
    /// How far its origin came in training from where its parent carries it, at the most.
    float pose_gap;
    /// Its inverse bind matrix: model space to the joint's rest frame.
    struct sinew_matrix inverse_bind;
    /// Its rest frame in its parent's, the root's in model space.
    struct sinew_local_transform rest_local;
} sinew_joint;

/// A name of the caller's.
typedef struct sinew_name {
    /// UTF-8; no zero at its end is needed.
    const char *name;
    /// Bytes of the name.
    size_t name_len;
} sinew_name;

/// What `sinew_envelope_bind` found of the file's joints in a skeleton.
typedef struct sinew_bound_joints {
    /// Number of joints that the skeleton has, at least the root.
    uint32_t found_len;
    /// First joint that the skeleton lacks although it has the joint's child, or `SINEW_NO_JOINT`.
    uint32_t missing_parent;
} sinew_bound_joints;

/// What `sinew_envelope_check_pose` found.
typedef struct sinew_pose_fault {
    /// The likely mistake; all else is 0 where there is none.
    sinew_pose_fault_kind kind;
    /// The joint that shows it.
    uint32_t joint;
    /// Of a scale how large it is; of units what to multiply the pose's lengths by, 1 where they are right.
    float factor;
    /// How far the joint is from what it may be: off a rotation, or off the place to which its parent carries it.
    float found;
    /// How far it may be.
    float allowed;
    /// Which axis of the pose each axis of the model is, from 1 and negative where it is turned round.
    int32_t axes[3];
} sinew_pose_fault;

/// What a kernel's fit was measured to reach, in the units of its outputs.
typedef struct sinew_kernel_fit {
    /// RMS over the samples of how far the values are from theirs.
    float rms_residual;
    /// The same, each sample left out of its own fit; 0 if it was not computed.
    float left_out_rms;
    /// The largest bound on errors of single precision that was found.
    float rounding_error;
    /// Reciprocal of the condition number of what was solved.
    float reciprocal_condition;
} sinew_kernel_fit;

/// What a kernel is made of: every length that its calls need.
typedef struct sinew_kernel_info {
    /// Its name: UTF-8 in the file's bytes, not ended by a zero.
    const char *name;
    /// Bytes of the name.
    size_t name_len;
    /// Its number among the file's parts.
    uint32_t part;
    /// The number of its function in FORMAT.md's table of kernels.
    uint32_t kernel;
    /// Inputs.
    size_t input_len;
    /// Outputs.
    size_t output_len;
    /// R, numbers of a query: those of the inputs together.
    size_t query_len;
    /// Numbers of the outputs together.
    size_t result_len;
    /// m, values: what outputs are made of, and what a Jacobian and variances are of. A rotation has 3.
    size_t value_len;
    /// Floats of scratch that `sinew_kernel_evaluate` needs.
    size_t scratch_len;
    /// Floats of scratch that `sinew_kernel_jacobian` needs.
    size_t jacobian_scratch_len;
    /// Floats of scratch that `sinew_kernel_variance` needs.
    size_t variance_scratch_len;
    /// 1 if it holds what a variance is computed of, else 0.
    uint32_t has_variance;
    /// What the fit was measured to reach.
    struct sinew_kernel_fit fit;
} sinew_kernel_info;

/// An input or an output of a kernel.
typedef struct sinew_quantity {
    /// Its name: UTF-8 in the file's bytes, not ended by a zero.
    const char *name;
    /// Bytes of the name.
    size_t name_len;
    /// Its number in FORMAT.md's table of inputs, or of outputs.
    uint32_t kind;
    /// Its numbers: 1 of a scalar, 3 of a vector, of a rotation the 4 of a quaternion x, y, z, w.
    size_t number_len;
} sinew_quantity;

/// What a skin is made of: every length that its calls need.
typedef struct sinew_skin_info {
    /// Its name: UTF-8 in the file's bytes, not ended by a zero.
    const char *name;
    /// Bytes of the name.
    size_t name_len;
    /// Its number among the file's parts.
    uint32_t part;
    /// That of the envelope whose palette it follows, or `SINEW_NO_PART`.
    uint32_t envelope_part;
    /// V, vertices.
    size_t vertex_len;
    /// K, influences of each vertex.
    size_t influence_len;
    /// Transforms of the palette that it takes; 0 without an envelope.
    size_t palette_len;
    /// Named ranges of vertices.
    size_t range_len;
    /// S, shapes.
    size_t shape_len;
    /// 1 with tangents, else 0.
    uint32_t has_tangents;
    /// 1 with tangent coefficients, by which jobs then turn normals and tangents; 0 where they go by cofactors,
    /// which are wrong where transforms part.
    uint32_t has_coefficients;
} sinew_skin_info;

/// A named range of vertices: one of the meshes that the skin was made of.
typedef struct sinew_range {
    /// Its name: UTF-8 in the file's bytes, not ended by a zero.
    const char *name;
    /// Bytes of the name.
    size_t name_len;
    /// First vertex.
    size_t start;
    /// One more than the last vertex.
    size_t end;
} sinew_range;

/// What a filter is made of.
typedef struct sinew_filter_info {
    /// Its name: UTF-8 in the file's bytes, not ended by a zero.
    const char *name;
    /// Bytes of the name.
    size_t name_len;
    /// Its number among the file's parts.
    uint32_t part;
    /// F, fine samples of each coarse one.
    size_t factor;
    /// N, coarse samples that each fine one is made of: no signal may be shorter.
    size_t tap_len;
    /// From one coarse sample to the next, in the unit of what the signal runs along; 0 if it has none.
    float step;
    /// RMS error over samples that were left out, in the signal's unit; 0 if it was not measured.
    float left_out_rms;
    /// The same of linear interpolation.
    float linear_rms;
} sinew_filter_info;

/// How samples lie: signals one after the other, of samples one after the other, of lanes side by side. An image
/// of H rows of W pixels of C channels is along its columns one signal of H samples of W C lanes, and along its rows H
/// signals of W samples of C lanes.
typedef struct sinew_samples {
    /// Signals.
    size_t signal_len;
    /// Samples of each signal.
    size_t sample_len;
    /// Numbers of each sample, each of which goes by itself.
    size_t lane_len;
} sinew_samples;

/// Where an attribute is written: that of the i-th vertex *of the range* at `floats[i * stride]`.
/// Zeros mean that it is not wanted; a stride without floats is `NULL`.
typedef struct sinew_output {
    /// Where the range's first vertex goes. Attributes may share a buffer, each from its own first
    /// float on: so a vertex can be interleaved.
    float *floats;
    /// Floats from there on: `(n - 1) * stride` and the attribute's own, at least, for n vertices.
    size_t len;
    /// Floats from one vertex to the next; at least the attribute's own, 3 or 4.
    size_t stride;
} sinew_output;

/// Skins a range of vertices. Floats between attributes are left alone; where attributes overlap, the
/// later field of this structure wins.
typedef struct sinew_skin_job {
    /// The skin.
    const struct sinew_skin *skin;
    /// `sinew_skin_info.palette_len` transforms, rest to posed.
    const struct sinew_matrix *palette;
    /// Their number.
    size_t palette_len;
    /// First vertex: of the remap where there is one, else of the skin.
    size_t start;
    /// One more than the last vertex.
    size_t end;
    /// Null, or for each vertex of the engine's the skin's that it is a copy of: so that vertices which
    /// were split along seams, or put into another order, need no second pass.
    const uint32_t *remap;
    /// Their number.
    size_t remap_len;
    /// Null, or what stands for the file's rest positions: 3 floats for each of the skin's V vertices,
    /// of another face or body of the same topology.
    const float *rest_positions;
    /// Null, or what stands for the file's rest normals: 3 floats of length 1 each.
    const float *rest_normals;
    /// Null, or what stands for the file's rest tangents: 3 floats of length 1, and the handedness.
    const float *rest_tangents;
    /// V, vertices of each of these three arrays that is not null.
    size_t rest_len;
    /// Where to put positions: 3 floats, model space.
    struct sinew_output positions;
    /// Where to put normals: 3 floats of length 1, outward also where the palette mirrors; where the
    /// palette leaves one no direction, the rest normal, turned by the strongest influence if the skin
    /// has tangent coefficients.
    struct sinew_output normals;
    /// Where to put tangents: 3 floats of length 1 (the rest tangent where the palette leaves one no
    /// direction), then the handedness.
    struct sinew_output tangents;
} sinew_skin_job;

/// A box along the axes, in model space.
typedef struct sinew_bounds {
    /// Least coordinates.
    float min[3];
    /// Greatest coordinates.
    float max[3];
} sinew_bounds;

/// A shape of a skin.
typedef struct sinew_shape {
    /// Its name: UTF-8 in the file's bytes, not ended by a zero.
    const char *name;
    /// Bytes of the name.
    size_t name_len;
    /// The box of how far it moves any vertex at a weight of 1, 0 among it.
    struct sinew_bounds bounds;
} sinew_shape;

/// Shapes vertices at rest: what it writes a `sinew_skin_job` takes as its rest mesh.
typedef struct sinew_shapes_job {
    /// The skin.
    const struct sinew_skin *skin;
    /// `sinew_skin_info.shape_len` weights.
    const float *weights;
    /// Their number.
    size_t weights_len;
    /// First vertex. Of ranges that start at multiples of 64 no sum is computed twice.
    size_t start;
    /// One more than the last vertex.
    size_t end;
    /// Where to put positions: 3 floats, model space.
    struct sinew_output positions;
    /// Where to put normals: 3 floats of length 1; where the shapes leave one no direction, the file's.
    struct sinew_output normals;
    /// Where to put tangents: 3 floats of length 1, likewise, then the handedness.
    struct sinew_output tangents;
} sinew_shapes_job;

/// What a prior is made of, and what it was measured to reach; lengths are in the file's unit.
typedef struct sinew_prior_info {
    /// Its name: UTF-8 in the file's bytes, not ended by a zero.
    const char *name;
    /// Bytes of the name.
    size_t name_len;
    /// Its number among the file's parts.
    uint32_t part;
    /// That of its skin.
    uint32_t skin_part;
    /// S, shapes of its skin.
    size_t shape_len;
    /// Pairs of shapes that mirror each other.
    size_t symmetry_len;
    /// Pairs of shapes of which one alone is at work.
    size_t cancel_len;
    /// Doubles of scratch that a job without pins needs.
    size_t scratch_len;
    /// Doubles of scratch that each scalar of its pins needs: at most three a pin.
    size_t scratch_len_each;
    /// The square of the length by which a pin of stiffness 1 may miss.
    float beta;
    /// Frames that it was learned from; 0 of one that was not.
    float frames;
    /// RMS over vertices of the distance to held-out frames; 0 if it was not measured.
    float error;
    /// The same of the prior without covariance.
    float slider_error;
} sinew_prior_info;

/// Where a vertex is to be, as far as up to three rows look at it.
typedef struct sinew_pin {
    /// The vertex of the skin.
    uint32_t vertex;
    /// What is looked at of its posed position x: `row . (x, 1)`, three rows of four. A row whose first three
    /// numbers are 0 looks at nothing.
    float rows[3][4];
    /// What each row is to give.
    float target[3];
    /// How much it counts against others and the prior; 1 is the prior's tolerance.
    float stiffness;
} sinew_pin;

/// Solves weights of all shapes for pins.
typedef struct sinew_pin_job {
    /// The prior.
    const struct sinew_prior *prior;
    /// Its skin, or another with the same shapes.
    const struct sinew_skin *skin;
    /// `sinew_skin_info.palette_len` transforms of the pose in which pins are where they are.
    const struct sinew_matrix *palette;
    /// Their number.
    size_t palette_len;
    /// The pins, in any order.
    const struct sinew_pin *pins;
    /// Their number, at most `SINEW_PINS_MAX`.
    size_t pins_len;
    /// 0 to change the weights that are there as little as pins allow, else the mean ones.
    uint32_t is_from_mean;
    /// 1 to keep weights between the prior's bounds, else 0.
    uint32_t is_bounded;
    /// 1 to hold the smaller weight of each pair that cancels at 0, else 0.
    uint32_t cancels;
    /// The square of the length by which a pin of stiffness 1 may miss: `sinew_prior_info.beta`, or another.
    float beta;
    /// How much the prior's symmetry counts; 0 leaves it out, 1 is as stiff as the prior has it.
    float symmetry;
    /// How much the frame before counts: the reciprocal of the mean square by which a weight changes.
    float temporal;
    /// Null, or the S weights of the frame before.
    const float *last_weights;
    /// Their number.
    size_t last_len;
    /// At least `scratch_len + scalars * scratch_len_each` doubles of `sinew_prior_info`. What it holds of a run
    /// with the same prior, terms and pins but for their targets is used again: keep it for a drag.
    double *scratch;
    /// Their number.
    size_t scratch_len;
    /// The S weights that are there; receives those that are solved.
    float *weights;
    /// Their number.
    size_t weights_len;
} sinew_pin_job;

/// What a pin job did.
typedef struct sinew_edit {
    /// How unlikely the prior finds the change.
    float norm;
    /// Pins that no shape moves, which count as none.
    uint32_t unreachable_len;
    /// Factors and solves that it took; 0 where there was nothing to solve.
    uint32_t round_len;
    /// 1 where bounds were found to hold at the least, 0 where weights were cut to them.
    uint32_t is_least;
} sinew_edit;

/// What views are made of, and what they were measured to reach; lengths are in pixels.
typedef struct sinew_views_info {
    /// Their name: UTF-8 in the file's bytes, not ended by a zero.
    const char *name;
    /// Bytes of the name.
    size_t name_len;
    /// Their number among the file's parts.
    uint32_t part;
    /// 1 if they move as another object does, else 0.
    uint32_t is_transferred;
    /// 1 if elements of a layer hide each other by depth, else 0: then a render job needs depths.
    uint32_t has_depth;
    /// 1 if a layer is clipped by another, else 0: then a render job needs clips.
    uint32_t has_clips;
    /// 1 if a layer is drawn by itself before it is blended, else 0: then a render job needs a group.
    uint32_t has_groups;
    /// 0.
    uint32_t reserved;
    /// K, control points.
    size_t point_len;
    /// V, vertices.
    size_t vertex_len;
    /// E, elements.
    size_t element_len;
    /// L, layers.
    size_t layer_len;
    /// N, key views.
    size_t view_len;
    /// M, maps.
    size_t map_len;
    /// E + L, the numbers that a render job sorts.
    size_t order_len;
    /// Width of the screen on which points are, in pixels.
    size_t width;
    /// Height of that screen.
    size_t height;
    /// RMS over points and examples of the distance to the examples.
    float rms_error;
    /// The same, each example left out of its own fit; 0 if it was not measured.
    float left_out_rms;
    /// Share of the points whose visibility is that of the examples.
    float visibility;
} sinew_views_info;

/// A map of an object: a kernel, which `sinew_kernel_open` opens by its name.
typedef struct sinew_map_info {
    /// Its name: UTF-8 in the file's bytes, not ended by a zero.
    const char *name;
    /// Bytes of the name.
    size_t name_len;
    /// Its number among the file's parts.
    uint32_t part;
    /// Numbers of its parameters.
    size_t parameters_len;
    /// Floats of scratch that a frame needs.
    size_t scratch_len;
} sinew_map_info;

/// Evaluates a map of an object.
typedef struct sinew_frame_job {
    /// The object.
    const struct sinew_views *views;
    /// The number of the map.
    size_t map;
    /// `sinew_map_info.parameters_len` numbers, as `sinew_kernel_evaluate` takes a query.
    const float *parameters;
    /// Their number.
    size_t parameters_len;
    /// At least `sinew_map_info.scratch_len` floats, of any content.
    float *scratch;
    /// Their number.
    size_t scratch_len;
    /// Receives K points: x to the right and y down, in pixels of the screen, and depth, which grows away from the
    /// viewer.
    float (*points)[3];
    /// Their number.
    size_t points_len;
    /// Receives K visibilities; above 0.5 a point is visible.
    float *visibility;
    /// Their number.
    size_t visibility_len;
    /// Receives N scores of key views.
    float *scores;
    /// Their number.
    size_t scores_len;
    /// Receives opacity, from 0 to 1, and order of L layers: those of a greater order are drawn over those of a lesser
    /// one.
    float (*layers)[2];
    /// Their number.
    size_t layers_len;
} sinew_frame_job;

/// What a frame job found.
typedef struct sinew_found {
    /// The characteristic view: the one with the highest score, the first of equal ones.
    size_t view;
    /// The map's confidence in the parameters.
    float confidence;
} sinew_found;

/// Draws an object into a picture.
typedef struct sinew_render_job {
    /// The object.
    const struct sinew_views *views;
    /// K points, as a frame job gives them.
    const float (*points)[3];
    /// Their number.
    size_t points_len;
    /// K visibilities: an element between points is drawn from key views that show as much of it.
    const float *visibility;
    /// Their number.
    size_t visibility_len;
    /// N scores of key views, by which they are blended.
    const float *scores;
    /// Their number.
    size_t scores_len;
    /// Opacity and order of L layers, as a frame job gives them.
    const float (*layers)[2];
    /// Their number.
    size_t layers_len;
    /// Width of the picture in pixels.
    size_t width;
    /// Pixels row by row from the top, red, green, blue and alpha: sRGB, each times its alpha. Drawn over.
    uint8_t (*pixels)[4];
    /// Their number, of whole rows.
    size_t pixels_len;
    /// V places of scratch, of any content.
    float (*vertices)[3];
    /// Their number.
    size_t vertices_len;
    /// `sinew_views_info.order_len` numbers of scratch, of any content.
    uint16_t *order;
    /// Their number.
    size_t order_len;
    /// Scratch of any content: at least a float a pixel if `sinew_views_info.has_depth`, else null will do.
    float *depths;
    /// Their number.
    size_t depths_len;
    /// Scratch of any content: at least a pixel each if `sinew_views_info.has_groups`, else null will do.
    uint8_t (*group)[4];
    /// Their number.
    size_t group_len;
    /// Scratch of any content: at least a byte a pixel if `sinew_views_info.has_clips`, else null will do.
    uint8_t *clips;
    /// Their number.
    size_t clips_len;
} sinew_render_job;

/// What a render job drew.
typedef struct sinew_drawn {
    /// Elements drawn.
    size_t element_len;
    /// Those of them that are turned over against their texture, or folded, with all of their points visible.
    size_t flipped_len;
} sinew_drawn;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/// Returns the version of the ABI, to be compared with `SINEW_ABI_VERSION` where the library is
/// loaded at run time.
uint32_t sinew_abi_version(void);

/// Returns the version of the library, as text that ends in a zero.
const char *sinew_version(void);

/// Returns the version of the file format that the library reads.
uint32_t sinew_format_version(void);

/// Returns the name of an argument, ended by a zero; of any other number, that it is unknown. Never
/// null, valid for ever.
const char *sinew_argument_text(uint32_t argument);

/// Returns what a status means, in a few words that end in a zero; of any other number, that it is
/// unknown. Never null, valid for ever.
const char *sinew_status_text(int32_t status);

/// Returns the bytes of memory that a model needs: at most those of `SINEW_MODEL_WORDS` words.
size_t sinew_model_bytes(void);

/// Writes the limits that `sinew_model_load` has without others: generous for any character.
///
/// Returns `NULL`, `MISALIGNED`.
sinew_status sinew_limits_default(struct sinew_limits *out_limits,
                                  struct sinew_error *out_error);

/// Loads a model in place and checks all of it, in time bounded by the file's length. After that
/// no evaluation fails for the file's sake.
///
/// Envelopes, skins and kernels of what the memory held before are refused from now on, unless the file is the
/// same; if loading fails they are not.
///
/// - `memory`, `memory_bytes`: for the model; at least `sinew_model_bytes()`, aligned as a
///   `uintptr_t`.
/// - `file`, `file_bytes`: the file, at any address; not copied.
/// - `limits`: null for the default ones.
/// - `out_model`: receives the handle, which is `memory`.
///
/// Returns `NULL`, `MISALIGNED`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`, and every status from 100 on.
sinew_status sinew_model_load(void *memory,
                              size_t memory_bytes,
                              const uint8_t *file,
                              size_t file_bytes,
                              const struct sinew_limits *limits,
                              const struct sinew_model **out_model,
                              struct sinew_error *out_error);

/// Says what a file holds, and in which space.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `OVERLAP`.
sinew_status sinew_model_describe(const struct sinew_model *model,
                                  struct sinew_model_info *out_info,
                                  struct sinew_error *out_error);

/// Returns the blob, which holds every section at the offset that `sinew_model_section` gives:
/// what a GPU is given, as one buffer.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `OVERLAP`.
sinew_status sinew_model_blob(const struct sinew_model *model,
                              const uint8_t **out_blob,
                              size_t *out_bytes,
                              struct sinew_error *out_error);

/// Finds a section of a part.
///
/// - `part`: `sinew_envelope_info.part`, `sinew_skin_info.part` or `sinew_kernel_info.part`.
/// - `kind`: its number in FORMAT.md.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `OVERLAP`, `NOT_FOUND`.
sinew_status sinew_model_section(const struct sinew_model *model,
                                 uint32_t part,
                                 uint32_t kind,
                                 struct sinew_section *out_section,
                                 struct sinew_error *out_error);

/// Returns the bytes of memory that an envelope needs: at most those of `SINEW_ENVELOPE_WORDS`
/// words.
size_t sinew_envelope_bytes(void);

/// Opens an envelope of a model.
///
/// - `name`, `name_len`: its name, without a zero at its end; null and 0 for any.
/// - `index`: which of those; 0 for the first.
/// - `memory`, `memory_bytes`: for the envelope; at least `sinew_envelope_bytes()`, aligned as a
///   `uintptr_t`.
/// - `out_envelope`: receives the handle, which is `memory`.
///
/// Returns `NULL`, `MISALIGNED`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`, `NOT_LOADED`, `NOT_FOUND`.
sinew_status sinew_envelope_open(const struct sinew_model *model,
                                 const char *name,
                                 size_t name_len,
                                 size_t index,
                                 void *memory,
                                 size_t memory_bytes,
                                 const struct sinew_envelope **out_envelope,
                                 struct sinew_error *out_error);

/// Says what an envelope is made of.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`.
sinew_status sinew_envelope_describe(const struct sinew_envelope *envelope,
                                     struct sinew_envelope_info *out_info,
                                     struct sinew_error *out_error);

/// Describes a joint.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`, `OUT_OF_RANGE`.
sinew_status sinew_envelope_joint(const struct sinew_envelope *envelope,
                                  size_t joint,
                                  struct sinew_joint *out_joint,
                                  struct sinew_error *out_error);

/// Copies the J joints' numbers in an order in which each comes after its parent.
///
/// - `out_order`, `order_len`: room for J numbers.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`.
sinew_status sinew_envelope_order(const struct sinew_envelope *envelope,
                                  uint32_t *out_order,
                                  size_t order_len,
                                  struct sinew_error *out_error);

/// Computes the skinning matrices of a pose from local transforms and the hierarchy. An engine that
/// has skinning matrices (rest to posed, model space) does not need this.
///
/// - `local`, `local_len`: J local transforms, the root's in model space.
/// - `out_pose`, `pose_len`: J matrices.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `NON_FINITE`, `ZERO_ROTATION`,
/// `TOO_LONG`, `OVERLAP`.
sinew_status sinew_envelope_pose(const struct sinew_envelope *envelope,
                                 const struct sinew_local_transform *local,
                                 size_t local_len,
                                 struct sinew_matrix *out_pose,
                                 size_t pose_len,
                                 struct sinew_error *out_error);

/// Computes the palette of a pose and the confidence in it.
///
/// - `pose`, `pose_len`: J skinning matrices, rest to posed, in model space; rigid to 1e-4, which is not looked at
///   here: `sinew_envelope_check_pose` does in a debug build.
/// - `scratch`, `scratch_len`: at least `sinew_envelope_info.scratch_len` floats, of any content; its
///   content afterwards means nothing. One for each thread.
/// - `out_palette`, `palette_len`: `sinew_envelope_info.palette_len` transforms, rest to posed, in
///   model space: for `sinew_skin_run`, or with `sinew_skin_influences` for a shader.
/// - `out_confidence`: null, or receives 1 within what was seen in training down to 0 far from it.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `TOO_SHORT`, `NON_FINITE`,
/// `TOO_LONG`, `OVERLAP`.
sinew_status sinew_envelope_palette(const struct sinew_envelope *envelope,
                                    const struct sinew_matrix *pose,
                                    size_t pose_len,
                                    float *scratch,
                                    size_t scratch_len,
                                    struct sinew_matrix *out_palette,
                                    size_t palette_len,
                                    float *out_confidence,
                                    struct sinew_error *out_error);

/// Computes what `sinew_envelope_palette` does at a level of evaluation, with the same arguments.
///
/// - `level`: a `sinew_level`.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OUT_OF_RANGE`, `LENGTH`, `TOO_SHORT`, `NON_FINITE`,
/// `TOO_LONG`, `OVERLAP`.
sinew_status sinew_envelope_palette_at(const struct sinew_envelope *envelope,
                                       uint32_t level,
                                       const struct sinew_matrix *pose,
                                       size_t pose_len,
                                       float *scratch,
                                       size_t scratch_len,
                                       struct sinew_matrix *out_palette,
                                       size_t palette_len,
                                       float *out_confidence,
                                       struct sinew_error *out_error);

/// Computes how confident each joint is of a pose, by the kernel maps of its skin and by its trained range: which part of
/// the skin the confidence of `sinew_envelope_palette` is about. A rotational envelope has none: `NO_STAGE`.
///
/// - `pose`, `pose_len`, `scratch`, `scratch_len`: as for `sinew_envelope_palette`.
/// - `out_confidences`, `confidences_len`: J values in [0, 1]; of a joint whose skin no map moves, what its
///   trained range tells. 1 without maps.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `NO_STAGE`, `LENGTH`, `TOO_SHORT`, `NON_FINITE`,
/// `TOO_LONG`, `OVERLAP`.
sinew_status sinew_envelope_joint_confidences(const struct sinew_envelope *envelope,
                                              const struct sinew_matrix *pose,
                                              size_t pose_len,
                                              float *scratch,
                                              size_t scratch_len,
                                              float *out_confidences,
                                              size_t confidences_len,
                                              struct sinew_error *out_error);

/// Computes the palettes of a batch of poses, with the bits of `sinew_envelope_palette` for each.
///
/// - `poses`, `poses_len`: J skinning matrices a pose, one pose after the other.
/// - `scratch`, `scratch_len`: as for one pose.
/// - `out_palettes`, `palettes_len`: `sinew_envelope_info.palette_len` transforms a pose.
/// - `out_confidences`, `confidences_len`: one a pose; their number is that of the poses.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `TOO_SHORT`, `NON_FINITE`,
/// `TOO_LONG`, `OVERLAP`.
sinew_status sinew_envelope_palettes(const struct sinew_envelope *envelope,
                                     const struct sinew_matrix *poses,
                                     size_t poses_len,
                                     float *scratch,
                                     size_t scratch_len,
                                     struct sinew_matrix *out_palettes,
                                     size_t palettes_len,
                                     float *out_confidences,
                                     size_t confidences_len,
                                     struct sinew_error *out_error);

/// Computes what `sinew_envelope_palette` does, with the same arguments, of a rotational envelope
/// alone: any other is `NO_STAGE`. A program that calls this and not the other is linked without kernel
/// maps: on a Cortex-M4F 5 kB less if optimised for size, 9 kB if for speed.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `NO_STAGE`, `LENGTH`, `TOO_SHORT`,
/// `NON_FINITE`, `TOO_LONG`, `OVERLAP`.
sinew_status sinew_envelope_rotational_palette(const struct sinew_envelope *envelope,
                                               const struct sinew_matrix *pose,
                                               size_t pose_len,
                                               float *scratch,
                                               size_t scratch_len,
                                               struct sinew_matrix *out_palette,
                                               size_t palette_len,
                                               float *out_confidence,
                                               struct sinew_error *out_error);

/// Copies the J joints' rest frames, each in its parent's, the root's in model space: what an animation changes, and
/// of what `sinew_envelope_pose` makes the rest pose.
///
/// - `out_local`, `local_len`: room for J local transforms.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`.
sinew_status sinew_envelope_rest_locals(const struct sinew_envelope *envelope,
                                        struct sinew_local_transform *out_local,
                                        size_t local_len,
                                        struct sinew_error *out_error);

/// Finds the file's joints in a skeleton of the caller's, for `sinew_envelope_gather`. Names must be equal. A joint
/// that the skeleton lacks follows its parent: compare `found_len` of `out_bound` with the envelope's `joint_len`.
///
/// - `names`, `names_len`: of the skeleton's joints, in its order; more than the file has, or fewer. Of two
///   of one name the first counts.
/// - `out_map`, `map_len`: receive for each of the J joints the number of the skeleton's, or `SINEW_FOLDED`.
/// - `out_bound`: null, or receives how many joints were found.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `OTHER_NAME`, `NO_ROOT`, `NO_JOINTS`, `TOO_LONG`,
/// `OVERLAP`.
sinew_status sinew_envelope_bind(const struct sinew_envelope *envelope,
                                 const struct sinew_name *names,
                                 size_t names_len,
                                 uint32_t *out_map,
                                 size_t map_len,
                                 struct sinew_bound_joints *out_bound,
                                 struct sinew_error *out_error);

/// Gathers the J skinning matrices of a pose from the frames of the caller's skeleton after its hierarchy pass:
/// matrix j is `root * world[map[j]] * inverse_bind_j`; a joint that is folded has its parent's.
///
/// - `map`, `map_len`: J numbers, as `sinew_envelope_bind` gives them.
/// - `world`, `world_len`: the frames, all in one space and in the unit of the model.
/// - `root`: null, or carries that space to the one in which the palette is wanted.
/// - `out_pose`, `pose_len`: J matrices.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `OUT_OF_RANGE`, `NO_ROOT`, `NON_FINITE`,
/// `TOO_LONG`, `OVERLAP`.
sinew_status sinew_envelope_gather(const struct sinew_envelope *envelope,
                                   const uint32_t *map,
                                   size_t map_len,
                                   const struct sinew_matrix *world,
                                   size_t world_len,
                                   const struct sinew_matrix *root,
                                   struct sinew_matrix *out_pose,
                                   size_t pose_len,
                                   struct sinew_error *out_error);

/// Checks for a debug build that a pose is one of the skeleton's: that each matrix turns and moves only, and that each
/// joint is where its parent carries it, as far as it was in training. A pose that is not is no error of the
/// call: `out_fault` says what is likely wrong. A pose is taken in a few microseconds; naming a mistake takes
/// milliseconds.
///
/// - `pose`, `pose_len`: J skinning matrices, rest to posed, in model space.
/// - `out_fault`: receives the likely mistake, or that there is none.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `TOO_LONG`, `OVERLAP`.
sinew_status sinew_envelope_check_pose(const struct sinew_envelope *envelope,
                                       const struct sinew_matrix *pose,
                                       size_t pose_len,
                                       struct sinew_pose_fault *out_fault,
                                       struct sinew_error *out_error);

/// Returns what to do about the mistake of a pose, in a few words that end in a zero; of any other number, that it is
/// unknown. Never null, valid for ever.
const char *sinew_pose_fault_text(uint32_t kind);

/// Takes out of a pose the scale that all its joints share, as that of a scaled actor; what is left is rigid.
/// `sinew_palette_scale` puts it back on the palette. It is read off the first joint; none, or one within 4e-6 of 1, is
/// given as 1, and the pose keeps its bits.
///
/// - `pose`, `pose_len`: skinning matrices, which are changed.
/// - `out_scale`: receives the scale.
///
/// Returns `NULL`, `MISALIGNED`, `TOO_LONG`, `OVERLAP`.
sinew_status sinew_pose_take_scale(struct sinew_matrix *pose,
                                   size_t pose_len,
                                   float *out_scale,
                                   struct sinew_error *out_error);

/// Scales what a palette makes of its vertices, about the origin of model space: a scale that was taken out of the
/// pose. Normals and tangents need nothing more.
///
/// - `palette`, `palette_len`: transforms, which are changed.
///
/// Returns `NULL`, `MISALIGNED`, `TOO_LONG`.
sinew_status sinew_palette_scale(struct sinew_matrix *palette,
                                 size_t palette_len,
                                 float scale,
                                 struct sinew_error *out_error);

/// Computes the hash of a skeleton, to compare with `sinew_envelope_info.skeleton_hash`; FORMAT.md says what it is
/// of.
///
/// - `names`, `parents`, `joint_len`: of the joints, in the file's order; `SINEW_NO_JOINT` for no parent.
/// - `out_hash`: receives the hash.
///
/// Returns `NULL`, `MISALIGNED`, `TOO_LONG`, `OVERLAP`.
sinew_status sinew_skeleton_hash(const struct sinew_name *names,
                                 const uint32_t *parents,
                                 size_t joint_len,
                                 uint32_t *out_hash,
                                 struct sinew_error *out_error);

/// Returns the bytes of memory that a kernel needs: at most those of `SINEW_KERNEL_WORDS` words.
size_t sinew_kernel_bytes(void);

/// Opens a kernel of a model.
///
/// - `name`, `name_len`: its name, without a zero at its end; null and 0 for any.
/// - `index`: which of those; 0 for the first.
/// - `memory`, `memory_bytes`: for the kernel; at least `sinew_kernel_bytes()`, aligned as a `uintptr_t`.
/// - `out_kernel`: receives the handle, which is `memory`.
///
/// Returns `NULL`, `MISALIGNED`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`, `NOT_LOADED`, `NOT_FOUND`.
sinew_status sinew_kernel_open(const struct sinew_model *model,
                               const char *name,
                               size_t name_len,
                               size_t index,
                               void *memory,
                               size_t memory_bytes,
                               const struct sinew_kernel **out_kernel,
                               struct sinew_error *out_error);

/// Says what a kernel is made of.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`.
sinew_status sinew_kernel_describe(const struct sinew_kernel *kernel,
                                   struct sinew_kernel_info *out_info,
                                   struct sinew_error *out_error);

/// Describes an input, in the order of a query.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`, `OUT_OF_RANGE`.
sinew_status sinew_kernel_input(const struct sinew_kernel *kernel,
                                size_t input,
                                struct sinew_quantity *out_input,
                                struct sinew_error *out_error);

/// Describes an output, in the order in which they are given.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`, `OUT_OF_RANGE`.
sinew_status sinew_kernel_output(const struct sinew_kernel *kernel,
                                 size_t output,
                                 struct sinew_quantity *out_output,
                                 struct sinew_error *out_error);

/// Computes the outputs of a query and the confidence in them.
///
/// - `query`, `query_len`: `sinew_kernel_info.query_len` numbers, one input after the other; of a rotation a
///   quaternion of any length but 0.
/// - `scratch`, `scratch_len`: at least `sinew_kernel_info.scratch_len` floats, of any content; its content
///   afterwards means nothing. One for each thread.
/// - `out_numbers`, `out_len`: `sinew_kernel_info.result_len` numbers, one output after the other; of a rotation
///   a quaternion of length 1.
/// - `out_confidence`: null, or receives 1 near the centres down to 0 far from all; 1 of a kernel that has no
///   fade.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `TOO_SHORT`, `NON_FINITE`,
/// `ZERO_ROTATION`, `TOO_LONG`, `OVERLAP`.
sinew_status sinew_kernel_evaluate(const struct sinew_kernel *kernel,
                                   const float *query,
                                   size_t query_len,
                                   float *scratch,
                                   size_t scratch_len,
                                   float *out_numbers,
                                   size_t out_len,
                                   float *out_confidence,
                                   struct sinew_error *out_error);

/// Computes the derivatives of the m values by the R numbers of a query: before the fade, ranges and sums of
/// outputs, so that those of a rotation are its vector's.
///
/// - `query`, `query_len`: as for `sinew_kernel_evaluate`.
/// - `scratch`, `scratch_len`: at least `sinew_kernel_info.jacobian_scratch_len` floats, likewise.
/// - `out_jacobian`, `jacobian_len`: m rows of R derivatives.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `TOO_SHORT`, `NON_FINITE`,
/// `ZERO_ROTATION`, `TOO_LONG`, `OVERLAP`.
sinew_status sinew_kernel_jacobian(const struct sinew_kernel *kernel,
                                   const float *query,
                                   size_t query_len,
                                   float *scratch,
                                   size_t scratch_len,
                                   float *out_jacobian,
                                   size_t jacobian_len,
                                   struct sinew_error *out_error);

/// Computes the variance of each of the m values, before the fade, ranges and sums of outputs.
///
/// - `query`, `query_len`: as for `sinew_kernel_evaluate`.
/// - `scratch`, `scratch_len`: at least `sinew_kernel_info.variance_scratch_len` floats, likewise.
/// - `out_variances`, `variances_len`: m variances, not negative.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `NO_ATTRIBUTE`, `LENGTH`, `TOO_SHORT`,
/// `NON_FINITE`, `ZERO_ROTATION`, `TOO_LONG`, `OVERLAP`.
sinew_status sinew_kernel_variance(const struct sinew_kernel *kernel,
                                   const float *query,
                                   size_t query_len,
                                   float *scratch,
                                   size_t scratch_len,
                                   float *out_variances,
                                   size_t variances_len,
                                   struct sinew_error *out_error);

/// Returns the bytes of memory that a skin needs: at most those of `SINEW_SKIN_WORDS` words.
size_t sinew_skin_bytes(void);

/// Opens a skin of a model.
///
/// - `name`, `name_len`: its name, without a zero at its end; null and 0 for any.
/// - `index`: which of those; 0 for the first.
/// - `memory`, `memory_bytes`: for the skin; at least `sinew_skin_bytes()`, aligned as a `uintptr_t`.
/// - `out_skin`: receives the handle, which is `memory`.
///
/// Returns `NULL`, `MISALIGNED`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`, `NOT_LOADED`, `NOT_FOUND`.
sinew_status sinew_skin_open(const struct sinew_model *model,
                             const char *name,
                             size_t name_len,
                             size_t index,
                             void *memory,
                             size_t memory_bytes,
                             const struct sinew_skin **out_skin,
                             struct sinew_error *out_error);

/// Says what a skin is made of.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`.
sinew_status sinew_skin_describe(const struct sinew_skin *skin,
                                 struct sinew_skin_info *out_info,
                                 struct sinew_error *out_error);

/// Describes a named range of vertices.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`, `OUT_OF_RANGE`.
sinew_status sinew_skin_range(const struct sinew_skin *skin,
                              size_t range,
                              struct sinew_range *out_range,
                              struct sinew_error *out_error);

/// Copies the rest positions of the vertices from `start` to before `end`: 3 floats each, packed.
///
/// - `out_positions`, `out_len`: room for `3 * (end - start)` floats.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OUT_OF_RANGE`, `TOO_SHORT`, `TOO_LONG`,
/// `OVERLAP`.
sinew_status sinew_skin_rest_positions(const struct sinew_skin *skin,
                                       size_t start,
                                       size_t end,
                                       float *out_positions,
                                       size_t out_len,
                                       struct sinew_error *out_error);

/// Copies the rest normals of the vertices from `start` to before `end`: 3 floats each, packed.
///
/// - `out_normals`, `out_len`: room for `3 * (end - start)` floats.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OUT_OF_RANGE`, `TOO_SHORT`, `TOO_LONG`,
/// `OVERLAP`.
sinew_status sinew_skin_rest_normals(const struct sinew_skin *skin,
                                     size_t start,
                                     size_t end,
                                     float *out_normals,
                                     size_t out_len,
                                     struct sinew_error *out_error);

/// Copies the rest tangents of the vertices from `start` to before `end`: 4 floats each, packed,
/// the last the handedness.
///
/// - `out_tangents`, `out_len`: room for `4 * (end - start)` floats.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `NO_ATTRIBUTE`, `OUT_OF_RANGE`, `TOO_SHORT`,
/// `TOO_LONG`, `OVERLAP`.
sinew_status sinew_skin_rest_tangents(const struct sinew_skin *skin,
                                      size_t start,
                                      size_t end,
                                      float *out_tangents,
                                      size_t out_len,
                                      struct sinew_error *out_error);

/// Copies the K influences of each vertex from `start` to before `end`: with a palette, all that a
/// skinning shader needs. Unused ones weigh 0; those of a vertex sum to 1.
///
/// - `out_indices`, `indices_len`: room for `K * (end - start)` indices into the palette.
/// - `out_weights`, `weights_len`: room for as many weights.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OUT_OF_RANGE`, `TOO_SHORT`, `TOO_LONG`,
/// `OVERLAP`.
sinew_status sinew_skin_influences(const struct sinew_skin *skin,
                                   size_t start,
                                   size_t end,
                                   uint16_t *out_indices,
                                   size_t indices_len,
                                   float *out_weights,
                                   size_t weights_len,
                                   struct sinew_error *out_error);

/// Computes the hash of a skin's rest positions: which mesh it is, and in which order.
///
/// - `out_hash`: receives what `sinew_mesh_hash` gives of them.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`.
sinew_status sinew_skin_mesh_hash(const struct sinew_skin *skin,
                                  uint32_t *out_hash,
                                  struct sinew_error *out_error);

/// Computes the hash of a mesh's rest positions, to compare with `sinew_skin_mesh_hash`.
///
/// - `positions`, `vertex_len`: 3 floats a vertex, packed, in the file's order.
/// - `out_hash`: receives the hash.
///
/// Returns `NULL`, `MISALIGNED`, `TOO_LONG`, `OVERLAP`.
sinew_status sinew_mesh_hash(const float *positions,
                             size_t vertex_len,
                             uint32_t *out_hash,
                             struct sinew_error *out_error);

/// Returns the bytes of memory that a filter needs: at most those of `SINEW_FILTER_WORDS` words.
size_t sinew_filter_bytes(void);

/// Opens a filter of a model.
///
/// - `name`, `name_len`: its name, without a zero at its end; null and 0 for any.
/// - `index`: which of those; 0 for the first.
/// - `memory`, `memory_bytes`: for the filter; at least `sinew_filter_bytes()`, aligned as a `uintptr_t`.
/// - `out_filter`: receives the handle, which is `memory`.
///
/// Returns `NULL`, `MISALIGNED`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`, `NOT_LOADED`, `NOT_FOUND`.
sinew_status sinew_filter_open(const struct sinew_model *model,
                               const char *name,
                               size_t name_len,
                               size_t index,
                               void *memory,
                               size_t memory_bytes,
                               const struct sinew_filter **out_filter,
                               struct sinew_error *out_error);

/// Says what a filter is made of.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`.
sinew_status sinew_filter_describe(const struct sinew_filter *filter,
                                   struct sinew_filter_info *out_info,
                                   struct sinew_error *out_error);

/// Makes samples `sinew_filter_info.factor` times as fine. Two calls make an image finer, one along its columns and one
/// along its rows.
///
/// - `shape`: how the samples lie.
/// - `samples`, `samples_len`: the numbers.
/// - `out_samples`, `out_len`: factor times as many; they lie likewise, with factor times as many samples a signal.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `TOO_SHORT`, `NON_FINITE`, `TOO_LONG`, `OVERLAP`.
sinew_status sinew_filter_apply(const struct sinew_filter *filter,
                                const struct sinew_samples *shape,
                                const float *samples,
                                size_t samples_len,
                                float *out_samples,
                                size_t out_len,
                                struct sinew_error *out_error);

/// Runs a skin job. Its outputs may overlap each other, but nothing that it reads. Jobs may run at the
/// same time, on any threads, if no output of one overlaps an output of another.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `NO_OUTPUT`, `LENGTH`, `OUT_OF_RANGE`,
/// `NO_ATTRIBUTE`, `STRIDE`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`.
sinew_status sinew_skin_run(const struct sinew_skin_job *job,
                            struct sinew_error *out_error);

/// Computes a box that holds every vertex of the posed skin, from the palette alone.
///
/// - `palette`, `palette_len`: `sinew_skin_info.palette_len` transforms.
/// - `rest_offset`: how far a rest mesh of the caller's has any position from the file's, along each
///   axis at most; 0 for the file's own.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `OUT_OF_RANGE`, `NO_VERTICES`,
/// `TOO_LONG`, `OVERLAP`.
sinew_status sinew_skin_bounds(const struct sinew_skin *skin,
                               const struct sinew_matrix *palette,
                               size_t palette_len,
                               float rest_offset,
                               struct sinew_bounds *out_bounds,
                               struct sinew_error *out_error);

/// Describes a shape.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`, `OUT_OF_RANGE`.
sinew_status sinew_skin_shape(const struct sinew_skin *skin,
                              size_t shape,
                              struct sinew_shape *out_shape,
                              struct sinew_error *out_error);

/// Runs a shapes job. Its outputs may overlap each other, but nothing that it reads. Jobs may run at the
/// same time, on any threads, if no output of one overlaps an output of another.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `NO_OUTPUT`, `LENGTH`, `NON_FINITE`, `OUT_OF_RANGE`,
/// `NO_ATTRIBUTE`, `STRIDE`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`.
sinew_status sinew_shapes_run(const struct sinew_shapes_job *job,
                              struct sinew_error *out_error);

/// Computes a box that holds every vertex of the shaped and posed skin, from weights and palette alone.
///
/// - `palette`, `palette_len`: `sinew_skin_info.palette_len` transforms.
/// - `weights`, `weights_len`: `sinew_skin_info.shape_len` weights.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `NON_FINITE`, `NO_VERTICES`, `TOO_LONG`,
/// `OVERLAP`.
sinew_status sinew_shapes_bounds(const struct sinew_skin *skin,
                                 const struct sinew_matrix *palette,
                                 size_t palette_len,
                                 const float *weights,
                                 size_t weights_len,
                                 struct sinew_bounds *out_bounds,
                                 struct sinew_error *out_error);

/// Returns the bytes of memory that a prior needs: at most those of `SINEW_PRIOR_WORDS` words.
size_t sinew_prior_bytes(void);

/// Opens a prior of a model.
///
/// - `name`, `name_len`: its name, without a zero at its end; null and 0 for any.
/// - `index`: which of those; 0 for the first.
/// - `memory`, `memory_bytes`: for the prior; at least `sinew_prior_bytes()`, aligned as a `uintptr_t`.
/// - `out_prior`: receives the handle, which is `memory`.
///
/// Returns `NULL`, `MISALIGNED`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`, `NOT_LOADED`, `NOT_FOUND`.
sinew_status sinew_prior_open(const struct sinew_model *model,
                              const char *name,
                              size_t name_len,
                              size_t index,
                              void *memory,
                              size_t memory_bytes,
                              const struct sinew_prior **out_prior,
                              struct sinew_error *out_error);

/// Says what a prior is made of.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`.
sinew_status sinew_prior_describe(const struct sinew_prior *prior,
                                  struct sinew_prior_info *out_info,
                                  struct sinew_error *out_error);

/// Computes where a vertex is with weights and a palette: as a target it makes a pin hold the vertex there.
///
/// - `palette`, `palette_len`: `sinew_skin_info.palette_len` transforms.
/// - `weights`, `weights_len`: a weight of each shape; of fewer the others are 0.
/// - `out_place`: receives 3 floats, model space.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `OUT_OF_RANGE`, `TOO_LONG`, `OVERLAP`.
sinew_status sinew_skin_place(const struct sinew_skin *skin,
                              uint32_t vertex,
                              const struct sinew_matrix *palette,
                              size_t palette_len,
                              const float *weights,
                              size_t weights_len,
                              float (*out_place)[3],
                              struct sinew_error *out_error);

/// Runs a pin job. Without a pin that any shape moves the weights stay as they are.
///
/// - `out_edit`: null, or receives what it did.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `TOO_SHORT`, `OUT_OF_RANGE`, `NON_FINITE`,
/// `TOO_LONG`, `OVERLAP`.
sinew_status sinew_pins_solve(const struct sinew_pin_job *job,
                              struct sinew_edit *out_edit,
                              struct sinew_error *out_error);

/// Returns the bytes of memory that views need: at most those of `SINEW_VIEWS_WORDS` words.
size_t sinew_views_bytes(void);

/// Opens views of a model.
///
/// - `name`, `name_len`: their name, without a zero at its end; null and 0 for any.
/// - `index`: which of those; 0 for the first.
/// - `memory`, `memory_bytes`: for the views; at least `sinew_views_bytes()`, aligned as a `uintptr_t`.
/// - `out_views`: receives the handle, which is `memory`.
///
/// Returns `NULL`, `MISALIGNED`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`, `NOT_LOADED`, `NOT_FOUND`.
sinew_status sinew_views_open(const struct sinew_model *model,
                              const char *name,
                              size_t name_len,
                              size_t index,
                              void *memory,
                              size_t memory_bytes,
                              const struct sinew_views **out_views,
                              struct sinew_error *out_error);

/// Says what views are made of.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`.
sinew_status sinew_views_describe(const struct sinew_views *views,
                                  struct sinew_views_info *out_info,
                                  struct sinew_error *out_error);

/// Describes a map.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`, `OUT_OF_RANGE`.
sinew_status sinew_views_map(const struct sinew_views *views,
                             size_t map,
                             struct sinew_map_info *out_map,
                             struct sinew_error *out_error);

/// Runs a frame job: from parameters to points, visibilities, scores, layers and the characteristic view.
///
/// - `out_found`: receives what it found.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `TOO_SHORT`, `OUT_OF_RANGE`, `NON_FINITE`,
/// `ZERO_ROTATION`, `TOO_LONG`, `OVERLAP`.
sinew_status sinew_views_frame(const struct sinew_frame_job *job,
                               struct sinew_found *out_found,
                               struct sinew_error *out_error);

/// Runs a render job: from points to a picture, over what it holds.
///
/// - `out_drawn`: null, or receives what it drew.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `TOO_SHORT`, `NON_FINITE`, `TOO_LONG`, `OVERLAP`.
sinew_status sinew_views_render(const struct sinew_render_job *job,
                                struct sinew_drawn *out_drawn,
                                struct sinew_error *out_error);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* SINEW_H */
