// What the collisions and flights of a scene may need: chosen once a scene, so that what most do
// without costs them nothing.
#pragma once

#include <algorithm>
#include <variant>

#include "pvol/math/circles.h"
#include "render/path/local_matter.h"

namespace pvol::detail {

/// All matter scatters by one Henyey-Greenstein lobe and is the same all over its volume, nothing
/// emits along flights or is met by them as a light, nothing moves.
struct SimplePaths {
  static constexpr bool kSimple = true;
  [[nodiscard]] static const HenyeyGreenstein& phase(const Matter& m) {
    return *std::get_if<HenyeyGreenstein>(&m.phase);
  }
  template <class Traversal>
  [[nodiscard]] static const Matter& local(const PathSetup&, const Traversal&, const Matter& m) {
    return m;
  }
  /// Of samples of phase functions, as these take them: all at once where there is but one kind.
  [[nodiscard]] static CirclePoints azimuths(Float4 turns) { return points_at_turns(turns); }
};

/// Whatever a scene may hold.
struct AnyPaths {
  static constexpr bool kSimple = false;
  [[nodiscard]] static const PhaseFunction& phase(const Matter& m) { return m.phase; }
  template <class Traversal>
  [[nodiscard]] static LocalMatter local(const PathSetup& s, const Traversal& at, const Matter& m) {
    return detail::local(s, at, m);
  }
  [[nodiscard]] static Float4 azimuths(Float4 turns) { return turns; }
};

[[nodiscard]] inline bool are_simple(const PathSetup& s) {
  return s.emission == nullptr && !s.meets_lights && !s.moving && !s.albedo_varies &&
         std::ranges::all_of(s.volumes, [](const VolumeSetup& v) {
           return std::ranges::all_of(v.matter, [](const Matter& m) {
             return std::holds_alternative<HenyeyGreenstein>(m.phase);
           });
         });
}

}  // namespace pvol::detail
