/// C++17 wrapper of sinew.h: owns objects, and returns failures without exceptions. For all other
/// functions of sinew.h, `get()` returns the handle. A vector that receives a result is resized even
/// if the call fails.
#ifndef SINEW_HPP
#define SINEW_HPP

#include "sinew.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace sinew {

/// Result of a call: `if (auto failed = model.load(file)) { report(failed.text()); }`.
///
/// `text()` names the argument, the mistake, and the index, the expected and the found value of the
/// status.
struct [[nodiscard]] Failure {
    sinew_error error{SINEW_STATUS_OK, SINEW_ARGUMENT_CALL, SINEW_NO_PART, 0, 0, 0, 0};
    sinew_status status = SINEW_STATUS_OK;

    explicit operator bool() const { return status != SINEW_STATUS_OK; }
    std::string text() const {
        std::string text(sinew_error_text(&error, nullptr, 0), '\0');
        sinew_error_text(&error, text.data(), text.size() + 1);
        return text;
    }
};

/// A pointer and a length; converts from any container with `data()` and `size()`.
template <class T> struct Span {
    T *data = nullptr;
    std::size_t len = 0;

    Span() = default;
    Span(T *at, std::size_t count) : data(at), len(count) {}
    template <class C, class = decltype(std::declval<C &>().data())> Span(C &&container)
        : data(container.data()), len(container.size()) {}
};

/// A loaded file. The model owns the file's bytes, or points to bytes that stay (flash, a mapped
/// file).
///
/// Parts point to their model and must not outlive it. A load, an assignment, or a move from the
/// model makes its parts stale: every call refuses them until they are opened again. A hot reload
/// takes nothing else. No thread may use a model while its content is replaced.
class Model {
  public:
    Model() = default;
    /// Moves; the other model is then not loaded.
    Model(Model &&other) noexcept
        : memory_(std::exchange(other.memory_, {})), file_(std::move(other.file_)) {}
    Model &operator=(Model &&other) noexcept {
        if (this != &other) {
            memory_ = std::exchange(other.memory_, {});
            file_ = std::move(other.file_);
        }
        return *this;
    }

    /// Loads a file and owns its bytes. On failure the model is unchanged.
    Failure load(std::vector<std::uint8_t> file, const sinew_limits *limits = nullptr) {
        Failure failure = borrow(file, limits);
        if (!failure) {
            file_ = std::move(file);
        }
        return failure;
    }

    /// Loads a file without owning it: the bytes must outlive the model unchanged. A temporary does
    /// not compile.
    Failure borrow(std::vector<std::uint8_t> &&, const sinew_limits * = nullptr) = delete;
    Failure borrow(Span<const std::uint8_t> file, const sinew_limits *limits = nullptr) {
        Failure failure;
        const sinew_model *handle;
        failure.status = sinew_model_load(memory_.data(), sizeof memory_, file.data, file.len,
                                          limits, &handle, &failure.error);
        return failure;
    }

    /// Describes the contents of the file and its space.
    Failure describe(sinew_model_info &out) const {
        Failure failure;
        failure.status = sinew_model_describe(get(), &out, &failure.error);
        return failure;
    }

    /// Returns the handle. Every call refuses the handle of a model that is not loaded.
    const sinew_model *get() const { return reinterpret_cast<const sinew_model *>(memory_.data()); }

  private:
    std::array<std::uintptr_t, SINEW_MODEL_WORDS> memory_{};
    std::vector<std::uint8_t> file_;
};

/// Base of the parts of a model: memory, name and description. `name()` is a copy and `info()` has
/// no name, so that neither points into a file that was replaced.
template <class Handle, class Info> class Part {
  public:
    const Handle *get() const { return reinterpret_cast<const Handle *>(memory_.data()); }
    const Info &info() const { return info_; }
    const std::string &name() const { return name_; }

  protected:
    template <class Describe> Failure open_as(sinew_part_kind kind, Describe describe,
                                              const Model &model, std::string_view name,
                                              std::size_t index) {
        Failure failure;
        failure.status =
            sinew_part_open(model.get(), kind, name.empty() ? nullptr : name.data(), name.size(),
                            index, memory_.data(), sizeof memory_, &failure.error);
        if (!failure) {
            failure.status = describe(get(), &info_, &failure.error);
        }
        if (!failure) {
            name_.assign(info_.name, info_.name_len);
            info_.name = nullptr;
            info_.name_len = 0;
        }
        return failure;
    }

  private:
    std::array<std::uintptr_t, SINEW_PART_WORDS> memory_{};
    Info info_{};
    std::string name_;
};

