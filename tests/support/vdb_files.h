// Reading .vdb files in tests: samples of a grid, and what is said about a file.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "pvol/error.h"
#include "pvol/formats/vdb.h"

// OpenVDB loses a node where compressed values of it turn out to be damaged.
extern "C" const char* __lsan_default_suppressions();
extern "C" [[gnu::used]] inline const char* __lsan_default_suppressions() {
  return "leak:readTopology";
}

namespace pvol::test {

/// Finds bricks fast, for comparing whole clouds.
struct SampleFinder {
  explicit SampleFinder(const VoxelGrid& g) : grid(g) {
    for (const Brick& b : g.bricks) bricks[{b.origin.x, b.origin.y, b.origin.z}] = b.values;
  }
  [[nodiscard]] float operator()(Vec3i p) const {
    const auto at = bricks.find({p.x & ~7, p.y & ~7, p.z & ~7});
    if (at != bricks.end()) return at->second[((p.x & 7) * 8 + (p.y & 7)) * 8 + (p.z & 7)];
    VoxelGrid tiles;
    tiles.tiles = grid.tiles;
    return sample(tiles, p);
  }
  const VoxelGrid& grid;
  std::map<std::tuple<int, int, int>, const float*> bricks;
};

/// What reading does: the message of the error, or nothing.
inline std::string refusal(const std::filesystem::path& file,
                           const formats::GridOptions& options = {}) {
  try {
    static_cast<void>(formats::read_vdb(file, options));
    return {};
  } catch (const Error& e) {
    return e.what();
  }
}

inline std::string all(const std::vector<std::string>& warnings) {
  std::string text;
  for (const std::string& w : warnings) text += w + "\n";
  return text;
}

}  // namespace pvol::test
