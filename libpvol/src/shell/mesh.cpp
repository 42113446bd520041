#include "pvol/shell/mesh.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>
#include <tuple>

#include "pvol/bounds/pyramid.h"
#include "pvol/error.h"
#include "pvol/math/parallel.h"

// Marching tetrahedra: Doi and Koide. An Efficient Method of Triangulating Equi-Valued Surfaces by
// Using Tetrahedral Cells. IEICE Transactions E74(1), 1991; in Kuhn's split of a cube into six
// tetrahedra along one diagonal, which neighbouring cubes agree upon (THEORY.md, T7.6).
namespace pvol {
namespace {

/// Corner i of a cube lies at (i & 1, i >> 1 & 1, i >> 2). Each tetrahedron climbs from corner 0 to
/// corner 7 one axis at a time, so that each edge leads from a corner to one with more bits; the
/// first three tetrahedra are right-handed, the last three left-handed.
constexpr int kTetrahedra[6][4] = {{0, 1, 3, 7}, {0, 2, 6, 7}, {0, 4, 5, 7},
                                   {0, 1, 5, 7}, {0, 2, 3, 7}, {0, 4, 6, 7}};

constexpr int kBlock = 8;          ///< cubes along a block, the least that is examined whole
constexpr int kTask = 8 * kBlock;  ///< cubes along what one task examines
constexpr int kLeastSteps = 8;     ///< along the shortest side of the box
constexpr int kHalvings = 11;

Vec3i corner_offset(int corner) { return {corner & 1, corner >> 1 & 1, corner >> 2}; }

/// Lattice points half a step off the shell's box, from one outside to one outside: the faces of
/// the box cut edges in the middle, where no rounding decides on which side a point lies.
struct Lattice {
  const Shell& shell;
  ShellFrame frame;
  Vec3i steps;  ///< across the box
  Vec3d step;

  Lattice(const Shell& s, int resolution) : shell(s), frame(pvol::frame(s)) {
    const Vec3d extent(s.hi - s.lo);
    for (int axis = 0; axis < 3; ++axis) {
      const double n = std::ceil(resolution * extent[axis] / max_component(extent));
      steps[axis] = std::max(kLeastSteps, int(n));
      step[axis] = extent[axis] / steps[axis];
    }
  }