/// Predicts palettes from poses. Points to its model.
class Envelope : public Part<sinew_envelope, sinew_envelope_info> {
  public:
    /// Opens the `index`-th envelope with this name, or the `index`-th of all. On failure the
    /// envelope is unchanged.
    Failure open(const Model &&, std::string_view = {}, std::size_t = 0) = delete;
    Failure open(const Model &model, std::string_view name = {}, std::size_t index = 0) {
        return open_as(SINEW_PART_KIND_ENVELOPE, sinew_envelope_describe, model, name, index);
    }

    /// Copies the joints' rest frames, each relative to its parent. An animation starts from these
    /// frames.
    Failure rest_locals(std::vector<sinew_local_transform> &out) const {
        Failure failure;
        out.resize(info().joint_len);
        failure.status = sinew_envelope_rest_locals(get(), out.data(), out.size(), &failure.error);
        return failure;
    }

    /// Finds the file's joints in a skeleton by name; `out_bound` receives how many were found.
    Failure bind(Span<const sinew_name> names, std::vector<std::uint32_t> &out_map,
                 sinew_bound_joints &out_bound) const {
        return bind(
            names, [](std::string_view name) { return name; }, out_map, out_bound);
    }

    /// Finds the file's joints after `rename` has changed each name. It takes and returns a
    /// `std::string_view`. `[](auto name) { return name.substr(name.rfind(':') + 1); }` removes the
    /// prefix of `mixamorig:Hips`.
    template <class Rename> Failure bind(Span<const sinew_name> names, Rename rename,
                                         std::vector<std::uint32_t> &out_map,
                                         sinew_bound_joints &out_bound) const {
        using Renamed = std::invoke_result_t<Rename &, std::string_view>;
        static_assert(std::is_same_v<Renamed, std::string_view>,
                      "rename returns a std::string_view of memory that outlives the call");
        Failure failure;
        out_map.resize(info().joint_len);
        sinew_rename call = [](sinew_name name, void *user) -> sinew_name {
            const std::string_view own{name.name, name.name_len};
            const std::string_view found = (*static_cast<Rename *>(user))(own);
            return {found.data(), found.size()};
        };
        failure.status =
            sinew_envelope_bind(get(), names.data, names.len, call, &rename, out_map.data(),
                                out_map.size(), &out_bound, &failure.error);
        return failure;
    }

    /// Describes a curve. Its name is in the model's file.
    Failure curve(std::size_t index, sinew_curve &out) const {
        Failure failure;
        failure.status = sinew_envelope_curve(get(), index, &out, &failure.error);
        return failure;
    }

    /// Finds the file's curves among the caller's by name: `curves[c] = values[out_map[c]]`.
    Failure bind_curves(Span<const sinew_name> names, std::vector<std::uint32_t> &out_map) const {
        Failure failure;
        out_map.resize(info().curve_len);
        failure.status = sinew_envelope_bind_curves(get(), names.data, names.len, out_map.data(),
                                                    out_map.size(), &failure.error);
        return failure;
    }

    /// Gathers the skinning matrices of a pose from a skeleton's frames; `root` may be null.
    Failure gather(Span<const std::uint32_t> map, Span<const sinew_matrix> world,
                   const sinew_matrix *root, std::vector<sinew_matrix> &out_pose) const {
        Failure failure;
        out_pose.resize(info().joint_len);
        failure.status =
            sinew_envelope_gather(get(), map.data, map.len, world.data, world.len, root,
                                  out_pose.data(), out_pose.size(), &failure.error);
        return failure;
    }

    /// Checks that a pose fits the skeleton. `out` receives the likely mistake, which is not a
    /// failure.
    Failure check_pose(Span<const sinew_matrix> pose, sinew_pose_fault &out,
                       Span<const float> curves = {}) const {
        Failure failure;
        failure.status = sinew_envelope_check_pose(get(), pose.data, pose.len, curves.data,
                                                   curves.len, &out, &failure.error);
        return failure;
    }
};

/// A mesh that follows a palette. Points to its model.
class Skin : public Part<sinew_skin, sinew_skin_info> {
  public:
    /// Opens the `index`-th skin with this name, or the `index`-th of all. On failure the skin is
    /// unchanged.
    Failure open(const Model &&, std::string_view = {}, std::size_t = 0) = delete;
    Failure open(const Model &model, std::string_view name = {}, std::size_t index = 0) {
        return open_as(SINEW_PART_KIND_SKIN, sinew_skin_describe, model, name, index);
    }

