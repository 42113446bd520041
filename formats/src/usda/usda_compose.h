// A scene from layers: sublayers, references, payloads, classes and variants.
#pragma once

#include "usda/usda_prim.h"

namespace pvol::formats::detail {

/// A scene of usda text with all that it refers to, in the order of strength that USD has: a prim's
/// own opinions, those of classes that it inherits, of its variants, references and payloads. The
/// result has neither arcs nor variants. Layers that cannot be followed (binary files, files that
/// are not there, prims that a layer only gets from others) are named in `notes`. Throws Error for
/// text that is damaged, for arcs that lead to themselves and for a scene without bounds.
[[nodiscard]] UsdPrim compose_usda(const std::filesystem::path& file, ImportNotes& notes);

}  // namespace pvol::formats::detail
