// Colours by place, for tests.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "pvol/density/color_grid.h"
#include "pvol/volume/albedo_field.h"

namespace pvol::test {

/// color(p) at each lattice point p of origin + [0, size); nothing where a sample says none.
[[nodiscard]] inline ColorGrid make_colors(Vec3i origin, Vec3i size,
                                           const std::function<std::optional<Rgb>(Vec3i)>& color,
                                           const Affine& index_to_world = {}) {
  std::array<std::vector<float>, 4> values;
  for (int x = 0; x < size.x; ++x) {
    for (int y = 0; y < size.y; ++y) {
      for (int z = 0; z < size.z; ++z) {
        const auto c = color(origin + Vec3i(x, y, z));
        for (int k = 0; k < 3; ++k) values[std::size_t(k)].push_back(c ? (*c)[k] : 0.0f);
        values[3].push_back(c ? 1.0f : 0.0f);
      }
    }
  }
  ColorGrid grid;
  for (std::size_t k = 0; k < 4; ++k) {
    VoxelGrid& to = k < 3 ? grid.channels[k] : grid.known;
    to = make_grid({.values = values[k].data(), .size = size, .origin = origin}, index_to_world);
    to.name = "Cd";
  }
  return grid;
}

/// Made ready at a place.
[[nodiscard]] inline std::shared_ptr<const AlbedoField> albedo_of(
    const ColorGrid& colors, const VoxelGrid* density = nullptr, const Affine& place = {}) {
  return std::make_shared<const AlbedoField>(make_albedo_field({}, colors, density, place));
}

}  // namespace pvol::test
