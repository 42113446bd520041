#include "pvol/math/rng.h"

#include "math/philox.h"

namespace pvol {

template struct PhiloxOf<7>;

}  // namespace pvol
