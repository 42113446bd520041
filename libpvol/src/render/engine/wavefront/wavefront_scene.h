// A scene as the lane kernels read it: tables of floats without variants.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "render/engine/wavefront/path_fields.h"
#include "render/engine/wavefront/world_rays.h"
#include "render/guide/importance.h"
#include "render/path/path_setup.h"
#include "volume/simd/simd_field.h"

namespace pvol::detail {

/// One column of a table for each component of the medium: what collisions with it ask for.
struct ComponentTable {
  std::vector<float> share_up_to;
  std::array<std::vector<float>, 3> albedo;
  /// The two lobes of its phase function; a share of 1 is of the first alone.
  std::vector<float> lobe_share;
  struct Lobe {
    std::vector<float> g, one_minus_g, one_minus_g2, axis;
  };
  std::array<Lobe, 2> lobes;
  /// All components where a phase function has other than lobes, else none: then lanes are asked
  /// for one by one (phase_batch.h).
  std::span<const MediumComponent> one_by_one;
};

/// A light, by the way in which kernels sample it.
struct SimdLight {
  enum class Kind {
    delta,  ///< one direction
    disc,   ///< uniform over a disc in the sky
    point,  ///< from a place
    other,  ///< from a place of its own, one lane at a time
    sky,    ///< by its picture
  };
  Kind kind = Kind::sky;
  Vec3f direction{};               ///< of delta and disc
  Vec3f place{};                   ///< of a point, in cells as rays have them
  float one_minus_cos_radius = 0;  ///< of a disc
  float pdf = 0;                   ///< of a disc
  Rgb radiance{0.0f};  ///< what a shadow ray brings, or has the colour of: irradiance of delta
                       ///< lights, intensity of those at places
  float value = 0;     ///< absolute luminance of that
};

/// Constants of a render that all threads share, for paths in one of its volumes.
struct WavefrontScene {
  const PathSetup& setup;
  const VolumeSetup& volume;
  bool many;                      ///< whether rays are kept in the world: fly_in_the_world()
  std::array<Vec3f, 3> to_world;  ///< rows of the map of steps in cells to the world
  SimdField field;                ///< with the setup's bounds

  ComponentTable components;
  bool one_lobe;  ///< one component of one lobe, and grey albedos: all that most clouds need
  bool emits;     ///< whether collisions add light of their own

  std::vector<SimdLight> lights;  ///< those of the scene; then the sky, if it is sampled
  bool drawn;  ///< whether they are so many that of the scene's some are drawn at a collision
  bool lines;  ///< whether records note where flights begin that bring light on their way or ask
               ///< lamps: through one volume, or within an instance alone
  bool along;  ///< whether they bring any before they collide, or ask lamps
  bool fire_in_lanes;  ///< whether lanes find what a fire brings at collisions
  bool lines_outside;  ///< whether they bring any outside of its box
  bool camera_lines;   ///< whether those of the camera do any of this
  bool ratio;          ///< whether shadow rays have weights, as of ratio tracking
  Rgb share;           ///< of the extinction, by channel
  bool limited;        ///< whether a light may be nearer than the edge of the volume
  bool weighted;       ///< whether lights that paths meet by themselves are weighted by densities
  bool count;          ///< whether work is counted
  bool counts_collisions;  ///< whether paths count their own
  bool orders;             ///< whether light is told apart by how often it was scattered
  bool times;              ///< whether records have those of their paths
  std::uint32_t fields;    ///< bits of those that rays of the scene have
  bool dark_sky;           ///< whether rays that leave after a scattering bring nothing

  explicit WavefrontScene(const PathSetup& s, std::size_t number = 0);

  [[nodiscard]] const Importance* importance() const { return setup.importance.get(); }
};

/// One for each volume of the setup.
[[nodiscard]] std::vector<WavefrontScene> make_wavefront_scenes(const PathSetup& s);

}  // namespace pvol::detail
