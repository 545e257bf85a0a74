// Tests sinew.hpp: ownership, moves, hot reload and failures.
//
//     raii MODEL OTHER COMPLETE
//
// COMPLETE has a skin with tangents and tangent coefficients.
#include <sinew.hpp>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <type_traits>
#include <utility>

static int failures = 0;

static void expect(bool held, const char *what) {
    if (!held) {
        std::printf("%s\n", what);
        failures++;
    }
}
#define EXPECT(what) expect(what, #what)

/// Whether a model can borrow bytes of this type.
template <class Bytes> constexpr auto can_borrow(int)
    -> decltype(std::declval<sinew::Model &>().borrow(std::declval<Bytes>()), bool()) {
    return true;
}
template <class> constexpr bool can_borrow(long) { return false; }

/// Whether a part can be opened from a model of this type.
template <class Part, class Model> constexpr auto can_open(int)
    -> decltype(std::declval<Part &>().open(std::declval<Model>()), bool()) {
    return true;
}
template <class, class> constexpr bool can_open(long) { return false; }

static std::vector<std::uint8_t> read(const char *path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

static std::vector<sinew_matrix> rest(std::size_t joint_len) {
    return std::vector<sinew_matrix>(joint_len,
                                     sinew_matrix{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}});
}

/// A character of a scene: parts and arrays of a frame.
struct Actor {
    sinew::Envelope envelope;
    sinew::Skin skin;
    std::vector<sinew_matrix> pose, palette;
    std::vector<float> curves, scratch, positions;

    explicit Actor(const sinew::Model &model) {
        EXPECT(!envelope.open(model));
        EXPECT(!skin.open(model));
        pose = rest(envelope.info().joint_len);
        curves.resize(envelope.info().curve_len);
        palette.resize(envelope.info().palette_len);
        scratch.resize(envelope.info().scratch_len);
        positions.resize(3 * skin.info().vertex_len);
    }

    /// Makes every call of a frame and every call that reads the file. Returns whether each call
    /// gives this status, and whether each error names the expected argument: the part or its
    /// model.
    bool comes_to(sinew_status status, sinew_argument of_envelope, sinew_argument of_skin) {
        sinew_error error{};
        bool all = true;
        const auto came = [&](sinew_status found, sinew_argument argument) {
            all =
                all && found == status && (found == SINEW_STATUS_OK || error.argument == argument);
        };
        const std::size_t j = pose.size(), c = curves.size(), p = palette.size();
        const std::size_t v = skin.info().vertex_len;
        const sinew_envelope *e = envelope.get();
        const sinew_skin *s = skin.get();
        std::vector<sinew_local_transform> local(j, sinew_local_transform{{0, 0, 0, 1}, {0, 0, 0}});
        std::vector<sinew_matrix> out_pose(j);
        sinew_envelope_info info;
        sinew_joint joint;
        sinew_skin_info mesh;
        sinew_bounds bounds;
        float confidence;
        came(sinew_envelope_describe(e, &info, &error), of_envelope);
        came(sinew_envelope_joint(e, 0, &joint, &error), of_envelope);
        came(sinew_envelope_pose(e, local.data(), j, out_pose.data(), j, &error), of_envelope);
        came(sinew_envelope_palette(e, pose.data(), j, curves.data(), c, scratch.data(),
                                    scratch.size(), palette.data(), p, &confidence, &error),
             of_envelope);
        came(sinew_envelope_palettes(e, pose.data(), j, curves.data(), c, scratch.data(),
                                     scratch.size(), palette.data(), p, &confidence, 1, &error),
             of_envelope);
        came(sinew_skin_describe(s, &mesh, &error), of_skin);
        came(sinew_skin_attribute(s, SINEW_ATTRIBUTE_POSITION, 0, v, positions.data(), 3 * v,
                                  &error),
             of_skin);
        came(sinew_skin_bounds(s, palette.data(), p, 0.0f, &bounds, &error), of_skin);
        sinew_skin_job job{};
        job.skin = s;
        job.palette = palette.data();
        job.palette_len = p;
        job.end = v;
        job.positions = {positions.data(), positions.size(), 3};
        came(sinew_skin_run(&job, &error), of_skin);
        return all;
    }

    bool works() { return comes_to(SINEW_STATUS_OK, SINEW_ARGUMENT_CALL, SINEW_ARGUMENT_CALL); }
    bool is_stale() {
        return comes_to(SINEW_STATUS_STALE, SINEW_ARGUMENT_ENVELOPE, SINEW_ARGUMENT_SKIN);
    }
    bool has_lost_its_model() {
        return comes_to(SINEW_STATUS_NOT_LOADED, SINEW_ARGUMENT_MODEL, SINEW_ARGUMENT_MODEL);
    }
};

