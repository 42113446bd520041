#include "render/guide/coarse_cells.h"

#include "bounds/octree_children.h"
#include "math/parallel.h"
#include "pvol/bounds/pyramid.h"
#include "pvol/field/brick_field.h"

namespace pvol::detail {
namespace {

/// Integral of the interpolated density over the 8^3 cells of each brick, in cells^3.
std::vector<double> brick_integrals(const BrickField& field) {
  std::vector<double> all(field.bricks());
  parallel_for(0, all.size(), [&](std::size_t b) {
    const float* s = field.brick(std::uint32_t(b));
    // A sample on a face belongs to the leaf by half along that axis.
    const auto weight = [](int i) { return i == 0 || i == kLeafEdge ? 0.5f : 1.0f; };
    double sum = 0;
    for (int i = 0; i < kFieldEdge; ++i) {
      for (int j = 0; j < kFieldEdge; ++j) {
        float row = 0;
        for (int k = 0; k < kFieldEdge; ++k, ++s) row += *s * weight(k);
        sum += double(row * weight(i) * weight(j));
      }
    }
    all[b] = sum;
  });
  return all;
}

/// Adds up the mass of the octree's bricks by coarse cube.
struct MassOfCubes {
  const Octree& tree;
  const std::vector<double>& of_brick;
  const CoarseCells& cells;
  std::vector<double>& sums;

  void add_node(const Octree::Node& node, Vec3i at) {
    for_children(tree, node, at, [&](const Octree::Entry& e, Vec3i low, int edge) {
      if (e.link & Octree::kNodeBit) {
        add_node(tree.nodes[e.link & ~Octree::kNodeBit], low);
      } else {
        add_cube(low, edge, of_brick[e.link] / (kLeafEdge * kLeafEdge * kLeafEdge));
      }
    });
  }

  /// A leaf, or a uniform cube, which may span several coarse ones.
  void add_cube(Vec3i low, int edge, double density) {
    const int step = std::min(edge, 1 << cells.shift);
    const Vec3i end = min(low + Vec3i(edge), vec3(tree.support_hi));
    for (int x = low.x; x < end.x; x += step) {
      for (int y = low.y; y < end.y; y += step) {
        for (int z = low.z; z < end.z; z += step) {
          const Int4 c = (Int4{x, y, z, 0} >> cells.shift) - cells.low;
          if (any_bits((c < 0) & 1) != 0) continue;
          sums[cells.index({c[0], c[1], c[2]})] += density * step * step * step;
        }
      }
    }
  }
};

}  // namespace

CoarseCells make_coarse_cells(const Volume& volume) {
  constexpr std::size_t kMost = std::size_t(1) << 18;
  const Octree& tree = volume.density.octree;
  CoarseCells cells;
  std::size_t count = 0;
  for (;; ++cells.shift) {
    cells.low = tree.support_lo >> cells.shift;
    cells.last = ((tree.support_hi - 1) >> cells.shift) - cells.low;
    cells.size = vec3(cells.last) + Vec3i(1);
    count = std::size_t(cells.size.x) * std::size_t(cells.size.y) * std::size_t(cells.size.z);
    if (count <= kMost) break;
  }
  std::vector<double> sums(count);
  MassOfCubes{tree, brick_integrals(volume.density.bricks()), cells, sums}.add_node(tree.nodes[0],
                                                                                    {0, 0, 0});

  const double scale =
      double(volume.density.scale) / std::abs(determinant(volume.density.world_to_cells));
  cells.rows.resize(count);
  cells.places.resize(1);
  cells.mass.resize(1);
  for (int x = 0; x < cells.size.x; ++x) {
    for (int y = 0; y < cells.size.y; ++y) {
      for (int z = 0; z < cells.size.z; ++z) {
        const std::size_t i = cells.index({x, y, z});
        if (!(sums[i] > 0)) continue;
        cells.rows[i] = std::uint32_t(cells.count());
        cells.places.push_back({x, y, z});
        cells.mass.push_back(sums[i] * scale);
      }
    }
  }
  return cells;
}

}  // namespace pvol::detail
