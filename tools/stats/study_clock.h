// Measuring a study within its budget.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "pvol/measure/sweep.h"
#include "stats/study_report.h"

namespace pvol::cli {

/// What studies of settings have in common: the part of the budget that the reference gets, and the
/// pixels of their pictures; and the seed of the reference, far from all others.
inline constexpr double kReferencePart = 0.2;
inline constexpr int kPixelsOfStudy = 96 * 96;
inline constexpr std::uint64_t kReferenceSeed = std::uint64_t(1) << 40;

/// Measures for a report and keeps the clock; from the reference on interruptions leave a report of
/// what was measured. Says on stderr what is measured next, at each round and every few seconds.
class StudyClock {
 public:
  StudyClock(StudyReport& report, bool quiet);

  /// Seconds of the budget.
  [[nodiscard]] double left() const;
  void announce(const std::string& next) { announce(next, left()); }

  /// Renders the reference for a part of what is left, on so many threads (see RenderOptions).
  void measure_reference(const LoadedScene& loaded, double part, int threads);

  /// Sweeps settings of these names for so many seconds of what is left, and with seeds from `seed`
  /// on. For `always` see SweepOptions.
  [[nodiscard]] std::vector<measure::Measured> sweep(const std::vector<std::string>& names,
                                                     double seconds, std::uint64_t seed,
                                                     std::uint32_t most_samples,
                                                     const std::function<bool(std::size_t)>& always,
                                                     const measure::Render& render);

  /// Notes the time used.
  void stop();

  /// Throws Error where the study was interrupted: for after the report of what was measured.
  static void require_whole();

 private:
  void announce(const std::string& next, double seconds_left);
  [[nodiscard]] measure::SweepOptions options(double seconds, std::uint64_t seed) const;

  StudyReport& report_;
  bool quiet_;
  double begin_, last_ = 0;
  std::string round_;  // that was told last
};

}  // namespace pvol::cli
