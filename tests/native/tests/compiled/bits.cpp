// skin.c with the C++ wrapper sinew.hpp.
//
//     skin MODEL [POSES]
#include <sinew.hpp>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>

namespace {

/// Prints the error and stops. An engine would show its placeholder instead.
void check(const sinew::Failure &failure) {
    if (failure) {
        std::fprintf(stderr, "skin: %s\n", failure.text().c_str());
        std::exit(1);
    }
}

/// SplitMix64; returns a number in [-1, 1) from its upper bits.
float next(std::uint64_t &state) {
    std::uint64_t z = state += 0x9e3779b97f4a7c15;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return float((z ^ (z >> 31)) >> 40) / 8388608.0f - 1.0f;
}

/// Replaces an animation system: applies slight, usual and wild rotations to the rest pose, and
/// moves the curves as far.
std::vector<sinew_local_transform> animate(std::vector<sinew_local_transform> rest,
                                           std::vector<float> &curves, unsigned long frame,
                                           std::uint64_t &state) {
    const float turn = std::array{0.01f, 0.3f, 1.0f, 8.0f}[frame % 4];
    for (sinew_local_transform &joint : rest) {
        for (int i = 0; i < 3; i++) {
            joint.rotation[i] += next(state) * turn;
        }
    }
    for (float &curve : curves) {
        curve = next(state) * turn;
    }
    return rest;
}

/// FNV-1a over the bits of floats, the least significant byte first.
void hash(std::uint64_t &state, const float *values, std::size_t len) {
    for (std::size_t i = 0; i < len; i++) {
        std::uint32_t bits;
        std::memcpy(&bits, values + i, sizeof bits);
        for (int shift = 0; shift < 32; shift += 8) {
            state = (state ^ ((bits >> shift) & 0xff)) * 0x100000001b3;
        }
    }
}

} // namespace

int main(int argc, char **argv) {
    if (argc < 2) {
        std::fprintf(stderr, "usage: skin MODEL [POSES]\n");
        return 2;
    }
    const unsigned long poses = argc > 2 ? std::strtoul(argv[2], nullptr, 10) : 1;
    std::ifstream file(argv[1], std::ios::binary);
    sinew::Model model;
    check(model.load({std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()}));
    sinew::Envelope envelope;
    check(envelope.open(model));
    sinew::Skin skin;
    check(skin.open(model));
    const std::size_t vertex_len = skin.info().vertex_len;
    if (vertex_len == 0) {
        std::fprintf(stderr, "skin: %s has no vertices\n", argv[1]);
        return 1;
    }

    const std::size_t stride = skin.info().has_tangents ? 10 : 6;
    std::vector<sinew_local_transform> rest;
    check(envelope.rest_locals(rest));
    std::vector<sinew_bone> bones;
    std::vector<float> vertices(vertex_len * stride), curves(envelope.info().curve_len);
    sinew::Character character(envelope);
    sinew_skin_job job = skin.job();
    job.positions = {vertices.data(), vertices.size(), stride};
    job.normals = {vertices.data() + 3, vertices.size() - 3, stride};
    if (skin.info().has_tangents) {
        job.tangents = {vertices.data() + 6, vertices.size() - 6, stride};
    }

    sinew_bounds bounds{};
    float least = 1.0f;
    std::uint64_t state = 2007, bits = 0xcbf29ce484222325;
    for (unsigned long i = 0; i < poses; i++) {
        const std::vector<sinew_local_transform> local = animate(rest, curves, i, state);
        check(character.pose(local, curves));
        check(character.bones(bones));
        check(skin.run(job, character.palette()));
        check(skin.bounds(character.palette(), bounds));
        const float confidence = character.confidence();
        least = confidence < least ? confidence : least;
        for (const sinew_matrix &transform : character.palette()) {
            hash(bits, transform.rows[0], 4);
            hash(bits, transform.rows[1], 4);
            hash(bits, transform.rows[2], 4);
        }
        for (const sinew_bone &bone : bones) {
            hash(bits, bone.translation, 3);
            hash(bits, bone.scale, 3);
            hash(bits, bone.centre, 3);
            hash(bits, bone.rotation, 4);
        }
        hash(bits, &confidence, 1);
        hash(bits, vertices.data(), vertices.size());
        hash(bits, bounds.min, 3);
        hash(bits, bounds.max, 3);
    }
    std::printf("model       %s: %zu vertices, %zu joints, %zu transforms\n",
                envelope.name().c_str(), vertex_len, envelope.info().joint_len,
                envelope.info().palette_len);
    std::printf("bounds      %.6f %.6f %.6f to %.6f %.6f %.6f\n", bounds.min[0], bounds.min[1],
                bounds.min[2], bounds.max[0], bounds.max[1], bounds.max[2]);
    std::printf("confidence  %.6f at least\n", least);
    std::printf("hash        %016llx\n", static_cast<unsigned long long>(bits));
    return 0;
}
