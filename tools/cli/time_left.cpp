#include "cli/time_left.h"

namespace pvol::cli {

void TimeLeft::begin(double now, std::uint64_t done, double unit_seconds) {
  begin_ = now, before_ = done, unit_seconds_ = unit_seconds;
}

std::optional<double> TimeLeft::at(double now, std::uint64_t done, std::uint64_t total) const {
  constexpr double kShare = 0.05;
  const double did = double(done - before_), left = double(total - done);
  const double weight = unit_seconds_ > 0 ? kShare * double(total - before_) : 0;
  if (did + weight <= 0) return std::nullopt;
  return left * (now - begin_ + weight * unit_seconds_) / (did + weight);
}

double TimeLeft::rate(double now, std::uint64_t done) const {
  return now > begin_ ? double(done - before_) / (now - begin_) : 0;
}

}  // namespace pvol::cli
