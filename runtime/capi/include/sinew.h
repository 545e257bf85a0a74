/* Sinew: evaluates baked models of how skin moves. Made by cbindgen of runtime/capi/src; do not edit.
 *
 * Objects: a model is a loaded file, an envelope a skin in it. They lie in memory of the caller, who
 * asks for its size (sinew_*_bytes) or takes an array of SINEW_*_WORDS uintptr_t. Nothing is
 * allocated and nothing has to be freed. The file's bytes must outlive both, unchanged.
 *
 * Calls: every function that can fail returns a sinew_status, and writes what went wrong to its last
 * argument unless that is null. When a call fails it has written nothing else. Statuses are named
 * in these comments without their prefix SINEW_STATUS_.
 *
 * Pointers: one that is null, misaligned, or that overlaps what it must not, is a status. What no
 * library can see remains the caller's: that a pointer and its length describe memory of the
 * caller, that a handle points to memory at least as large as the object, which once loaded nobody
 * changes, and that nobody else writes to what a call reads, or uses what it writes, while it runs.
 * Where the error goes is not compared with the rest. An array of length 0 may be null.
 *
 * Threads: the library has no state. Every function may run at any time on any thread; models and
 * envelopes never change and are shared freely; workspaces and outputs belong to one call at a
 * time.
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
#define SINEW_ABI_VERSION 1

/// Elements of a `uintptr_t` array that holds a model on every target:
/// `uintptr_t memory[SINEW_MODEL_WORDS]`.
#define SINEW_MODEL_WORDS 12

/// Elements of a `uintptr_t` array that holds an envelope on every target:
/// `uintptr_t memory[SINEW_ENVELOPE_WORDS]`.
#define SINEW_ENVELOPE_WORDS 72

/// Stands for no joint: the parent of the root.
#define SINEW_NO_JOINT UINT32_MAX

/// What a call came to. 1 to 99: the call is wrong. From 100 on: the file is.
///
/// `sinew_error` tells more: what an entry names as subject, index, expected and found.
enum sinew_status
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// Done.
    SINEW_STATUS_OK = 0,
    /// A pointer is null. Subject: the argument.
    SINEW_STATUS_NULL = 1,
    /// A pointer is not aligned for what it points to. Subject: the argument; expected: bytes of
    /// alignment; found: bytes beyond the last multiple of it.
    SINEW_STATUS_MISALIGNED = 2,
    /// An array would reach beyond the address space. Subject: the argument; found: its length.
    SINEW_STATUS_TOO_LONG = 3,
    /// Memory to be written overlaps other memory of the call, or the object or the file that the
    /// call reads. Subject: the argument to be written.
    SINEW_STATUS_OVERLAP = 4,
    /// A handle points to no loaded object of its kind. Subject: the argument.
    SINEW_STATUS_NOT_LOADED = 5,
    /// An array whose length must be exact has another. Subject: the array; expected, found:
    /// lengths in its own elements.
    SINEW_STATUS_LENGTH = 6,
    /// An array is too short. Subject: the array; expected: the least length; found: its length.
    SINEW_STATUS_TOO_SHORT = 7,
    /// A joint, or a range of vertices, is not in the model. Subject: joints or vertices; index: the
    /// joint, or the range's start; expected: how many there are; found: the joint, or the range's end.
    SINEW_STATUS_OUT_OF_RANGE = 8,
    /// The pose of a joint is not finite. Subject: the argument; index: the joint.
    SINEW_STATUS_NON_FINITE = 9,
    /// A joint's quaternion has no direction: it is zero, or too small or too large to square.
    /// Subject: the argument; index: the joint.
    SINEW_STATUS_ZERO_ROTATION = 10,
    /// A stride is shorter than its attribute. Expected: floats of the attribute; found: the stride.
    SINEW_STATUS_STRIDE = 11,
    /// An attribute names no buffer. Subject: the attribute; found: the number in the buffer's place.
    SINEW_STATUS_BUFFER = 12,
    /// Tangents were asked of a model that has none. Subject: tangents.
    SINEW_STATUS_NO_TANGENTS = 13,
    /// The model has no vertices, and so no bounds. Subject: vertices.
    SINEW_STATUS_NO_VERTICES = 14,
    /// The file holds no such envelope, or no such section. Subject: the envelope, or the section if it
    /// is one of FORMAT.md's; found: the section's number.
    SINEW_STATUS_NOT_FOUND = 15,
    /// The model's predictor has no such stage. Found: the predictor.
    SINEW_STATUS_NO_STAGE = 16,
    /// More than the limits or the format allow. Subject: of what; expected: the most; found.
    SINEW_STATUS_LIMIT = 100,
    /// The file ends early, or a length in it is no length.
    SINEW_STATUS_MALFORMED = 101,
    /// Not a model: expected and found are the first four bytes, the first the least significant.
    SINEW_STATUS_MAGIC = 102,
    /// Written in a version of the format that this library does not know. Expected, found.
    SINEW_STATUS_VERSION = 103,
    /// The file was changed after it was written. Expected, found: its CRC-32.
    SINEW_STATUS_CHECKSUM = 104,
    /// Bytes follow the model's end. Found: how many.
    SINEW_STATUS_TRAILING_BYTES = 105,
    /// The file needs features that this library does not have. Found: their bits.
    SINEW_STATUS_FEATURES = 106,
    /// The blob's alignment is none, or the blob does not start on it. Found: its power of two.
    SINEW_STATUS_ALIGNMENT = 107,
    /// Padding that is not zero.
    SINEW_STATUS_PADDING = 108,
    /// The part table has no whole number of rows, or too many or none. Found: its bytes.
    SINEW_STATUS_PART_TABLE = 109,
    /// The section table has no whole number of rows, or too many. Found: its bytes.
    SINEW_STATUS_SECTION_TABLE = 110,
    /// A row states flags that this version does not have. Found: the flags.
    SINEW_STATUS_FLAGS = 111,
    /// A part that a reader must know and this one does not. Found: its kind.
    SINEW_STATUS_UNKNOWN_PART = 112,
    /// A section that a reader must know and this one does not. Found: its kind.
    SINEW_STATUS_UNKNOWN_SECTION = 113,
    /// A section names a part that is not there. Index: its row; found: the part.
    SINEW_STATUS_SECTION_PART = 114,
    /// A section does not start on the file's alignment. Index: its row.
    SINEW_STATUS_SECTION_ALIGNMENT = 115,
    /// A section starts before the one listed before it ends. Index: its row.
    SINEW_STATUS_SECTION_OVERLAP = 116,
    /// A section reaches beyond the blob. Index: its row.
    SINEW_STATUS_SECTION_BOUNDS = 117,
    /// A part has two sections of one kind. Index: the second's row.
    SINEW_STATUS_DUPLICATE_SECTION = 118,
    /// A predictor that this library does not know. Found: its number.
    SINEW_STATUS_PREDICTOR = 119,
    /// There is none of what there must be at least one. Subject: of what; expected: 1.
    SINEW_STATUS_EMPTY = 120,
    /// A part lacks a section. Subject: the section.
    SINEW_STATUS_MISSING_SECTION = 121,
    /// A section that the part's predictor does not have. Subject: the section.
    SINEW_STATUS_UNEXPECTED_SECTION = 122,
    /// A section's length does not follow from the part's counts. Subject: the section; expected,
    /// found: bytes.
    SINEW_STATUS_SECTION_LENGTH = 123,
    /// A name is not UTF-8, or its place is wrong. Index: 0 the part's, 1 + j that of joint j.
    SINEW_STATUS_NAME = 124,
    /// A parent or the evaluation order is not that of one tree. Index: the joint.
    SINEW_STATUS_HIERARCHY = 125,
    /// A float is out of its range or not finite. Subject: its section or the certificate; index.
    SINEW_STATUS_FLOAT = 126,
    /// An index points beyond its target. Subject: its section; index: its place; expected: what it
    /// must be below; found.
    SINEW_STATUS_INDEX = 127,
    /// The weights of a vertex do not sum to one. Index: the vertex.
    SINEW_STATUS_WEIGHTS = 128,
    /// A twist matrix is too large. Index: its key.
    SINEW_STATUS_TWIST = 129,
    /// A kernel that this library does not know. Index: its group; found: its number.
    SINEW_STATUS_KERNEL = 130,
    /// A byte of a group that must be zero is not. Index: the group.
    SINEW_STATUS_RESERVED = 131,
    /// A group without proxies, or with centres and neither inputs nor rank. Index: the group.
    SINEW_STATUS_EMPTY_GROUP = 132,
    /// A group's fade does not start and then end in its range. Index: the group.
    SINEW_STATUS_FADE = 133,
    /// A group does not start where the one before it ends. Index: the group; expected, found: words.
    SINEW_STATUS_GROUP_OFFSET = 134,
    /// The groups' proxies are not those of the part. Expected, found.
    SINEW_STATUS_GROUP_PROXIES = 135,
    /// The part states another length of scratch than its groups need. Expected, found: floats.
    SINEW_STATUS_SCRATCH = 136,
    /// A vertex lies outside the rest box of a map that moves it. Index: the map; found: the vertex.
    SINEW_STATUS_REST_BOX = 137,
    /// An inverse bind matrix is no rigid motion. Index: the joint.
    SINEW_STATUS_INVERSE_BIND = 138,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum sinew_status sinew_status;
#else
typedef int32_t sinew_status;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// What an error is about: an argument (below 64), a quantity (from 64), a section of the file
/// (128 and the section's number).
enum sinew_subject
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// Nothing in particular.
    SINEW_SUBJECT_NONE = 0,
    /// Memory for an object; lengths in bytes.
    SINEW_SUBJECT_MEMORY = 1,
    /// Bytes of the file.
    SINEW_SUBJECT_FILE = 2,
    /// Limits.
    SINEW_SUBJECT_LIMITS = 3,
    /// Handle of a model.
    SINEW_SUBJECT_MODEL = 4,
    /// Handle of an envelope.
    SINEW_SUBJECT_ENVELOPE = 5,
    /// A name; lengths in bytes.
    SINEW_SUBJECT_NAME = 6,
    /// Local transforms of the joints.
    SINEW_SUBJECT_LOCAL = 7,
    /// Skinning matrices of the joints.
    SINEW_SUBJECT_POSE = 8,
    /// Scratch; lengths in floats.
    SINEW_SUBJECT_WORKSPACE = 9,
    /// The palette; lengths in matrices.
    SINEW_SUBJECT_PALETTE = 10,
    /// A skin job.
    SINEW_SUBJECT_JOB = 11,
    /// Output buffer A; lengths in floats.
    SINEW_SUBJECT_OUT_A = 12,
    /// Output buffer B; lengths in floats.
    SINEW_SUBJECT_OUT_B = 13,
    /// Positions.
    SINEW_SUBJECT_POSITIONS = 14,
    /// Normals.
    SINEW_SUBJECT_NORMALS = 15,
    /// Tangents.
    SINEW_SUBJECT_TANGENTS = 16,
    /// Palette indices of influences.
    SINEW_SUBJECT_INDICES = 17,
    /// Weights of influences.
    SINEW_SUBJECT_WEIGHTS = 18,
    /// Evaluation order of the joints.
    SINEW_SUBJECT_ORDER = 19,
    /// Where a result goes.
    SINEW_SUBJECT_RESULT = 20,
    /// Where a second result goes.
    SINEW_SUBJECT_SECOND_RESULT = 21,
    /// Bytes of the file.
    SINEW_SUBJECT_FILE_BYTES = 64,
    /// Vertices.
    SINEW_SUBJECT_VERTICES = 65,
    /// Joints.
    SINEW_SUBJECT_JOINTS = 66,
    /// Proxies.
    SINEW_SUBJECT_PROXIES = 67,
    /// Influences of a vertex.
    SINEW_SUBJECT_INFLUENCES = 68,
    /// Groups of proxies.
    SINEW_SUBJECT_GROUPS = 69,
    /// The certificate.
    SINEW_SUBJECT_CERTIFICATE = 128,
    /// Section: names.
    SINEW_SUBJECT_SECTION_NAMES = 129,
    /// Section: hierarchy.
    SINEW_SUBJECT_SECTION_HIERARCHY = 130,
    /// Section: inverse bind matrices.
    SINEW_SUBJECT_SECTION_INVERSE_BINDS = 131,
    /// Section: rest positions.
    SINEW_SUBJECT_SECTION_REST_POSITIONS = 132,
    /// Section: rest normals.
    SINEW_SUBJECT_SECTION_REST_NORMALS = 133,
    /// Section: rest tangents.
    SINEW_SUBJECT_SECTION_REST_TANGENTS = 134,
    /// Section: palette index of each influence.
    SINEW_SUBJECT_SECTION_INFLUENCE_INDICES = 135,
    /// Section: weight of each influence.
    SINEW_SUBJECT_SECTION_INFLUENCE_WEIGHTS = 136,
    /// Section: key predictors.
    SINEW_SUBJECT_SECTION_KEYS = 137,
    /// Section: gradients to palette.
    SINEW_SUBJECT_SECTION_C1 = 138,
    /// Section: joints to palette.
    SINEW_SUBJECT_SECTION_C2 = 139,
    /// Section: rest box of what each map moves.
    SINEW_SUBJECT_SECTION_REST_BOXES = 140,
    /// Section: largest rotation of each joint in training.
    SINEW_SUBJECT_SECTION_POSE_RANGES = 141,
    /// Section: origin of each joint in the rest pose.
    SINEW_SUBJECT_SECTION_ORIGINS = 142,
    /// Section: groups of proxies that share a kernel map.
    SINEW_SUBJECT_SECTION_GROUPS = 143,
    /// Section: numbers of the kernel maps.
    SINEW_SUBJECT_SECTION_CORRECTIONS = 144,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum sinew_subject sinew_subject;
#else
typedef uint32_t sinew_subject;
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
    /// The palette is P proxies, of rotational regression and kernel maps together.
    SINEW_PREDICTOR_HYBRID = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum sinew_predictor sinew_predictor;
#else
typedef uint32_t sinew_predictor;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// Which output buffer of a `sinew_skin_job` an attribute is written to.
enum sinew_buffer
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// None: the attribute is not wanted.
    SINEW_BUFFER_NONE = 0,
    /// `out_a`.
    SINEW_BUFFER_A = 1,
    /// `out_b`.
    SINEW_BUFFER_B = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum sinew_buffer sinew_buffer;
#else
typedef uint32_t sinew_buffer;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// A skin of V vertices that follows J joints by a palette of maps: a view of the file's bytes,
/// of which the model's rules hold. It does not need the model any more.
typedef struct sinew_envelope sinew_envelope;

/// A loaded file: a view of its bytes, which must stay where they are and as they are for as long
/// as the model or an envelope of it is used. It never changes and may be used on any number of
/// threads at once. It may be moved with `memcpy`, and needs no destruction.
typedef struct sinew_model sinew_model;

/// The most of everything that a file may hold. All work, of loading and of evaluating, grows with
/// these counts and with nothing else.
typedef struct sinew_limits {
    /// Bytes of the file.
    uint32_t file_bytes;
    /// Vertices of a part.
    uint32_t vertices;
    /// Joints of a part.
    uint32_t joints;
    /// Proxies of a part.
    uint32_t proxies;
    /// Influences of a vertex.
    uint32_t influences;
} sinew_limits;

/// What went wrong; written only when a call returns another status than `SINEW_STATUS_OK`.
///
/// Each status says which fields it fills; the others are 0.
typedef struct sinew_error {
    /// What the call returned.
    sinew_status status;
    /// What it is about.
    sinew_subject subject;
    /// A joint, vertex, row, group or place.
    uint64_t index;
    /// What should have been there: an exact value, the least or the most, as the status says.
    uint64_t expected;
    /// What was there.
    uint64_t found;
} sinew_error;

/// A section of the file, known to the library or not, by its number in FORMAT.md.
typedef struct sinew_section {
    /// Where it starts, in bytes from the blob's start; a multiple of the file's alignment.
    uint32_t offset;
    /// Its length in bytes.
    uint32_t bytes;
} sinew_section;

/// What the fit was measured to reach, in the units of the input.
typedef struct sinew_certificate {
    /// Diagonal of the rest pose's box.
    float diagonal;
    /// RMS error over vertices and training frames.
    float training_rms;
    /// The same, each frame predicted by a fit that had not seen its fold.
    float cross_validated_rms;
    /// The same, of linear blend skinning.
    float lbs_training_rms;
    /// The farthest that single precision may move a vertex through the correction; 0 without one.
    float correction_error;
} sinew_certificate;

/// What an envelope is made of: every length that a caller needs.
typedef struct sinew_envelope_info {
    /// Its name: UTF-8 in the file's bytes, not ended by a zero.
    const char *name;
    /// Bytes of the name.
    size_t name_len;
    /// Its number among the file's parts, for `sinew_model_section`.
    uint32_t part;
    /// How it predicts.
    sinew_predictor predictor;
    /// V, vertices.
    size_t vertex_len;
    /// J, joints: skinning matrices of a pose.
    size_t joint_len;
    /// P, proxies or helpers.
    size_t proxy_len;
    /// Matrices of the palette.
    size_t palette_len;
    /// Floats of scratch that `sinew_envelope_palette` needs.
    size_t workspace_len;
    /// K, influences of each vertex.
    size_t influence_len;
    /// The joint without a parent.
    uint32_t root;
    /// 1 with tangents, else 0.
    uint32_t has_tangents;
    /// What the fit was measured to reach.
    struct sinew_certificate certificate;
} sinew_envelope_info;

/// A rigid or affine map, as three rows of four: `y[r] = rows[r][0..2] . x + rows[r][3]`.
typedef struct sinew_matrix {
    /// The rows.
    float rows[3][4];
} sinew_matrix;

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
    /// Its inverse bind matrix: model space to the joint's rest frame.
    struct sinew_matrix inverse_bind;
} sinew_joint;

/// A joint's frame in its parent's.
typedef struct sinew_transform {
    /// Quaternion x, y, z, w; it is normalised by the call.
    float rotation[4];
    /// Origin in the parent's frame, in the units of the model.
    float translation[3];
} sinew_transform;

/// A box along the axes, in model space.
typedef struct sinew_bounds {
    /// Least coordinates.
    float min[3];
    /// Greatest coordinates.
    float max[3];
} sinew_bounds;

/// Where an attribute is written: that of the i-th vertex *of the range* at `offset + i * stride`.
/// Zeros mean that it is not wanted.
typedef struct sinew_attribute {
    /// A `sinew_buffer`.
    uint32_t buffer;
    /// Where the range's first vertex goes, in floats.
    size_t offset;
    /// Floats from one vertex to the next; at least the attribute's own.
    size_t stride;
} sinew_attribute;

/// Skins a range of vertices. Floats between attributes are left alone; where attributes overlap,
/// the later field of this structure wins.
typedef struct sinew_skin_job {
    /// The envelope.
    const struct sinew_envelope *envelope;
    /// `sinew_envelope_info.palette_len` maps, rest to posed.
    const struct sinew_matrix *palette;
    /// Their number.
    size_t palette_len;
    /// First vertex.
    size_t start;
    /// One more than the last vertex.
    size_t end;
    /// Where to put positions: 3 floats, model space.
    struct sinew_attribute positions;
    /// Where to put normals: 3 floats of length 1; where a map leaves one no direction, the rest
    /// normal.
    struct sinew_attribute normals;
    /// Where to put tangents: 3 floats of length 1 (the rest tangent where a map leaves one no
    /// direction), then the handedness.
    struct sinew_attribute tangents;
    /// Buffer A, as long as its attributes need: `offset + (n - 1) * stride + 3` floats for n
    /// positions, say. Null if none is in it.
    float *out_a;
    /// Its length in floats.
    size_t out_a_len;
    /// Buffer B; likewise.
    float *out_b;
    /// Its length in floats.
    size_t out_b_len;
} sinew_skin_job;

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

/// Returns what a status means, in a few words that end in a zero; of any other number, that it is
/// unknown. Never null, valid for ever.
const char *sinew_status_text(int32_t status);

/// Returns the name of a subject, ended by a zero; of any other number, that it is unknown. Never
/// null, valid for ever.
const char *sinew_subject_text(uint32_t subject);

/// Returns the bytes of memory that a model needs: at most those of `SINEW_MODEL_WORDS` words.
size_t sinew_model_bytes(void);

/// Returns the alignment of the memory for models and envelopes: that of `uintptr_t`, or less.
size_t sinew_object_alignment(void);

/// Writes the limits that `sinew_model_load` has without others: generous for any character.
///
/// Returns `NULL`, `MISALIGNED`.
sinew_status sinew_limits_default(struct sinew_limits *out_limits,
                                  struct sinew_error *out_error);

/// Loads a model in place and checks all of it, in time bounded by the file's length. After that
/// no evaluation fails for the file's sake.
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
/// - `part`: `sinew_envelope_info.part`.
/// - `kind`: its number in FORMAT.md; `SINEW_SUBJECT_SECTION_C1 - SINEW_SUBJECT_CERTIFICATE`, say.
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
/// - `name`, `name_len`: its name, without a zero at its end; null for the first envelope.
/// - `memory`, `memory_bytes`: for the envelope; at least `sinew_envelope_bytes()`, aligned as a
///   `uintptr_t`.
/// - `out_envelope`: receives the handle, which is `memory`.
///
/// Returns `NULL`, `MISALIGNED`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`, `NOT_LOADED`, `NOT_FOUND`.
sinew_status sinew_envelope_open(const struct sinew_model *model,
                                 const char *name,
                                 size_t name_len,
                                 void *memory,
                                 size_t memory_bytes,
                                 const struct sinew_envelope **out_envelope,
                                 struct sinew_error *out_error);

/// Says what an envelope is made of.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `OVERLAP`.
sinew_status sinew_envelope_describe(const struct sinew_envelope *envelope,
                                     struct sinew_envelope_info *out_info,
                                     struct sinew_error *out_error);

/// Describes a joint.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `OVERLAP`, `OUT_OF_RANGE`.
sinew_status sinew_envelope_joint(const struct sinew_envelope *envelope,
                                  size_t joint,
                                  struct sinew_joint *out_joint,
                                  struct sinew_error *out_error);

/// Copies the J joints' numbers in an order in which each comes after its parent.
///
/// - `out_order`, `order_len`: room for J numbers.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`.
sinew_status sinew_envelope_order(const struct sinew_envelope *envelope,
                                  uint32_t *out_order,
                                  size_t order_len,
                                  struct sinew_error *out_error);

/// Computes the skinning matrices of a pose from local transforms and the hierarchy. An engine that
/// has skinning matrices (rest to posed, model space) does not need this.
///
/// - `local`, `local_len`: J transforms, the root's in model space.
/// - `out_pose`, `pose_len`: J matrices.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `LENGTH`, `NON_FINITE`, `ZERO_ROTATION`, `TOO_LONG`,
/// `OVERLAP`.
sinew_status sinew_envelope_pose(const struct sinew_envelope *envelope,
                                 const struct sinew_transform *local,
                                 size_t local_len,
                                 struct sinew_matrix *out_pose,
                                 size_t pose_len,
                                 struct sinew_error *out_error);

/// Computes the palette of a pose and the confidence in it.
///
/// - `pose`, `pose_len`: J skinning matrices, rest to posed, in model space; rigid to 1e-4.
/// - `workspace`, `workspace_len`: at least `sinew_envelope_info.workspace_len` floats, of any
///   content; its content afterwards means nothing. One for each thread.
/// - `out_palette`, `palette_len`: `sinew_envelope_info.palette_len` maps, rest to posed, in model
///   space: for `sinew_skin`, or with `sinew_envelope_influences` for a shader.
/// - `out_confidence`: null, or receives 1 within what was seen in training down to 0 far from it.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `LENGTH`, `TOO_SHORT`, `NON_FINITE`, `TOO_LONG`,
/// `OVERLAP`.
sinew_status sinew_envelope_palette(const struct sinew_envelope *envelope,
                                    const struct sinew_matrix *pose,
                                    size_t pose_len,
                                    float *workspace,
                                    size_t workspace_len,
                                    struct sinew_matrix *out_palette,
                                    size_t palette_len,
                                    float *out_confidence,
                                    struct sinew_error *out_error);

/// Computes what `sinew_envelope_palette` does, with the same arguments, of a rotational model alone:
/// any other is `NO_STAGE`. A program that calls this and not the other is linked without kernel
/// maps: on a Cortex-M4F 6 kB less if optimised for size, 15 kB if for speed.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `NO_STAGE`, `LENGTH`, `TOO_SHORT`, `NON_FINITE`,
/// `TOO_LONG`, `OVERLAP`.
sinew_status sinew_envelope_rotational_palette(const struct sinew_envelope *envelope,
                                               const struct sinew_matrix *pose,
                                               size_t pose_len,
                                               float *workspace,
                                               size_t workspace_len,
                                               struct sinew_matrix *out_palette,
                                               size_t palette_len,
                                               float *out_confidence,
                                               struct sinew_error *out_error);

/// Computes a box that holds every vertex of the posed skin, from the palette alone.
///
/// - `palette`, `palette_len`: `sinew_envelope_info.palette_len` maps.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `LENGTH`, `NO_VERTICES`, `TOO_LONG`, `OVERLAP`.
sinew_status sinew_envelope_bounds(const struct sinew_envelope *envelope,
                                   const struct sinew_matrix *palette,
                                   size_t palette_len,
                                   struct sinew_bounds *out_bounds,
                                   struct sinew_error *out_error);

/// Copies the rest positions of the vertices from `start` to before `end`: 3 floats each, packed.
///
/// - `out_positions`, `out_len`: room for `3 * (end - start)` floats.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `OUT_OF_RANGE`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`.
sinew_status sinew_envelope_rest_positions(const struct sinew_envelope *envelope,
                                           size_t start,
                                           size_t end,
                                           float *out_positions,
                                           size_t out_len,
                                           struct sinew_error *out_error);

/// Copies the rest normals of the vertices from `start` to before `end`: 3 floats each, packed.
///
/// - `out_normals`, `out_len`: room for `3 * (end - start)` floats.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `OUT_OF_RANGE`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`.
sinew_status sinew_envelope_rest_normals(const struct sinew_envelope *envelope,
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
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `NO_TANGENTS`, `OUT_OF_RANGE`, `TOO_SHORT`,
/// `TOO_LONG`, `OVERLAP`.
sinew_status sinew_envelope_rest_tangents(const struct sinew_envelope *envelope,
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
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `OUT_OF_RANGE`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`.
sinew_status sinew_envelope_influences(const struct sinew_envelope *envelope,
                                       size_t start,
                                       size_t end,
                                       uint16_t *out_indices,
                                       size_t indices_len,
                                       float *out_weights,
                                       size_t weights_len,
                                       struct sinew_error *out_error);

/// Runs a skin job. Jobs may run at the same time, on any threads, if none of the buffers given to
/// one overlaps those given to another.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `LENGTH`, `OUT_OF_RANGE`, `BUFFER`, `NO_TANGENTS`,
/// `STRIDE`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`.
sinew_status sinew_skin(const struct sinew_skin_job *job,
                        struct sinew_error *out_error);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* SINEW_H */
