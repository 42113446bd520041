#include "support/fields.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>

#include "pvol/bounds/pyramid.h"
#include "pvol/math/rng.h"
#include "support/cloud_scene.h"

namespace pvol::test {
namespace {

std::int32_t floor_to(std::int32_t v, std::int32_t edge) { return v & -edge; }

/// The lower corners of the aligned cubes of this edge that meet the field's box.
std::vector<Vec3i> cubes(const Field& f, std::int32_t edge) {
  std::vector<Vec3i> at;
  const Vec3i end = f.origin + f.size;
  for (std::int32_t x = floor_to(f.origin.x, edge); x < end.x; x += edge) {
    for (std::int32_t y = floor_to(f.origin.y, edge); y < end.y; y += edge) {
      for (std::int32_t z = floor_to(f.origin.z, edge); z < end.z; z += edge)
        at.push_back({x, y, z});
    }
  }
  return at;
}

bool is_constant(const Field& f, Vec3i at, std::int32_t edge) {
  const float first = f.at(at);
  for (int i = 0; i < edge; ++i) {
    for (int j = 0; j < edge; ++j) {
      for (int k = 0; k < edge; ++k) {
        if (f.at(at + Vec3i(i, j, k)) != first) return false;
      }
    }
  }
  return true;
}

bool in_tile(const VoxelGrid& grid, Vec3i at) {
  return std::any_of(grid.tiles.begin(), grid.tiles.end(), [at](const Tile& t) {
    return Vec3i(floor_to(at.x, t.edge), floor_to(at.y, t.edge), floor_to(at.z, t.edge)) ==
           t.origin;
  });
}

void add_tiles(Field& f, std::int32_t edge) {
  for (const Vec3i at : cubes(f, edge)) {
    if (f.at(at) > 0 && is_constant(f, at, edge)) f.grid.tiles.push_back({at, edge, f.at(at)});
  }
}

void add_bricks(Field& f) {
  std::vector<Vec3i> places;
  for (const Vec3i at : cubes(f, kBrickEdge)) {
    const bool empty = f.at(at) == 0 && is_constant(f, at, kBrickEdge);
    if (!empty && !in_tile(f.grid, at)) places.push_back(at);
  }
  auto values = std::make_shared<std::vector<float>>(places.size() * kBrickSamples);
  float* next = values->data();
  for (const Vec3i at : places) {
    f.grid.bricks.push_back({at, next});
    for (int i = 0; i < kBrickEdge; ++i) {
      for (int j = 0; j < kBrickEdge; ++j) {
        for (int k = 0; k < kBrickEdge; ++k) *next++ = f.at(at + Vec3i(i, j, k));
      }
    }
  }
  f.grid.owner = values;
}

/// Uniform in [0, 1), fixed for each lattice point.
double noise(Vec3i p) {
  const auto u = [](std::int32_t v) { return std::uint64_t(std::uint32_t(v)); };
  return double(mix64(mix64(u(p.x) << 32 | u(p.y)) ^ u(p.z)) >> 11) * 0x1p-53;
}

double gaussian(Vec3i p, Vec3d centre, double sigma) {
  const Vec3d d = Vec3d(p) - centre;
  return std::exp(-0.5 * dot(d, d) / (sigma * sigma));
}

std::vector<Field> make_fields() {
  constexpr Vec3i kFar{-3, 5, 1000003};
  std::vector<Field> f;
  f.push_back(make_field("constant", {0, 0, 0}, {20, 20, 20}, [](Vec3i) { return 1; }));
  f.push_back(
      make_field("linear", {2, 1, 3}, {30, 12, 9}, [](Vec3i p) { return double(p.x - 1) / 30; }));
  f.push_back(make_field("gaussian", {-20, -20, -20}, {41, 41, 41}, [](Vec3i p) {
    return gaussian(p, {0, 0, 0}, 6);
  }));
  f.push_back(make_field("exponential", {0, 0, 0}, {16, 16, 40},
                         [](Vec3i p) { return std::exp(-0.2 * p.z); }));
  f.push_back(make_field("checkerboard", {-8, -8, -8}, {24, 24, 24},
                         [](Vec3i p) { return (p.x + p.y + p.z) & 1 ? 1.0 : 0.5; }));
  f.push_back(make_field("nearly_empty", {0, 0, 0}, {64, 64, 64}, [](Vec3i p) {
    if (p == Vec3i(40, 41, 42)) return 1.0;
    return p == Vec3i(3, 3, 3) || p == Vec3i(20, 20, 20) || p == Vec3i(21, 20, 20) ? 1e-6 : 0.0;
  }));
  f.push_back(make_field("contrast", {0, 0, 0}, {16, 16, 16},
                         [](Vec3i p) { return noise(p) < 0.1 ? 1.0 : 1e-6; }));
  f.push_back(make_field("one_voxel", {4, 4, 4}, {1, 1, 1}, [](Vec3i) { return 1; }));
  f.push_back(make_field("one_voxel_on_a_border", {7, 8, -1}, {1, 1, 1}, [](Vec3i) { return 1; }));
  f.push_back(make_field("sheet", {-10, -10, 8}, {40, 40, 1}, [](Vec3i) { return 1; }));
  f.push_back(make_field("sparse", {-30, 10, -50}, {70, 60, 50},
                         [](Vec3i p) { return noise(p) < 0.01 ? noise(p) * 100 : 0; }));
  f.push_back(make_field("far", kFar, {33, 25, 41}, [](Vec3i p) {
    return gaussian(p, {10, 20, 1000020}, 7) * (0.5 + 0.5 * noise(p));
  }));
  f.push_back(make_field(
      "tiles_8", {-16, 0, 8}, {48, 32, 32},
      [](Vec3i p) { return ((p.x >> 3) + (p.y >> 4)) & 1 ? 1.0
                           : noise(p) < 0.001            ? 0.0
                                                         : 0.25; },
      Tiles::edge_8));
  f.push_back(make_field(
      "tiles_128", {-128, 0, 0}, {136, 128, 128},
      [](Vec3i p) { return p.x < 0 ? 0.75 : 0.5 + 0.5 * noise(p); }, Tiles::edge_128));
  return f;
}

}  // namespace

Field make_field(std::string name, Vec3i origin, Vec3i size,
                 const std::function<double(Vec3i)>& density, Tiles tiles, double voxel) {
  Field f;
  f.name = std::move(name);
  f.origin = origin;
  f.size = size;
  for (int i = 0; i < size.x; ++i) {
    for (int j = 0; j < size.y; ++j) {
      for (int k = 0; k < size.z; ++k) {
        const float v = float(density(origin + Vec3i(i, j, k)));
        f.samples.push_back(v);
        f.largest = std::max(f.largest, v);
        f.sum += double(v);
      }
    }
  }
  if (tiles != Tiles::none) add_tiles(f, tiles == Tiles::edge_8 ? 8 : 128);
  add_bricks(f);
  f.grid.index_to_world = scaling(Vec3d(voxel));
  return f;
}

const std::vector<Field>& fields() {
  static const std::vector<Field> all = make_fields();
  return all;
}

const Field& field(const std::string& name) {
  for (const Field& f : fields()) {
    if (f.name == name) return f;
  }
  throw std::invalid_argument("no test field " + name);
}

Vec3d random_point_near_density(const Field& field, Rng& rng) {
  std::size_t i = rng.block().lo % field.samples.size();
  while (field.samples[i] == 0) i = (i + 1) % field.samples.size();
  const std::size_t ny = std::size_t(field.size.y), nz = std::size_t(field.size.z);
  const Vec3d at(double(i / (ny * nz)), double(i / nz % ny), double(i % nz));
  const auto offset = [&] { return 2 * double(rng.uniform()) - 1; };
  return Vec3d(field.origin) + at + Vec3d{offset(), offset(), offset()};
}

Volume make_test_volume(const Field& field, double extinction, std::optional<int> depth,
                        Tracker tracker, LookUp look_up) {
  CloudScene scene;
  scene.medium.extinction = extinction;
  scene.options.depth = depth;
  scene.options.tracker = tracker;
  scene.options.look_up = look_up;
  VolumeOptions o = scene.volume_options();
  o.samples = SampleStorage::copied;
  return pvol::make_volume(field.grid, build_pyramid(field.grid, look_up), scene.medium.medium(),
                           o);
}

}  // namespace pvol::test