    /// Makes the job of all vertices, without outputs.
    sinew_skin_job job() const {
        sinew_skin_job job{};
        job.end = info().vertex_len;
        return job;
    }

    /// Copies an attribute of all vertices, packed.
    Failure attribute(sinew_attribute attribute, std::vector<float> &out) const {
        Failure failure;
        std::size_t float_len = 3;
        if (attribute == SINEW_ATTRIBUTE_TANGENT) {
            float_len = 4;
        } else if (attribute == SINEW_ATTRIBUTE_TANGENT_COEFFICIENTS) {
            float_len = info().influence_len > 0 ? 2 * (info().influence_len - 1) : 0;
        }
        out.resize(float_len * info().vertex_len);
        failure.status = sinew_skin_attribute(get(), attribute, 0, info().vertex_len, out.data(),
                                              out.size(), &failure.error);
        return failure;
    }

    /// Runs a job; this call fills in the skin and the palette.
    Failure run(sinew_skin_job job, Span<const sinew_matrix> palette) const {
        Failure failure;
        job.skin = get();
        job.palette = palette.data;
        job.palette_len = palette.len;
        failure.status = sinew_skin_run(&job, &failure.error);
        return failure;
    }

    /// Describes a shape. Its name is in the model's file.
    Failure shape(std::size_t index, sinew_shape &out) const {
        Failure failure;
        failure.status = sinew_skin_shape(get(), index, &out, &failure.error);
        return failure;
    }

    /// Runs a shapes job; this call fills in the skin and the weights.
    Failure run_shapes(sinew_shapes_job job, Span<const float> weights) const {
        Failure failure;
        job.skin = get();
        job.weights = weights.data;
        job.weights_len = weights.len;
        failure.status = sinew_shapes_run(&job, &failure.error);
        return failure;
    }

    /// Computes a box that contains the shaped and posed skin.
    Failure shaped_bounds(Span<const sinew_matrix> palette, Span<const float> weights,
                          sinew_bounds &out) const {
        Failure failure;
        failure.status = sinew_shapes_bounds(get(), palette.data, palette.len, weights.data,
                                             weights.len, &out, &failure.error);
        return failure;
    }

    /// Computes the position of a vertex of the shaped and posed skin. A pin with this target holds
    /// the vertex in place.
    Failure place(std::uint32_t vertex, Span<const sinew_matrix> palette, Span<const float> weights,
                  std::array<float, 3> &out) const {
        Failure failure;
        float at[3];
        failure.status = sinew_skin_place(get(), vertex, palette.data, palette.len, weights.data,
                                          weights.len, &at, &failure.error);
        if (!failure) {
            out = {at[0], at[1], at[2]};
        }
        return failure;
    }

    /// Computes a box that contains the posed skin. `rest_offset` is the rest mesh's largest
    /// distance from the file's along an axis.
    Failure bounds(Span<const sinew_matrix> palette, sinew_bounds &out,
                   float rest_offset = 0.0f) const {
        Failure failure;
        failure.status =
            sinew_skin_bounds(get(), palette.data, palette.len, rest_offset, &out, &failure.error);
        return failure;
    }
};

/// A function from named inputs to named outputs. Points to its model.
class Kernel : public Part<sinew_kernel, sinew_kernel_info> {
  public:
    /// Opens the `index`-th kernel with this name, or the `index`-th of all. On failure the kernel
    /// is unchanged.
    Failure open(const Model &&, std::string_view = {}, std::size_t = 0) = delete;
    Failure open(const Model &model, std::string_view name = {}, std::size_t index = 0) {
        return open_as(SINEW_PART_KIND_KERNEL, sinew_kernel_describe, model, name, index);
    }

    /// Computes the outputs of a query, in scratch of `info().scratch_len` floats.
    Failure evaluate(Span<const float> query, Span<float> scratch, Span<float> out,
                     float *confidence = nullptr) const {
        Failure failure;
        failure.status =
            sinew_kernel_evaluate(get(), query.data, query.len, scratch.data, scratch.len, out.data,
                                  out.len, confidence, &failure.error);
        return failure;
    }
};

