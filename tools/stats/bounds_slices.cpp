#include "stats/bounds_slices.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "pvol/field/brick_field.h"
#include "report/colour_map.h"
#include "report/html.h"

namespace pvol::cli {
namespace {

constexpr int kLongest = 460;     // pixels
constexpr double kLeastCube = 9;  // pixels along a cube's edge
constexpr Srgb kEmpty{252, 252, 250}, kOutline{213, 94, 0};

/// A cube of the pyramid: of the level drawn, or a larger uniform one.
struct Cube {
  std::size_t level = 0, node = 0;
  friend bool operator==(const Cube&, const Cube&) = default;
};

/// Density and bounds at cells of index space.
class Lookup {
 public:
  Lookup(const VoxelGrid& grid, const Pyramid& pyramid)
      : pyramid_(pyramid), field_(build_field(grid, pyramid)) {}

  /// The cube of `level` or above that holds a cell; none in empty space.
  [[nodiscard]] std::optional<Cube> cube(Vec3l cell, std::size_t level) const {
    const Vec3l in_root = cell - pyramid_.origin;
    for (; level < pyramid_.levels.size(); ++level) {
      const auto found = find(pyramid_.levels[level], code(in_root, level));
      if (found && (level == drawn_ || is_uniform(pyramid_, level, *found))) {
        return Cube{level, *found};
      }
    }
    return std::nullopt;
  }
  void set_drawn(std::size_t level) { drawn_ = level; }

  /// The sample at the low corner of a cell.
  [[nodiscard]] float density(Vec3l cell) const {
    const Vec3l in_root = cell - pyramid_.origin;
    for (std::size_t level = 0; level < pyramid_.levels.size(); ++level) {
      const auto found = find(pyramid_.levels[level], code(in_root, level));
      if (!found || (level > 0 && !is_uniform(pyramid_, level, *found))) continue;
      const Vec3i at(int(in_root.x & 7), int(in_root.y & 7), int(in_root.z & 7));
      return field_.field.brick(
          field_.brick_of[level][*found])[(at.x * kFieldEdge + at.y) * kFieldEdge + at.z];
    }
    return 0;
  }

 private:
  static std::uint64_t code(Vec3l in_root, std::size_t level) {
    const Vec3l cube(in_root.x >> (3 + level), in_root.y >> (3 + level), in_root.z >> (3 + level));
    return morton_encode(Vec3<std::uint32_t>(cube));
  }

  const Pyramid& pyramid_;
  FieldWithLinks field_;
  std::size_t drawn_ = 0;
};

/// A slice and its pixels.
struct Plane {
  int across, right, up;
  int width, height;
  Vec3l lo, size;

  [[nodiscard]] Vec3d point(int x, int y) const {
    Vec3d p = Vec3d(lo) + Vec3d(size) * 0.5;
    p[across] = std::floor(p[across]) + 0.5;  // the middle of a layer: no rounding decides
    p[right] = double(lo[right]) + double(size[right]) * (x + 0.5) / width;
    p[up] = double(lo[up]) + double(size[up]) * (height - y - 0.5) / height;
    return p;
  }
  [[nodiscard]] Vec3l cell(int x, int y) const {
    const Vec3d p = point(x, y);
    return Vec3l(Vec3d{std::floor(p.x), std::floor(p.y), std::floor(p.z)});
  }
};

Plane make_plane(int across, Vec3l lo, Vec3l size) {
  Plane p{across, across == 0 ? 1 : 0, across == 2 ? 1 : 2, 0, 0, lo, size};
  const double scale = kLongest / double(std::max(size[p.right], size[p.up]));
  p.width = std::max(1, int(std::lround(double(size[p.right]) * scale)));
  p.height = std::max(1, int(std::lround(double(size[p.up]) * scale)));
  return p;
}

/// Grey by density, on a root scale so that thin edges show.
Srgb shade(float density, float scale) {
  const double t = std::sqrt(std::clamp(double(density) / double(scale), 0.0, 1.0));
  const auto v = std::uint8_t(std::lround(236 - 176 * t));
  return {v, v, v};
}

bool is_outline(const Plane& plane, const Shell& shell, int x, int y) {
  if (!contains(shell, plane.point(x, y))) return false;
  for (const auto& [dx, dy] :
       {std::pair(1, 0), std::pair(-1, 0), std::pair(0, 1), std::pair(0, -1)}) {
    if (!contains(shell, plane.point(x + dx, y + dy))) return true;
  }
  return false;
}

Srgb colour_of(const Plane& plane, const Lookup& lookup, std::size_t level, const Pyramid& pyramid,
               const Shell* shell, int x, int y) {
  if (shell != nullptr && is_outline(plane, *shell, x, y)) return kOutline;
  const auto cube = lookup.cube(plane.cell(x, y), level);
  if (!cube) return kEmpty;
  const auto differs = [&](int dx, int dy) {
    const int nx = x + dx, ny = y + dy;
    if (nx < 0 || ny < 0 || nx >= plane.width || ny >= plane.height) return true;
    return lookup.cube(plane.cell(nx, ny), level) != cube;
  };
  if (differs(-1, 0) || differs(0, -1) || differs(1, 0) || differs(0, 1)) {
    const PyramidNode& n = pyramid.levels[cube->level][cube->node];
    return colour_at(ColourMap::sequential, (double(n.hi) - double(n.lo)) / double(pyramid.scale));
  }
  return shade(lookup.density(plane.cell(x, y)), pyramid.scale);
}

}  // namespace

std::vector<BoundsSlice> slice_bounds(const VoxelGrid& grid, const Pyramid& pyramid,
                                      const Shell* shell) {
  Lookup lookup(grid, pyramid);
  const Vec3l size = pyramid.support_hi - pyramid.support_lo;
  std::vector<BoundsSlice> slices;
  for (int across = 0; across < 3; ++across) {
    const Plane plane = make_plane(across, pyramid.support_lo, size);
    const double pixels_per_cell = plane.width / double(size[plane.right]);
    std::size_t level = 0;
    while (level + 1 < pyramid.levels.size() &&
           pixels_per_cell * double(std::int64_t(kLeafEdge) << level) < kLeastCube) {
      ++level;
    }
    lookup.set_drawn(level);
    BoundsSlice s;
    s.across = across;
    s.edge = std::int64_t(kLeafEdge) << level;
    s.picture.width = plane.width, s.picture.height = plane.height;
    for (int y = 0; y < plane.height; ++y) {
      for (int x = 0; x < plane.width; ++x) {
        const Srgb c = colour_of(plane, lookup, level, pyramid, shell, x, y);
        s.picture.rgb.insert(s.picture.rgb.end(), c.begin(), c.end());
      }
    }
    slices.push_back(std::move(s));
  }
  return slices;
}

std::string cube_name(std::int64_t edge) {
  return fmt::format("{}³ voxels{}", edge, edge == kLeafEdge ? ", the leaves" : "");
}

std::vector<report::Figure> slice_figures(const formats::Cloud& cloud, bool name_cubes) {
  std::vector<report::Figure> figures;
  const Shell* const shell = cloud.shell ? &*cloud.shell : nullptr;
  for (const BoundsSlice& s : slice_bounds(cloud.grid(), cloud.pyramid, shell)) {
    const std::string across = fmt::format("across {}", "xyz"[s.across]);
    figures.push_back({html::image(formats::encode_png(s.picture), "slice " + across, false),
                       name_cubes ? across + ", cubes of " + cube_name(s.edge) : across});
  }
  return figures;
}

}  // namespace pvol::cli