/// A scene keeps running while the file of its model is replaced. Every call refuses parts of the
/// old file. No call reads the old file, which the sanitizer would report.
static void hot_reload(const std::vector<std::uint8_t> &file,
                       const std::vector<std::uint8_t> &other) {
    sinew::Model model;
    EXPECT(!model.load(file));
    Actor actor(model);
    const Actor copied = actor;
    EXPECT(actor.works());

    EXPECT(model.load(std::vector<std::uint8_t>(64, 7)).status == SINEW_STATUS_FILE_NOT_A_MODEL);
    EXPECT(actor.works());
    EXPECT(!model.load(file)); // the same file at another address
    EXPECT(actor.works());

    EXPECT(!model.load(other));
    EXPECT(actor.is_stale());
    Actor again(model);
    EXPECT(again.works());
    const std::string name = actor.envelope.name();
    EXPECT(!name.empty() && actor.envelope.info().name == nullptr);

    sinew::Model fresh;
    EXPECT(!fresh.load(file));
    model = std::move(fresh);
    EXPECT(again.is_stale());
    EXPECT(actor.works()); // the model has its file again
    Actor late = copied;
    EXPECT(late.works());

    Actor of_fresh(model);
    sinew::Model moved(std::move(model));
    EXPECT(of_fresh.has_lost_its_model());
    EXPECT(again.has_lost_its_model());
    EXPECT(Actor(moved).works());
    sinew::Character character(of_fresh.envelope);
    EXPECT(character.pose_matrices(of_fresh.pose).status == SINEW_STATUS_NOT_LOADED);
    EXPECT(!model.load(other));
    EXPECT(character.pose_matrices(of_fresh.pose).status == SINEW_STATUS_STALE);
    sinew_bounds bounds;
    EXPECT(of_fresh.skin.bounds(of_fresh.palette, bounds).status == SINEW_STATUS_STALE);
    EXPECT(of_fresh.skin.run({}, of_fresh.palette).status == SINEW_STATUS_STALE);
}

/// Copies every attribute of a skin that has all of them.
static void attributes(const std::vector<std::uint8_t> &file) {
    sinew::Model model;
    sinew::Skin skin;
    EXPECT(!model.borrow(file));
    EXPECT(!skin.open(model));
    const std::size_t v = skin.info().vertex_len, k = skin.info().influence_len;
    for (const auto &[attribute, float_len] :
         {std::pair{SINEW_ATTRIBUTE_POSITION, 3 * v},
          {SINEW_ATTRIBUTE_NORMAL, 3 * v},
          {SINEW_ATTRIBUTE_TANGENT, 4 * v},
          {SINEW_ATTRIBUTE_TANGENT_COEFFICIENTS, 2 * (k - 1) * v}}) {
        std::vector<float> floats, expected(float_len, NAN);
        EXPECT(!sinew_skin_attribute(skin.get(), attribute, 0, v, expected.data(), float_len,
                                     nullptr));
        EXPECT(!skin.attribute(attribute, floats));
        EXPECT(!floats.empty() && floats == expected);
    }
}

