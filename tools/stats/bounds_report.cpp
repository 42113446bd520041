#include "stats/bounds_report.h"

#include "cli/cli.h"

namespace pvol::cli {

std::string describe_size(const BoundsReport& r) {
  const Pyramid& p = r.cloud.pyramid;
  if (p.empty()) return "the density is 0 everywhere";
  const Vec3l cells = p.support_hi - p.support_lo;
  return std::to_string(cells.x) + " x " + std::to_string(cells.y) + " x " +
         std::to_string(cells.z) + " voxels, largest density " + readable(double(p.scale));
}

std::vector<LookupFigure> lookup_figures(const BoundsReport& r) {
  const BoundsStatistics& s = r.bounds;
  const Tightness& leaves = s.depths.back().tightness;
  std::vector<LookupFigure> f{{"delta, one majorant over the box", s.global_majorant, {}},
                              {"delta, leaves of 8^3", leaves.majorant, {}},
                              {"decomposition, leaves of 8^3", leaves.residual, {}}};
  if (!r.cut) return f;
  LookupFigure delta{"delta, the cut of the cost model", r.cut->tightness.majorant, {}};
  LookupFigure decomposition{
      "decomposition, the cut of the cost model", r.cut->tightness.residual, {}};
  if (r.probe) {
    delta.measured = r.probe->delta.lookups;
    decomposition.measured = r.probe->decomposition.lookups;
  }
  f.push_back(delta);
  f.push_back(decomposition);
  if (r.probe) {
    f.push_back({"the same with micro-bounds of 2^3 voxels",
                 CollisionCost{r.probe->squeezed_expected, 0}, r.probe->squeezed.lookups});
  }
  return f;
}

}  // namespace pvol::cli
