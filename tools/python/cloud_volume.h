// What Python calls a volume: a cloud, what was said of it, and both made ready for rays.
#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>

#include "pvol/formats/cloud.h"
#include "pvol/formats/scene_file.h"
#include "pvol/volume/batch.h"
#include "pvol/volume/volume.h"
#include "python/words.h"

namespace pvol::python {

/// A field that the first who needs it makes.
struct LazyBatchField {
  std::once_flag made;
  std::optional<BatchField> field;
};

/// Never changed once it is made, so that any number of threads may use it without Python's lock.
struct CloudVolume {
  std::shared_ptr<const formats::Cloud> cloud;  ///< shared by copies with other media
  Words medium;                                 ///< what was said of [medium], "medium.g"
  Words making;                                 ///< and of [render], "render.depth"
  formats::SceneVolume given;                   ///< what follows from it; the file is its name
  RenderOptions options;                        ///< what follows from that
  Volume volume;
  /// For many rays at once; made when it is asked for. Copies share it, as all of them are of one
  /// volume.
  std::shared_ptr<LazyBatchField> batches = std::make_shared<LazyBatchField>();

  [[nodiscard]] const BatchField& batch_field() const;
};

/// How a volume is made of its cloud, beside the medium.
struct Making {
  Words medium;   ///< of [medium], each under "medium."
  Words options;  ///< of [render], each under "render."
};

/// The medium and placement that the words say, around a file, and the options.
[[nodiscard]] formats::SceneFile read_making(const std::filesystem::path& file, const Making& how);

/// Makes a cloud ready. Without an extinction it is chosen as pvol-render does, where `choose`.
/// Throws Error.
[[nodiscard]] CloudVolume make_cloud_volume(std::shared_ptr<const formats::Cloud> cloud,
                                            const std::filesystem::path& file, const Making& how,
                                            bool choose);

/// A cloud of samples with their bounds.
[[nodiscard]] std::shared_ptr<const formats::Cloud> bound_grid(VoxelGrid grid, LookUp look_up);

/// The same cloud with another medium: what does not scale or place it is exchanged, all else has
/// it made anew.
[[nodiscard]] CloudVolume with_medium(const CloudVolume& v, Words medium);

/// The same cloud made anew with other options, of which those that are not named stay.
[[nodiscard]] CloudVolume with_options(const CloudVolume& v, const Words& options);

/// The same volume with a shell, or none.
[[nodiscard]] CloudVolume with_shell(const CloudVolume& v, const std::optional<Shell>& shell);

/// From the pyramid's index space to the world, at the volume's place.
[[nodiscard]] Affine index_to_world(const CloudVolume& v);

}  // namespace pvol::python
