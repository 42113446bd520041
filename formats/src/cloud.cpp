#include "pvol/formats/cloud.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "pvol/bounds/recipe_bounds.h"
#include "pvol/density/coarsen.h"
#include "pvol/density/sample_count.h"
#include "pvol/error.h"
#include "pvol/formats/field_names.h"
#include "pvol/formats/recipe_file.h"
#include "pvol/formats/scene_file.h"

namespace pvol::formats {
namespace {

std::string hex(std::uint64_t v) { return fmt::format("{:016x}", v); }

/// What a reader would have reported for samples that are known to be clean.
GridReport describe_samples(const VoxelGrid& grid, const std::string& type,
                            const SampleCount& count) {
  GridReport r;
  r.grid = grid.name;
  r.type = type;
  r.active = count.active, r.largest = count.largest;
  return r;
}

/// The file with the density that a .pvol file refers to, only if it is unchanged.
std::filesystem::path find_source(const std::filesystem::path& file, const Metadata& m) {
  const std::filesystem::path source = file.parent_path() / m.source.file;
  const std::string advice =
      "; restore the original, or fit again (--density fp32 for a .pvol that needs no other file)";
  std::error_code failure;
  if (!std::filesystem::is_regular_file(source, failure)) {
    throw Error(file.string() + ": its density is in " + source.string() +
                ", which does not exist" + advice);
  }
  const FileHash found = hash_file(source);
  if (found.bytes != m.source.bytes || found.hash != m.source.hash) {
    throw Error(fmt::format(
        "{}: its density is in {}, which has changed: {} bytes with hash {}, expected {} with {}{}",
        file.string(), source.string(), found.bytes, hex(found.hash), m.source.bytes,
        hex(m.source.hash), advice));
  }
  return source;
}

LoadedGrid take_density(const std::filesystem::path& file, PvolFile& content,
                        const GridOptions& options) {
  if (!content.density) {
    const Metadata& m = content.metadata;
    return load_grid(find_source(file, m), {m.source.grid, options.strict});
  }
  LoadedGrid loaded;
  loaded.grid = std::move(*content.density);
  loaded.report = describe_samples(loaded.grid, "float", content.count);
  return loaded;
}

Recipe read_recipe_of(const std::filesystem::path& file, const GridOptions& options) {
  if (!is_recipe(file)) {
    throw Error(file.string() +
                ": found a scene, expected a cloud: a .vdb, .nvdb or .pvol file, or a recipe, "
                "which is a .toml file with a [recipe] table");
  }
  Recipe recipe = read_recipe(file);
  if (!options.grid.empty() && options.grid != recipe.name) {
    throw Error(file.string() + ": the recipe holds the grid \"" + recipe.name + "\", not \"" +
                options.grid + "\"");
  }
  return recipe;
}

LoadedGrid load_recipe(const std::filesystem::path& file, const GridOptions& options) {
  LoadedGrid loaded;
  loaded.grid = make_grid(read_recipe_of(file, options));
  loaded.report = describe_samples(loaded.grid, "recipe", count_samples(loaded.grid));
  return loaded;
}

[[noreturn]] void refuse_procedural(const std::filesystem::path& file) {
  throw Error(file.string() +
              ": procedural look-ups are for recipes (.toml), and for .pvol files of recipes that "
              "were fitted with --closed-form; this one holds samples. Choose another "
              "interpolation.");
}

[[noreturn]] void refuse_kind(const std::filesystem::path& file) {
  refuse_folder(file, "a .vdb, .nvdb, .pvol or .toml (a recipe)");
  const std::string kind = ending(file);
  std::string what_to_do;
  if (kind == ".gz") what_to_do = "; unpack it first: gunzip " + file.string();
  if (kind == ".usda" || kind == ".pbrt") {
    what_to_do = "; make a scene of it: pvol-convert " + file.string() + " scene.toml";
  }
  throw Error(file.string() + ": the name ends in '" + kind +
              "', expected .vdb, .nvdb, .pvol or .toml (a recipe)" + what_to_do);
}

/// A recipe for procedural look-ups, without its bounds.
Cloud load_unsampled(const std::filesystem::path& file, const GridOptions& options) {
  Cloud cloud;
  cloud.density = std::make_shared<const Recipe>(read_recipe_of(file, options));
  cloud.report.grid = cloud.recipe()->name;
  cloud.report.type = "recipe, not sampled";
  return cloud;
}

/// `f()`, with the file's name in its errors.
template <class F>
auto naming(const std::filesystem::path& file, const F& f) {
  try {
    return f();
  } catch (const Error& e) {
    throw Error(file.string() + ": " + e.what());
  }
}

/// Refuses bounds that were made for another interpolation than the wanted one.
void check_interpolation(const std::filesystem::path& file, const Pyramid& pyramid, LookUp wanted) {
  if (holds_for(pyramid.look_up, wanted)) return;
  if (wanted == LookUp::procedural) refuse_procedural(file);
  throw Error(file.string() + ": its bounds were made for " + name(pyramid.look_up) +
              " interpolation and do not hold for " + name(wanted) +
              "; fit the cloud again with pvol-fit --interpolation " + name(wanted));
}

Cloud load_pvol(const std::filesystem::path& file, const GridOptions& options, LookUp look_up) {
  PvolFile content = read_pvol_grid(file, options.grid);
  check_interpolation(file, content.pyramid, look_up);
  Cloud cloud;
  if (look_up == LookUp::procedural) {
    cloud = load_unsampled(find_source(file, content.metadata), {content.metadata.source.grid});
  } else {
    LoadedGrid loaded = take_density(file, content, options);
    cloud.density = std::move(loaded.grid);
    cloud.report = std::move(loaded.report);
  }
  cloud.pyramid = std::move(content.pyramid);
  cloud.shell = std::move(content.shell);
  cloud.micro = std::move(content.micro);
  cloud.metadata = std::move(content.metadata);
  cloud.forget_pages = std::move(content.forget_pages);
  return cloud;
}

}  // namespace

void refuse_folder(const std::filesystem::path& file, const std::string& expected) {
  std::error_code ignored;
  if (!std::filesystem::is_directory(file, ignored)) return;
  throw Error(file.string() + ": is a folder; expected " + expected);
}

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
    PvolFile content = read_pvol_grid(file, options.grid);
    return take_density(file, content, options);
  }
  refuse_kind(file);
}

