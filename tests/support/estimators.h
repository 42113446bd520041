// All trackers and estimators of transmittance, for tests of every one.
#pragma once

#include "pvol/render/scene.h"

namespace pvol::test {

inline constexpr Tracker kTrackers[] = {Tracker::delta_global,           Tracker::delta,
                                        Tracker::decomposition,          Tracker::weighted_delta,
                                        Tracker::weighted_decomposition, Tracker::regular};
inline constexpr Transmittance kTransmittances[] = {Transmittance::ratio, Transmittance::analog,
                                                    Transmittance::residual_ratio,
                                                    Transmittance::regular};

/// Whether paths are slow: closed forms look at every cell on the way.
[[nodiscard]] constexpr bool is_slow(Tracker tracker, Transmittance transmittance) {
  return tracker == Tracker::regular || transmittance == Transmittance::regular;
}

/// Compilers warn of a missing case where one is added: then it belongs into the lists, too, unless
/// it stands for one of the others.
[[nodiscard]] constexpr const char* label(Tracker tracker) {
  switch (tracker) {
    case Tracker::delta_global:
      return "delta-global";
    case Tracker::delta:
      return "delta";
    case Tracker::decomposition:
      return "decomposition";
    case Tracker::weighted_delta:
      return "weighted-delta";
    case Tracker::weighted_decomposition:
      return "weighted-decomposition";
    case Tracker::regular:
      return "regular";
  }
  return "";
}
[[nodiscard]] constexpr const char* label(Transmittance transmittance) {
  switch (transmittance) {
    case Transmittance::ratio:
      return "ratio";
    case Transmittance::analog:
      return "analog";
    case Transmittance::residual_ratio:
      return "residual-ratio";
    case Transmittance::regular:
      return "regular";
    case Transmittance::automatic:
      return "auto";
  }
  return "";
}

}  // namespace pvol::test
