// Shapes, priors, pins, views and filters of sinew.hpp: prints hashes of their results.
//
//     parts FACE VIEWS FILTER
#include <sinew.hpp>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <type_traits>

static void check(const sinew::Failure &failure) {
    if (failure) {
        std::fprintf(stderr, "%s\n", failure.text().c_str());
        std::exit(1);
    }
}

static void expect(const sinew::Failure &failure, sinew_status status) {
    if (failure.status != status) {
        std::fprintf(stderr, "status %d instead of %d\n", int(failure.status), int(status));
        std::exit(1);
    }
}

/// Prints a label and the FNV-1a hash of bytes.
static void print(const char *what, const void *bytes, std::size_t len) {
    std::uint64_t state = 0xcbf29ce484222325;
    for (std::size_t i = 0; i < len; i++) {
        state = (state ^ static_cast<const unsigned char *>(bytes)[i]) * 0x100000001b3;
    }
    std::printf("%s %016llx\n", what, static_cast<unsigned long long>(state));
}
static void print(const char *what, const std::vector<float> &floats) {
    print(what, floats.data(), 4 * floats.size());
}

static sinew::Model load(const char *path) {
    std::ifstream file(path, std::ios::binary);
    sinew::Model model;
    check(model.load({std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()}));
    return model;
}

static void face(const char *path) {
    const sinew::Model model = load(path);
    sinew::Prior prior;
    sinew::Skin skin;
    expect(prior.open(model, "nobody"), SINEW_STATUS_NOT_FOUND);
    check(prior.open(model));
    check(skin.open(model));
    std::printf("prior %s of %zu shapes\n", prior.name().c_str(), prior.info().shape_len);
    sinew_shape shape;
    check(skin.shape(1, shape));
    std::printf("shape %.*s\n", int(shape.name_len), shape.name);
    expect(skin.shape(prior.info().shape_len, shape), SINEW_STATUS_OUT_OF_RANGE);

    sinew::Face face(prior, skin);
    face.weights().assign(face.weights().size(), 0.25f);
    std::array<float, 3> place{};
    check(skin.place(2, {}, face.weights(), place));
    print("place", place.data(), sizeof place);
    const std::array<float, 3> target{place[0] + 0.125f, place[1], place[2]};
    const std::array<std::array<float, 4>, 2> screen{{{1, 0, 0, 0.5f}, {0, 1, 0.5f, 0}}};
    sinew_edit edit;
    const std::vector<sinew_pin> pins{sinew::pin(2, target),
                                      sinew::pin_on_screen(7, screen, {0.5f, 0.25f}, 2.0f)};
    check(face.run(face.job(), pins, {}, &edit));
    print("pinned", face.weights());
    std::printf("rounds %u, unreachable %u\n", edit.round_len, edit.unreachable_len);
    sinew_pin_job job = face.job();
    job.beta = 0.0f;
    expect(face.run(job, pins), SINEW_STATUS_OUT_OF_RANGE);
    expect(face.run(face.job(), std::vector<sinew_pin>(SINEW_PINS_MAX + 1, pins[0])),
           SINEW_STATUS_OUT_OF_RANGE);

    std::vector<float> positions(3 * skin.info().vertex_len);
    sinew_shapes_job shapes{};
    shapes.end = skin.info().vertex_len;
    shapes.positions = {positions.data(), positions.size(), 3};
    check(skin.run_shapes(shapes, face.weights()));
    print("shaped", positions);
    sinew_bounds bounds;
    check(skin.shaped_bounds({}, face.weights(), bounds));
    print("bounds", &bounds, sizeof bounds);
}

static void views(const char *path) {
    const sinew::Model model = load(path);
    sinew::Views views;
    check(views.open(model));
    sinew_map_info map;
    check(views.map(0, map));
    std::printf("views %s, map %.*s\n", views.name().c_str(), int(map.name_len), map.name);
    expect(views.map(views.info().map_len, map), SINEW_STATUS_OUT_OF_RANGE);

    const sinew_views_info &info = views.info();
    std::printf("screen %zu x %zu, layers %zu\n", info.width, info.height, info.layer_len);
    sinew::Figure figure(views);
    for (int step = 0; step < 8; step++) {
        check(figure.frame(0, std::vector<float>{0.25f * float(step) - 1.0f, 0.125f}));
        print("points", figure.points());
        print("layers", figure.layers());
        std::printf("view %zu, confidence %.6f\n", figure.found().view, figure.found().confidence);
    }
    expect(figure.frame(0, std::vector<float>(3)), SINEW_STATUS_LENGTH);
    std::vector<std::uint8_t> pixels(4 * info.width * info.height, 9);
    sinew_drawn drawn;
    check(figure.render(pixels, info.width, &drawn));
    print("picture", pixels.data(), pixels.size());
    std::printf("drawn %zu\n", drawn.element_len);
    expect(figure.render(pixels, info.width - 1), SINEW_STATUS_LENGTH);
}

static void filter(const char *path) {
    const sinew::Model model = load(path);
    sinew::Filter filter;
    expect(filter.open(model, "nobody"), SINEW_STATUS_NOT_FOUND);
    check(filter.open(model, "sensor"));
    const sinew_samples shape = {2, 7, 3};
    std::vector<float> samples(2 * 7 * 3);
    for (std::size_t i = 0; i < samples.size(); i++) {
        samples[i] = 0.25f * static_cast<float>(i % 5) - 0.5f;
    }
    std::vector<float> fine(filter.info().factor * samples.size());
    check(filter.apply(shape, samples, fine));
    print("fine", fine);
    expect(filter.apply({2, 4, 3}, samples, fine), SINEW_STATUS_TOO_SHORT);
}

int main(int, char **argv) {
    static_assert(!std::is_constructible_v<sinew::Face, sinew::Prior, const sinew::Skin &>);
    static_assert(!std::is_constructible_v<sinew::Face, const sinew::Prior &, sinew::Skin>);
    static_assert(std::is_constructible_v<sinew::Face, const sinew::Prior &, const sinew::Skin &>);
    static_assert(!std::is_constructible_v<sinew::Figure, sinew::Views>);
    face(argv[1]);
    views(argv[2]);
    filter(argv[3]);
    return 0;
}
