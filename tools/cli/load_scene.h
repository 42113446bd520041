// From what the user names to volumes ready for rendering, for every tool that renders.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "pvol/formats/cloud.h"
#include "pvol/formats/scene_file.h"
#include "pvol/render/scene_volume.h"
#include "pvol/volume/facts.h"
#include "pvol/volume/volume.h"

namespace pvol::cli {

/// Mean optical thickness along the thickest axis where no extinction is given, of clouds.
inline constexpr double kChosenThickness = 40;

/// The same for a volume whose grids are bound: smoke around a fire that is shown is thinner.
[[nodiscard]] double chosen_thickness(const formats::SceneVolume& volume);

/// A scene file, or the default scene around a cloud, with values set and, unless empty, the grid
/// of the first volume's density.
[[nodiscard]] formats::SceneFile read_scene(const std::filesystem::path& input,
                                            const std::vector<std::string>& sets,
                                            const std::string& grid = {});

/// Reads the pixels of the scene's sky, where it is a picture; warns of one that has not the shape
/// of longitudes by latitudes.
void load_sky(const std::string& tool, formats::SceneFile& file);

/// Reads the bodies and triangles of the scene's surfaces, those that lack them, from their files.
/// Throws Error for files that cannot be read and for bodies without a surface in closed form.
void load_surfaces(formats::SceneFile& file);

/// Who loads a cloud: a tool that shows on a terminal what takes long, unless it is quiet, and
/// prints the reader's warnings.
struct Loader {
  std::string tool;
  bool quiet = false;
};

/// A cloud's samples, and a cloud with its bounds (formats::load_grid, load_cloud).
[[nodiscard]] formats::LoadedGrid load_grid(const Loader& by, const std::filesystem::path& file,
                                            const formats::GridOptions& grid);
[[nodiscard]] formats::Cloud load_cloud(const Loader& by, const std::filesystem::path& file,
                                        const formats::GridOptions& grid = {},
                                        LookUp look_up = LookUp::trilinear);

/// Whether the scene describes the colours of a volume's fire; else they are chosen.
[[nodiscard]] inline bool describes_fire_color(const formats::SceneVolume& v) {
  return v.fire && (v.fire->colored() || !v.shows_fire);
}

/// A volume's cloud as the scene's options want it: bounds for the interpolation, precision,
/// preview; with the fields of its fire. Tells which grids it chose where the volume leaves them
/// open.
[[nodiscard]] formats::Cloud load_cloud(const Loader& by, formats::SceneVolume& volume, bool strict,
                                        const formats::SceneFile& scene);

/// The extinction of three digits with which the cloud is this many mean free paths thick, averaged
/// over the columns along its thickest axis; 1 for a cloud of nothing. With a map about so many.
[[nodiscard]] double choose_extinction(const formats::Cloud& cloud, const Affine& object_to_world,
                                       double thickness = kChosenThickness,
                                       const FieldMap& map = {});

/// The intensity of three digits with which the cloud's fire shines with a radiance of about 1,
/// averaged over the columns along its longest way through; 1 for a fire of nothing.
[[nodiscard]] double choose_intensity(const formats::Cloud& cloud, const Fire& fire,
                                      const Affine& object_to_world);

/// The cloud with the medium and placements of a scene's volume, for the scene's options and
/// shutter.
[[nodiscard]] Volume make_volume(const formats::Cloud& cloud, const formats::SceneVolume& volume,
                                 const Scene& scene,
                                 SampleStorage samples = SampleStorage::automatic);

/// Figures about a cloud as a volume of a scene.
[[nodiscard]] VolumeFacts describe(const formats::Cloud& cloud, const formats::SceneVolume& volume);

/// Proves again that a cloud's shell, if it has one, holds it: a few milliseconds, where a wrong
/// one would cut parts of the cloud off without a word. Throws Error otherwise.
void require_proof(const std::filesystem::path& file, const formats::Cloud& cloud);

/// The camera that shows all volumes, where they are at the time of the files.
[[nodiscard]] Camera frame_all(std::span<const Volume> volumes, const Scene& scene);

}  // namespace pvol::cli