  [[nodiscard]] Vec3i cubes() const { return steps + Vec3i(1); }
  [[nodiscard]] Vec3d point(Vec3i i) const {
    return Vec3d(shell.lo) + (Vec3d(i) - Vec3d(0.5)) * step;
  }
  [[nodiscard]] std::uint64_t index(Vec3i i) const {
    const Vec3<std::uint64_t> p(i), n(steps + Vec3i(2));
    return (p.z * n.y + p.y) * n.x + p.x;
  }
  [[nodiscard]] Vec3i position(std::uint64_t index) const {
    const Vec3<std::uint64_t> n(steps + Vec3i(2));
    return Vec3i(Vec3<std::uint64_t>{index % n.x, index / n.x % n.y, index / n.x / n.y});
  }
};

/// Which values a shell's slack takes over a box of its frame.
Interval slack_range(const Shell& shell, const Box& box) {
  if (shell.kind == ShellKind::soft) return range(shell.form, box);
  Interval inside = range(shell.form.base, box);
  Interval outside(std::numeric_limits<double>::infinity());
  for (const Perturbation& r : shell.form.perturbations) {
    const Interval q = range(r.form, box);
    if (r.strength > 0) {
      inside = max(inside, q);
    } else {
      outside = min(outside, -q);
    }
  }
  return min(inside, outside);
}

/// Whether lattice points lo to hi may lie on both sides of the surface.
bool may_cross(const Lattice& lattice, Vec3i lo, Vec3i hi) {
  const ShellFrame& f = lattice.frame;
  const Box box{f.to_shell(lattice.point(lo)), f.to_shell(lattice.point(hi))};
  const Interval slack = slack_range(lattice.shell, box);
  const bool within = min_component(lo) > 0 && min_component(lattice.steps + Vec3i(1) - hi) > 0;
  return slack.lo < 0 ? slack.hi >= 0 : !within;
}

/// A vertex by the edge it lies on: eight times the index of the edge's lower end, plus the axes
/// along which it leads up from there.
using EdgeKey = std::uint64_t;
using EdgeTriangle = std::array<EdgeKey, 3>;

/// The part of the surface in a tetrahedron of the cube at `at`. An even permutation of a
/// right-handed tetrahedron puts its corners inside the surface first.
void add_tetrahedron(const Lattice& lattice, Vec3i at, int tetrahedron, unsigned inside,
                     std::vector<EdgeTriangle>& triangles) {
  std::array<int, 4> c{};
  std::copy_n(kTetrahedra[tetrahedron], 4, c.begin());
  bool odd = tetrahedron >= 3;
  int n = 0;
  for (int i = 0; i < 4; ++i) {
    if ((inside >> c[std::size_t(i)] & 1) == 0) continue;
    for (int j = i; j > n; --j, odd = !odd) std::swap(c[std::size_t(j)], c[std::size_t(j - 1)]);
    ++n;
  }
  if (n == 0 || n == 4) return;
  if (odd) n == 1 ? std::swap(c[2], c[3]) : std::swap(c[0], c[1]);
  const auto edge = [&](std::size_t a, std::size_t b) {
    const int low = std::min(c[a], c[b]);
    return lattice.index(at + corner_offset(low)) * 8 + EdgeKey(c[a] ^ c[b]);
  };
  if (n == 1) {
    triangles.push_back({edge(0, 1), edge(0, 2), edge(0, 3)});
  } else if (n == 3) {
    triangles.push_back({edge(3, 0), edge(3, 1), edge(3, 2)});
  } else {
    triangles.push_back({edge(0, 2), edge(0, 3), edge(1, 3)});
    triangles.push_back({edge(0, 2), edge(1, 3), edge(1, 2)});
  }
}

/// The part of the surface in the cubes from lo up to hi, at most kBlock along each axis.
void add_block(const Lattice& lattice, Vec3i lo, Vec3i hi, std::vector<EdgeTriangle>& triangles) {
  bool inside[kBlock + 1][kBlock + 1][kBlock + 1];
  for (int z = lo.z; z <= hi.z; ++z) {
    for (int y = lo.y; y <= hi.y; ++y) {
      for (int x = lo.x; x <= hi.x; ++x) {
        const Vec3d p = lattice.point({x, y, z});
        inside[z - lo.z][y - lo.y][x - lo.x] = contains(lattice.shell, p);
      }
    }
  }
  for (int z = lo.z; z < hi.z; ++z) {
    for (int y = lo.y; y < hi.y; ++y) {
      for (int x = lo.x; x < hi.x; ++x) {
        unsigned corners = 0;
        for (int i = 0; i < 8; ++i) {
          const Vec3i p = Vec3i(x, y, z) - lo + corner_offset(i);
          corners |= unsigned(inside[p.z][p.y][p.x]) << i;
        }
        if (corners == 0 || corners == 0xff) continue;
        for (int t = 0; t < 6; ++t) add_tetrahedron(lattice, {x, y, z}, t, corners, triangles);
      }
    }
  }
}

/// Descends to the blocks that the surface may cross. `edge`: of the cube of cubes at lo.
void add_part(const Lattice& lattice, Vec3i lo, int edge, std::vector<EdgeTriangle>& triangles) {
  const Vec3i hi = min(lo + Vec3i(edge), lattice.cubes());
  if (min_component(hi - lo) <= 0 || !may_cross(lattice, lo, hi)) return;
  if (edge == kBlock) return add_block(lattice, lo, hi, triangles);
  for (int i = 0; i < 8; ++i) {
    add_part(lattice, lo + corner_offset(i) * (edge / 2), edge / 2, triangles);
  }
}

/// The whole surface, in an order that does not depend on the number of threads.
std::vector<EdgeTriangle> march(const Lattice& lattice) {
  const Vec3i tasks{(lattice.cubes().x + kTask - 1) / kTask,
                    (lattice.cubes().y + kTask - 1) / kTask,
                    (lattice.cubes().z + kTask - 1) / kTask};
  std::vector<std::vector<EdgeTriangle>> parts(std::size_t(tasks.x) * std::size_t(tasks.y) *
                                               std::size_t(tasks.z));
  parallel_for(0, parts.size(), [&](std::size_t i) {
    const Vec3i at{int(i) % tasks.x, int(i) / tasks.x % tasks.y, int(i) / tasks.x / tasks.y};
    add_part(lattice, at * kTask, kTask, parts[i]);
  });
  std::vector<EdgeTriangle> triangles;
  for (std::vector<EdgeTriangle>& part : parts) {
    triangles.insert(triangles.end(), part.begin(), part.end());
    part = {};
  }
  return triangles;
}

/// Where the surface cuts an edge, by bisection. The middle of the last bracket is an odd multiple
/// of 2^-12 of the edge: never an end, so that no triangle degenerates.
Vec3d place_vertex(const Lattice& lattice, EdgeKey key) {
  const Vec3i at = lattice.position(key / 8);
  const Vec3d from = lattice.point(at);
  const Vec3d along = lattice.point(at + corner_offset(int(key % 8))) - from;
  const bool inside = contains(lattice.shell, from);
  double lo = 0, width = 1;
  for (int i = 0; i < kHalvings; ++i) {
    width /= 2;
    if (contains(lattice.shell, from + along * (lo + width)) == inside) lo += width;
  }
  return from + along * (lo + width / 2);
}

/// The distinct elements, ascending.
template <class T, class Less>
std::vector<T> distinct(std::vector<T> all, Less less) {
  tbb::parallel_sort(all.begin(), all.end(), less);
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

template <class T, class Less>
std::uint32_t find(const std::vector<T>& ascending, const T& element, Less less) {
  const auto at = std::lower_bound(ascending.begin(), ascending.end(), element, less);
  return std::uint32_t(at - ascending.begin());
}

/// A side of an occupied cell towards one that is not; the normal is +axis or -axis.
struct Face {
  Vec3i cell;  ///< from the support's origin
  int axis;
  bool up;

  /// Counter-clockwise as seen from outside.
  [[nodiscard]] std::array<Vec3i, 4> corners() const {
    Vec3i u, v, base = cell;
    u[(axis + 1) % 3] = v[(axis + 2) % 3] = 1;
    if (up) ++base[axis];
    if (!up) std::swap(u, v);
    return {base, base + u, base + u + v, base + v};
  }
};

void add_face_if_open(const Support& support, const Face& face, std::vector<Face>& faces) {
  Vec3l neighbour = support.origin + Vec3l(face.cell);
  neighbour[face.axis] += face.up ? 1 : -1;
  if (!is_occupied(support, neighbour)) faces.push_back(face);
}

/// The open sides among the faces of a full cube.
void add_cube(const Support& support, Vec3i lo, int edge, std::vector<Face>& faces) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool up : {false, true}) {
      for (int a = 0; a < edge; ++a) {
        for (int b = 0; b < edge; ++b) {
          Vec3i cell = lo;
          cell[(axis + 1) % 3] += a;
          cell[(axis + 2) % 3] += b;
          if (up) cell[axis] += edge - 1;
          add_face_if_open(support, {cell, axis, up}, faces);
        }
      }
    }
  }
}

