// One function for every kind of cloud file.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "pvol/density/density.h"
#include "pvol/density/velocity_grid.h"
#include "pvol/formats/color.h"
#include "pvol/formats/pvol_file.h"
#include "pvol/formats/vdb.h"
#include "pvol/volume/albedo_map.h"
#include "pvol/volume/facts.h"
#include "pvol/volume/fire.h"
#include "pvol/volume/shutter.h"

namespace pvol::formats {

struct AlbedoGrid;
struct FireFields;
struct CloudMotion;

/// A cloud that is ready to render: density, bounds, a shell if the file has one, and where they
/// came from. The density is a recipe only where it was loaded for procedural look-ups.
struct Cloud {
  Density density;
  Pyramid pyramid;
  std::optional<Shell> shell;
  std::optional<LeafMicroBounds> micro;  ///< of edge 2, if the file has them
  Metadata metadata;
  GridReport report;
  std::shared_ptr<const FireFields> fire{};  ///< null where there is none, or nobody asked for it
  std::shared_ptr<const CloudMotion> motion{};  ///< null where it stands still
  std::shared_ptr<const AlbedoGrid> albedo{};   ///< as `fire`
  std::function<void()> forget_pages{};         ///< as PvolFile's; null: its samples are in memory
  std::optional<DensityFacts> facts{};          ///< of its density, where somebody looked

  /// The samples of a density that has them.
  [[nodiscard]] const VoxelGrid& grid() const { return std::get<VoxelGrid>(density); }
  [[nodiscard]] VoxelGrid& grid() { return std::get<VoxelGrid>(density); }
  /// The recipe of one that has none, else null.
  [[nodiscard]] const Recipe* recipe() const {
    return is_sampled(density) ? nullptr : std::get<std::shared_ptr<const Recipe>>(density).get();
  }
};

/// The ending of a file's name in small letters, with its dot (".vdb"): what tells kinds of files
/// apart.
[[nodiscard]] std::string ending(const std::filesystem::path& file);

/// Throws Error, "clouds: is a folder; expected <expected>", where that is so.
void refuse_folder(const std::filesystem::path& file, const std::string& expected);

/// Density samples of a .vdb, .nvdb, .pvol or recipe (.toml) file, by its ending; a .pvol without
/// embedded density reads its source file and refuses one whose hash differs.
[[nodiscard]] LoadedGrid load_grid(const std::filesystem::path& file,
                                   const GridOptions& options = {});

/// Bounds of a grid read from `file`: `build_pyramid`, with the file's name in its errors.
[[nodiscard]] Pyramid build_bounds(const VoxelGrid& grid, const std::filesystem::path& file,
                                   LookUp look_up = LookUp::trilinear);

/// Density and bounds for an interpolation: bounds of a .pvol file as stored, else built here, once
/// `before_bounds` was called. `procedural` is for recipes and for .pvol files of recipes that were
/// bounded in closed form. Throws Error for stored bounds that were not made for the interpolation
/// (`holds_for`). The grid kNoGrid (scene_file.h) is an empty density.
[[nodiscard]] Cloud load_cloud(
    const std::filesystem::path& file, const GridOptions& options = {},
    LookUp look_up = LookUp::trilinear, const std::function<void()>& before_bounds = [] {});

/// What moves a cloud, and when.
struct CloudMotion {
  VelocityGrid velocity;
  double seconds;  ///< of a frame, times the factor on velocities
  Shutter shutter;
};

/// The fields of a fire, with their bounds.
struct FireFields {
  Cloud field;
  std::optional<Cloud> color_by;  ///< where colours take another one
};

/// Those of a fire whose grids have names (bind_fields). Throws what load_cloud throws.
[[nodiscard]] FireFields load_fire(const std::filesystem::path& file, const Fire& fire,
                                   bool strict = false);

/// The grid from which a cloud's albedo is made: of colours, or of numbers with its bounds.
struct AlbedoGrid {
  std::optional<LoadedColor> colors;
  std::optional<Cloud> numbers;
};

/// That of a map whose grid has a name. Where that is the grid of `loaded`, as it is in the file
/// and with trilinear bounds, it is not read again. Throws what load_cloud and read_color throw,
/// and Error for a map of numbers where the grid has colours.
[[nodiscard]] AlbedoGrid load_albedo(const std::filesystem::path& file, const AlbedoMap& map,
                                     bool strict = false, const Cloud* loaded = nullptr);

/// Rounds the density of a loaded cloud to what a precision can keep, as pvol-fit does before it
/// writes a file: the bounds are built again and micro-bounds dropped; a shell stays, since the
/// support does. A cloud that was read in that precision stays as it is. Throws Error for one that
/// was read in another but fp32.
void quantise(Cloud& cloud, const Quantisation& how, const std::filesystem::path& file);

/// Halves the samples of a cloud along each axis this many times (pvol::coarsen), bounds them again
/// and drops shell and micro-bounds. `file` is named in errors.
void coarsen(Cloud& cloud, int times, const std::filesystem::path& file);

}  // namespace pvol::formats
