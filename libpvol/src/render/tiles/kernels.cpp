#include "render/tiles/kernels.h"

#include "pvol/volume/extinction_source.h"
#include "render/path/traversal.h"

namespace pvol::detail {

TileFunction find_kernel(const Kernel& kernel) {
  if (kernel.paths == Paths::guided) {
    return visit_cells(kernel.look_up,
                       [&](auto look_up) { return find_kernel_of<look_up, true>(kernel); });
  }
  return visit_look_up(kernel.look_up,
                       [&](auto look_up) { return find_kernel_of<look_up, false>(kernel); });
}

}  // namespace pvol::detail