/// Covariance of the weights of a skin's shapes. Points to its model.
class Prior : public Part<sinew_prior, sinew_prior_info> {
  public:
    /// Opens the `index`-th prior with this name, or the `index`-th of all. On failure the prior is
    /// unchanged.
    Failure open(const Model &&, std::string_view = {}, std::size_t = 0) = delete;
    Failure open(const Model &model, std::string_view name = {}, std::size_t index = 0) {
        return open_as(SINEW_PART_KIND_PRIOR, sinew_prior_describe, model, name, index);
    }
};

/// Makes a pin with a target position in model space.
inline sinew_pin pin(std::uint32_t vertex, const std::array<float, 3> &target,
                     float stiffness = 1.0f) {
    return {vertex,
            {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}},
            {target[0], target[1], target[2]},
            stiffness};
}

/// Makes a pin with a target on a screen. `projection` maps positions to the screen without a
/// division.
inline sinew_pin pin_on_screen(std::uint32_t vertex,
                               const std::array<std::array<float, 4>, 2> &projection,
                               const std::array<float, 2> &target, float stiffness = 1.0f) {
    const auto &[x, y] = projection;
    return {vertex,
            {{x[0], x[1], x[2], x[3]}, {y[0], y[1], y[2], y[3]}, {0, 0, 0, 0}},
            {target[0], target[1], 0},
            stiffness};
}

/// Weights that upsample a signal. Points to its model.
class Filter : public Part<sinew_filter, sinew_filter_info> {
  public:
    /// Opens the `index`-th filter with this name, or the `index`-th of all. On failure the filter
    /// is unchanged.
    Failure open(const Model &&, std::string_view = {}, std::size_t = 0) = delete;
    Failure open(const Model &model, std::string_view name = {}, std::size_t index = 0) {
        return open_as(SINEW_PART_KIND_FILTER, sinew_filter_describe, model, name, index);
    }

    /// Upsamples by `info().factor`; `out` has `info().factor` times the length of `samples`.
    Failure apply(const sinew_samples &shape, Span<const float> samples, Span<float> out) const {
        Failure failure;
        failure.status = sinew_filter_apply(get(), &shape, samples.data, samples.len, out.data,
                                            out.len, &failure.error);
        return failure;
    }
};

/// Views of a drawn object. Points to its model.
class Views : public Part<sinew_views, sinew_views_info> {
  public:
    /// Opens the `index`-th views with this name, or the `index`-th of all. On failure the views
    /// are unchanged.
    Failure open(const Model &&, std::string_view = {}, std::size_t = 0) = delete;
    Failure open(const Model &model, std::string_view name = {}, std::size_t index = 0) {
        return open_as(SINEW_PART_KIND_VIEWS, sinew_views_describe, model, name, index);
    }

    /// Describes a map. Its name is in the model's file.
    Failure map(std::size_t index, sinew_map_info &out) const {
        Failure failure;
        failure.status = sinew_views_map(get(), index, &out, &failure.error);
        return failure;
    }
};

/// One character: scratch, palette and confidence. For one thread at a time. Points to the
/// envelope, which must stay in place. After the envelope is opened again, make a new character.
///
/// A pose has `info().curve_len` curves; a model without curves needs none.
class Character {
  public:
    explicit Character(const Envelope &&) = delete;
    explicit Character(const Envelope &envelope)
        : envelope_(&envelope), scratch_(envelope.info().scratch_len),
          pose_(envelope.info().joint_len, IDENTITY),
          palette_(envelope.info().palette_len, IDENTITY) {}

    /// Computes the pose of local transforms, and its palette.
    Failure pose(Span<const sinew_local_transform> local, Span<const float> curves = {}) {
        Failure failure;
        failure.status = sinew_envelope_pose(envelope_->get(), local.data, local.len, pose_.data(),
                                             pose_.size(), &failure.error);
        return failure ? failure : palette_of(sinew_envelope_palette, pose_, curves);
    }

    /// Computes the palette of skinning matrices: rest to posed, in model space.
    Failure pose_matrices(Span<const sinew_matrix> pose, Span<const float> curves = {}) {
        return palette_of(sinew_envelope_palette, kept(pose), curves);
    }

    /// Computes the base of the palette, for a character that is far away.
    Failure pose_far(Span<const sinew_matrix> pose, Span<const float> curves = {}) {
        return palette_of(sinew_envelope_base_palette, kept(pose), curves);
    }

