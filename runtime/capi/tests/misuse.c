/* Calls every function wrongly in every way that it can tell, and checks the status, its subject,
 * and that nothing was written. Run under sanitizers.
 *
 *     misuse MODEL
 */
#include <sinew.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { VERTICES = 64, JOINTS = 16, MAPS = 32, INFLUENCES = 8, FLOATS = 4096, FILE_BYTES = 65536 };

/* All that any call may write or read, so that one comparison sees whatever changes. */
static struct {
    uintptr_t model[SINEW_MODEL_WORDS];
    uintptr_t envelope[SINEW_ENVELOPE_WORDS];
    uintptr_t other[SINEW_ENVELOPE_WORDS];
    uintptr_t blank[SINEW_ENVELOPE_WORDS];
    _Alignas(16) uint8_t file[FILE_BYTES];
    const sinew_model *out_model;
    const sinew_envelope *out_envelope;
    const uint8_t *out_blob;
    size_t out_bytes;
    sinew_limits limits;
    sinew_section section;
    sinew_envelope_info info;
    sinew_joint joint;
    sinew_bounds bounds;
    sinew_transform local[JOINTS];
    sinew_matrix pose[JOINTS];
    sinew_matrix palette[MAPS];
    float workspace[FLOATS];
    float confidence;
    float out_a[10 * VERTICES];
    float out_b[10 * VERTICES];
    uint16_t indices[VERTICES * INFLUENCES];
    float weights[VERTICES * INFLUENCES];
    uint32_t order[JOINTS];
    sinew_skin_job job;
} w, before;

static sinew_error error, *err;
static int checks, failures;

static void expect(int line, const char *call, sinew_status expected, sinew_subject subject,
                   sinew_status found)
{
    checks++;
    if (found != expected || (err && expected && err->status != expected)) {
        printf("line %d: %s: expected status %d, found %d\n", line, call, (int)expected, (int)found);
        failures++;
    } else if (err && expected && err->subject != subject) {
        printf("line %d: %s: expected subject %s, found %s\n", line, call,
               sinew_subject_text(subject), sinew_subject_text(err->subject));
        failures++;
    } else if (memcmp(&w, &before, sizeof w) != 0) {
        printf("line %d: %s: memory was written\n", line, call);
        failures++;
    }
}

