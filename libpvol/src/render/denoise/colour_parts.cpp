#include "render/denoise/colour_parts.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <numeric>

#include "pvol/render/aov.h"

namespace pvol::detail {
namespace {

bool is_among(const auto& names, const Layer& layer) {
  return std::ranges::find(names, layer.name) != std::ranges::end(names);
}

/// Layers of Aov::scattering.
bool is_order(const Layer& layer) { return is_among(kOrderLayers, layer); }

/// Layers of Aov::lights: of all other layers of three colours the names are known.
bool is_light(const Layer& layer) {
  return layer.components == "RGB" && !is_order(layer) && !is_among(kHalfLayers, layer) &&
         !is_among(kNoisyLayers, layer) &&
         std::ranges::find(kAovs, layer.name, &AovRow::name) == kAovs.end();
}

template <class Is>
ColourParts find(const Film& film, const Is& is) {
  ColourParts parts;
  for (std::size_t k = 0; k < film.layers.size(); ++k) {
    if (is(film.layers[k])) parts.push_back(k);
  }
  return parts;
}

/// The mean of three filtered planes each where the picture is filtered, else the layer's values.
FilteredLayer mean_of(const Film& film, std::size_t layer, const Halves& halves,
                      const std::array<const Plane*, 2>& filtered) {
  FilteredLayer f{layer, {}};
  for (int y = 0; y < film.crop_height; ++y) {
    for (int x = 0; x < film.crop_width; ++x) {
      Vec3d v = value(film.layers[layer], film, film.index(x, y));
      for (int c = 0; halves.filtered.row(y)[x] > 0 && c < 3; ++c) {
        const float both = filtered[0][c].row(y)[x] + filtered[1][c].row(y)[x];
        v[c] = std::max(0.0, double(both) / 2) * halves.scale;
      }
      f.values.push_back(v);
    }
  }
  return f;
}

/// Scales layers, in each pixel that is filtered, so that they sum up to the colour.
void fit_sum(const Film& film, const Plane& where, const std::vector<Vec3d>& colour,
             std::vector<FilteredLayer>& set) {
  // Where no layer has light, the colour is shared as in the whole picture.
  constexpr double kNone = 1e-30;
  std::vector<Vec3d> totals;
  for (const FilteredLayer& f : set) {
    totals.push_back(std::accumulate(f.values.begin(), f.values.end(), Vec3d{}));
  }
  for (std::size_t i = 0; i < colour.size(); ++i) {
    const auto width = std::size_t(film.crop_width);
    if (!(where.row(int(i / width))[i % width] > 0)) continue;
    Vec3d sum;
    for (std::size_t k = 0; k < set.size(); ++k) {
      sum += set[k].values[i] += kNone * max(totals[k], Vec3d{});
    }
    for (FilteredLayer& f : set) {
      for (int c = 0; c < 3; ++c) {
        if (sum[c] > 0) f.values[i][c] *= colour[i][c] / sum[c];
      }
    }
  }
}

}  // namespace

std::vector<ColourParts> find_colour_parts(const Film& film) {
  std::vector<ColourParts> sets;
  for (ColourParts parts : {find(film, is_light), find(film, is_order)}) {
    if (!parts.empty()) sets.push_back(std::move(parts));
  }
  return sets;
}

Planes planes_of_parts(const Film& film, const std::vector<ColourParts>& sets, const Halves& halves,
                       int margin) {
  Planes planes;
  for (const ColourParts& parts : sets) {
    for (const std::size_t k : parts) {
      for (int c = 0; c < 3; ++c) {
        Plane& plane = planes.emplace_back(film.crop_width, film.crop_height, margin);
        for (int y = 0; y < film.crop_height; ++y) {
          for (int x = 0; x < film.crop_width; ++x) {
            const double own = value(film.layers[k], film, film.index(x, y))[c];
            plane.row(y)[x] = float(own / halves.scale);
          }
        }
        spread_part(plane, halves.fireflies, halves.filtered);
        plane.repeat_edges();
      }
    }
  }
  return planes;
}

std::vector<FilteredLayer> fit_parts(const Film& film, const std::vector<ColourParts>& sets,
                                     const Halves& halves,
                                     const std::array<const Plane*, 2>& filtered,
                                     const std::vector<Vec3d>& colour) {
  std::vector<FilteredLayer> all;
  std::size_t plane = 0;
  for (const ColourParts& parts : sets) {
    std::vector<FilteredLayer> set;
    for (const std::size_t k : parts) {
      set.push_back(mean_of(film, k, halves, {filtered[0] + plane, filtered[1] + plane}));
      plane += 3;
    }
    fit_sum(film, halves.filtered, colour, set);
    std::ranges::move(set, std::back_inserter(all));
  }
  return all;
}

}  // namespace pvol::detail