    /// Computes the palette of a pose whose joints share one scale, for example that of a scaled
    /// actor. `pose()` then returns the pose without the scale.
    Failure pose_scaled(Span<const sinew_matrix> pose, Span<const float> curves = {}) {
        Failure failure;
        float scale = 1.0f;
        const Span<const sinew_matrix> own = kept(pose);
        if (own.data == pose_.data()) {
            failure.status =
                sinew_pose_take_scale(pose_.data(), pose_.size(), &scale, &failure.error);
        }
        if (!failure) {
            failure = palette_of(sinew_envelope_palette, own, curves);
        }
        if (!failure) {
            failure.status =
                sinew_palette_scale(palette_.data(), palette_.size(), scale, &failure.error);
        }
        return failure;
    }

    /// Computes the confidence of each joint in a pose of skinning matrices, from the maps of its
    /// skin and its trained range.
    Failure joint_confidences(Span<const sinew_matrix> pose, std::vector<float> &out,
                              Span<const float> curves = {}) {
        Failure failure;
        out.resize(envelope_->info().joint_len);
        failure.status = sinew_envelope_joint_confidences(
            envelope_->get(), pose.data, pose.len, curves.data, curves.len, scratch_.data(),
            scratch_.size(), out.data(), out.size(), &failure.error);
        return failure;
    }

    /// Splits the helpers of the palette into bones of translation, rotation and scale, for an
    /// engine that skins by its own bones.
    Failure bones(std::vector<sinew_bone> &out) const {
        Failure failure;
        out.resize(envelope_->info().proxy_len);
        failure.status = sinew_envelope_bones(envelope_->get(), palette_.data(), palette_.size(),
                                              out.data(), out.size(), &failure.error);
        return failure;
    }

    /// Returns the pose of the last call, for example for `Envelope::check_pose`. Pose and palette
    /// are identities before the first call.
    const std::vector<sinew_matrix> &pose() const { return pose_; }
    const std::vector<sinew_matrix> &palette() const { return palette_; }
    float confidence() const { return confidence_; }

  private:
    static constexpr sinew_matrix IDENTITY{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};

    /// Keeps a pose. Returns it unkept if it has another length, for the call to refuse.
    Span<const sinew_matrix> kept(Span<const sinew_matrix> pose) {
        if (pose.len != pose_.size()) {
            return pose;
        }
        std::copy_n(pose.data, pose.len, pose_.data());
        return pose_;
    }

    Failure palette_of(decltype(sinew_envelope_palette) compute, Span<const sinew_matrix> pose,
                       Span<const float> curves) {
        Failure failure;
        failure.status = compute(envelope_->get(), pose.data, pose.len, curves.data, curves.len,
                                 scratch_.data(), scratch_.size(), palette_.data(),
                                 palette_.size(), &confidence_, &failure.error);
        return failure;
    }

    const Envelope *envelope_;
    std::vector<float> scratch_;
    std::vector<sinew_matrix> pose_, palette_;
    float confidence_ = 0.0f;
};

/// One face: the weights of its shapes, and the scratch of their solve, which a drag reuses. For
/// one thread at a time. Points to the prior and the skin, which must stay in place. After either
/// is opened again, make a new face.
class Face {
  public:
    explicit Face(const Prior &&, const Skin &) = delete;
    explicit Face(const Prior &, const Skin &&) = delete;
    explicit Face(const Prior &prior, const Skin &skin)
        : prior_(&prior), skin_(&skin), weights_(prior.info().shape_len) {}

    /// Makes the job of an artist's edit: from the current weights, within the bounds, without
    /// symmetry and temporal terms.
    sinew_pin_job job() const {
        sinew_pin_job job{};
        job.is_bounded = 1;
        job.beta = prior_->info().beta;
        return job;
    }

    /// Runs a job; this call fills in the prior, the skin, the palette, the pins, scratch and
    /// weights.
    Failure run(sinew_pin_job job, Span<const sinew_pin> pins,
                Span<const sinew_matrix> palette = {}, sinew_edit *edit = nullptr) {
        Failure failure;
        const sinew_prior_info &info = prior_->info();
        const std::size_t least = info.scratch_len + 3 * pins.len * info.scratch_len_each;
        if (pins.len <= SINEW_PINS_MAX && scratch_.size() < least) {
            scratch_.resize(least);
        }
        job.prior = prior_->get();
        job.skin = skin_->get();
        job.palette = palette.data;
        job.palette_len = palette.len;
        job.pins = pins.data;
        job.pins_len = pins.len;
        job.scratch = scratch_.data();
        job.scratch_len = scratch_.size();
        job.weights = weights_.data();
        job.weights_len = weights_.size();
        failure.status = sinew_pins_solve(&job, edit, &failure.error);
        return failure;
    }