Pyramid build_bounds(const VoxelGrid& grid, const std::filesystem::path& file, LookUp look_up) {
  return naming(file, [&] { return build_pyramid(grid, look_up); });
}

std::vector<GridEntry> grids_of(const std::filesystem::path& file) {
  const std::string kind = ending(file);
  if (kind == ".vdb") return list_vdb(file);
  if (kind == ".nvdb") return list_nvdb(file);
  if (kind == ".pvol") {
    std::vector<GridEntry> all;
    for (const PvolGridName& g : list_pvol(file)) {
      all.push_back({g.name, g.empty ? "empty" : "float", !g.empty});
    }
    return all;
  }
  if (kind == ".toml") return {{read_recipe_of(file, {}).name, "recipe", true}};
  refuse_kind(file);
}

FireFields load_fire(const std::filesystem::path& file, const Fire& fire, bool strict) {
  FireFields fields{load_cloud(file, {fire.field, strict}), std::nullopt};
  if (fire.colored() && fire.color_by != fire.field) {
    fields.color_by = load_cloud(file, {fire.color_by, strict});
  }
  return fields;
}

AlbedoGrid load_albedo(const std::filesystem::path& file, const AlbedoMap& map, bool strict,
                       const Cloud* loaded) {
  AlbedoGrid grid;
  if (!has_colors(grids_of(file), map.grid)) {
    const bool same = loaded != nullptr && is_sampled(loaded->density) &&
                      loaded->grid().name == map.grid &&
                      loaded->pyramid.look_up == LookUp::trilinear;
    grid.numbers = same ? *loaded : load_cloud(file, {map.grid, strict});
    return grid;
  }
  if (map.is_of_numbers()) {
    throw Error(fmt::format(
        "{}: the grid '{}' has colours, which are not mapped; found scale, offset, clamp, power, "
        "ramp or colors in [medium.albedo_field], which apply to grids of numbers; leave them out",
        file.string(), map.grid));
  }
  grid.colors = read_color(file, map.grid, strict);
  return grid;
}

