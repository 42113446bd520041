// Scenes as TOML files, and single values of them from the command line.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pvol/density/quantise.h"
#include "pvol/math/names.h"
#include "pvol/render/placement.h"
#include "pvol/render/scene.h"
#include "pvol/volume/albedo_map.h"
#include "pvol/volume/fire.h"

namespace pvol::formats {

/// In place of a grid's name: the volume has no density and is a fire alone.
inline constexpr const char* kNoGrid = "none";

/// What moves a volume while the camera's shutter is open.
struct VelocityChoice {
  std::filesystem::path file{};  ///< empty: the volume's own
  std::string field{};           ///< empty: by the usual names
  double scale = 1;              ///< factor on velocities
  friend bool operator==(const VelocityChoice&, const VelocityChoice&) = default;
};

template <std::same_as<VelocityChoice> V>
[[nodiscard]] constexpr auto keys(const V&) {
  return std::to_array<Key<V>>({
      key<&V::field>({.key = "field",
                      .metavar = "NAME",
                      .limits = any_text(),
                      .help = "Grid of velocities, in world units of the file per second, or three "
                              "grids of components, NAME.x, NAME.y and NAME.z",
                      .otherwise = "v, vel or velocity"}),
      {{.key = "file",
        .metavar = "FILE",
        .limits = file_name(),
        .help = "File with the velocities: .vdb, .pvol, or a recipe with a [flow]",
        .otherwise = "that of the volume"},
       [](const V& v) { return v.file.empty() ? Value{} : to_value(v.file.string()); },
       [](V& v, const Value& value) { v.file = *value.word(); }},
      key<&V::scale>({.key = "scale",
                      .metavar = "X",
                      .limits = number(Range::closed(-1e6, 1e6)),
                      .help = "Factor on the velocities"}),
  });
}

/// A volume of a scene, still to be loaded.
struct SceneVolume {
  std::filesystem::path file{};
  /// Of the density; empty: the only one, or "density". kNoGrid: there is none.
  std::string grid{};
  Medium medium{};
  Affine object_to_world{};         ///< placed after the grid's own map
  bool has_extinction = false;      ///< false: the caller may choose one that suits the cloud
  std::vector<Affine> instances{};  ///< placed after that, once under each; none: once as it is
  FieldMap density_map{};           ///< of the density's values
  std::optional<Fire> fire{};
  bool has_intensity = false;  ///< of the fire; false: the caller may choose one
  bool shows_fire = false;  ///< grids of a fire are shown as one, whether there is a density or not
  std::optional<VelocityChoice> velocity{};  ///< without: by the usual names, where there are any
  /// Without: by the usual names, where there are any. A grid kNoGrid: the albedo is no field.
  std::optional<AlbedoMap> albedo_field{};
  /// Of object_to_world, where it has another value a frame later.
  std::optional<MovingPlacement> moving{};
  /// The same of each of the instances; fewer: those behind stand still.
  std::vector<std::optional<MovingPlacement>> moving_instances{};

