// Volumes for a scene.
#pragma once

#include <memory>

#include "pvol/render/scene.h"
#include "pvol/volume/volume.h"

namespace pvol {

/// What a volume of the scene is made for.
[[nodiscard]] VolumeOptions volume_options(const RenderOptions& options);

/// make_volume for the scene's medium and options.
[[nodiscard]] Volume make_volume(const VoxelGrid& grid, const Pyramid& pyramid, const Scene& scene,
                                 const LeafMicroBounds* stored = nullptr);
[[nodiscard]] Volume make_volume(std::shared_ptr<const Recipe> recipe, const Pyramid& pyramid,
                                 const Scene& scene);

}  // namespace pvol
