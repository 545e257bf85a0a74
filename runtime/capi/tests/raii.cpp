// What sinew.hpp promises of ownership, moves and failures.
//
//     raii MODEL
#include <sinew.hpp>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <type_traits>

static int failures = 0;

static void expect(bool held, const char *what)
{
    if (!held) {
        std::printf("%s\n", what);
        failures++;
    }
}
#define EXPECT(what) expect(what, #what)

/// Whether a model can borrow what is given so.
template <class Bytes>
constexpr auto can_borrow(int)
    -> decltype(std::declval<sinew::Model &>().borrow(std::declval<Bytes>()), bool())
{
    return true;
}
template <class> constexpr bool can_borrow(long)
{
    return false;
}

int main(int, char **argv)
{
    std::ifstream in(argv[1], std::ios::binary);
    const std::vector<std::uint8_t> file{std::istreambuf_iterator<char>(in), {}};

    sinew::Model model;
    sinew::Envelope envelope;
    EXPECT(envelope.open(model).status == SINEW_STATUS_NOT_LOADED);
    EXPECT(!model.load(file));
    EXPECT(!envelope.open(model, "golden"));
    EXPECT(envelope.name() == "golden");
    EXPECT(envelope.open(model, "nobody").status == SINEW_STATUS_NOT_FOUND);
    EXPECT(envelope.name() == "golden");

    // A failed load leaves the model as it was.
    const sinew::Failure failed = model.load({1, 2, 3, 4});
    EXPECT(failed.status == SINEW_STATUS_MAGIC);
    EXPECT(std::strcmp(failed.text(), sinew_status_text(failed.error.status)) == 0);
    EXPECT(!envelope.open(model));

    // A move takes the file along; a further load replaces it.
    sinew::Model moved(std::move(model));
    EXPECT(sinew::Envelope().open(model).status == SINEW_STATUS_NOT_LOADED);
    EXPECT(!envelope.open(moved));
    model = std::move(moved);
    EXPECT(sinew::Envelope().open(moved).status == SINEW_STATUS_NOT_LOADED);
    EXPECT(!model.load(file));
    sinew::Model &itself = model;
    model = std::move(itself);
    EXPECT(!envelope.open(model));
    EXPECT(model.load({}).status == SINEW_STATUS_MALFORMED);
    const sinew::Envelope copied = envelope;

    std::vector<sinew_matrix> pose(copied.info().joint_len);
    for (sinew_matrix &map : pose) {
        map = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    }
    sinew::Character character(copied);
    EXPECT(!character.pose_matrices(pose));
    EXPECT(character.confidence() == 1.0f);
    pose.back().rows[0][0] = NAN;
    const sinew::Failure not_finite = character.pose_matrices(pose);
    EXPECT(not_finite.status == SINEW_STATUS_NON_FINITE);
    EXPECT(not_finite.error.index == pose.size() - 1);
    EXPECT(std::strcmp(not_finite.subject(), "pose") == 0);
    EXPECT(character.confidence() == 1.0f);

    // Bytes that stay can be borrowed, others cannot; nor can an envelope that goes.
    static_assert(!std::is_constructible_v<sinew::Character, sinew::Envelope>);
    static_assert(std::is_constructible_v<sinew::Character, const sinew::Envelope &>);
    static_assert(!can_borrow<std::vector<std::uint8_t>>(0));
    static_assert(can_borrow<const std::vector<std::uint8_t> &>(0));
    sinew::Model borrowed;
    EXPECT(!borrowed.borrow(file));
    EXPECT(!sinew::Envelope().open(borrowed));
    std::printf("%d failures\n", failures);
    return failures != 0;
}
