// Compares skinning with ozz-animation's SkinningJob in one process on one core. Both skin one mesh
// with equal influences. The runs alternate; the program prints the medians of 301 runs.
// trainer/COMPARE.md has the figures.
//
//     git clone https://github.com/guillaumeblanc/ozz-animation ozz
//     S="ozz/src/geometry/runtime/skinning_job.cc ozz/src/base/maths/simd_math.cc
//        ozz/src/base/memory/allocator.cc ozz/src/base/log.cc"
//     g++ -std=c++17 -O3 -DNDEBUG -Iozz/include -Iozz/src -Iruntime/capi/include
//     runtime/capi/benches/ozz.cpp $S
//         target/embed/libsinew_capi.a -o bench && ./bench MODEL
//
// Build the library as in capi/README.md. Use -march=x86-64-v3 and RUSTFLAGS="-C
// target-cpu=x86-64-v3" together, or neither.
#include <sinew.hpp>

#include <ozz/base/maths/simd_math.h>
#include <ozz/geometry/runtime/skinning_job.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>

namespace {

constexpr int RUNS = 301;

/// Returns the time of a call in nanoseconds.
template <class Call> double timed(Call call) {
    const auto start = std::chrono::steady_clock::now();
    if (!call()) {
        std::fprintf(stderr, "a call failed\n");
        std::exit(1);
    }
    const std::chrono::duration<double, std::nano> taken = std::chrono::steady_clock::now() - start;
    return taken.count();
}

double median(std::vector<double> all) {
    std::nth_element(all.begin(), all.begin() + all.size() / 2, all.end());
    return all[all.size() / 2];
}

/// Makes a pose: rotates each joint about z, by an angle that depends on joint and run.
void turn(std::vector<sinew_matrix> &pose, int run) {
    for (std::size_t joint = 0; joint < pose.size(); joint++) {
        const float angle = 0.3f * std::sin(0.1f * float(run) + float(joint));
        const float c = std::cos(angle), s = std::sin(angle);
        pose[joint] = {{{c, -s, 0, 0}, {s, c, 0, 0}, {0, 0, 1, 0}}};
    }
}

} // namespace

int main(int argc, char **argv) {
    std::ifstream file(argc > 1 ? argv[1] : "", std::ios::binary);
    sinew::Model model;
    sinew::Envelope envelope;
    sinew::Skin skin;
    if (model.load({std::istreambuf_iterator<char>(file), {}}) || envelope.open(model) ||
        skin.open(model)) {
        std::fprintf(stderr, "usage: bench MODEL\n");
        return 2;
    }
    const std::size_t v = skin.info().vertex_len, k = skin.info().influence_len;
    std::vector<float> positions(3 * v), normals(3 * v), weights(v * k), own(3 * v),
        own_normals(3 * v);
    std::vector<float> theirs(3 * v), their_normals(3 * v), given(v * (k - 1));
    std::vector<std::uint16_t> indices(v * k);
    sinew_error error;
    if (skin.attribute(SINEW_ATTRIBUTE_POSITION, positions) ||
        skin.attribute(SINEW_ATTRIBUTE_NORMAL, normals) ||
        sinew_skin_influences(skin.get(), 0, v, indices.data(), indices.size(), weights.data(),
                              weights.size(), &error)) {
        return 1;
    }
    for (std::size_t vertex = 0; vertex < v; vertex++) {
        std::copy_n(&weights[vertex * k], k - 1, &given[vertex * (k - 1)]);
    }

    sinew::Character character(envelope);
    std::vector<sinew_matrix> pose(envelope.info().joint_len);
    std::vector<ozz::math::Float4x4> matrices(envelope.info().palette_len);
    sinew_skin_job job{};
    job.end = v;
    std::vector<float> scratch(skin.info().scratch_len);
    job.scratch = scratch.data();
    job.scratch_len = scratch.size();
    job.positions = {own.data(), own.size(), 3};
    sinew_skin_job with_normals = job;
    with_normals.normals = {own_normals.data(), own_normals.size(), 3};
    ozz::geometry::SkinningJob their_job;
    their_job.vertex_count = int(v);
    their_job.influences_count = int(k);
    their_job.joint_matrices = {matrices.data(), matrices.size()};
    their_job.joint_indices = {indices.data(), indices.size()};
    their_job.joint_indices_stride = sizeof(std::uint16_t) * k;
    their_job.joint_weights = {given.data(), given.size()};
    their_job.joint_weights_stride = sizeof(float) * (k - 1);
    their_job.in_positions = {positions.data(), positions.size()};
    their_job.out_positions = {theirs.data(), theirs.size()};
    their_job.in_positions_stride = their_job.out_positions_stride = 12;
    ozz::geometry::SkinningJob their_normals_job = their_job;
    their_normals_job.in_normals = {normals.data(), normals.size()};
    their_normals_job.out_normals = {their_normals.data(), their_normals.size()};
    their_normals_job.in_normals_stride = their_normals_job.out_normals_stride = 12;

    std::vector<double> palettes, skins, skins_normals, ozz_skins, ozz_normals;
    double farthest = 0.0;
    for (int run = 0; run < RUNS; run++) {
        turn(pose, run);
        palettes.push_back(timed([&] { return !character.pose_matrices(pose); }));
        for (std::size_t at = 0; at < matrices.size(); at++) {
            const auto &rows = character.palette()[at].rows;
            for (int c = 0; c < 4; c++) {
                matrices[at].cols[c] = ozz::math::simd_float4::Load(
                    rows[0][c], rows[1][c], rows[2][c], c == 3 ? 1.0f : 0.0f);
            }
        }
        skins.push_back(timed([&] { return !skin.run(job, character.palette()); }));
        ozz_skins.push_back(timed([&] { return their_job.Run(); }));
        skins_normals.push_back(
            timed([&] { return !skin.run(with_normals, character.palette()); }));
        ozz_normals.push_back(timed([&] { return their_normals_job.Run(); }));
        for (std::size_t at = 0; at < own.size(); at++) {
            farthest = std::max(farthest, double(std::fabs(own[at] - theirs[at])));
        }
    }
    const auto vertex = [&](const std::vector<double> &all) { return median(all) / double(v); };
    std::printf("%zu vertices, %zu influences, %zu joints, %zu transforms; positions differ by "
                "%.1e at most\n",
                v, k, pose.size(), matrices.size(), farthest);
    std::printf("palette                %8.2f us\n", median(palettes) / 1000.0);
    std::printf("positions              %8.2f ns a vertex, ozz %.2f\n", vertex(skins),
                vertex(ozz_skins));
    std::printf("positions and normals  %8.2f ns a vertex, ozz %.2f\n", vertex(skins_normals),
                vertex(ozz_normals));
    return 0;
}
