#include "cli/shell_export.h"

#include <gtest/gtest.h>
#include <png.h>

#include <array>
#include <map>
#include <vector>

#include "support/temporary_folder.h"

namespace pvol::cli {
namespace shell_export_test {

using Colour = std::array<int, 3>;
constexpr Colour kCell{140, 140, 140}, kCutOff{220, 40, 40}, kEmpty{188, 212, 246},
    kOutline{30, 60, 120}, kWhite{255, 255, 255};

struct Picture {
  int width = 0, height = 0;
  std::map<Colour, int> pixels;  ///< of each colour
};

Picture read_png(const std::filesystem::path& file) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  EXPECT_TRUE(png_image_begin_read_from_file(&image, file.c_str()));
  image.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> bytes(PNG_IMAGE_SIZE(image));
  EXPECT_TRUE(png_image_finish_read(&image, nullptr, bytes.data(), 0, nullptr));
  Picture picture{int(image.width), int(image.height), {}};
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    ++picture.pixels[{bytes[i], bytes[i + 1], bytes[i + 2]}];
  }
  return picture;
}

/// A block of 20 x 10 x 40 cells in a box twice as large.
Support block() {
  std::vector<Vec3l> cells;
  for (int i = 0; i < 20 * 10 * 40; ++i) {
    cells.push_back(Vec3l(-10, -5, 80) + Vec3l(i % 20, i / 20 % 10, i / 200));
  }
  return make_support(cells);
}

/// The box with a dent that is a half-space: x < `from` is cut off.
Shell shell_from(double from) {
  Shell shell;
  shell.lo = {-20, -10, 60}, shell.hi = {20, 10, 140};
  const Vec3d p = frame(shell).to_shell({from, 0, 100});
  shell.form = {{{}, {}, {}, 1}, {{{half_space(p, {-1, 0, 0}), {}}, -1}}};
  return shell;
}

Picture slices(const Shell& shell) {
  const TemporaryFolder folder;
  write_shell_slices(folder.file("a.png"), shell, block());
  return read_png(folder.file("a.png"));
}

TEST(ShellExport, SlicesShowCellsAndWhatElseTheShellHolds) {
  const Picture p = slices(shell_from(-100));
  EXPECT_NEAR(p.width, 1200, 12);
  // Slices of 20 x 80, 40 x 80 and 40 x 20 cells; a quarter of each is occupied.
  const double scale = (1200 - 4 * 12) / 100.0,
               cells = (20 * 80 + 40 * 80 + 40 * 20) * scale * scale;
  EXPECT_NEAR(p.pixels.at(kCell), cells / 4, 0.01 * cells);
  EXPECT_NEAR(p.pixels.at(kEmpty) + p.pixels.at(kOutline), cells * 3 / 4, 0.01 * cells);
  EXPECT_LT(p.pixels.at(kOutline), 0.05 * cells);
  EXPECT_EQ(p.pixels.count(kCutOff), 0u);
  EXPECT_EQ(p.pixels.size(), 4u);
}

TEST(ShellExport, SlicesAreWhiteOutsideAndRedWhereCellsAreCutOff) {
  const Picture all = slices(shell_from(-100)), part = slices(shell_from(-15));
  EXPECT_GT(part.pixels.at(kWhite), all.pixels.at(kWhite) * 1.1);
  EXPECT_EQ(part.pixels.at(kCell), all.pixels.at(kCell));
  EXPECT_GT(slices(shell_from(-5)).pixels.at(kCutOff), 1000);
}

TEST(ShellExport, MeshIsThatOfTheShell) {
  const TemporaryFolder folder;
  write_shell_mesh(folder.file("a.ply"), shell_from(0), {}, 16);
  EXPECT_GT(read_bytes(folder.file("a.ply")).size(), 10000u);
}

}  // namespace shell_export_test
}  // namespace pvol::cli
