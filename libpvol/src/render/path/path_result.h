// What a camera path brings home.
#pragma once

#include <cstdint>
#include <string>

#include "pvol/error.h"
#include "render/path/path_setup.h"

namespace pvol::detail {

/// Where a camera path first collided.
struct FirstCollision {
  Vec3d place{};               ///< in the world
  std::uint32_t instance = 0;  ///< number of the one that it hit, if no surface
};

/// The sums of one sample. Everything that adds light to it is in gather_light.h. Layers are those
/// of each light in their order, then of the sky, which has all that is constant, and of emission;
/// none where nobody asks for them.
struct PathResult {
  Rgb radiance{0.0f};
  float alpha = 0;       ///< estimate of 1 - transmittance
  Rgb tint{0.0f};        ///< what that transmittance has more by channel
  Rgb background{0.0f};  ///< of the radiance, what a shadow catcher shows of the background
  std::vector<Rgb> layers;
  /// Radiance by scatterings: of light that was not scattered, that was once, that was more often;
  /// empty where nobody asks.
  std::vector<Rgb> orders;
  FirstCollision first{};  ///< where somebody asks
  float first_weight = 0;  ///< of the flight that ended there; 0: none did
  float time = 0;          ///< of the path, in frames, where the setup moves
  Vec3d first_normal;      ///< where that place is on a surface, which has this finish
  const Material* first_material = nullptr;  ///< a shadow catcher's too, which no weight counts
  const MovingMap* first_moves = nullptr;    ///< and what moves it; or null

  explicit PathResult(const PathSetup& s)
      : layers(s.options.aovs.has(Aov::lights) ? s.light.sources.size() + 2 : 0),
        orders(s.options.aovs.has(Aov::scattering) ? kOrders : 0) {}
  void reset() {
    radiance = background = tint = Rgb(0.0f), alpha = 0, first_weight = 0, first_material = nullptr;
    for (Rgb& layer : layers) layer = Rgb(0.0f);
    for (Rgb& order : orders) order = Rgb(0.0f);
  }

  [[nodiscard]] bool in_layers() const { return !layers.empty(); }
  [[nodiscard]] Rgb& sky() { return layers[layers.size() - 2]; }
  [[nodiscard]] Rgb& emission() { return layers.back(); }

  static constexpr std::size_t kOrders = 3;
};

/// Throws Error for a sample of pixel (x, y) that is more than a float holds.
inline void require_finite(const PathResult& r, int x, int y) {
  if (is_finite(r.radiance)) return;
  throw Error("pixel (" + std::to_string(x) + ", " + std::to_string(y) +
              ") became infinite: the lights are too bright for single precision; scale them down");
}

}  // namespace pvol::detail
