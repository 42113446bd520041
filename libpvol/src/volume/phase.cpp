#include "pvol/volume/phase.h"

#include <string>

#include "pvol/error.h"

namespace pvol {

void validate(const HenyeyGreenstein& hg) {
  if (std::abs(hg.mean_cosine) <= kLargestMeanCosine) return;
  throw Error("g = " + std::to_string(hg.mean_cosine) + ": must lie in [-0.9999, 0.9999]");
}

}  // namespace pvol
