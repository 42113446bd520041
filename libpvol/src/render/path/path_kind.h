// What the collisions and flights of a scene may need: chosen once a scene, so that what most do
// without costs them nothing.
#pragma once

#include <algorithm>
#include <variant>

#include "pvol/math/circles.h"
#include "render/path/local_medium.h"

namespace pvol::detail {

/// Most lights that are all asked at a collision.
inline constexpr std::size_t kMostAsked = 64;

/// All media scatter by one Henyey-Greenstein lobe and are the same all over their volumes, lights
/// are a few suns and points, nothing emits along flights, nothing moves.
struct SimplePaths {
  static constexpr bool kSimple = true;
  [[nodiscard]] static const HenyeyGreenstein& phase(const MediumComponent& m) {
    return *std::get_if<HenyeyGreenstein>(&m.phase);
  }
  template <class Traversal>
  [[nodiscard]] static const MediumComponent& local(const PathSetup&, const Traversal&,
                                                    const MediumComponent& m) {
    return m;
  }
  template <class Where>
  [[nodiscard]] static LightSample sample(const LightSource& light, const Where& where, Rng& rng) {
    if (const auto* sun = std::get_if<SunLight>(&light)) return sun->sample(where, rng);
    return std::get_if<PointSource>(&light)->sample(where, rng);
  }
  /// Of samples of phase functions, as these take them: all at once where there is but one kind.
  [[nodiscard]] static CirclePoints azimuths(Float4 turns) { return points_at_turns(turns); }
};

/// Whatever a scene may hold.
struct AnyPaths {
  static constexpr bool kSimple = false;
  [[nodiscard]] static const PhaseFunction& phase(const MediumComponent& m) { return m.phase; }
  template <class Traversal>
  [[nodiscard]] static LocalMedium local(const PathSetup& s, const Traversal& at,
                                         const MediumComponent& m) {
    return detail::local(s, at, m);
  }
  template <class Where>
  [[nodiscard]] static LightSample sample(const LightSource& light, const Where& where, Rng& rng) {
    // The commonest first: a jump by kind costs as much as the rest.
    if (const auto* sun = std::get_if<SunLight>(&light)) return sun->sample(where, rng);
    if (const auto* point = std::get_if<PointSource>(&light)) return point->sample(where, rng);
    return std::visit([&](const auto& l) { return l.sample(where, rng); }, light);
  }
  [[nodiscard]] static Float4 azimuths(Float4 turns) { return turns; }
};

[[nodiscard]] inline bool are_simple(const PathSetup& s) {
  const auto is_simple = [](const LightSource& l) {
    return std::holds_alternative<SunLight>(l) || std::holds_alternative<PointSource>(l);
  };
  return s.light.sources.size() <= kMostAsked && std::ranges::all_of(s.light.sources, is_simple) &&
         s.emission == nullptr && !s.moving && !s.albedo_varies &&
         std::ranges::all_of(s.volumes, [](const VolumeSetup& v) {
           return std::ranges::all_of(v.components, [](const MediumComponent& m) {
             return std::holds_alternative<HenyeyGreenstein>(m.phase);
           });
         });
}

}  // namespace pvol::detail
