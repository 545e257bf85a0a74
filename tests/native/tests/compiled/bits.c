/* Loads a model, poses it repeatedly, skins it, and prints bounds, confidence and a hash of all
 * output bits. The hash is the same on every CPU.
 *
 *     skin MODEL [POSES]
 */
#include <sinew.h>

#include <stdio.h>
#include <stdlib.h>

/* State of one character. All characters of this shape share model, envelope and skin; each has its
 * own arrays. */
typedef struct {
    const sinew_envelope *envelope;
    const sinew_skin *skin;
    sinew_envelope_info info;
    sinew_skin_info mesh;
    sinew_local_transform *rest;
    sinew_local_transform *local;
    float *curves;
    sinew_matrix *pose;
    sinew_matrix *palette;
    sinew_bone *bones;
    float *scratch;
    float *vertices;
    size_t vertices_len;
    size_t stride;
} character;

static void *allocate(size_t count, size_t size) {
    void *memory = calloc(count ? count : 1, size);
    if (!memory) {
        fprintf(stderr, "skin: no memory\n");
        exit(1);
    }
    return memory;
}

/* Prints the error and stops. An engine would show its placeholder instead. */
static void check(sinew_status status, const sinew_error *error) {
    if (status == SINEW_STATUS_OK) {
        return;
    }
    char text[256];
    sinew_error_text(error, text, sizeof text);
    fprintf(stderr, "skin: %s (status %d)\n", text, (int)status);
    exit(1);
}

static uint8_t *read_file(const char *path, size_t *bytes) {
    FILE *file = fopen(path, "rb");
    uint8_t *content = NULL;
    size_t room = 4096, len = 0, more = 1;
    while (file && more > 0) {
        room *= 2;
        content = realloc(content, room);
        if (!content) {
            break;
        }
        more = fread(content + len, 1, room - len, file);
        len += more;
    }
    if (!content || ferror(file) || fclose(file) != 0) {
        fprintf(stderr, "skin: %s cannot be read\n", path);
        exit(1);
    }
    *bytes = len;
    return content;
}

/* SplitMix64; returns a number in [-1, 1) from its upper bits. */
static float next(uint64_t *state) {
    uint64_t z = *state += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return (float)((z ^ (z >> 31)) >> 40) / 8388608.0f - 1.0f;
}

/* Replaces an animation system: applies slight, usual and wild rotations to the rest pose, and
 * moves the curves as far. */
static void animate(character *c, unsigned frame, uint64_t *state) {
    static const float turns[4] = {0.01f, 0.3f, 1.0f, 8.0f};
    float turn = turns[frame % 4];
    for (size_t joint = 0; joint < c->info.joint_len; joint++) {
        sinew_local_transform *local = &c->local[joint];
        *local = c->rest[joint];
        for (int i = 0; i < 3; i++) {
            local->rotation[i] += next(state) * turn;
        }
    }
    for (size_t curve = 0; curve < c->info.curve_len; curve++) {
        c->curves[curve] = next(state) * turn;
    }
}

/* Computes a frame: vertices, bounds and confidence from local transforms and curves. */
static void frame(character *c, sinew_bounds *bounds, float *confidence) {
    sinew_error error;
    const sinew_envelope_info *info = &c->info;
    const size_t palette_len = info->palette_len, stride = c->stride, len = c->vertices_len;
    sinew_skin_job job = {
        .skin = c->skin,
        .palette = c->palette,
        .palette_len = palette_len,
        .end = c->mesh.vertex_len,
        .positions = {c->vertices, len, stride},
        .normals = {c->vertices + 3, len - 3, stride},
    };
    if (c->mesh.has_tangents) {
        job.tangents = (sinew_output){c->vertices + 6, len - 6, stride};
    }
    check(sinew_envelope_pose(c->envelope, c->local, info->joint_len, c->pose, info->joint_len,
                              &error),
          &error);
    check(sinew_envelope_palette(c->envelope, c->pose, info->joint_len, c->curves, info->curve_len,
                                 c->scratch, info->scratch_len, c->palette, palette_len, confidence,
                                 &error),
          &error);
    check(sinew_envelope_bones(c->envelope, c->palette, palette_len, c->bones, info->proxy_len,
                               &error),
          &error);
    check(sinew_skin_run(&job, &error), &error);
    check(sinew_skin_bounds(c->skin, c->palette, palette_len, 0.0f, bounds, &error), &error);
}

