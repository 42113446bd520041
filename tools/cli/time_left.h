// How long work will go on.
#pragma once

#include <cstdint>
#include <optional>

namespace pvol::cli {

/// Estimates the time left from how the work has gone since it began, and from a forecast, if there
/// is one, which counts like the first twentieth of the work.
class TimeLeft {
 public:
  /// The work begins at a time in seconds, with so many units that were done before; a unit should
  /// take `unit_seconds`, 0 where that is not known. May begin again.
  void begin(double now, std::uint64_t done, double unit_seconds);

  /// Seconds; nothing where neither a forecast nor any work says. `done` is at most `total`.
  [[nodiscard]] std::optional<double> at(double now, std::uint64_t done, std::uint64_t total) const;

  /// Units per second since the beginning; 0 where no time has passed.
  [[nodiscard]] double rate(double now, std::uint64_t done) const;

 private:
  double begin_ = 0, unit_seconds_ = 0;
  std::uint64_t before_ = 0;
};

}  // namespace pvol::cli
