/// Sinew in C++17: who owns what, and results without exceptions. Everything else is in sinew.h,
/// whose functions take what `get()` returns.
#ifndef SINEW_HPP
#define SINEW_HPP

#include "sinew.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sinew {

/// What a call came to: `if (auto failed = model.load(file)) { report(failed.text()); }`.
struct [[nodiscard]] Failure {
    sinew_error error{SINEW_STATUS_OK, SINEW_ARGUMENT_CALL, SINEW_NO_PART, 0, 0, 0, 0};
    sinew_status status = SINEW_STATUS_OK;

    explicit operator bool() const { return status != SINEW_STATUS_OK; }
    const char *text() const { return sinew_status_text(status); }
    const char *argument() const { return sinew_argument_text(error.argument); }
};

/// A pointer and a length; made of anything that has `data()` and `size()`.
template <class T> struct Span {
    T *data = nullptr;
    std::size_t len = 0;

    Span() = default;
    Span(T *at, std::size_t count) : data(at), len(count) {}
    template <class C, class = decltype(std::declval<C &>().data())>
    Span(C &&container) : data(container.data()), len(container.size()) {}
};

/// A loaded file. It keeps the file's bytes, or points to bytes that stay (flash, a mapped file).
///
/// Envelopes, skins and kernels point to it, and must not outlive it. Whatever replaces what it holds, a load,
/// an assignment, a move from it, makes them stale: every call refuses them until they are opened
/// again, which is all that a hot reload takes. Nobody may use a model while it is replaced.
class Model {
  public:
    Model() = default;
    /// Moves; the other is as if never loaded.
    Model(Model &&other) noexcept
        : memory_(std::exchange(other.memory_, {})), file_(std::move(other.file_)) {}
    Model &operator=(Model &&other) noexcept {
        if (this != &other) {
            memory_ = std::exchange(other.memory_, {});
            file_ = std::move(other.file_);
        }
        return *this;
    }

    /// Takes a file and loads it; on failure the model is what it was.
    Failure load(std::vector<std::uint8_t> file, const sinew_limits *limits = nullptr) {
        Failure failure = borrow(file, limits);
        if (!failure) {
            file_ = std::move(file);
        }
        return failure;
    }

    /// Loads a file that outlives the model, unchanged: no temporary one.
    Failure borrow(std::vector<std::uint8_t> &&, const sinew_limits * = nullptr) = delete;
    Failure borrow(Span<const std::uint8_t> file, const sinew_limits *limits = nullptr) {
        Failure failure;
        const sinew_model *handle;
        failure.status = sinew_model_load(memory_.data(), sizeof memory_, file.data, file.len,
                                          limits, &handle, &failure.error);
        return failure;
    }

    /// Says what the file holds, and in which space.
    Failure describe(sinew_model_info &out) const {
        Failure failure;
        failure.status = sinew_model_describe(get(), &out, &failure.error);
        return failure;
    }

    /// The handle; one that is not loaded is refused by every call.
    const sinew_model *get() const {
        return reinterpret_cast<const sinew_model *>(memory_.data());
    }

  private:
    std::array<std::uintptr_t, SINEW_MODEL_WORDS> memory_{};
    std::vector<std::uint8_t> file_;
};

/// What envelopes, skins and kernels have in common: memory, a name and what `describe` says. Its name is a copy,
/// and `info()` has none, so that neither points into a file that is gone.
template <class Handle, class Info, std::size_t Words> class Part {
  public:
    const Handle *get() const { return reinterpret_cast<const Handle *>(memory_.data()); }
    const Info &info() const { return info_; }
    const std::string &name() const { return name_; }

  protected:
    template <class Open, class Describe>
    Failure open_by(Open open, Describe describe, const Model &model, std::string_view name,
                    std::size_t index) {
        Failure failure;
        const Handle *handle;
        failure.status = open(model.get(), name.empty() ? nullptr : name.data(), name.size(), index,
                              memory_.data(), sizeof memory_, &handle, &failure.error);
        if (!failure) {
            failure.status = describe(handle, &info_, &failure.error);
        }
        if (!failure) {
            name_.assign(info_.name, info_.name_len);
            info_.name = nullptr;
            info_.name_len = 0;
        }
        return failure;
    }

  private:
    std::array<std::uintptr_t, Words> memory_{};
    Info info_{};
    std::string name_;
};