int main(int, char **argv) {
    const std::vector<std::uint8_t> file = read(argv[1]), other = read(argv[2]);

    sinew::Model model;
    sinew::Envelope envelope;
    sinew::Skin skin;
    EXPECT(envelope.open(model).status == SINEW_STATUS_NOT_LOADED);
    EXPECT(skin.open(model).status == SINEW_STATUS_NOT_LOADED);
    EXPECT(!model.load(file));
    sinew_model_info info{};
    EXPECT(!model.describe(info));
    EXPECT(info.envelope_len > 0 && info.skin_len > 0);
    EXPECT(!envelope.open(model));
    const std::string name = envelope.name();
    EXPECT(!envelope.open(model, name));
    EXPECT(envelope.name() == name);
    EXPECT(envelope.open(model, "nobody").status == SINEW_STATUS_NOT_FOUND);
    EXPECT(envelope.open(model, {}, info.envelope_len).status == SINEW_STATUS_NOT_FOUND);
    EXPECT(envelope.name() == name);
    EXPECT(!skin.open(model));
    EXPECT(!skin.open(model, std::string(skin.name())));
    EXPECT(skin.open(model, {}, info.skin_len).status == SINEW_STATUS_NOT_FOUND);

    // A failed load does not change the model.
    const sinew::Failure failed = model.load(std::vector<std::uint8_t>(64, 7));
    EXPECT(failed.status == SINEW_STATUS_FILE_NOT_A_MODEL);
    EXPECT(failed.text().find(sinew_status_text(failed.error.status)) != std::string::npos);
    EXPECT(!envelope.open(model));

    // A move takes the file along; the next load replaces the file.
    sinew::Model moved(std::move(model));
    EXPECT(sinew::Envelope().open(model).status == SINEW_STATUS_NOT_LOADED);
    EXPECT(!envelope.open(moved));
    model = std::move(moved);
    EXPECT(sinew::Envelope().open(moved).status == SINEW_STATUS_NOT_LOADED);
    EXPECT(!model.load(file));
    sinew::Model &itself = model;
    model = std::move(itself);
    EXPECT(!envelope.open(model));
    EXPECT(model.load({}).status == SINEW_STATUS_FILE_TRUNCATED);
    const sinew::Envelope copied = envelope;

    std::vector<sinew_matrix> pose = rest(copied.info().joint_len);
    sinew::Character character(copied);
    std::vector<sinew_bone> bones;
    EXPECT(!character.bones(bones) && bones.size() == copied.info().proxy_len);
    EXPECT(bones[0].scale[0] == 1.0f && bones[0].translation[0] == bones[0].centre[0]);
    EXPECT(!character.pose_matrices(pose));
    EXPECT(character.confidence() == 1.0f);

    // A pose of another length is refused, and the next pose is a pose again.
    std::vector<sinew_local_transform> local;
    EXPECT(!copied.rest_locals(local));
    const std::vector<sinew_matrix> short_pose(pose.begin() + 1, pose.end());
    EXPECT(character.pose_matrices(short_pose).status == SINEW_STATUS_LENGTH);
    EXPECT(character.pose_far(short_pose).status == SINEW_STATUS_LENGTH);
    EXPECT(character.pose_scaled(short_pose).status == SINEW_STATUS_LENGTH);
    EXPECT(!character.pose(local));
    pose.back().rows[0][0] = NAN;
    const sinew::Failure not_finite = character.pose_matrices(pose);
    EXPECT(not_finite.status == SINEW_STATUS_NON_FINITE);
    EXPECT(not_finite.error.index == pose.size() - 1);
    EXPECT(not_finite.text() ==
           "pose: a transform or a number is not finite, index " + std::to_string(pose.size() - 1));
    EXPECT(character.pose().size() == pose.size());
    EXPECT(character.confidence() == 1.0f);
    pose.back().rows[0][0] = 1.0f;
    const std::size_t curve_len = copied.info().curve_len;
    const sinew::Failure too_many = character.pose_far(pose, std::vector<float>(curve_len + 1));
    EXPECT(too_many.status == SINEW_STATUS_LENGTH);
    EXPECT(too_many.error.argument == SINEW_ARGUMENT_CURVES);
    pose.back().rows[2][3] += 1.0f;
    EXPECT(!character.pose_far(pose, std::vector<float>(curve_len)));
    EXPECT(character.pose().back().rows[2][3] == pose.back().rows[2][3]);

    std::vector<float> floats;
    EXPECT(!skin.attribute(SINEW_ATTRIBUTE_POSITION, floats));
    EXPECT(skin.attribute(SINEW_ATTRIBUTE_TANGENT_COEFFICIENTS, floats).status ==
           SINEW_STATUS_NO_ATTRIBUTE);
    EXPECT(skin.attribute(sinew_attribute(5), floats).status == SINEW_STATUS_OUT_OF_RANGE);
    attributes(read(argv[3]));

    // A skeleton whose names have a prefix.
    std::vector<std::string> prefixed;
    for (std::size_t joint = 0; joint < copied.info().joint_len; joint++) {
        sinew_joint own;
        sinew_error error;
        EXPECT(sinew_envelope_joint(copied.get(), joint, &own, &error) == SINEW_STATUS_OK);
        prefixed.push_back("rig:" + std::string(own.name, own.name_len));
    }
    std::vector<sinew_name> names;
    for (const std::string &own : prefixed) {
        names.push_back({own.data(), own.size()});
    }
    std::vector<std::uint32_t> joints;
    sinew_bound_joints bound{};
    EXPECT(copied.bind(names, joints, bound).status == SINEW_STATUS_OTHER_NAME);
    EXPECT(!copied.bind(
        names, [](auto own) { return own.substr(own.rfind(':') + 1); }, joints, bound));
    EXPECT(bound.found_len == prefixed.size() && joints[0] == 0);
    sinew_curve curve;
    EXPECT(copied.curve(curve_len, curve).status == SINEW_STATUS_OUT_OF_RANGE);
    std::vector<std::uint32_t> map;
    const sinew_status unbound = curve_len == 0 ? SINEW_STATUS_OK : SINEW_STATUS_NO_CURVE;
    EXPECT(copied.bind_curves({}, map).status == unbound);
    EXPECT(map.size() == curve_len);

    // A temporary vector of bytes cannot be borrowed, and no part can point to a temporary envelope
    // or model.
    static_assert(!std::is_constructible_v<sinew::Character, sinew::Envelope>);
    static_assert(std::is_constructible_v<sinew::Character, const sinew::Envelope &>);
    static_assert(!can_borrow<std::vector<std::uint8_t>>(0));
    static_assert(can_borrow<const std::vector<std::uint8_t> &>(0));
    static_assert(!can_open<sinew::Envelope, sinew::Model>(0));
    static_assert(can_open<sinew::Envelope, const sinew::Model &>(0));
    static_assert(!can_open<sinew::Skin, sinew::Model>(0));
    static_assert(can_open<sinew::Skin, const sinew::Model &>(0));
    sinew::Model borrowed;
    EXPECT(!borrowed.borrow(file));
    EXPECT(!sinew::Envelope().open(borrowed));

    hot_reload(file, other);
    std::printf("%d failures\n", failures);
    return failures != 0;
}
