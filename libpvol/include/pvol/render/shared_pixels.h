// Pixels of pictures that many scenes have in common.
#pragma once

#include <algorithm>
#include <cstddef>
#include <initializer_list>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "pvol/math/vec.h"

namespace pvol {

/// Pixels that copies share until one of them is edited: scenes are copied at every change that
/// somebody makes while a picture refines, and their skies may have a hundred million pixels.
class SharedPixels {
 public:
  SharedPixels() = default;
  SharedPixels(std::vector<Rgb> pixels)  // NOLINT: as a vector is given
      : largest_(largest_of(pixels)),
        pixels_(std::make_shared<std::vector<Rgb>>(std::move(pixels))) {}

  SharedPixels(std::initializer_list<Rgb> pixels) : SharedPixels(std::vector<Rgb>(pixels)) {}

  [[nodiscard]] std::size_t size() const { return pixels_ ? pixels_->size() : 0; }
  [[nodiscard]] bool empty() const { return size() == 0; }
  [[nodiscard]] const Rgb& operator[](std::size_t i) const { return (*pixels_)[i]; }
  [[nodiscard]] const Rgb* begin() const { return pixels_ ? pixels_->data() : nullptr; }
  [[nodiscard]] const Rgb* end() const { return begin() + size(); }
  [[nodiscard]] const Rgb& front() const { return pixels_->front(); }
  [[nodiscard]] const Rgb& back() const { return pixels_->back(); }

  /// Of all pixels, by channel; none where one is negative or not finite.
  [[nodiscard]] std::optional<Rgb> largest() const {
    return pixels_ && !largest_ ? largest_of(*pixels_) : largest_;
  }

  /// The pixels of this copy alone, to be changed before it is copied again.
  [[nodiscard]] std::vector<Rgb>& edit() {
    if (!pixels_ || pixels_.use_count() > 1) {
      pixels_ = std::make_shared<std::vector<Rgb>>(begin(), end());
    }
    largest_.reset();
    return *pixels_;
  }

  friend bool operator==(const SharedPixels& a, const SharedPixels& b) {
    return a.pixels_ == b.pixels_ || std::equal(a.begin(), a.end(), b.begin(), b.end());
  }

 private:
  static std::optional<Rgb> largest_of(const std::vector<Rgb>& pixels) {
    Rgb most(0.0f);
    for (const Rgb p : pixels) {
      if (!is_finite(p) || !(min_component(p) >= 0)) return std::nullopt;
      most = max(most, p);
    }
    return most;
  }

  std::optional<Rgb> largest_;  ///< as it was made; none once it was edited
  std::shared_ptr<std::vector<Rgb>> pixels_;
};

}  // namespace pvol