std::vector<Face> open_faces(const Support& support) {
  std::vector<Face> faces;
  for (const SupportBlock& b : support.blocks) {
    const Vec3i lo = Vec3i(morton_decode(b.code)) * 8;
    if (b.level > 0) {
      add_cube(support, lo, 8 << b.level, faces);
      continue;
    }
    for (int x = 0; x < 8; ++x) {
      for (std::uint64_t word = support.masks[b.mask][std::size_t(x)]; word != 0;
           word &= word - 1) {
        const int bit = std::countr_zero(word);
        add_cube(support, lo + Vec3i(x, bit / 8, bit % 8), 1, faces);
      }
    }
  }
  return faces;
}

}  // namespace

TriangleMesh make_mesh(const Shell& shell, int resolution) {
  if (resolution < 8 || resolution > 1024) {
    throw Error("found a resolution of " + std::to_string(resolution) +
                " steps, expected 8 to 1024");
  }
  const Lattice lattice(shell, resolution);
  const std::vector<EdgeTriangle> triangles = march(lattice);
  std::vector<EdgeKey> keys;
  keys.reserve(3 * triangles.size());
  for (const EdgeTriangle& t : triangles) keys.insert(keys.end(), t.begin(), t.end());
  keys = distinct(std::move(keys), std::less<>());

  TriangleMesh mesh;
  mesh.vertices.resize(keys.size());
  parallel_for(0, keys.size(),
               [&](std::size_t i) { mesh.vertices[i] = place_vertex(lattice, keys[i]); });
  mesh.triangles.resize(triangles.size());
  parallel_for(0, triangles.size(), [&](std::size_t i) {
    for (std::size_t k = 0; k < 3; ++k) {
      mesh.triangles[i][k] = find(keys, triangles[i][k], std::less<>());
    }
  });
  return mesh;
}

TriangleMesh make_mesh(const Support& support) {
  const std::vector<Face> faces = open_faces(support);
  const auto less = [](Vec3i a, Vec3i b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  };
  std::vector<Vec3i> points;
  points.reserve(4 * faces.size());
  for (const Face& face : faces) {
    const std::array<Vec3i, 4> c = face.corners();
    points.insert(points.end(), c.begin(), c.end());
  }
  points = distinct(std::move(points), less);

  TriangleMesh mesh;
  mesh.vertices.reserve(points.size());
  for (const Vec3i p : points) mesh.vertices.push_back(Vec3d(support.origin + Vec3l(p)));
  mesh.triangles.resize(2 * faces.size());
  parallel_for(0, faces.size(), [&](std::size_t i) {
    std::array<std::uint32_t, 4> v{};
    const std::array<Vec3i, 4> c = faces[i].corners();
    for (std::size_t k = 0; k < 4; ++k) v[k] = find(points, c[k], less);
    mesh.triangles[2 * i] = {v[0], v[1], v[2]};
    mesh.triangles[2 * i + 1] = {v[0], v[2], v[3]};
  });
  return mesh;
}

double volume(const TriangleMesh& mesh) {
  if (mesh.vertices.empty()) return 0;
  const Vec3d apex = mesh.vertices.front();  // near the surface: no digits are lost far out
  double sum = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3d a = mesh.vertices[t[0]] - apex, b = mesh.vertices[t[1]] - apex,
                c = mesh.vertices[t[2]] - apex;
    sum += dot(a, cross(b, c));
  }
  return sum / 6;
}

}  // namespace pvol
