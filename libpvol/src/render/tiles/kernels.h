// From a plan's kernel to the function compiled for it.
#pragma once

#include "render/path/path_setup.h"

namespace pvol::detail {

/// Adds samples [begin, end) of every pixel of a tile, a part of the film, to it and their counts
/// to `counts`.
using TileFunction = void (*)(const PathSetup&, const ImagePart& tile, std::uint32_t begin,
                              std::uint32_t end, Film&, Counts& counts);

[[nodiscard]] TileFunction find_kernel(const Kernel& kernel);

/// The same for one way of look-up, for paths that are guided or not. Each is defined in a source
/// of its own, generated from kernel.cpp.in by the list in libpvol/CMakeLists.txt: they take long
/// to compile, and compilers inline less in large sources.
template <LookUp kLookUp, bool kGuided>
[[nodiscard]] TileFunction find_kernel_of(const Kernel& kernel);

}  // namespace pvol::detail