/* FNV-1a over the bits of floats, the least significant byte first. */
static uint64_t hash(uint64_t state, const float *values, size_t len) {
    for (size_t i = 0; i < len; i++) {
        union {
            float value;
            uint32_t bits;
        } word = {values[i]};
        for (int shift = 0; shift < 32; shift += 8) {
            state = (state ^ ((word.bits >> shift) & 0xff)) * UINT64_C(0x100000001b3);
        }
    }
    return state;
}

int main(int argc, char **argv) {
    static uintptr_t model_memory[SINEW_MODEL_WORDS];
    static uintptr_t envelope_memory[SINEW_PART_WORDS], skin_memory[SINEW_PART_WORDS];
    const sinew_model *model;
    character c;
    sinew_error error;
    sinew_bounds bounds = {{0}, {0}};
    float confidence = 0.0f, least = 1.0f;
    uint64_t state = 2007, bits = UINT64_C(0xcbf29ce484222325);
    size_t bytes;
    if (argc < 2) {
        fprintf(stderr, "usage: skin MODEL [POSES]\n");
        return 2;
    }
    unsigned long poses = argc > 2 ? strtoul(argv[2], NULL, 10) : 1;
    uint8_t *file = read_file(argv[1], &bytes);

    check(sinew_model_load(model_memory, sizeof model_memory, file, bytes, NULL, &model, &error),
          &error);
    check(sinew_part_open(model, SINEW_PART_KIND_ENVELOPE, NULL, 0, 0, envelope_memory,
                          sizeof envelope_memory, &error),
          &error);
    check(sinew_part_open(model, SINEW_PART_KIND_SKIN, NULL, 0, 0, skin_memory, sizeof skin_memory,
                          &error),
          &error);
    c.envelope = (const sinew_envelope *)envelope_memory;
    c.skin = (const sinew_skin *)skin_memory;
    check(sinew_envelope_describe(c.envelope, &c.info, &error), &error);
    check(sinew_skin_describe(c.skin, &c.mesh, &error), &error);
    if (c.mesh.vertex_len == 0) {
        fprintf(stderr, "skin: %s has no vertices\n", argv[1]);
        return 1;
    }
    c.stride = c.mesh.has_tangents ? 10 : 6;
    c.vertices_len = c.mesh.vertex_len * c.stride;
    c.local = allocate(c.info.joint_len, sizeof *c.local);
    c.rest = allocate(c.info.joint_len, sizeof *c.rest);
    c.curves = allocate(c.info.curve_len, sizeof *c.curves);
    c.pose = allocate(c.info.joint_len, sizeof *c.pose);
    c.palette = allocate(c.info.palette_len, sizeof *c.palette);
    c.bones = allocate(c.info.proxy_len, sizeof *c.bones);
    c.scratch = allocate(c.info.scratch_len, sizeof *c.scratch);
    c.vertices = allocate(c.vertices_len, sizeof *c.vertices);

    check(sinew_envelope_rest_locals(c.envelope, c.rest, c.info.joint_len, &error), &error);
    for (unsigned long i = 0; i < poses; i++) {
        animate(&c, (unsigned)i, &state);
        frame(&c, &bounds, &confidence);
        least = confidence < least ? confidence : least;
        bits = hash(bits, (const float *)c.palette, 12 * c.info.palette_len);
        for (size_t helper = 0; helper < c.info.proxy_len; helper++) {
            bits = hash(bits, c.bones[helper].translation, 3);
            bits = hash(bits, c.bones[helper].scale, 3);
            bits = hash(bits, c.bones[helper].centre, 3);
            bits = hash(bits, c.bones[helper].rotation, 4);
        }
        bits = hash(bits, &confidence, 1);
        bits = hash(bits, c.vertices, c.vertices_len);
        bits = hash(bits, bounds.min, 3);
        bits = hash(bits, bounds.max, 3);
    }
    printf("model       %.*s: %lu vertices, %lu joints, %lu transforms\n", (int)c.info.name_len,
           c.info.name, (unsigned long)c.mesh.vertex_len, (unsigned long)c.info.joint_len,
           (unsigned long)c.info.palette_len);
    printf("bounds      %.6f %.6f %.6f to %.6f %.6f %.6f\n", bounds.min[0], bounds.min[1],
           bounds.min[2], bounds.max[0], bounds.max[1], bounds.max[2]);
    printf("confidence  %.6f at least\n", least);
    printf("hash        %08lx%08lx\n", (unsigned long)(bits >> 32),
           (unsigned long)(bits & 0xffffffff));

    free(c.vertices);
    free(c.scratch);
    free(c.bones);
    free(c.palette);
    free(c.pose);
    free(c.curves);
    free(c.rest);
    free(c.local);
    free(file);
    return 0;
}
