// The verb `info`: the grids of files, where they lie, and what a render would make of them.
#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <limits>
#include <optional>

#include "cli/json.h"
#include "pvol/error.h"
#include "pvol/field/micro_range.h"
#include "pvol/formats/field_names.h"
#include "pvol/formats/scene_file.h"
#include "pvol/formats/velocity.h"
#include "report/terminal.h"
#include "stats/stats.h"

namespace pvol::cli {
namespace {

/// Of a brick of 8^3 samples, with those of its neighbours that interpolation reads.
constexpr std::uint64_t kSamplesInMemory = 9 * 9 * 9;

/// What reading a grid shows.
struct GridContent {
  std::uint64_t active = 0;  ///< voxels; of a .pvol or a recipe those that are occupied
  DensityRange values{};     ///< of samples above 0
  Vec3l first, last;         ///< samples above 0 lie between these, both included
  Box world{};               ///< where the interpolated values can be above 0
  Vec3d voxel{};             ///< lengths of its edges in the world
  bool is_rotated = false;   ///< whether its axes are not those of the world
  std::uint64_t memory = 0;  ///< bytes of samples while it is rendered
};

struct GridInfo {
  formats::GridEntry entry;
  std::string use;                       ///< "density", "fire", ...; empty: none
  std::optional<GridContent> content{};  ///< nothing for vectors, and what holds no values above 0
  std::string problem{};                 ///< why it cannot be read
};

struct FileInfo {
  std::string file;
  std::uint64_t bytes = 0;
  std::vector<GridInfo> grids{};
  std::vector<std::string> notes{};  ///< what a render binds by itself
};

DensityRange values_of(const VoxelGrid& grid) {
  DensityRange r{std::numeric_limits<float>::max(), 0};
  const auto add = [&](float v) {
    if (v > 0) r = {std::min(r.lo, v), std::max(r.hi, v)};
  };
  for (const Brick& b : grid.bricks) std::for_each_n(b.values, kBrickSamples, add);
  for (const Tile& t : grid.tiles) add(t.value);
  return r;
}

std::optional<GridContent> content_of(const formats::Cloud& cloud) {
  const Pyramid& p = cloud.pyramid;
  if (p.empty()) return std::nullopt;
  const VoxelGrid& grid = cloud.grid();
  const Affine& map = grid.index_to_world;
  GridContent c;
  c.active = cloud.report.active;
  c.values = values_of(grid);
  c.first = p.support_lo + Vec3l(1), c.last = p.support_hi - Vec3l(1);
  c.world = transform(map, p.support());
  c.voxel = {length(map.vector({1, 0, 0})), length(map.vector({0, 1, 0})),
             length(map.vector({0, 0, 1}))};
  c.is_rotated = map.m[0].y != 0 || map.m[0].z != 0 || map.m[1].x != 0 || map.m[1].z != 0 ||
                 map.m[2].x != 0 || map.m[2].y != 0;
  c.memory = grid.bricks.size() * kSamplesInMemory * sizeof(float);
  return c;
}

/// The uses that a render of the file by itself finds by the names of grids.
void bind(FileInfo& info, const std::vector<formats::GridEntry>& grids) {
  formats::SceneVolume v;
  v.file = info.file;
  v.shows_fire = true;
  info.notes = formats::bind_fields(v, grids);
  for (std::string& note : formats::bind_albedo(v, grids)) info.notes.push_back(std::move(note));
  const auto use = [&](const std::string& name, const std::string& what) {
    for (GridInfo& g : info.grids) {
      // Of several of one name a render takes the first.
      const bool used = g.entry.name == name || g.entry.name == name + "[0]";
      if (used) g.use += (g.use.empty() ? "" : ", ") + what;
    }
  };
  const auto only_usable = [&]() -> std::string {
    const auto usable = [](const formats::GridEntry& g) { return g.usable; };
    if (std::ranges::count_if(grids, usable) != 1) return "density";
    return std::ranges::find_if(grids, usable)->name;
  };
  if (v.grid != formats::kNoGrid) use(v.grid.empty() ? only_usable() : v.grid, "density");
  if (v.fire) {
    use(v.fire->field, "fire");
    if (v.fire->color_by != v.fire->field) use(v.fire->color_by, "colour of the fire");
  } else {
    for (const std::string& name : formats::usual_fire_grids(grids))
      use(name, "fire, if asked for");
  }
  if (v.albedo_field) use(v.albedo_field->grid, "albedo");
  const std::string velocity = formats::usual_velocity(grids);
  if (!velocity.empty()) use(velocity, "velocity");
}

FileInfo info_of(const std::filesystem::path& file) {
  FileInfo info{file.string(), std::filesystem::file_size(file)};
  const std::vector<formats::GridEntry> grids = formats::grids_of(file);
  for (const formats::GridEntry& entry : grids) {
    GridInfo g{entry, ""};
    try {
      if (entry.usable) g.content = content_of(formats::load_cloud(file, {entry.name, false}));
    } catch (const Error& e) {
      g.problem = e.what();
    }
    info.grids.push_back(std::move(g));
  }
  bind(info, grids);
  return info;
}

template <class V>
std::string triple(const V& v) {
  return fmt::format("{:.6g} {:.6g} {:.6g}", double(v.x), double(v.y), double(v.z));
}

std::string voxel_text(const GridContent& c) {
  const bool is_cube = c.voxel.x == c.voxel.y && c.voxel.x == c.voxel.z;
  return (is_cube ? fmt::format("{:.6g}", c.voxel.x) : triple(c.voxel)) +
         (c.is_rotated ? ", turned" : "");
}

report::Document document_of(const FileInfo& info) {
  report::Document d{.title = info.file,
                     .subject = info.file,
                     .lead = fmt::format("{}, {} grid{}", readable_bytes(info.bytes),
                                         info.grids.size(), info.grids.size() == 1 ? "" : "s")};
  const bool has_active_voxels = info.file.ends_with("vdb");  // others know what is not 0
  report::Table grids{.header = {"grid", "type", "use",
                                 has_active_voxels ? "active voxels" : "voxels above 0", "values",
                                 "memory"}};
  report::Table places{.header = {"grid", "voxels from", "to", "world from", "to", "voxel"}};
  for (const GridInfo& g : info.grids) {
    std::vector<std::string> row{g.entry.name, g.entry.type, g.use.empty() ? "-" : g.use};
    if (!g.content) {
      row.insert(row.end(), {"", g.problem.empty() ? "" : "cannot be read", ""});
    } else {
      const GridContent& c = *g.content;
      row.insert(row.end(), {readable_count(c.active),
                             fmt::format("{:.4g} to {:.4g}", c.values.lo, c.values.hi),
                             readable_bytes(c.memory)});
      places.rows.push_back({g.entry.name, triple(c.first), triple(c.last), triple(c.world.lo),
                             triple(c.world.hi), voxel_text(c)});
    }
    grids.rows.push_back(std::move(row));
  }
  add(d, grids);
  if (!places.rows.empty()) add(d, places);
  for (const GridInfo& g : info.grids) {
    if (!g.problem.empty()) add(d, report::Text{g.problem});
  }
  for (const std::string& note : info.notes) add(d, report::Text{"Render: " + note + "."});
  return d;
}

Json json_of(const FileInfo& info) {
  Json grids = Json::array();
  for (const GridInfo& g : info.grids) {
    Json j{{"name", g.entry.name}, {"type", g.entry.type}, {"use", g.use}};
    if (!g.problem.empty()) j["problem"] = g.problem;
    if (g.content) {
      const GridContent& c = *g.content;
      const auto list = [](const auto& v) { return Json::array({v.x, v.y, v.z}); };
      j["active_voxels"] = c.active;
      j["values"] = {c.values.lo, c.values.hi};
      j["voxels"] = {{"first", list(c.first)}, {"last", list(c.last)}};
      j["world"] = {{"low", list(c.world.lo)}, {"high", list(c.world.hi)}};
      j["voxel_size"] = list(c.voxel);
      j["rotated"] = c.is_rotated;
      j["memory"] = c.memory;
    }
    grids.push_back(std::move(j));
  }
  return {{"file", info.file}, {"bytes", info.bytes}, {"grids", grids}, {"notes", info.notes}};
}

}  // namespace

int run_info(const InfoOptions& o) {
  int code = kSuccess;
  Json all = Json::array();
  for (const std::filesystem::path& file : o.inputs) {
    try {
      if (!std::filesystem::exists(file)) throw Error(file.string() + ": there is no such file");
      const FileInfo info = info_of(file);
      if (std::ranges::any_of(info.grids, [](const auto& g) { return !g.problem.empty(); })) {
        code = kFailure;
      }
      if (o.json) {
        all.push_back(json_of(info));
      } else {
        std::cout << (&file == &o.inputs.front() ? "" : "\n")
                  << report::to_terminal(document_of(info));
      }
    } catch (const Error& e) {
      std::cerr << "pvol-stats: error: " << e.what() << '\n';
      code = kFailure;
    }
  }
  if (o.json) std::cout << to_text(all);
  return code;
}

}  // namespace pvol::cli
