// Refusal of work that would not end.
#pragma once

#include "pvol/render/scene.h"
#include "pvol/volume/facts.h"

namespace pvol::detail {

/// Throws Error, which begins with the volume's name, for what would not end in reasonable time:
/// see `plan`.
void refuse_endless_work(const Volume& volume, const VolumeFacts& facts,
                         const RenderOptions& options);

}  // namespace pvol::detail
