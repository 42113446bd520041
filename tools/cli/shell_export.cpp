#include "cli/shell_export.h"

#include <algorithm>
#include <cmath>

#include "pvol/formats/image.h"
#include "pvol/formats/mesh_file.h"
#include "pvol/shell/mesh.h"

namespace pvol::cli {
namespace {

constexpr int kWidth = 1200;   ///< of the picture, about
constexpr int kHeight = 2400;  ///< at most: for clouds that are towers
constexpr int kGap = 12;       ///< around each slice

/// Colours by their bytes in sRGB, as linear values: pictures are encoded when they are written.
Vec3d from_srgb(int r, int g, int b) {
  const auto linear = [](double v) {
    return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
  };
  return {linear(r / 255.0), linear(g / 255.0), linear(b / 255.0)};
}

/// A middle slice, seen along an axis; pixels are `scale` to a cell.
struct Slice {
  int across, right, up;  ///< axes
  int width, height;      ///< in pixels
};

Slice make_slice(int across, Vec3l size, double scale) {
  const int right = across == 0 ? 1 : 0, up = across == 2 ? 1 : 2;
  const auto pixels = [&](int axis) {
    return std::max(1, int(std::lround(double(size[axis]) * scale)));
  };
  return {across, right, up, pixels(right), pixels(up)};
}

/// The index point in the middle of a pixel; rows count from the top.
Vec3d point_of(const Slice& slice, const Shell& shell, int x, int y) {
  const Vec3d lo(shell.lo), extent(shell.hi - shell.lo);
  Vec3d p = lo + extent * 0.5;
  // The middle of a layer of cells, where no rounding decides which cell is meant.
  p[slice.across] = std::floor(p[slice.across]) + 0.5;
  p[slice.right] = lo[slice.right] + extent[slice.right] * (x + 0.5) / slice.width;
  p[slice.up] = lo[slice.up] + extent[slice.up] * (slice.height - y - 0.5) / slice.height;
  return p;
}

bool is_inside(const Slice& slice, const Shell& shell, int x, int y) {
  return x >= 0 && y >= 0 && x < slice.width && y < slice.height &&
         contains(shell, point_of(slice, shell, x, y));
}

Vec3d colour_of(const Slice& slice, const Shell& shell, const Support& support, int x, int y) {
  const Vec3d p = point_of(slice, shell, x, y);
  const Vec3l cell(Vec3d{std::floor(p.x), std::floor(p.y), std::floor(p.z)});
  const bool inside = is_inside(slice, shell, x, y);
  // Red: cells that the shell cuts off, which a certified one never does.
  if (is_occupied(support, cell)) return inside ? from_srgb(140, 140, 140) : from_srgb(220, 40, 40);
  if (!inside) return from_srgb(255, 255, 255);
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if (!is_inside(slice, shell, x + dx, y + dy)) return from_srgb(30, 60, 120);
    }
  }
  return from_srgb(188, 212, 246);
}

}  // namespace

void write_shell_mesh(const std::filesystem::path& file, const Shell& shell,
                      const Affine& index_to_world, int resolution) {
  formats::write_mesh(file, make_mesh(shell, resolution), index_to_world);
}

void write_shell_slices(const std::filesystem::path& file, const Shell& shell,
                        const Support& support) {
  const Vec3l size = shell.hi - shell.lo;
  const double across = double(size.y + 2 * size.x), high = double(std::max(size.y, size.z));
  const double scale = std::min((kWidth - 4 * kGap) / across, (kHeight - 2 * kGap) / high);
  const Slice slices[] = {make_slice(0, size, scale), make_slice(1, size, scale),
                          make_slice(2, size, scale)};
  Film film;
  for (const Slice& s : slices) {
    film.width += s.width + kGap;
    film.height = std::max(film.height, s.height + 2 * kGap);
  }
  film.width += kGap;
  film.crop_width = film.width, film.crop_height = film.height;
  PixelSums white;
  white.sum = Vec3d(1), white.samples = 1;
  film.pixels.assign(std::size_t(film.width) * std::size_t(film.height), white);
  int left = kGap;
  for (const Slice& s : slices) {
    for (int y = 0; y < s.height; ++y) {
      for (int x = 0; x < s.width; ++x) {
        const auto row = std::size_t(film.height - kGap - s.height + y);  // on a common ground
        film.pixels[row * std::size_t(film.width) + std::size_t(left + x)].sum =
            colour_of(s, shell, support, x, y);
      }
    }
    left += s.width + kGap;
  }
  formats::write_png(file, film);
}

}  // namespace pvol::cli
