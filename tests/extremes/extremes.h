// Sweeps over decades of everything that a scene has in units: at each decade the right picture, or
// a refusal that says why.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "pvol/render/options.h"

namespace pvol::extremes {

enum class Verdict {
  exact,    ///< the picture of decade 0 to the last bit, or the closed form to 1e-6
  within,   ///< what follows from it by rounding and by chance
  refused,  ///< by an Error
  wrong,
};

struct Outcome {
  Verdict verdict = Verdict::exact;
  std::string note{};  ///< the error, or how far off
};

/// A way to render that a sweep is made with.
struct Setting {
  std::string name;
  Tracker tracker = Tracker::decomposition;
  Transmittance transmittance = Transmittance::ratio;
  LookUp look_up = LookUp::trilinear;
  MicroBoundsUse micro_bounds = MicroBoundsUse::none;
  GuideUse guide = GuideUse::off;
  int volumes = 1;
  bool shell = false;
};
[[nodiscard]] const std::vector<Setting>& settings();

struct Quantity {
  std::string name;   ///< "size of the world"
  std::string about;  ///< what stays the same in units, and what the outcome is compared with
  std::function<Outcome(int decade, const Setting&)> at;
  bool of_settings = true;                         ///< false: a setting makes no difference
  std::function<std::string(int decade)> value{};  ///< in words, where it is not a power of ten
};
[[nodiscard]] const std::vector<Quantity>& quantities();

inline constexpr int kFirstDecade = -15, kLastDecade = 15;

/// The worst outcome over all settings, its note with the setting's name.
[[nodiscard]] Outcome worst(const Quantity& quantity, int decade);

/// The table of all of it, as tests/bench/EXTREMES.md has it.
[[nodiscard]] std::string page();

}  // namespace pvol::extremes
