// Which samples a render takes, pass by pass. Each pass leaves a whole picture; the first ones are
// short.
#pragma once

#include <optional>

#include "pvol/render/film.h"
#include "pvol/render/options.h"
#include "render/engine/tiles/sample_targets.h"
#include "render/film/adaptive_samples.h"

namespace pvol::detail {

/// Most samples of a pixel in one pass: a tile's batch of 16 x 16 pixels then fits the lane
/// kernels.
inline constexpr std::uint32_t kMostOfPass = 256;

/// The same where all pixels get equally many.
inline constexpr std::uint32_t kMostOfEqualPass = 16;

/// Most adaptive samples of a pixel.
inline constexpr std::uint32_t kMostOfPixel = 1u << 30;

/// The passes of a render: `options.samples` in every pixel or, where noise or time are limited,
/// adaptive samples.
class Passes {
 public:
  /// For a film of so many pixels.
  Passes(const RenderOptions& options, std::size_t pixels);

  /// Goes on where a film stands that earlier passes left, in the middle of one perhaps.
  void resume(const Film& film);

  /// Samples to have after the next pass; none where the picture is done. `film` has those of all
  /// passes before, and gets its needs once its pilot is done; it is `seconds` since the render
  /// began.
  [[nodiscard]] std::optional<SampleTargets> next(Film& film, double seconds);

  /// Samples of the whole render, as far as they can be foreseen; 0 where they cannot yet.
  [[nodiscard]] std::uint64_t total() const { return total_; }

 private:
  bool adaptive_;
  bool pilot_only_;
  std::uint32_t samples_;
  std::optional<double> noise_, time_;
  std::uint32_t least_;  // samples of each pixel, whatever the time
  std::uint64_t total_ = 0;

  std::uint32_t uniform_ = 0;        // samples of every pixel while they are equal
  double average_ = kPilot;          // samples of a pixel at which adaptive passes aim
  std::vector<std::uint32_t> goal_;  // what they come to for each pixel

  double seconds_ = 0, done_ = 0, speed_ = 0;  // after the last pass; samples per second in it

  void measure(const Film& film, double seconds);
  [[nodiscard]] double affordable() const;
  [[nodiscard]] std::optional<SampleTargets> next_equal(const Film& film, std::uint32_t end);
  [[nodiscard]] std::optional<SampleTargets> next_adaptive(Film& film);
  [[nodiscard]] bool raise_goal(const Film& film);
  [[nodiscard]] std::optional<SampleTargets> towards_goal(const Film& film) const;
  [[nodiscard]] double samples_of(const Film& film, std::size_t pixel, double average) const;
};

}  // namespace pvol::detail