    std::vector<float> &weights() { return weights_; }
    const std::vector<float> &weights() const { return weights_; }

  private:
    const Prior *prior_;
    const Skin *skin_;
    std::vector<double> scratch_;
    std::vector<float> weights_;
};

/// One drawn object: points, visibilities, scores of key views, and layers. For one thread at a
/// time. Points to the views, which must stay in place. After the views are opened again, make a
/// new figure.
class Figure {
  public:
    explicit Figure(const Views &&) = delete;
    explicit Figure(const Views &views)
        : views_(&views), points_(3 * views.info().point_len), visibility_(views.info().point_len),
          scores_(views.info().view_len), layers_(2 * views.info().layer_len),
          vertices_(3 * views.info().vertex_len), order_(views.info().order_len) {
        for (std::size_t index = 0; index < views.info().map_len; index++) {
            sinew_map_info map;
            if (!views.map(index, map) && scratch_.size() < map.scratch_len) {
                scratch_.resize(map.scratch_len);
            }
        }
    }

    /// Evaluates a map.
    Failure frame(std::size_t map, Span<const float> parameters) {
        Failure failure;
        sinew_frame_job job{};
        job.views = views_->get();
        job.map = map;
        job.parameters = parameters.data;
        job.parameters_len = parameters.len;
        job.scratch = scratch_.data();
        job.scratch_len = scratch_.size();
        job.points = reinterpret_cast<float(*)[3]>(points_.data());
        job.points_len = visibility_.size();
        job.visibility = visibility_.data();
        job.visibility_len = visibility_.size();
        job.scores = scores_.data();
        job.scores_len = scores_.size();
        job.layers = reinterpret_cast<float(*)[2]>(layers_.data());
        job.layers_len = layers_.size() / 2;
        failure.status = sinew_views_frame(&job, &found_, &failure.error);
        return failure;
    }

    /// Draws the last frame over RGBA8 pixels, premultiplied by alpha. A larger picture than before
    /// allocates scratch, if the object needs scratch per pixel.
    Failure render(Span<std::uint8_t> pixels, std::size_t width, sinew_drawn *drawn = nullptr) {
        Failure failure;
        const std::size_t pixel_len = pixels.len / 4;
        if (views_->info().has_depth && depths_.size() < pixel_len) {
            depths_.resize(pixel_len);
        }
        if (views_->info().has_groups && group_.size() < 4 * pixel_len) {
            group_.resize(4 * pixel_len);
        }
        if (views_->info().has_clips && clips_.size() < pixel_len) {
            clips_.resize(pixel_len);
        }
        sinew_render_job job{};
        job.views = views_->get();
        job.points = reinterpret_cast<const float(*)[3]>(points_.data());
        job.points_len = visibility_.size();
        job.visibility = visibility_.data();
        job.visibility_len = visibility_.size();
        job.scores = scores_.data();
        job.scores_len = scores_.size();
        job.layers = reinterpret_cast<const float(*)[2]>(layers_.data());
        job.layers_len = layers_.size() / 2;
        job.width = width;
        job.pixels = reinterpret_cast<std::uint8_t(*)[4]>(pixels.data);
        job.pixels_len = pixel_len;
        job.vertices = reinterpret_cast<float(*)[3]>(vertices_.data());
        job.vertices_len = vertices_.size() / 3;
        job.order = order_.data();
        job.order_len = order_.size();
        job.depths = depths_.data();
        job.depths_len = depths_.size();
        job.group = reinterpret_cast<std::uint8_t(*)[4]>(group_.data());
        job.group_len = group_.size() / 4;
        job.clips = clips_.data();
        job.clips_len = clips_.size();
        failure.status = sinew_views_render(&job, drawn, &failure.error);
        return failure;
    }

    /// Three numbers per point: x to the right and y down, in pixels, and depth.
    const std::vector<float> &points() const { return points_; }
    const std::vector<float> &visibility() const { return visibility_; }
    const std::vector<float> &scores() const { return scores_; }
    /// Two numbers per layer: opacity and order.
    const std::vector<float> &layers() const { return layers_; }
    const sinew_found &found() const { return found_; }

  private:
    const Views *views_;
    std::vector<float> points_, visibility_, scores_, layers_, scratch_, vertices_, depths_;
    std::vector<std::uint16_t> order_;
    std::vector<std::uint8_t> group_, clips_;
    sinew_found found_{};
};

} // namespace sinew

#endif
