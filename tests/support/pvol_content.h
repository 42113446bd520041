// Contents of .pvol files, and a fixture that writes them, for tests.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "pvol/error.h"
#include "pvol/formats/pvol_file.h"
#include "support/pvol_bytes.h"
#include "support/temporary_folder.h"

namespace pvol::test {

namespace fs = std::filesystem;
using formats::Compression;
using formats::Metadata;
using formats::PvolFile;

/// A folder of its own for each test.
class PvolFileTest : public testing::Test {
 protected:
  [[nodiscard]] fs::path path(const std::string& name) const { return folder_ / name; }

  /// Names in the folder.
  [[nodiscard]] std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_)) {
      names.push_back(entry.path().filename().string());
    }
    return names;
  }

  [[nodiscard]] std::vector<std::byte> written(const PvolFile& content,
                                               Compression compression = Compression::zstd) const {
    write_pvol(path("bytes.pvol"), content, compression);
    return load(path("bytes.pvol"));
  }

  const TemporaryFolder own_;
  const fs::path folder_ = own_.path();
};

inline Metadata some_metadata() {
  Metadata m;
  m.grid_name = "dichte \"ρ\"\n";
  m.index_to_world = scaling({0.1, -1e-9, 3e9});
  m.index_to_world.t = {1.0 / 3, -0.0, 1e308};
  m.source = {"clouds/a b.vdb", "density[1]", 0xffffffffffffffff, 0x0123456789abcdef};
  m.unit = std::string("m");  // GCC 12 warns of a literal here, in some programs
  m.options = {{"depth", "auto"}, {"", "empty"}, {"shells", ""}};
  m.written_by = "pvol-fit 0.1.0";
  return m;
}

/// A shell of the cloud's size with numbers of all kinds; it need not hold anything.
inline Shell some_shell(const Pyramid& pyramid) {
  Shell s;
  s.kind = ShellKind::soft;
  s.lo = pyramid.support_lo;
  s.hi = pyramid.support_hi;
  s.form.base = ellipsoid({0.1, 0.2, 0.3}, Vec3d(0.9, 0.8, 0.7));
  s.form.perturbations = {{{half_space({0.5, 0.5, 0}, {1, 2, 3}), {}}, -0.3},
                          {{ellipsoid({-0.5, 0, 1e-30}, Vec3d(1e-9)), {}}, 1e30}};
  s.form = round_to_float(s.form);
  s.certificate = {1.0 / 3, 0x123456789ab, -4};
  s.tightness = {1.5, 1.125, 4, 2.25};
  return s;
}

/// A field of a few bricks and tiles, with its true bounds, and a shell.
inline PvolFile some_file(int bricks = 12, bool tiles = true) {
  VoxelGrid g;
  g.name = some_metadata().grid_name;
  g.index_to_world = some_metadata().index_to_world;
  auto values = std::make_shared<std::vector<float>>(std::size_t(bricks) * kBrickSamples);
  std::mt19937 random(5);
  for (float& v : *values) v = random() % 3 == 0 ? 0 : float(random() % 1000) * 0.007f;
  std::vector<Vec3i> origins;
  for (int i = 0; i < bricks; ++i) origins.push_back(Vec3i(i % 3, i / 3 % 5, i / 15) * 8);
  std::shuffle(origins.begin(), origins.end(), random);
  for (int i = 0; i < bricks; ++i) {
    g.bricks.push_back({origins[std::size_t(i)] - Vec3i(16), values->data() + i * kBrickSamples});
  }
  if (tiles) {
    g.tiles.push_back({{128, 0, -128}, 128, 0.25f});
    g.tiles.push_back({{-64, 0, 0}, 8, 0.125f});
    g.tiles.push_back({{-80, 0, 0}, 8, 0.0f});
  }
  g.owner = values;
  PvolFile file{some_metadata(), build_pyramid(g), g, std::nullopt};
  file.shell = some_shell(file.pyramid);
  return file;
}

/// A cloud of few leaves, some of them of one density: small enough to be read thousands of times.
inline PvolFile compact_file() {
  PvolFile file = some_file(12, false);
  for (int i = 0; i < 8; ++i) {
    file.density->tiles.push_back(
        {Vec3i(-64, 0, 0) + Vec3i(i >> 2, i >> 1 & 1, i & 1) * 8, 8, 0.125f});
  }
  file.pyramid = build_pyramid(*file.density);
  file.shell = some_shell(file.pyramid);
  return file;
}

/// The same with micro-bounds of its density, or of what its codes stand for.
inline PvolFile with_micro_bounds(PvolFile file) {
  const VoxelGrid grid = file.codes ? decode(*file.codes) : *file.density;
  file.micro = build_leaf_micro_bounds(grid, file.pyramid, 2);
  return file;
}

/// The same with codes in place of its density, and bounds of what they stand for.
inline PvolFile with_codes(PvolFile file, const Quantisation& how) {
  file.codes = quantise(*file.density, how);
  file.density.reset();
  file.pyramid = build_pyramid(decode(*file.codes));  // of the same support, so a shell stays
  return file;
}

inline PvolFile tiny_file() {
  auto values = std::make_shared<std::vector<float>>(std::size_t(kBrickSamples));
  values->at(kBrickSamples - 1) = 0.75f;
  VoxelGrid g;
  g.bricks.push_back({{0, 8, -8}, values->data()});
  g.owner = values;
  PvolFile file{{}, build_pyramid(g), std::nullopt, std::nullopt};
  file.metadata.source = {"a.vdb", "density", 1234, 0xfedcba9876543210};
  file.metadata.written_by = "test";
  return file;
}

/// Equal bricks and tiles in any order; those of zeros may be missing.
inline void expect_equal_samples(const VoxelGrid& a, const VoxelGrid& b) {
  const auto contents = [](const VoxelGrid& g) {
    std::map<std::array<std::int32_t, 4>, std::vector<float>> all;  // by origin and edge
    for (const Brick& brick : g.bricks) {
      const Vec3i o = brick.origin;
      all[{o.x, o.y, o.z, 0}].assign(brick.values, brick.values + kBrickSamples);
    }
    for (const Tile& t : g.tiles) all[{t.origin.x, t.origin.y, t.origin.z, t.edge}] = {t.value};
    std::erase_if(all, [](const auto& entry) {
      return std::all_of(entry.second.begin(), entry.second.end(), [](float v) { return v == 0; });
    });
    return all;
  };
  EXPECT_FALSE(contents(a).empty());
  EXPECT_TRUE(contents(a) == contents(b));
}

inline std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& e) {
    return e.what();
  }
  return {};
}

}  // namespace pvol::test
