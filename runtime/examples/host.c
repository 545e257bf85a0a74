/* host MODEL: skins a character on the CPU. It bends the joints and prints the mesh's box. */
#include <sinew.h>
#include <stdio.h>
#include <stdlib.h>

static unsigned char file[1 << 22]; /* an engine has its own memory; flash is enough */
static uintptr_t in_model[SINEW_MODEL_WORDS], in_env[SINEW_PART_WORDS], in_skin[SINEW_PART_WORDS];
static sinew_error err;

static void check(sinew_status status) {
    char text[256];
    if (status != SINEW_STATUS_OK) {
        sinew_error_text(&err, text, sizeof text);
        fprintf(stderr, "host: %s\n", text);
        exit(1);
    }
}

int main(int argc, char **argv) {
    FILE *in = argc > 1 ? fopen(argv[1], "rb") : NULL;
    size_t bytes = in ? fread(file, 1, sizeof file, in) : 0;
    /* Once for each file: checks all of it, and reads it in place. */
    const sinew_model *model;
    const sinew_envelope *envelope = (void *)in_env;
    const sinew_skin *skin = (void *)in_skin;
    sinew_envelope_info e;
    sinew_skin_info s;
    check(sinew_model_load(in_model, sizeof in_model, file, bytes, NULL, &model, &err));
    check(
        sinew_part_open(model, SINEW_PART_KIND_ENVELOPE, NULL, 0, 0, in_env, sizeof in_env, &err));
    check(sinew_part_open(model, SINEW_PART_KIND_SKIN, NULL, 0, 0, in_skin, sizeof in_skin, &err));
    check(sinew_envelope_describe(envelope, &e, &err));
    check(sinew_skin_describe(skin, &s, &err));
    printf("%.*s: %zu vertices, %zu joints\n", (int)e.name_len, e.name, s.vertex_len, e.joint_len);
    /* Once for each character: all lengths are known. */
    const size_t j = e.joint_len, p = e.palette_len, c = e.curve_len, n = 3 * s.vertex_len;
    sinew_local_transform *local = calloc(j, sizeof *local);
    sinew_matrix *pose = calloc(j, sizeof *pose), *palette = calloc(p, sizeof *palette);
    float *curves = calloc(c + e.scratch_len + n, sizeof *curves);
    float *scratch = curves + c, *positions = scratch + e.scratch_len;
    sinew_skin_job job = {.skin = skin, .palette = palette, .palette_len = p, .end = s.vertex_len};
    job.positions = (sinew_output){positions, n, 3};
    for (int i = 0; i < 3; i++) {
        /* Each frame: the animation's frames of the joints, each relative to its parent. */
        float turn = 0.1f * (float)i, confidence;
        sinew_bounds b;
        check(sinew_envelope_rest_locals(envelope, local, j, &err));
        for (size_t joint = 1; joint < j; joint++)
            local[joint].rotation[2] += turn;
        check(sinew_envelope_pose(envelope, local, j, pose, j, &err));
        check(sinew_envelope_palette(envelope, pose, j, curves, c, scratch, e.scratch_len, palette,
                                     p, &confidence, &err));
        check(sinew_skin_run(&job, &err)); /* unless the engine's shader skins by the palette */
        check(sinew_skin_bounds(skin, palette, p, 0, &b, &err));
        printf("%.1f: up to %.3f %.3f %.3f, confidence %.2f\n", turn, b.max[0], b.max[1], b.max[2],
               confidence);
    }
    free(local), free(pose), free(palette), free(curves);
    return 0;
}