/* Makes a call that must fail, with and without room for the error. */
#define FAILS(status, subject, call) CHECK(SINEW_STATUS_##status, SINEW_SUBJECT_##subject, call)
#define CHECK(status, subject, call)                                                             \
    do {                                                                                         \
        memcpy(&before, &w, sizeof w);                                                           \
        err = &error;                                                                            \
        expect(__LINE__, #call, status, subject, call);                                          \
        err = NULL;                                                                              \
        expect(__LINE__, #call, status, subject, call);                                          \
        err = (sinew_error *)((char *)&error + 1);                                               \
        sinew_status odd = call;                                                                 \
        err = NULL;                                                                              \
        expect(__LINE__, #call, SINEW_STATUS_MISALIGNED, SINEW_SUBJECT_NONE, odd);               \
    } while (0)

/* Makes a call that must succeed. */
#define WORKS(call)                                                                              \
    do {                                                                                         \
        err = &error;                                                                            \
        sinew_status done = call;                                                                \
        memcpy(&before, &w, sizeof w);                                                           \
        expect(__LINE__, #call, SINEW_STATUS_OK, SINEW_SUBJECT_NONE, done);                      \
    } while (0)

/* An address that no value of the type may have; never read through. */
#define ODD(pointer) ((void *)((char *)(pointer) + 1))
#define MANY (SIZE_MAX / 2)

static void model(size_t bytes)
{
    size_t room = sizeof w.model;
    sinew_limits *none = NULL;
#define LOAD(memory, memory_bytes, file, len, limits, out)                                       \
    sinew_model_load(memory, memory_bytes, file, len, limits, out, err)
    FAILS(NULL, RESULT, sinew_limits_default(NULL, err));
    FAILS(MISALIGNED, RESULT, sinew_limits_default(ODD(&w.limits), err));
    WORKS(sinew_limits_default(&w.limits, err));

    FAILS(NULL, MEMORY, LOAD(NULL, room, w.file, bytes, none, &w.out_model));
    FAILS(NULL, FILE, LOAD(w.model, room, NULL, bytes, none, &w.out_model));
    FAILS(MALFORMED, NONE, LOAD(w.model, room, NULL, 0, none, &w.out_model));
    FAILS(NULL, RESULT, LOAD(w.model, room, w.file, bytes, none, NULL));
    FAILS(MISALIGNED, MEMORY, LOAD(ODD(w.model), room, w.file, bytes, none, &w.out_model));
    FAILS(MISALIGNED, LIMITS, LOAD(w.model, room, w.file, bytes, ODD(&w.limits), &w.out_model));
    FAILS(MISALIGNED, RESULT, LOAD(w.model, room, w.file, bytes, none, ODD(&w.out_model)));
    FAILS(TOO_SHORT, MEMORY,
          LOAD(w.model, sinew_model_bytes() - 1, w.file, bytes, none, &w.out_model));
    FAILS(TOO_SHORT, MEMORY, LOAD(w.model, 0, w.file, bytes, none, &w.out_model));
    FAILS(TOO_LONG, FILE, LOAD(w.model, room, w.file, SIZE_MAX, none, &w.out_model));
    FAILS(TOO_LONG, FILE, LOAD(w.model, room, w.file, MANY + 1, none, &w.out_model));
    FAILS(OVERLAP, MEMORY, LOAD(w.file, room, w.file, bytes, none, &w.out_model));
    FAILS(OVERLAP, RESULT, LOAD(w.model, room, w.file, bytes, none, (void *)w.file));
    FAILS(OVERLAP, MEMORY, LOAD(w.model, room, w.file, bytes, none, (void *)w.model));
    FAILS(OVERLAP, MEMORY, LOAD(w.model, room, w.file, bytes, (void *)w.model, &w.out_model));
    FAILS(MALFORMED, NONE, LOAD(w.model, room, w.file, 0, none, &w.out_model));
    for (size_t len = 4; len < bytes; len++) {
        sinew_status status = LOAD(w.model, room, w.file, len, none, &w.out_model);
        if (status < SINEW_STATUS_LIMIT) {
            printf("a file cut to %lu bytes: status %d\n", (unsigned long)len, (int)status);
            failures++;
        }
    }
    w.file[bytes] = 0;
    FAILS(CHECKSUM, NONE, LOAD(w.model, room, w.file, bytes + 1, none, &w.out_model));
    w.file[0] ^= 1;
    FAILS(MAGIC, NONE, LOAD(w.model, room, w.file, bytes, none, &w.out_model));
    w.file[0] ^= 1;
    w.file[bytes - 1] ^= 1;
    FAILS(CHECKSUM, NONE, LOAD(w.model, room, w.file, bytes, none, &w.out_model));
    w.file[bytes - 1] ^= 1;
    w.limits.vertices = 1;
    FAILS(LIMIT, VERTICES, LOAD(w.model, room, w.file, bytes, &w.limits, &w.out_model));

    FAILS(NULL, MODEL, sinew_model_blob(NULL, &w.out_blob, &w.out_bytes, err));
    FAILS(NOT_LOADED, MODEL,
          sinew_model_blob((void *)w.blank, &w.out_blob, &w.out_bytes, err));
    WORKS(LOAD(w.model, room, w.file, bytes, none, &w.out_model));

    const sinew_model *m = w.out_model;
    FAILS(MISALIGNED, MODEL, sinew_model_blob(ODD(m), &w.out_blob, &w.out_bytes, err));
    FAILS(NULL, RESULT, sinew_model_blob(m, NULL, &w.out_bytes, err));
    FAILS(NULL, SECOND_RESULT, sinew_model_blob(m, &w.out_blob, NULL, err));
    FAILS(MISALIGNED, RESULT, sinew_model_blob(m, ODD(&w.out_blob), &w.out_bytes, err));
    FAILS(MISALIGNED, SECOND_RESULT, sinew_model_blob(m, &w.out_blob, ODD(&w.out_bytes), err));
    FAILS(OVERLAP, RESULT, sinew_model_blob(m, (void *)&w.out_bytes, &w.out_bytes, err));
    FAILS(OVERLAP, SECOND_RESULT, sinew_model_blob(m, &w.out_blob, (void *)w.model, err));
    WORKS(sinew_model_blob(m, &w.out_blob, &w.out_bytes, err));

    FAILS(NULL, MODEL, sinew_model_section(NULL, 0, 1, &w.section, err));
    FAILS(MISALIGNED, MODEL, sinew_model_section(ODD(m), 0, 1, &w.section, err));
    FAILS(NOT_LOADED, MODEL, sinew_model_section((void *)w.blank, 0, 1, &w.section, err));
    FAILS(NULL, RESULT, sinew_model_section(m, 0, 1, NULL, err));
    FAILS(MISALIGNED, RESULT, sinew_model_section(m, 0, 1, ODD(&w.section), err));
    FAILS(OVERLAP, RESULT, sinew_model_section(m, 0, 1, (void *)(w.file + 256), err));
    FAILS(NOT_FOUND, NONE, sinew_model_section(m, 0, 999, &w.section, err));
    FAILS(NOT_FOUND, NONE, sinew_model_section(m, 0, 65536 + 1, &w.section, err));
    FAILS(NOT_FOUND, SECTION_NAMES, sinew_model_section(m, 7, 1, &w.section, err));
    WORKS(sinew_model_section(m, 0, 1, &w.section, err));
}

static void envelope(void)
{
    const sinew_model *m = w.out_model;
    size_t room = sizeof w.envelope;
#define OPEN(model, name, name_len, memory, memory_bytes, out)                                   \
    sinew_envelope_open(model, name, name_len, memory, memory_bytes, out, err)
    FAILS(NULL, MODEL, OPEN(NULL, NULL, 0, w.envelope, room, &w.out_envelope));
    FAILS(MISALIGNED, MODEL, OPEN(ODD(m), NULL, 0, w.envelope, room, &w.out_envelope));
    FAILS(NOT_LOADED, MODEL, OPEN((void *)w.blank, NULL, 0, w.envelope, room, &w.out_envelope));
    FAILS(NULL, MEMORY, OPEN(m, NULL, 0, NULL, room, &w.out_envelope));
    FAILS(MISALIGNED, MEMORY, OPEN(m, NULL, 0, ODD(w.envelope), room, &w.out_envelope));
    FAILS(TOO_SHORT, MEMORY,
          OPEN(m, NULL, 0, w.envelope, sinew_envelope_bytes() - 1, &w.out_envelope));
    FAILS(NULL, RESULT, OPEN(m, NULL, 0, w.envelope, room, NULL));
    FAILS(MISALIGNED, RESULT, OPEN(m, NULL, 0, w.envelope, room, ODD(&w.out_envelope)));
    FAILS(OVERLAP, MEMORY, OPEN(m, NULL, 0, w.model, room, &w.out_envelope));
    FAILS(OVERLAP, MEMORY, OPEN(m, NULL, 0, w.file, room, &w.out_envelope));
    FAILS(OVERLAP, RESULT, OPEN(m, NULL, 0, w.envelope, room, (void *)w.model));
    FAILS(OVERLAP, MEMORY, OPEN(m, (char *)w.envelope, 4, w.envelope, room, &w.out_envelope));
    FAILS(TOO_LONG, NAME, OPEN(m, "x", SIZE_MAX, w.envelope, room, &w.out_envelope));
    FAILS(NOT_FOUND, ENVELOPE, OPEN(m, "nobody", 6, w.envelope, room, &w.out_envelope));
    FAILS(NOT_FOUND, ENVELOPE, OPEN(m, "\xff", 1, w.envelope, room, &w.out_envelope));
    FAILS(NOT_FOUND, ENVELOPE, OPEN(m, "", 0, w.envelope, room, &w.out_envelope));
    WORKS(OPEN(m, NULL, 0, w.other, room, &w.out_envelope));
    WORKS(OPEN(m, "golden", 6, w.envelope, room, &w.out_envelope));

    const sinew_envelope *e = w.out_envelope;
    FAILS(NULL, ENVELOPE, sinew_envelope_describe(NULL, &w.info, err));
    FAILS(MISALIGNED, ENVELOPE, sinew_envelope_describe(ODD(e), &w.info, err));
    FAILS(NOT_LOADED, ENVELOPE, sinew_envelope_describe((void *)w.blank, &w.info, err));
    FAILS(NULL, RESULT, sinew_envelope_describe(e, NULL, err));
    FAILS(MISALIGNED, RESULT, sinew_envelope_describe(e, ODD(&w.info), err));
    FAILS(OVERLAP, RESULT, sinew_envelope_describe(e, (void *)w.envelope, err));
    WORKS(sinew_envelope_describe(e, &w.info, err));
    size_t j = w.info.joint_len;

    FAILS(NULL, ENVELOPE, sinew_envelope_joint(NULL, 0, &w.joint, err));
    FAILS(NOT_LOADED, ENVELOPE, sinew_envelope_joint((void *)w.blank, 0, &w.joint, err));
    FAILS(MISALIGNED, ENVELOPE, sinew_envelope_joint(ODD(e), 0, &w.joint, err));
    FAILS(NULL, RESULT, sinew_envelope_joint(e, 0, NULL, err));
    FAILS(MISALIGNED, RESULT, sinew_envelope_joint(e, 0, ODD(&w.joint), err));
    FAILS(OVERLAP, RESULT, sinew_envelope_joint(e, 0, (void *)w.file, err));
    FAILS(OUT_OF_RANGE, JOINTS, sinew_envelope_joint(e, j, &w.joint, err));
    FAILS(OUT_OF_RANGE, JOINTS, sinew_envelope_joint(e, SIZE_MAX, &w.joint, err));
    WORKS(sinew_envelope_joint(e, j - 1, &w.joint, err));

    FAILS(NULL, ENVELOPE, sinew_envelope_order(NULL, w.order, j, err));
    FAILS(NOT_LOADED, ENVELOPE, sinew_envelope_order((void *)w.blank, w.order, j, err));
    FAILS(MISALIGNED, ENVELOPE, sinew_envelope_order(ODD(e), w.order, j, err));
    FAILS(NULL, ORDER, sinew_envelope_order(e, NULL, j, err));
    FAILS(TOO_SHORT, ORDER, sinew_envelope_order(e, NULL, 0, err));
    FAILS(TOO_SHORT, ORDER, sinew_envelope_order(e, w.order, j - 1, err));
    FAILS(TOO_LONG, ORDER, sinew_envelope_order(e, w.order, MANY, err));
    FAILS(MISALIGNED, ORDER, sinew_envelope_order(e, ODD(w.order), j, err));
    FAILS(OVERLAP, ORDER, sinew_envelope_order(e, (void *)w.envelope, j, err));
    WORKS(sinew_envelope_order(e, w.order, j, err));
}

/* The copies of rest positions, normals and tangents have one shape. */
#define COPY(function, SUBJECT, floats)                                                          \
    FAILS(NULL, ENVELOPE, function(NULL, 0, v, w.out_a, n * floats, err));                       \
    FAILS(NOT_LOADED, ENVELOPE, function((void *)w.blank, 0, v, w.out_a, n * floats, err));      \
    FAILS(MISALIGNED, ENVELOPE, function(ODD(e), 0, v, w.out_a, n * floats, err));               \
    FAILS(NULL, SUBJECT, function(e, 0, v, NULL, n * floats, err));                              \
    FAILS(TOO_SHORT, SUBJECT, function(e, 0, v, NULL, 0, err));                                  \
    FAILS(TOO_SHORT, SUBJECT, function(e, 0, v, w.out_a, n * floats - 1, err));                  \
    FAILS(TOO_LONG, SUBJECT, function(e, 0, v, w.out_a, MANY, err));                             \
    FAILS(MISALIGNED, SUBJECT, function(e, 0, v, ODD(w.out_a), n * floats, err));                \
    FAILS(OVERLAP, SUBJECT, function(e, 0, v, (void *)w.file, n * floats, err));                 \
    FAILS(OUT_OF_RANGE, VERTICES, function(e, 0, v + 1, w.out_a, n * floats, err));              \
    FAILS(OUT_OF_RANGE, VERTICES, function(e, 2, 1, w.out_a, n * floats, err));                  \
    FAILS(OUT_OF_RANGE, VERTICES, function(e, 0, SIZE_MAX, w.out_a, n * floats, err));           \
    WORKS(function(e, v, v, NULL, 0, err));                                                      \
    WORKS(function(e, 0, v, w.out_a, n * floats, err))

static void mesh(void)
{
    const sinew_envelope *e = w.out_envelope;
    size_t v = w.info.vertex_len, n = v, k = v * w.info.influence_len;
    COPY(sinew_envelope_rest_positions, POSITIONS, 3);
    COPY(sinew_envelope_rest_normals, NORMALS, 3);
    if (w.info.has_tangents) {
        COPY(sinew_envelope_rest_tangents, TANGENTS, 4);
    } else {
        FAILS(NO_TANGENTS, TANGENTS, sinew_envelope_rest_tangents(e, 0, v, w.out_a, 4 * v, err));
    }
#define COPY_INFLUENCES(e, start, end, indices, len, weights, weights_len)                            \
    sinew_envelope_influences(e, start, end, indices, len, weights, weights_len, err)
    FAILS(NULL, ENVELOPE, COPY_INFLUENCES(NULL, 0, v, w.indices, k, w.weights, k));
    FAILS(NOT_LOADED, ENVELOPE, COPY_INFLUENCES((void *)w.blank, 0, v, w.indices, k, w.weights, k));
    FAILS(MISALIGNED, ENVELOPE, COPY_INFLUENCES(ODD(e), 0, v, w.indices, k, w.weights, k));
    FAILS(NULL, INDICES, COPY_INFLUENCES(e, 0, v, NULL, k, w.weights, k));
    FAILS(NULL, WEIGHTS, COPY_INFLUENCES(e, 0, v, w.indices, k, NULL, k));
    FAILS(TOO_SHORT, INDICES, COPY_INFLUENCES(e, 0, v, w.indices, k - 1, w.weights, k));
    FAILS(TOO_SHORT, WEIGHTS, COPY_INFLUENCES(e, 0, v, w.indices, k, w.weights, k - 1));
    FAILS(TOO_LONG, INDICES, COPY_INFLUENCES(e, 0, v, w.indices, MANY, w.weights, k));
    FAILS(TOO_LONG, WEIGHTS, COPY_INFLUENCES(e, 0, v, w.indices, k, w.weights, MANY));
    FAILS(MISALIGNED, INDICES, COPY_INFLUENCES(e, 0, v, ODD(w.indices), k, w.weights, k));
    FAILS(MISALIGNED, WEIGHTS, COPY_INFLUENCES(e, 0, v, w.indices, k, ODD(w.weights), k));
    FAILS(OVERLAP, INDICES, COPY_INFLUENCES(e, 0, v, (void *)w.weights, k, w.weights, k));
    FAILS(OVERLAP, WEIGHTS, COPY_INFLUENCES(e, 0, v, w.indices, k, (void *)w.file, k));
    FAILS(OUT_OF_RANGE, VERTICES, COPY_INFLUENCES(e, 0, v + 1, w.indices, k, w.weights, k));
    WORKS(COPY_INFLUENCES(e, 0, v, w.indices, k, w.weights, k));
}

typedef sinew_status palette_call(const sinew_envelope *, const sinew_matrix *, size_t, float *,
                                  size_t, sinew_matrix *, size_t, float *, sinew_error *);

static void palette(palette_call *call)
{
    const sinew_envelope *e = w.out_envelope;
    size_t j = w.info.joint_len, p = w.info.palette_len, s = w.info.workspace_len;
#define PALETTE(e, pose, pose_len, workspace, len, palette, palette_len, confidence)             \
    call(e, pose, pose_len, workspace, len, palette, palette_len, confidence, err)
    float *c = &w.confidence;
    FAILS(NULL, ENVELOPE, PALETTE(NULL, w.pose, j, w.workspace, s, w.palette, p, c));
    FAILS(NOT_LOADED, ENVELOPE, PALETTE((void *)w.blank, w.pose, j, w.workspace, s, w.palette, p, c));
    FAILS(NOT_LOADED, ENVELOPE, PALETTE((void *)w.model, w.pose, j, w.workspace, s, w.palette, p, c));
    FAILS(MISALIGNED, ENVELOPE, PALETTE(ODD(e), w.pose, j, w.workspace, s, w.palette, p, c));
    FAILS(NULL, POSE, PALETTE(e, NULL, j, w.workspace, s, w.palette, p, c));
    FAILS(NULL, WORKSPACE, PALETTE(e, w.pose, j, NULL, s, w.palette, p, c));
    FAILS(NULL, PALETTE, PALETTE(e, w.pose, j, w.workspace, s, NULL, p, c));
    FAILS(LENGTH, POSE, PALETTE(e, w.pose, j + 1, w.workspace, s, w.palette, p, c));
    FAILS(TOO_SHORT, WORKSPACE, PALETTE(e, w.pose, j, w.workspace, s - 1, w.palette, p, c));
    FAILS(TOO_SHORT, WORKSPACE, PALETTE(e, w.pose, j, NULL, 0, w.palette, p, c));
    FAILS(LENGTH, PALETTE, PALETTE(e, w.pose, j, w.workspace, s, w.palette, p - 1, c));
    FAILS(LENGTH, PALETTE, PALETTE(e, w.pose, j, w.workspace, s, w.palette, p + 1, c));
    FAILS(TOO_LONG, POSE, PALETTE(e, w.pose, MANY, w.workspace, s, w.palette, p, c));
    FAILS(TOO_LONG, WORKSPACE, PALETTE(e, w.pose, j, w.workspace, MANY, w.palette, p, c));
    FAILS(TOO_LONG, PALETTE, PALETTE(e, w.pose, j, w.workspace, s, w.palette, MANY, c));
    FAILS(MISALIGNED, POSE, PALETTE(e, ODD(w.pose), j, w.workspace, s, w.palette, p, c));
    FAILS(MISALIGNED, WORKSPACE, PALETTE(e, w.pose, j, ODD(w.workspace), s, w.palette, p, c));
    FAILS(MISALIGNED, PALETTE, PALETTE(e, w.pose, j, w.workspace, s, ODD(w.palette), p, c));
    FAILS(MISALIGNED, RESULT, PALETTE(e, w.pose, j, w.workspace, s, w.palette, p, ODD(c)));
    FAILS(OVERLAP, WORKSPACE, PALETTE(e, w.pose, j, (void *)w.pose, s, w.palette, p, c));
    FAILS(OVERLAP, WORKSPACE, PALETTE(e, w.pose, j, w.workspace, s, (void *)w.workspace, p, c));
    FAILS(OVERLAP, PALETTE, PALETTE(e, w.pose, j, w.workspace, s, (void *)w.file, p, c));
    FAILS(OVERLAP, RESULT, PALETTE(e, w.pose, j, w.workspace, s, w.palette, p, (void *)w.file));
    w.pose[j - 1].rows[2][3] = INFINITY;
    FAILS(NON_FINITE, POSE, PALETTE(e, w.pose, j, w.workspace, s, w.palette, p, c));
    w.pose[j - 1] = w.pose[0];
    WORKS(PALETTE(e, w.pose, j, w.workspace, s, w.palette, p, NULL));
    WORKS(PALETTE(e, w.pose, j, w.workspace, FLOATS, w.palette, p, c));
}

static void evaluate(void)
{
    const sinew_envelope *e = w.out_envelope;
    size_t j = w.info.joint_len, p = w.info.palette_len, s = w.info.workspace_len;
    for (size_t i = 0; i < j; i++) {
        w.local[i] = (sinew_transform){{0.1f, 0.0f, 0.0f, 1.0f}, {1.0f, 0.0f, 0.0f}};
    }
#define POSE(e, local, local_len, pose, pose_len)                                                \
    sinew_envelope_pose(e, local, local_len, pose, pose_len, err)
    FAILS(NULL, ENVELOPE, POSE(NULL, w.local, j, w.pose, j));
    FAILS(NOT_LOADED, ENVELOPE, POSE((void *)w.blank, w.local, j, w.pose, j));
    FAILS(MISALIGNED, ENVELOPE, POSE(ODD(e), w.local, j, w.pose, j));
    FAILS(NULL, LOCAL, POSE(e, NULL, j, w.pose, j));
    FAILS(NULL, POSE, POSE(e, w.local, j, NULL, j));
    FAILS(LENGTH, LOCAL, POSE(e, NULL, 0, w.pose, j));
    FAILS(LENGTH, LOCAL, POSE(e, w.local, j + 1, w.pose, j));
    FAILS(LENGTH, POSE, POSE(e, w.local, j, w.pose, j - 1));
    FAILS(LENGTH, POSE, POSE(e, w.local, j, w.pose, j + 1));
    FAILS(TOO_LONG, LOCAL, POSE(e, w.local, MANY, w.pose, j));
    FAILS(TOO_LONG, POSE, POSE(e, w.local, j, w.pose, MANY));
    FAILS(MISALIGNED, LOCAL, POSE(e, ODD(w.local), j, w.pose, j));
    FAILS(MISALIGNED, POSE, POSE(e, w.local, j, ODD(w.pose), j));
    FAILS(OVERLAP, POSE, POSE(e, (void *)w.pose, j, w.pose, j));
    w.local[1].translation[2] = NAN;
    FAILS(NON_FINITE, LOCAL, POSE(e, w.local, j, w.pose, j));
    w.local[1] = (sinew_transform){{0.0f, 0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f}};
    FAILS(ZERO_ROTATION, LOCAL, POSE(e, w.local, j, w.pose, j));
    w.local[1] = w.local[0];
    WORKS(POSE(e, w.local, j, w.pose, j));

    palette(sinew_envelope_palette);
    if (w.info.predictor == SINEW_PREDICTOR_ROTATIONAL) {
        palette(sinew_envelope_rotational_palette);
    } else {
        FAILS(NO_STAGE, NONE, sinew_envelope_rotational_palette(e, w.pose, j, w.workspace, s,
                                                                w.palette, p, &w.confidence, err));
    }

    FAILS(NULL, ENVELOPE, sinew_envelope_bounds(NULL, w.palette, p, &w.bounds, err));
    FAILS(NOT_LOADED, ENVELOPE, sinew_envelope_bounds((void *)w.blank, w.palette, p, &w.bounds, err));
    FAILS(MISALIGNED, ENVELOPE, sinew_envelope_bounds(ODD(e), w.palette, p, &w.bounds, err));
    FAILS(NULL, PALETTE, sinew_envelope_bounds(e, NULL, p, &w.bounds, err));
    FAILS(NULL, RESULT, sinew_envelope_bounds(e, w.palette, p, NULL, err));
    FAILS(LENGTH, PALETTE, sinew_envelope_bounds(e, w.palette, p + 1, &w.bounds, err));
    FAILS(LENGTH, PALETTE, sinew_envelope_bounds(e, NULL, 0, &w.bounds, err));
    FAILS(TOO_LONG, PALETTE, sinew_envelope_bounds(e, w.palette, MANY, &w.bounds, err));
    FAILS(MISALIGNED, PALETTE, sinew_envelope_bounds(e, ODD(w.palette), p, &w.bounds, err));
    FAILS(MISALIGNED, RESULT, sinew_envelope_bounds(e, w.palette, p, ODD(&w.bounds), err));
    FAILS(OVERLAP, RESULT, sinew_envelope_bounds(e, w.palette, p, (void *)w.palette, err));
    WORKS(sinew_envelope_bounds(e, w.palette, p, &w.bounds, err));
}

/* Runs the job in `w` with one field changed. */
#define JOB(status, subject, change)                                                             \
    do {                                                                                         \
        sinew_skin_job sound = w.job;                                                            \
        change;                                                                                  \
        CHECK(SINEW_STATUS_##status, SINEW_SUBJECT_##subject, sinew_skin(&w.job, err));          \
        w.job = sound;                                                                           \
    } while (0)

static void skin(void)
{
    size_t v = w.info.vertex_len;
    w.job = (sinew_skin_job){
        .envelope = w.out_envelope,
        .palette = w.palette,
        .palette_len = w.info.palette_len,
        .end = v,
        .positions = {SINEW_BUFFER_A, 0, 6},
        .normals = {SINEW_BUFFER_A, 3, 6},
        .out_a = w.out_a,
        .out_a_len = 6 * v,
    };
    FAILS(NULL, JOB, sinew_skin(NULL, err));
    FAILS(MISALIGNED, JOB, sinew_skin(ODD(&w.job), err));
    JOB(NULL, ENVELOPE, w.job.envelope = NULL);
    JOB(NOT_LOADED, ENVELOPE, w.job.envelope = (void *)w.blank);
    JOB(MISALIGNED, ENVELOPE, w.job.envelope = ODD(w.job.envelope));
    JOB(NULL, PALETTE, w.job.palette = NULL);
    JOB(LENGTH, PALETTE, w.job.palette_len--);
    JOB(TOO_LONG, PALETTE, w.job.palette_len = MANY);
    JOB(MISALIGNED, PALETTE, w.job.palette = ODD(w.palette));
    JOB(OUT_OF_RANGE, VERTICES, w.job.end++);
    JOB(OUT_OF_RANGE, VERTICES, w.job.start = v + 1);
    JOB(OUT_OF_RANGE, VERTICES, (w.job.start = 2, w.job.end = 1));
    JOB(BUFFER, POSITIONS, w.job.positions.buffer = 3);
    JOB(BUFFER, NORMALS, w.job.normals.buffer = UINT32_MAX);
    JOB(BUFFER, TANGENTS, w.job.tangents.buffer = 9);
    JOB(STRIDE, NONE, w.job.positions.stride = 2);
    JOB(TOO_SHORT, OUT_A, w.job.out_a_len--);
    JOB(TOO_SHORT, OUT_A, (w.job.out_a = NULL, w.job.out_a_len = 0));
    JOB(TOO_SHORT, OUT_A, w.job.positions.offset = SIZE_MAX);
    JOB(TOO_SHORT, OUT_A, w.job.normals.stride = SIZE_MAX);
    JOB(TOO_SHORT, OUT_B, w.job.positions.buffer = SINEW_BUFFER_B);
    JOB(NULL, OUT_A, w.job.out_a = NULL);
    JOB(NULL, OUT_B, w.job.out_b_len = 1);
    JOB(TOO_LONG, OUT_A, w.job.out_a_len = MANY);
    JOB(TOO_LONG, OUT_B, (w.job.out_b = w.out_b, w.job.out_b_len = MANY));
    JOB(MISALIGNED, OUT_A, w.job.out_a = ODD(w.out_a));
    JOB(MISALIGNED, OUT_B, (w.job.out_b = ODD(w.out_b), w.job.out_b_len = 1));
    JOB(OVERLAP, OUT_A, (w.job.out_b = w.out_a + 6 * v - 1, w.job.out_b_len = 2));
    JOB(OVERLAP, OUT_A, w.job.out_a = (float *)w.palette);
    JOB(OVERLAP, OUT_A, w.job.out_a = (float *)w.file);
    JOB(OVERLAP, OUT_A, w.job.out_a = (float *)w.envelope);
    JOB(OVERLAP, OUT_B, (w.job.out_b = (float *)&w.job, w.job.out_b_len = 1));
    if (!w.info.has_tangents) {
        JOB(NO_TANGENTS, TANGENTS, w.job.tangents = w.job.positions);
    }
    WORKS(sinew_skin(&w.job, err));
    w.job.out_b = w.out_b;
    w.job.out_b_len = 0;
    WORKS(sinew_skin(&w.job, err));
}

int main(int argc, char **argv)
{
    FILE *file = argc == 2 ? fopen(argv[1], "rb") : NULL;
    if (!file) {
        printf("usage: misuse MODEL\n");
        return 2;
    }
    memset(&w, 0xa5, sizeof w);
    memset(w.blank, 0, sizeof w.blank);
    size_t bytes = fread(w.file, 1, sizeof w.file - 1, file);
    fclose(file);
    model(bytes);
    envelope();
    if (w.info.vertex_len > VERTICES || w.info.joint_len >= JOINTS || w.info.palette_len >= MAPS ||
        w.info.workspace_len > FLOATS || w.info.influence_len > INFLUENCES) {
        printf("the model is too large for this test\n");
        return 2;
    }
    mesh();
    evaluate();
    skin();
    printf("%d checks, %d failures\n", checks, failures);
    return failures ? 1 : 0;
}
