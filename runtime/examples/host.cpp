// Skins a character on the CPU: loads a model, bends its joints, and prints the mesh's box.
//
//     host MODEL
#include <sinew.hpp>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>

static void check(const sinew::Failure &failure) {
    if (failure) {
        std::fprintf(stderr, "host: %s\n", failure.text().c_str());
        std::exit(1);
    }
}

int main(int argc, char **argv) {
    // Once for each file: the model owns the bytes.
    std::ifstream file(argc > 1 ? argv[1] : "", std::ios::binary);
    sinew::Model model;
    sinew::Envelope envelope;
    sinew::Skin skin;
    check(model.load({std::istreambuf_iterator<char>(file), {}}));
    check(envelope.open(model));
    check(skin.open(model));
    std::printf("%s: %zu vertices, %zu joints\n", envelope.name().c_str(), skin.info().vertex_len,
                envelope.info().joint_len);

    // Once for each character: position and normal of each vertex.
    sinew::Character character(envelope);
    std::vector<float> floats(6 * skin.info().vertex_len), curves(envelope.info().curve_len);
    sinew_skin_job job = skin.job();
    job.positions = {floats.data(), floats.size(), 6};
    job.normals = {floats.data() + 3, floats.size() - 3, 6};

    for (const float turn : {0.0f, 0.1f, 0.2f}) {
        // Each frame: the animation's frames of the joints, each relative to its parent.
        std::vector<sinew_local_transform> local;
        check(envelope.rest_locals(local));
        for (std::size_t joint = 1; joint < local.size(); joint++) {
            local[joint].rotation[2] += turn;
        }
        check(character.pose(local, curves));
        check(skin.run(job, character.palette())); // unless the engine's shader skins
        sinew_bounds b;
        check(skin.bounds(character.palette(), b));
        std::printf("%.1f: up to %.3f %.3f %.3f, confidence %.2f\n", turn, b.max[0], b.max[1],
                    b.max[2], character.confidence());
    }
    return 0;
}