  [[nodiscard]] bool names_density() const { return !grid.empty() && grid != kNoGrid; }
  /// Where it is first: after the grid's own map.
  [[nodiscard]] Affine first_place() const {
    return instances.empty() ? object_to_world : instances.front() * object_to_world;
  }
  friend bool operator==(const SceneVolume&, const SceneVolume&) = default;
};

/// Of its [volume] alone.
template <std::same_as<SceneVolume> V>
[[nodiscard]] constexpr auto keys(const V&) {
  return std::to_array<Key<V>>({
      {{.key = "file",
        .metavar = "FILE",
        .limits = file_name(),
        .help = "File of the cloud: .pvol, .vdb, .nvdb, or a recipe (.toml)",
        .required = true},
       [](const V& v) { return to_value(v.file.string()); },
       [](V& v, const Value& value) { v.file = *value.word(); }},
      key<&V::grid>({.key = "grid",
                     .metavar = "NAME",
                     .limits = any_text(),
                     .help = "Grid with the density; none: the volume has only a fire",
                     .otherwise = "density, else the only one"}),
  });
}

/// Which way the world stands: what lies across or above by default, if nothing says otherwise.
enum class UpAxis { y, z };
[[nodiscard]] constexpr auto names(UpAxis) {
  return std::to_array<Named<UpAxis>>({{UpAxis::y, "y"}, {UpAxis::z, "z"}});
}
struct World {
  UpAxis up = UpAxis::y;
};
template <std::same_as<World> W>
[[nodiscard]] constexpr auto keys(const W&) {
  return std::to_array<Key<W>>({
      key<&W::up>({.key = "up",
                   .help = "Axis that is up, the default for the camera, the sky and the default "
                           "sun; z as in Blender"}),
  });
}

/// A scene and the file names in it, still to be loaded. The pixels of an ImageSky, bodies
/// and triangles of surfaces are not read: the caller fills them from their files.
struct SceneFile {
  Scene scene{};
  std::vector<SceneVolume> volumes{};     ///< at least one; they may overlap
  bool has_camera = false;                ///< false: the caller frames the cloud
  std::optional<Quantisation> density{};  ///< of all volumes; without: as each file has it
  friend bool operator==(const SceneFile&, const SceneFile&) = default;
};

/// Everything that [render] may set: the options and the precision of the density. Bound to the
/// scene, which must outlive them; with those that scenes do not have (Description::in_scenes).
[[nodiscard]] Entries render_keys(SceneFile& scene);

/// Reads a scene. Sections, all optional but [volume]; their keys are the rows of the structs
/// beside them, and `describe_sections` lists them all:
///
///   [volume]       SceneVolume; or [[volume]] for several: the first has the scene's [medium],
///                  each further one its own [volume.medium]; [[volume.instance]] each Placement
///                  under which it is there, after that of the medium: none means once;
///                  [volume.to], and `to` of an instance: the Placement one frame later, whose
///                  keys are those of the first where they are left out
///   [world]        World: which way the others stand by default
///   [camera]       Camera; [camera.to] CameraPlace, where it is one frame later
///   [medium]       Medium, its first Component with the phase function's keys, Placement;
///                  [[medium.component]] each further Component, whose share the first one lacks;
///                  [medium.density] FieldMap; [medium.fire] Fire, light of a grid of the same
///                  file; [medium.motion] VelocityChoice, what moves both while the shutter is
///                  open; [medium.albedo_field] AlbedoMap, how a grid of the file varies the albedo
///   [environment]  type = "constant", "gradient", "image" or "clear": ConstantSky, GradientSky,
///                  ImageSky, ClearSky; without `type` it is the one whose first key is
///                  there, else a gradient
///   [[sun]]        Sun; each kind of Light has sections of its name, and lights are in the order
///                  of their kinds
///   [[plane]]      PlaneSurface; so each kind of Surface. `to` of a ball is a BallPlace, that of a
///                  solid or mesh the Placement one frame later
///   [render]       RenderOptions and Quantisation
///
/// Colours are one number or three. File names are relative to the scene file.
///
/// `sets` are "section.key=value" with values in TOML syntax (a bare word is taken as a string)
/// that replace or add to what the file says, e.g. "medium.g=0.5"; sun.* means the first sun, and
/// file names are relative to the current folder. Every key is checked: Error names file, line and
/// column or the set, what was found and what was expected, and lists the keys of the section for
/// one that is unknown.
[[nodiscard]] SceneFile read_scene(const std::filesystem::path& file,
                                   const std::vector<std::string>& sets = {});

/// Where a scene names a file of this name, as read_scene has it, first: "shot.toml:12:8:
/// mesh[2].file"; empty where it does not. Throws Error as read_scene does for what is no TOML.
[[nodiscard]] std::string where_named(const std::filesystem::path& scene,
                                      const std::filesystem::path& file);

/// The same as read_scene for the text of a scene, such as `to_toml` makes; `name` stands for its
/// file in messages. File names stay as they are.
[[nodiscard]] SceneFile parse_scene(const std::string& text, const std::string& name);

/// The same with `sets`, for a text that somebody writes: where it says nothing of light, it has
/// the usual sun, as read_scene has it.
[[nodiscard]] SceneFile parse_scene(const std::string& text, const std::string& name,
                                    const std::vector<std::string>& sets);

/// The same for a cloud without a scene file: a gradient sky and one sun, changed by `sets`.
[[nodiscard]] SceneFile default_scene(const std::filesystem::path& volume,
                                      const std::vector<std::string>& sets = {});

/// The scene as TOML, with every value that changes the picture (so without the number of threads
/// and whether to count): `read_scene` makes an equal scene of it, but for lights and surfaces of
/// several kinds, which it puts into the order of their kinds as `plan` does. File names stay as
/// they are, so relative ones need the text to be in the current folder. Camera and extinction are
/// left out where the scene has none. Throws Error for a seed above 2^63 - 1, which TOML cannot
/// write.
[[nodiscard]] std::string to_toml(const SceneFile& scene);

/// A section of a scene for manuals.
struct SectionManual {
  struct Line {
    std::string key, help;
    std::string expected;   ///< "a number in (0, 180)"
    std::string otherwise;  ///< the default as TOML, or in words; empty where there is none
  };
  std::string heading;  ///< "[camera]"
  std::string about;    ///< a sentence or two
  std::vector<Line> lines;
};

/// Every section and key that a scene may have.
[[nodiscard]] std::vector<SectionManual> describe_sections();

}  // namespace pvol::formats
