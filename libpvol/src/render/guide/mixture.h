// All that a scene's volumes are made of, taken together, for the coarse parts of guiding.
#pragma once

#include <vector>

#include "render/guide/coarse_cells.h"
#include "render/path/path_setup.h"

namespace pvol::detail {

/// A kind of medium with its share of the extinction of all volumes at all places.
struct Share {
  const MediumComponent* component;
  float share;
};

/// They sum up to 1; the setup outlives them.
[[nodiscard]] inline std::vector<Share> mixture(const PathSetup& setup, const CoarseCells& cells) {
  double sum = 0;
  for (const double m : cells.mass_of_volumes) sum += m;
  std::vector<Share> all;
  for (std::size_t i = 0; i < setup.volumes.size(); ++i) {
    const auto of_volume = float(sum > 0 ? cells.mass_of_volumes[i] / sum : 0);
    for (const MediumComponent& m : setup.volumes[i].components) {
      all.push_back({&m, float(m.share) * of_volume});
    }
  }
  return all;
}

}  // namespace pvol::detail
