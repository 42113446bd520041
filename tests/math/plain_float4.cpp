// The lanes as arrays, beside those of the processor in the same program.
#define PVOL_PLAIN_LANES
#include "pvol/math/float4.h"

#include "math/float4_cases.h"

namespace pvol::test {

std::vector<LaneCase> plain_lane_cases() { return lane_cases<Float4, Int4>(); }

}  // namespace pvol::test
