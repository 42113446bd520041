#include "extremes/extremes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "extremes/probes.h"
#include "pvol/error.h"
#include "support/effort.h"

namespace pvol::extremes {
namespace extremes_test {

TEST(Extremes, AreRightOrRefusedAsThePageSays) {
  std::ifstream in(PVOL_EXTREMES);
  std::ostringstream stored;
  stored << in.rdbuf();
  const std::string now = page();
  EXPECT_EQ(now.find("WRONG"), std::string::npos) << now;
  // What is exact on one machine may differ by rounding on another.
  const auto alike = [](std::string text) {
    std::replace(text.begin(), text.end(), '~', '=');
    return text;
  };
  EXPECT_EQ(alike(stored.str()), alike(now))
      << "tests/bench/EXTREMES.md is not what `extremes` writes";
}

TEST(Extremes, RandomScenesAreRightOrRefused) {
  int refused = 0;
  const auto scenes = proof::samples(std::uint64_t{60}, std::uint64_t{3});
  for (const Setting& s : settings()) {
    for (std::uint64_t i = 0; i < scenes; ++i) {
      try {
        const Outcome o = random_scene(i, s);
        EXPECT_NE(o.verdict, Verdict::wrong) << s.name << ", scene " << i << ": " << o.note;
      } catch (const Error&) {
        ++refused;
      }
    }
  }
  EXPECT_LT(refused, int(scenes * settings().size()) * 2 / 3) << "most are rendered";
}

}  // namespace extremes_test
}  // namespace pvol::extremes