/// Predicts palettes from poses. Points to its model.
class Envelope : public Part<sinew_envelope, sinew_envelope_info, SINEW_ENVELOPE_WORDS> {
  public:
    /// Opens the `index`-th envelope of a name, or of any; on failure it is what it was.
    Failure open(const Model &&, std::string_view = {}, std::size_t = 0) = delete;
    Failure open(const Model &model, std::string_view name = {}, std::size_t index = 0) {
        return open_by(sinew_envelope_open, sinew_envelope_describe, model, name, index);
    }
};

/// A mesh that follows a palette. Points to its model.
class Skin : public Part<sinew_skin, sinew_skin_info, SINEW_SKIN_WORDS> {
  public:
    /// Opens the `index`-th skin of a name, or of any; on failure it is what it was.
    Failure open(const Model &&, std::string_view = {}, std::size_t = 0) = delete;
    Failure open(const Model &model, std::string_view name = {}, std::size_t index = 0) {
        return open_by(sinew_skin_open, sinew_skin_describe, model, name, index);
    }

    /// Runs a job; the skin and the palette are filled in here.
    Failure run(sinew_skin_job job, Span<const sinew_matrix> palette) const {
        Failure failure;
        job.skin = get();
        job.palette = palette.data;
        job.palette_len = palette.len;
        failure.status = sinew_skin_run(&job, &failure.error);
        return failure;
    }

    /// Computes a box that holds the posed skin, of a rest mesh as far from the file's as that.
    Failure bounds(Span<const sinew_matrix> palette, sinew_bounds &out,
                   float rest_offset = 0.0f) const {
        Failure failure;
        failure.status = sinew_skin_bounds(get(), palette.data, palette.len, rest_offset, &out,
                                           &failure.error);
        return failure;
    }
};

/// A function from named inputs to named outputs. Points to its model.
class Kernel : public Part<sinew_kernel, sinew_kernel_info, SINEW_KERNEL_WORDS> {
  public:
    /// Opens the `index`-th kernel of a name, or of any; on failure it is what it was.
    Failure open(const Model &&, std::string_view = {}, std::size_t = 0) = delete;
    Failure open(const Model &model, std::string_view name = {}, std::size_t index = 0) {
        return open_by(sinew_kernel_open, sinew_kernel_describe, model, name, index);
    }

    /// Computes the outputs of a query, in scratch of `info().scratch_len` floats.
    Failure evaluate(Span<const float> query, Span<float> scratch, Span<float> out,
                     float *confidence = nullptr) const {
        Failure failure;
        failure.status = sinew_kernel_evaluate(get(), query.data, query.len, scratch.data,
                                               scratch.len, out.data, out.len, confidence,
                                               &failure.error);
        return failure;
    }
};

/// One character: its scratch, its palette and the confidence in it. For one thread at a time. Points
/// to the envelope, which must stay where it is; once that was opened anew, so must this be made.
class Character {
  public:
    explicit Character(const Envelope &&) = delete;
    explicit Character(const Envelope &envelope)
        : envelope_(&envelope), scratch_(envelope.info().scratch_len),
          pose_(envelope.info().joint_len), palette_(envelope.info().palette_len) {}

    /// Computes the palette of local transforms.
    Failure pose(Span<const sinew_local_transform> local) {
        Failure failure;
        failure.status = sinew_envelope_pose(envelope_->get(), local.data, local.len, pose_.data(),
                                             pose_.size(), &failure.error);
        return failure ? failure : pose_matrices(pose_);
    }

    /// Computes the palette of skinning matrices: rest to posed, in model space.
    Failure pose_matrices(Span<const sinew_matrix> pose) {
        Failure failure;
        failure.status = sinew_envelope_palette(envelope_->get(), pose.data, pose.len,
                                                scratch_.data(), scratch_.size(), palette_.data(),
                                                palette_.size(), &confidence_, &failure.error);
        return failure;
    }

    const std::vector<sinew_matrix> &palette() const { return palette_; }
    float confidence() const { return confidence_; }

  private:
    const Envelope *envelope_;
    std::vector<float> scratch_;
    std::vector<sinew_matrix> pose_, palette_;
    float confidence_ = 0.0f;
};

} // namespace sinew

#endif
