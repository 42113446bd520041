// Scenes as TOML files, and single values of them from the command line.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pvol/density/quantise.h"
#include "pvol/math/names.h"
#include "pvol/render/scene.h"

namespace pvol::formats {

/// A volume of a scene, still to be loaded.
struct SceneVolume {
  std::filesystem::path file{};
  std::string grid{};  ///< empty: the only one, or "density"
  Medium medium{};
  Affine object_to_world{};     ///< placed after the grid's own map
  bool has_extinction = false;  ///< false: the caller may choose one that suits the cloud
  friend bool operator==(const SceneVolume&, const SceneVolume&) = default;
};

/// A scene and the file names in it, still to be loaded.
struct SceneFile {
  Scene scene{};
  std::vector<SceneVolume> volumes{};  ///< at least one; they may overlap
  std::filesystem::path sky{};         ///< picture of the environment; empty unless it is one. Its
                                       ///< pixels are not read: the caller fills the ImageSky's
  bool has_camera = false;             ///< false: the caller frames the cloud
  std::optional<Quantisation> density{};  ///< of all volumes; without: as each file has it
  friend bool operator==(const SceneFile&, const SceneFile&) = default;
};

/// Reads a scene. Sections and keys, all optional but volume.file:
///
///   [volume]       file, grid
///   [camera]       position, target (both or no camera), up, fov (vertical, degrees)
///   [medium]       extinction, albedo, g, emission; placement: scale, rotate, translate, or
///                  matrix; [[medium.component]] share, albedo, g, emission
///   [[volume]]     instead of [volume]; the first has the scene's [medium], each further one its
///                  own [volume.medium]
///   [environment]  type = "constant": radiance;  "gradient": zenith, horizon, ground, up;
///                  "image": file, scale, rotation
///   [[sun]]        direction, irradiance, angle (degrees)
///   [render]       size = [w, h], crop = [x, y, w, h], spp, seed, tracker, transmittance,
///                  micro_bounds ("auto", "none", "2", "1"), interpolation ("nearest",
///                  "trilinear", "tricubic", or "procedural" for recipes), shells, guide, depth
///                  (0..16 or "auto"), max_bounces (or "none"), background, density ("stored",
///                  "fp32", "fp16", "fp8", "fpn"), density_tolerance (of fpn), majorant_scale,
///                  homogenise (a tolerance or "off"), preview (0..8)
///
/// Colours are one number or three. The cloud is scaled, then rotated, then moved: scale is a
/// number or three, rotate = [x, y, z, degrees] or several of them, applied in turn; matrix is row
/// by row, 12 or 16 numbers, the translation in the last column. File names are relative to the
/// scene file. Without `type` an environment is what its keys say, else a gradient.
///
/// `sets` are "section.key=value" with values in TOML syntax (a bare word is taken as a string)
/// that replace or add to what the file says, e.g. "medium.g=0.5"; sun.* means the first sun, and
/// file names are relative to the current folder. Every key is checked: Error names file, line and
/// column or the set, what was found and what was expected, and lists the keys of the section for
/// one that is unknown.
[[nodiscard]] SceneFile read_scene(const std::filesystem::path& file,
                                   const std::vector<std::string>& sets = {});

/// The same for a cloud without a scene file: a gradient sky and one sun, changed by `sets`.
[[nodiscard]] SceneFile default_scene(const std::filesystem::path& volume,
                                      const std::vector<std::string>& sets = {});

/// The scene as TOML, with every value that changes the picture (so without the number of threads
/// and whether to count): `read_scene` makes an equal scene of it. File names stay as they are, so
/// relative ones need the text to be in the current folder. Camera and extinction are left out
/// where the scene has none. Throws Error for a seed above 2^63 - 1, which TOML cannot write.
[[nodiscard]] std::string to_toml(const SceneFile& scene);

using pvol::name;  // of enumerations, as they are written in scenes and on command lines
/// The other way; Error lists the names there are.
[[nodiscard]] Tracker parse_tracker(const std::string& name);
[[nodiscard]] Transmittance parse_transmittance(const std::string& name);
[[nodiscard]] MicroBoundsUse parse_micro_bounds(const std::string& name);
[[nodiscard]] LookUp parse_interpolation(const std::string& name);
[[nodiscard]] ShellUse parse_shell_use(const std::string& name);
[[nodiscard]] GuideUse parse_guide_use(const std::string& name);

}  // namespace pvol::formats
