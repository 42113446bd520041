#include "render/guide/coarse_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "bounds/octree_children.h"
#include "pvol/bounds/pyramid.h"
#include "pvol/math/parallel.h"
#include "pvol/volume/facts.h"
#include "pvol/volume/motion.h"
#include "pvol/volume/moving_places.h"
#include "volume/cell_look_up.h"
#include "volume/field_samples.h"

namespace pvol::detail {
namespace {

/// Integral of the interpolated density over the 8^3 cells of each brick, in cells^3.
std::vector<double> brick_integrals(const VolumeField& field) {
  std::vector<double> all(count_bricks(field));
  parallel_for(0, all.size(), [&](std::size_t b) {
    std::array<float, kFieldSamples> scratch;
    const float* s = samples_of(field, std::uint32_t(b), scratch.data());
    // A sample on a face belongs to the leaf by half along that axis.
    const auto weight = [](int i) { return i == 0 || i == kLeafEdge ? 0.5f : 1.0f; };
    double sum = 0;
    for (int i = 0; i < kFieldEdge; ++i) {
      for (int j = 0; j < kFieldEdge; ++j) {
        float row = 0;
        for (int k = 0; k < kFieldEdge; ++k, ++s) row += *s * weight(k);
        sum += double(row * weight(i) * weight(j));
      }
    }
    all[b] = sum;
  });
  return all;
}

/// A leaf, or a uniform cube, which may span several coarse ones.
struct Terminal {
  Vec3i low;
  int edge;
  std::uint32_t brick;
  double density = 0;  ///< the mean
};

/// Whether the samples of bricks are all that there is to the density.
[[nodiscard]] bool is_plain(const VolumeField& f) {
  return (f.look_up == LookUp::nearest || f.look_up == LookUp::trilinear) && f.map == nullptr &&
         f.motion == nullptr;
}

/// Centre of one of along^3 parts of a box.
[[nodiscard]] Vec3d part_centre(const Box& box, int along, int part) {
  const Vec3d at(part / (along * along), part / along % along, part % along);
  return box.lo + box.extent() * ((at + Vec3d(0.5)) / double(along));
}

/// The most times at which what moves is looked at, evenly while the shutter is open.
constexpr int kTimes = 16;

/// mu_t at a place in cells, as the i-th look finds it.
[[nodiscard]] float extinction_in_look(const Volume& v, Vec3d cells, int i) {
  const Motion* const motion = v.density.motion.get();
  if (motion == nullptr) return extinction_in_cells(v, cells);
  return extinction_in_cells(v, cells, float(motion->shutter.at((i % kTimes + 0.5) / kTimes)));
}

/// Mean over 4^3 points of a cube, each at another time: 5 and 16 share no factor, so that all
/// times are spread over all of the cube.
[[nodiscard]] double mean_density(const Volume& v, const Terminal& t) {
  constexpr int kAlong = 4, kPoints = kAlong * kAlong * kAlong;
  const Box cube{Vec3d(t.low), Vec3d(t.low + Vec3i(t.edge))};
  double sum = 0;
  for (int i = 0; i < kPoints; ++i) {
    sum += double(extinction_in_look(v, part_centre(cube, kAlong, i), 5 * i + i / kTimes));
  }
  return sum / kPoints / double(v.density.scale);
}

[[nodiscard]] std::vector<Terminal> measure_terminals(const Volume& v) {
  const VolumeField& f = v.density;
  std::vector<Terminal> all;
  for_bricks(f.octree, f.octree.nodes[0], {}, [&](Vec3i low, int edge, std::uint32_t brick) {
    all.push_back({low, edge, brick});
  });
  if (is_plain(f)) {
    const std::vector<double> of_brick = brick_integrals(f);
    for (Terminal& t : all) t.density = of_brick[t.brick] / (kLeafEdge * kLeafEdge * kLeafEdge);
  } else if (f.scale > 0) {
    parallel_for(0, all.size(), [&](std::size_t i) { all[i].density = mean_density(v, all[i]); });
  }
  return all;
}

/// Adds the mass of a terminal by coarse cube, in cells^3 of density 1.
void add_mass(const Terminal& t, const Octree& tree, const CoarseCells& cells,
              std::vector<double>& sums) {
  const int step = std::min(t.edge, 1 << cells.shift);
  const Vec3i end = min(t.low + Vec3i(t.edge), vec3(tree.support_hi));
  for (int x = t.low.x; x < end.x; x += step) {
    for (int y = t.low.y; y < end.y; y += step) {
      for (int z = t.low.z; z < end.z; z += step) {
        const Int4 c = (Int4{x, y, z, 0} >> cells.shift) - cells.low;
        if (any_bits((c < 0) & 1) != 0) continue;
        sums[cells.index({c[0], c[1], c[2]})] += t.density * step * step * step;
      }
    }
  }
}

/// Gives the cubes with mass their rows.
void add_rows(const std::vector<double>& sums, double scale, CoarseCells& cells) {
  cells.rows.assign(sums.size(), 0);
  cells.places.resize(1);
  cells.mass.resize(1);
  for (int x = 0; x < cells.size.x; ++x) {
    for (int y = 0; y < cells.size.y; ++y) {
      for (int z = 0; z < cells.size.z; ++z) {
        const std::size_t i = cells.index({x, y, z});
        if (!(sums[i] > 0)) continue;
        cells.rows[i] = std::uint32_t(cells.count());
        cells.places.push_back({x, y, z});
        cells.mass.push_back(sums[i] * scale);
      }
    }
  }
}

[[nodiscard]] std::size_t count_cubes(const CoarseCells& cells) {
  return std::size_t(cells.size.x) * std::size_t(cells.size.y) * std::size_t(cells.size.z);
}

/// Cubes of this edge over a box of the world.
[[nodiscard]] CoarseCells world_grid(const Box& box, double edge) {
  CoarseCells cells;
  cells.shift = 0;
  cells.to_world = translation(box.lo) * scaling(Vec3d(edge));
  cells.to_cells = inverse(cells.to_world);
  const Vec3d extent = box.extent() / edge;
  cells.size =
      max(Vec3i(Vec3d(std::ceil(extent.x), std::ceil(extent.y), std::ceil(extent.z))), Vec3i(1));
  cells.last = widen(cells.size - Vec3i(1));
  return cells;
}

/// How the mass of each row's cube lies on the centres of its along^3 parts: shares, row by row.
[[nodiscard]] std::vector<float> spread(const Volume& v, const CoarseCells& cells, int along) {
  constexpr float kEven = 0.2f;  // for what lies between the points
  const int looks = v.density.motion != nullptr ? kTimes : 1;
  const auto parts = std::size_t(along * along * along);
  std::vector<float> all(cells.count() * parts);
  parallel_for(1, cells.count(), [&](std::size_t row) {
    float* const shares = all.data() + row * parts;
    float sum = 0;
    for (std::size_t i = 0; i < parts; ++i) {
      const Vec3d place = part_centre(cells.cube(row), along, int(i));
      for (int look = 0; look < looks; ++look) shares[i] += extinction_in_look(v, place, look);
      sum += shares[i];
    }
    for (std::size_t i = 0; i < parts; ++i) {
      shares[i] =
          (1 - kEven) * (sum > 0 ? shares[i] / sum : 1 / float(parts)) + kEven / float(parts);
    }
  });
  return all;
}

/// The maps from cells to the world of a volume's place: where it moves, at times so close that it
/// goes less than half of `edge` from one to the next, if that can be.
[[nodiscard]] std::vector<Affine> maps_of(const Volume& v, const Instance& at, double edge) {
  if (!place_moves(v, at.place)) return {inverse(at.world_to_cells)};
  const MovingPlaces& m = *v.moving_places;
  const Affine to_object = cells_to_object(v.density, v);
  const int times = int(std::clamp(std::ceil(4 * m.longest / edge), 1.0, double(kTimes)));
  std::vector<Affine> maps;
  for (int i = 0; i < times; ++i) {
    maps.push_back(m.all[at.place].at(m.shutter.at((i + 0.5) / times)) * to_object);
  }
  return maps;
}

/// Adds a volume at its places, by points of coarse cubes of its own, some of them in each cube of
/// the world. Returns the sum of their mass.
double add_world_mass(const Volume& v, std::span<const Instance> places, const CoarseCells& world,
                      std::vector<double>& sums) {
  const double edge = std::cbrt(std::abs(determinant(world.to_world)));
  const double cell = std::cbrt(std::abs(determinant(inverse(v.density.world_to_cells))));
  const int shift = std::clamp(int(std::floor(std::log2(edge / cell))), 3, 10);
  const CoarseCells own = make_coarse_cells(v, shift);
  std::map<int, std::vector<float>> spreads;  // by points along an edge: by size of the place
  double sum = 0;
  const auto add_at = [&](const Affine& to_world, double weight) {
    const Affine to_grid = world.to_cells * to_world;
    const double size = std::abs(determinant(to_world)) / std::abs(determinant(own.to_world));
    const double step = std::cbrt(std::abs(determinant(to_grid))) * std::ldexp(1.0, own.shift);
    const int along = std::clamp(int(std::ceil(2 * step)), 1, 8);
    const auto [shares, is_new] = spreads.try_emplace(along);
    if (is_new) shares->second = spread(v, own, along);
    const int parts = along * along * along;
    for (std::size_t row = 1; row < own.count(); ++row) {
      const double mass = own.mass[row] * size * weight;
      for (int i = 0; i < parts; ++i) {
        const Vec3d p = to_grid.point(part_centre(own.cube(row), along, i));
        const Vec3i c = min(max(Vec3i(p), Vec3i(0)), vec3(world.last));
        const auto share = shares->second[row * std::size_t(parts) + std::size_t(i)];
        sums[world.index(c)] += mass * double(share);
      }
      sum += mass;
    }
  };
  for (const Instance& at : places) {
    const std::vector<Affine> maps = maps_of(v, at, edge);
    for (const Affine& to_world : maps) add_at(to_world, 1.0 / double(maps.size()));
  }
  return sum;
}

}  // namespace

Box CoarseCells::cube(std::size_t row) const {
  const Vec3d at(places[row] + vec3(low));
  const double edge = std::ldexp(1.0, shift);
  return {at * edge, (at + Vec3d(1.0)) * edge};
}

Vec3d CoarseCells::point(std::size_t row, Rng& rng) const {
  const auto [u, v] = rng.uniform2();
  const Vec3d within(double(u), double(v), double(rng.uniform()));
  const Vec3d place(places[row] + vec3(low));
  return to_world.point((place + within) * std::ldexp(1.0, shift));
}

CoarseCells make_coarse_cells(const Volume& volume, int least_shift) {
  constexpr std::size_t kMost = std::size_t(1) << 18;
  const Octree& tree = volume.density.octree;
  CoarseCells cells;
  cells.to_cells = volume.density.world_to_cells;
  cells.to_world = inverse(cells.to_cells);
  for (cells.shift = least_shift;; ++cells.shift) {
    cells.low = tree.support_lo >> cells.shift;
    cells.last = ((tree.support_hi - 1) >> cells.shift) - cells.low;
    cells.size = vec3(cells.last) + Vec3i(1);
    if (count_cubes(cells) <= kMost) break;
  }
  std::vector<double> sums(count_cubes(cells));
  for (const Terminal& t : measure_terminals(volume)) add_mass(t, tree, cells, sums);
  add_rows(sums, double(volume.density.scale) / std::abs(determinant(cells.to_cells)), cells);
  cells.mass_of_volumes = {1};
  return cells;
}

CoarseCells make_world_cells(std::span<const Volume> volumes, const Instances& instances) {
  constexpr std::size_t kMostRows = std::size_t(1) << 18, kMostCubes = std::size_t(1) << 22;
  constexpr int kCells = 8;
  const Box box = world_box(volumes);
  double edge = std::numeric_limits<double>::infinity();
  for (const Instance& at : instances.all) {
    if (volumes[at.volume].density.octree.empty()) continue;
    edge = std::min(edge, kCells * std::cbrt(1 / std::abs(determinant(at.world_to_cells))));
  }
  for (;; edge *= 2) {
    const Vec3d cubes = box.extent() / edge + Vec3d(1.0);
    if (cubes.x * cubes.y * cubes.z > double(kMostCubes)) continue;
    CoarseCells cells = world_grid(box, edge);
    std::vector<double> sums(count_cubes(cells));
    auto from = instances.all.begin();
    for (const Volume& v : volumes) {
      const auto to = from + std::ptrdiff_t(count_places(v));
      const bool empty = v.density.octree.empty();
      cells.mass_of_volumes.push_back(empty ? 0 : add_world_mass(v, {from, to}, cells, sums));
      from = to;
    }
    if (std::size_t(std::ranges::count_if(sums, [](double m) { return m > 0; })) > kMostRows) {
      continue;
    }
    add_rows(sums, 1, cells);
    return cells;
  }
}

}  // namespace pvol::detail
