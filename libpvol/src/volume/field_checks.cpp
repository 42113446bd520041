#include "volume/field_checks.h"

#include <string>

#include "math/digits.h"
#include "pvol/bounds/verify.h"
#include "pvol/error.h"

namespace pvol::detail {

void require_bounds(const VoxelGrid& grid, const Pyramid& pyramid) {
  const BoundsCheck check = verify_bounds(grid, pyramid);
  if (check.holds()) return;
  throw Error("the bounds do not hold in " + std::to_string(check.wrong.size()) +
              " cubes, so the error of homogenised ones is unknown. They belong to another density "
              "or were damaged; fit the cloud again, or check it with pvol-stats bounds --verify.");
}

void require_cover(const VoxelGrid& grid, const Pyramid& pyramid) {
  const BoundsCheck check = verify_cover(grid, pyramid);
  if (check.wrong.empty()) return;
  const WrongBound& w = check.wrong.front();
  const auto at = [](std::int64_t v) { return std::to_string(v); };
  throw Error("the bounds do not hold: " +
              std::string(w.kind == WrongBound::Kind::missing ? "there is density outside them in"
                                                              : "they claim one value for") +
              " the cube of " + at(w.hi_cell.x - w.lo_cell.x) + "^3 voxels at (" + at(w.lo_cell.x) +
              ", " + at(w.lo_cell.y) + ", " + at(w.lo_cell.z) + "), its samples lie in [" +
              digits(double(w.found_lo), 6) + ", " + digits(double(w.found_hi), 6) +
              "]. They belong to another density or were damaged; fit the cloud again.");
}

}  // namespace pvol::detail
