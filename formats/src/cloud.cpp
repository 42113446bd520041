#include "pvol/formats/cloud.h"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <sstream>

#include "pvol/error.h"
#include "pvol/formats/recipe_file.h"
#include "pvol/medium/coarsen.h"

namespace pvol::formats {
namespace {

std::string hex(std::uint64_t v) {
  char text[24];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(v));
  return text;
}

/// What a reader would have reported for samples that are known to be clean.
GridReport describe_samples(const VoxelGrid& grid, const std::string& type) {
  GridReport r;
  r.grid = grid.name;
  r.type = type;
  for (const Brick& b : grid.bricks) {
    for (int i = 0; i < kBrickSamples; ++i) {
      r.active += b.values[i] > 0 ? 1 : 0;
      r.largest = std::max(r.largest, b.values[i]);
    }
  }
  for (const Tile& t : grid.tiles) {
    const auto edge = std::uint64_t(t.edge);
    r.active += edge * edge * edge;
    r.largest = std::max(r.largest, t.value);
  }
  return r;
}

void check_grid_name(const std::filesystem::path& file, const Metadata& m,
                     const GridOptions& options) {
  if (options.grid.empty() || options.grid == m.grid_name || options.grid == m.source.grid) return;
  throw Error(file.string() + ": holds the grid \"" + m.grid_name + "\", not \"" + options.grid +
              "\"; fit a file of its own to that grid");
}

/// The density that a .pvol file refers to, only if the file it was fitted to is unchanged.
LoadedGrid read_source(const std::filesystem::path& file, const Metadata& m, bool strict) {
  const std::filesystem::path source = file.parent_path() / m.source.file;
  const std::string advice =
      "; put the original back, or fit again (--density fp32 for a .pvol that "
      "needs no other file)";
  std::error_code failure;
  if (!std::filesystem::is_regular_file(source, failure)) {
    throw Error(file.string() + ": its density is in " + source.string() + ", which is not there" +
                advice);
  }
  const FileHash found = hash_file(source);
  if (found.bytes != m.source.bytes || found.hash != m.source.hash) {
    throw Error(file.string() + ": its density is in " + source.string() +
                ", which has changed: " + std::to_string(found.bytes) + " bytes with hash " +
                hex(found.hash) + ", expected " + std::to_string(m.source.bytes) + " with " +
                hex(m.source.hash) + advice);
  }
  return load_grid(source, {m.source.grid, strict});
}

LoadedGrid take_density(const std::filesystem::path& file, PvolFile& content,
                        const GridOptions& options) {
  check_grid_name(file, content.metadata, options);
  if (!content.density) return read_source(file, content.metadata, options.strict);
  LoadedGrid loaded;
  loaded.grid = std::move(*content.density);
  loaded.report = describe_samples(loaded.grid, "float");
  return loaded;
}

LoadedGrid load_recipe(const std::filesystem::path& file, const GridOptions& options) {
  if (!is_recipe(file)) {
    throw Error(file.string() +
                ": is a scene, expected a cloud: a .vdb, .nvdb or .pvol file, or a "
                "recipe, which is a .toml file with a [recipe] table");
  }
  LoadedGrid loaded;
  loaded.grid = make_grid(read_recipe(file));
  loaded.report = describe_samples(loaded.grid, "recipe");
  if (!options.grid.empty() && options.grid != loaded.grid.name) {
    throw Error(file.string() + ": a recipe makes the grid \"" + loaded.grid.name + "\", not \"" +
                options.grid + "\"");
  }
  return loaded;
}

}  // namespace

std::string ending(const std::filesystem::path& file) {
  std::string e = file.extension().string();
  std::transform(e.begin(), e.end(), e.begin(),
                 [](unsigned char c) { return char(std::tolower(c)); });
  return e;
}

LoadedGrid load_grid(const std::filesystem::path& file, const GridOptions& options) {
  const std::string kind = ending(file);
  if (kind == ".vdb") return read_vdb(file, options);
  if (kind == ".nvdb") return read_nvdb(file, options);
  if (kind == ".toml") return load_recipe(file, options);
  if (kind == ".pvol") {
    PvolFile content = read_pvol(file);
    return take_density(file, content, options);
  }
  throw Error(file.string() + ": the name ends in '" + kind +
              "', expected .vdb, .nvdb, .pvol or .toml (a recipe)");
}

Pyramid build_bounds(const VoxelGrid& grid, const std::filesystem::path& file) {
  try {
    return build_pyramid(grid);
  } catch (const Error& e) {
    throw Error(file.string() + ": " + e.what());
  }
}

Cloud load_cloud(const std::filesystem::path& file, const GridOptions& options) {
  Cloud cloud;
  LoadedGrid loaded;
  if (ending(file) == ".pvol") {
    PvolFile content = read_pvol(file);
    loaded = take_density(file, content, options);
    cloud.pyramid = std::move(content.pyramid);
    cloud.shell = std::move(content.shell);
    cloud.micro = std::move(content.micro);
    cloud.metadata = std::move(content.metadata);
  } else {
    loaded = load_grid(file, options);
    cloud.pyramid = build_bounds(loaded.grid, file);
    cloud.metadata.grid_name = loaded.grid.name;
    cloud.metadata.index_to_world = loaded.grid.index_to_world;
    cloud.metadata.source = {file.string(), loaded.report.grid, 0, 0};
  }
  cloud.grid = std::move(loaded.grid);
  cloud.report = std::move(loaded.report);
  return cloud;
}

void coarsen(Cloud& cloud, int times, const std::filesystem::path& file) {
  if (times <= 0) return;
  for (int i = 0; i < times; ++i) cloud.grid = pvol::coarsen(cloud.grid);
  cloud.pyramid = build_bounds(cloud.grid, file);
  cloud.micro.reset();
  cloud.shell.reset();
}

void quantise(Cloud& cloud, const Quantisation& how, const std::filesystem::path& file) {
  Metadata& m = cloud.metadata;
  const Quantisation& stored = m.quantisation;
  const bool same_tolerance = how.precision != Precision::fpn || how.tolerance == stored.tolerance;
  if (how.precision == stored.precision && same_tolerance) return;
  if (stored.precision != Precision::fp32) {
    std::ostringstream kept;
    kept << name(stored.precision) << " with a tolerance of " << stored.tolerance;
    throw Error(file.string() + ": its density is kept in " +
                (stored.precision == Precision::fpn ? kept.str() : name(stored.precision)) +
                "; render it as it is stored, or take its source, " + m.source.file);
  }
  m.quantisation = how;
  m.quantisation_error = quantise_in_place(cloud.grid, how);
  cloud.pyramid = build_bounds(cloud.grid, file);
  cloud.micro.reset();
}

}  // namespace pvol::formats
