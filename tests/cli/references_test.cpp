// The pictures of tests/references: made once by flights one by one, against global majorants and
// without guiding, and compared with those of other renderers (tests/bench/peers.py). Every scene
// must still look so.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "pvol/formats/image.h"
#include "pvol/measure/compare.h"
#include "support/effort.h"
#include "support/run_tool.h"

namespace pvol {
namespace references_test {

namespace fs = std::filesystem;
using testing::run_tool;
using testing::RunResult;
using testing::ScratchFolder;

fs::path folder() { return fs::path(PVOL_SAMPLES).parent_path() / "tests/references"; }

/// The same picture, brighter by this factor.
Film brighter(Film film, double factor) {
  for (PixelSums& p : film.pixels) p.sum *= factor, p.sum_squares *= factor * factor;
  return film;
}

/// A scene, and the samples of a pixel from which an error of 5 % is found; a quarter of them on
/// commits.
struct Case {
  std::string scene;
  int samples;
};

class References : public ::testing::TestWithParam<Case> {
 protected:
  /// What pvol-render makes of the scene by its own choices.
  Film render() {
    const std::string picture = folder_ / "picture.exr";
    const RunResult r =
        run_tool(PVOL_RENDER, {(folder() / (GetParam().scene + ".toml")).string(), "-o", picture,
                               "--no-png", "--aov", "variance,samples", "--spp",
                               std::to_string(proof::samples(GetParam().samples)), "--seed",
                               std::to_string(proof::seeded(5))});
    EXPECT_EQ(r.exit, 0) << r.err;
    return formats::read_film(picture).film;
  }

  ScratchFolder folder_;
};

TEST_P(References, AreWhatTheScenesLookLike) {
  const Film film = render();
  const Film reference = formats::read_film(folder() / (GetParam().scene + ".exr")).film;
  const measure::FilmComparison same = measure::compare(film, reference);
  ASSERT_TRUE(same.verdict);
  EXPECT_FALSE(same.verdict->detected)
      << "p " << same.verdict->p_value << ", relative bias " << same.luminance.relative_bias;
  // It would be noticed if the picture were wrong.
  const measure::FilmComparison other = measure::compare(brighter(film, 1.05), reference);
  EXPECT_TRUE(other.verdict->detected) << "p " << other.verdict->p_value;
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, References,
    ::testing::Values(Case{"backlit", 1024}, Case{"cube", 1024}, Case{"dark", 1024},
                      Case{"flock", 1024}, Case{"forward", 1024}, Case{"glow", 1024},
                      Case{"ground", 1024}, Case{"inside", 1024}, Case{"isotropic", 1024},
                      Case{"lamp", 4096}, Case{"low_sun", 8192}, Case{"overcast", 1024},
                      Case{"spot", 1024}, Case{"street", 1024}, Case{"sunset", 1024},
                      Case{"two", 1024}, Case{"window", 1024}),
    [](const auto& test) { return test.param.scene; });

}  // namespace references_test
}  // namespace pvol
