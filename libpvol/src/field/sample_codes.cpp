#include "pvol/field/sample_codes.h"

#include "field/brick_codes.h"
#include "pvol/math/parallel.h"

namespace pvol {

SampleCodes build_sample_codes(const BrickField& field) {
  constexpr std::size_t kGrain = 64;  // bricks of a task
  SampleCodes codes;
  codes.resize(field.bricks());
  parallel_parts(0, field.bricks(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (auto b = std::uint32_t(begin); b != end; ++b) {
      codes.scales[b] = detail::code_samples(field.brick(b), codes.of_brick(b));
    }
  });
  return codes;
}

}  // namespace pvol