Cloud load_cloud(const std::filesystem::path& file, const GridOptions& options, LookUp look_up,
                 const std::function<void()>& before_bounds) {
  if (options.grid == kNoGrid) {
    Cloud nothing;
    nothing.metadata.source.file = file.string();
    nothing.report.type = "none";
    return nothing;
  }
  if (ending(file) == ".pvol") return load_pvol(file, options, look_up);
  Cloud cloud;
  if (look_up == LookUp::procedural) {
    if (ending(file) != ".toml") refuse_procedural(file);
    cloud = load_unsampled(file, options);
    before_bounds();
    cloud.pyramid = naming(file, [&] { return build_pyramid(*cloud.recipe()); });
  } else {
    LoadedGrid loaded = load_grid(file, options);
    cloud.density = std::move(loaded.grid);
    cloud.report = std::move(loaded.report);
    before_bounds();
    cloud.pyramid = build_bounds(cloud.grid(), file, look_up);
  }
  const Recipe* recipe = cloud.recipe();
  cloud.metadata.grid_name = recipe ? recipe->name : cloud.grid().name;
  cloud.metadata.index_to_world = index_to_object(cloud.density);
  cloud.metadata.source = {file.string(), cloud.report.grid, 0, 0};
  return cloud;
}

namespace {

/// Refuses to change the samples of a cloud that has none.
void require_samples(const Cloud& cloud, const char* what, const std::filesystem::path& file) {
  if (cloud.recipe() == nullptr) return;
  throw Error(file.string() + ": a recipe with procedural look-ups has no samples, but " + what +
              " changes samples; choose another interpolation");
}

/// Bounds for new samples, for the interpolation that the old ones were for. Those of a recipe in
/// closed form served its samples, too.
void bound_again(Cloud& cloud, const std::filesystem::path& file) {
  const LookUp made = cloud.pyramid.look_up;
  cloud.pyramid =
      build_bounds(cloud.grid(), file, made == LookUp::tricubic ? made : LookUp::trilinear);
}

}  // namespace

void coarsen(Cloud& cloud, int times, const std::filesystem::path& file) {
  if (times <= 0) return;
  require_samples(cloud, "a preview", file);
  for (int i = 0; i < times; ++i) cloud.density = pvol::coarsen(cloud.grid());
  bound_again(cloud, file);
  cloud.micro.reset();
  cloud.shell.reset();
  cloud.facts.reset();
}

void quantise(Cloud& cloud, const Quantisation& how, const std::filesystem::path& file) {
  Metadata& m = cloud.metadata;
  const Quantisation& stored = m.quantisation;
  const bool same_tolerance = how.precision != Precision::fpn || how.tolerance == stored.tolerance;
  if (how.precision == stored.precision && same_tolerance) return;
  if (stored.precision != Precision::fp32) {
    const std::string tolerance = stored.precision == Precision::fpn
                                      ? fmt::format(" with a tolerance of {:g}", stored.tolerance)
                                      : "";
    throw Error(fmt::format(
        "{}: its density is stored as {}{}; render it as it is stored, or use its source, {}",
        file.string(), name(stored.precision), tolerance, m.source.file));
  }
  require_samples(cloud, "another precision", file);
  m.quantisation = how;
  cloud.facts.reset();
  m.quantisation_error = quantise_in_place(cloud.grid(), how);
  bound_again(cloud, file);
  cloud.micro.reset();
}

}  // namespace pvol::formats
