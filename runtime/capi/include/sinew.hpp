/// Sinew in C++17: who owns what, and results without exceptions. Everything else is in sinew.h,
/// whose functions take what `get()` returns.
#ifndef SINEW_HPP
#define SINEW_HPP

#include "sinew.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

namespace sinew {

/// What a call came to: `if (auto failed = model.load(file)) { report(failed.text()); }`.
struct [[nodiscard]] Failure {
    sinew_error error{SINEW_STATUS_OK, SINEW_SUBJECT_NONE, 0, 0, 0};
    sinew_status status = SINEW_STATUS_OK;

    explicit operator bool() const { return status != SINEW_STATUS_OK; }
    const char *text() const { return sinew_status_text(status); }
    const char *subject() const { return sinew_subject_text(error.subject); }
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
/// Immutable once loaded: share it between threads by reference.
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

    /// Takes a file and loads it; on failure the model is what it was. Envelopes of a file that was
    /// loaded before, or assigned to, have to be opened again.
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

    /// The handle; one that is not loaded is refused by every call.
    const sinew_model *get() const {
        return reinterpret_cast<const sinew_model *>(memory_.data());
    }

  private:
    std::array<std::uintptr_t, SINEW_MODEL_WORDS> memory_{};
    std::vector<std::uint8_t> file_;
};

/// A skin of a model, which it must not outlive. Immutable once opened.
class Envelope {
  public:
    /// Opens an envelope by name, or the first one.
    Failure open(const Model &model, std::string_view name = {}) {
        Failure failure;
        const sinew_envelope *handle;
        failure.status = sinew_envelope_open(model.get(), name.empty() ? nullptr : name.data(),
                                             name.size(), memory_.data(), sizeof memory_, &handle,
                                             &failure.error);
        if (!failure) {
            failure.status = sinew_envelope_describe(handle, &info_, &failure.error);
        }
        return failure;
    }

    const sinew_envelope *get() const {
        return reinterpret_cast<const sinew_envelope *>(memory_.data());
    }
    const sinew_envelope_info &info() const { return info_; }
    std::string_view name() const { return {info_.name, info_.name_len}; }

  private:
    std::array<std::uintptr_t, SINEW_ENVELOPE_WORDS> memory_{};
    sinew_envelope_info info_{};
};

/// One character that wears an envelope: its scratch, its palette and the confidence in it. For
/// one thread at a time. Points to the envelope, which must stay where it is.
class Character {
  public:
    explicit Character(const Envelope &&) = delete;
    explicit Character(const Envelope &envelope)
        : envelope_(&envelope), workspace_(envelope.info().workspace_len),
          pose_(envelope.info().joint_len), palette_(envelope.info().palette_len) {}

    /// Computes the palette of local transforms.
    Failure pose(Span<const sinew_transform> local) {
        Failure failure;
        failure.status = sinew_envelope_pose(envelope_->get(), local.data, local.len, pose_.data(),
                                             pose_.size(), &failure.error);
        return failure ? failure : pose_matrices(pose_);
    }

    /// Computes the palette of skinning matrices: rest to posed, in model space.
    Failure pose_matrices(Span<const sinew_matrix> pose) {
        Failure failure;
        failure.status = sinew_envelope_palette(
            envelope_->get(), pose.data, pose.len, workspace_.data(), workspace_.size(),
            palette_.data(), palette_.size(), &confidence_, &failure.error);
        return failure;
    }

    /// Skins; the envelope and the palette are filled in here.
    Failure skin(sinew_skin_job job) const {
        Failure failure;
        job.envelope = envelope_->get();
        job.palette = palette_.data();
        job.palette_len = palette_.size();
        failure.status = sinew_skin(&job, &failure.error);
        return failure;
    }

    /// Computes a box that holds the skin.
    Failure bounds(sinew_bounds &out) const {
        Failure failure;
        failure.status = sinew_envelope_bounds(envelope_->get(), palette_.data(), palette_.size(),
                                               &out, &failure.error);
        return failure;
    }

    const std::vector<sinew_matrix> &palette() const { return palette_; }
    float confidence() const { return confidence_; }

  private:
    const Envelope *envelope_;
    std::vector<float> workspace_;
    std::vector<sinew_matrix> pose_, palette_;
    float confidence_ = 0.0f;
};

} // namespace sinew

#endif
