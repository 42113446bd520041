#include "cli/instructions.h"

#include <gtest/gtest.h>

#include "pvol/math/rng.h"

namespace pvol::cli {
namespace instructions_test {

TEST(Work, IsCountedInSecondsAndWhereTheMachineCanInInstructions) {
  const InstructionCounter counter;
  const double begin = cpu_seconds();
  Rng rng(1, 2, 3);
  std::uint64_t drawn = 0;
  double sum = 0;
  for (; cpu_seconds() < begin + 0.02; drawn += 1000) {
    for (int i = 0; i < 1000; ++i) sum += double(rng.uniform());
  }
  EXPECT_GT(sum, 0);
  const auto first = counter.read();
  EXPECT_TRUE(!first || *first > drawn);
  EXPECT_GE(counter.read(), first);
}

}  // namespace instructions_test
}  // namespace pvol::cli
