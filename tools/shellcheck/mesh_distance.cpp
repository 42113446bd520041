#include "mesh_distance.h"

#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Approximate_min_ellipsoid_d.h>
#include <CGAL/Approximate_min_ellipsoid_d_traits_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/MP_Float.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/convex_hull_3.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>
#include <vector>

namespace pvol::detail {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Surface = CGAL::Surface_mesh<Point>;
using SurfaceTree =
    CGAL::AABB_tree<CGAL::AABB_traits<Kernel, CGAL::AABB_face_graph_triangle_primitive<Surface>>>;
using Triangles = std::vector<Kernel::Triangle_3>;
using TriangleTree = CGAL::AABB_tree<
    CGAL::AABB_traits<Kernel, CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>>>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kFinestMesh = 512;
constexpr double kGroupEdge = 4;  ///< in cells

Point to_point(Vec3d v) { return {v.x, v.y, v.z}; }

Surface to_surface(const TriangleMesh& mesh) {
  Surface surface;
  for (const Vec3d v : mesh.vertices) surface.add_vertex(to_point(v));
  for (const auto& t : mesh.triangles) {
    surface.add_face(Surface::Vertex_index(t[0]), Surface::Vertex_index(t[1]),
                     Surface::Vertex_index(t[2]));
  }
  return surface;
}

Triangles to_triangles(const TriangleMesh& mesh) {
  Triangles triangles;
  for (const auto& t : mesh.triangles) {
    triangles.emplace_back(to_point(mesh.vertices[t[0]]), to_point(mesh.vertices[t[1]]),
                           to_point(mesh.vertices[t[2]]));
  }
  return triangles;
}

double longest_edge(const TriangleMesh& mesh) {
  double longest = 0;
  for (const auto& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      longest = std::max(longest, length(mesh.vertices[t[k]] - mesh.vertices[t[(k + 1) % 3]]));
    }
  }
  return longest;
}

double greatest(const std::vector<double>& values) {
  return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
}

/// Points sorted by cubes of space, so that one stands for those around it.
struct Groups {
  std::vector<Vec3d> points;
  std::vector<std::size_t> begin;  ///< of each group, and the end of the last
  double diameter = 0;             ///< at most, of a group

  [[nodiscard]] std::size_t count() const { return begin.size() - 1; }
};

Groups group(std::vector<Vec3d> points, double edge) {
  const auto cube = [&](Vec3d p) {
    return std::tuple(std::floor(p.x / edge), std::floor(p.y / edge), std::floor(p.z / edge));
  };
  tbb::parallel_sort(points.begin(), points.end(), [&](Vec3d a, Vec3d b) {
    const auto ca = cube(a), cb = cube(b);
    return ca == cb ? std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z) : ca < cb;
  });
  Groups groups{std::move(points), {}, std::sqrt(3.0) * edge};
  for (std::size_t i = 0; i < groups.points.size(); ++i) {
    if (i == 0 || cube(groups.points[i - 1]) != cube(groups.points[i])) groups.begin.push_back(i);
  }
  groups.begin.push_back(groups.points.size());
  return groups;
}

/// The first point of each group.
std::vector<Vec3d> firsts(const Groups& groups) {
  std::vector<Vec3d> points;
  for (std::size_t g = 0; g < groups.count(); ++g) points.push_back(groups.points[groups.begin[g]]);
  return points;
}

/// The greatest of distance(p) over the points, given those of the firsts. Distances change no
/// faster than the place does, so only groups with a large one need a closer look.
template <class Distance>
double greatest_distance(const Groups& groups, const std::vector<double>& of_first,
                         const Distance& distance) {
  const double enough = greatest(of_first) - groups.diameter;
  std::vector<double> most = of_first;
  tbb::parallel_for(std::size_t{0}, groups.count(), [&](std::size_t g) {
    if (of_first[g] < enough) return;
    for (std::size_t i = groups.begin[g]; i < groups.begin[g + 1]; ++i) {
      most[g] = std::max(most[g], distance(groups.points[i]));
    }
  });
  return greatest(most);
}

template <class Distance>
std::vector<double> distances_of_firsts(const Groups& groups, const Distance& distance) {
  std::vector<double> d(groups.count());
  tbb::parallel_for(std::size_t{0}, groups.count(),
                    [&](std::size_t g) { d[g] = distance(groups.points[groups.begin[g]]); });
  return d;
}

/// The cubes of 2^log2 cells, counted from the support's origin, that hold an occupied one.
Support occupied_cubes(const Support& support, int log2) {
  std::vector<Vec3l> cubes;
  std::vector<SupportNode> open{root(support)};
  while (!open.empty()) {
    const SupportNode node = open.back();
    open.pop_back();
    if (node.log2 == log2) {
      const Vec3l d = node.lo - support.origin;
      cubes.push_back({d.x >> log2, d.y >> log2, d.z >> log2});
      continue;
    }
    const SupportChildren below = children(support, node);
    for (int i = 0; i < below.count; ++i) open.push_back(below.node[std::size_t(i)]);
  }
  return make_support(cubes);
}

/// The greatest distance from points of index space to these cubes, closed; in cells.
double greatest_distance_to_cubes(std::vector<Vec3d> points, const Support& support, int log2) {
  const Support cubes = occupied_cubes(support, log2);
  const Triangles triangles = to_triangles(make_mesh(cubes));
  TriangleTree tree(triangles.begin(), triangles.end());
  tree.accelerate_distance_queries();
  const double edge = std::exp2(log2);
  for (Vec3d& p : points) p = (p - Vec3d(support.origin)) / edge;
  const auto distance = [&](Vec3d p) {
    const Vec3l cube(Vec3d{std::floor(p.x), std::floor(p.y), std::floor(p.z)});
    return is_occupied(cubes, cube) ? 0 : std::sqrt(tree.squared_distance(to_point(p)));
  };
  const Groups groups = group(std::move(points), kGroupEdge / edge);
  return edge * greatest_distance(groups, distances_of_firsts(groups, distance), distance);
}

/// How much coarser than its cells the boundary is taken, log2, so that about `most` points are
/// left.
int coarsening(const Support& support, const TriangleMesh& boundary, std::uint64_t most) {
  int log2 = 0;
  while (boundary.vertices.size() >> (2 * log2) > most && log2 < support.root_log2) ++log2;
  return log2;
}

/// Whether no point lies outside a mesh and farther from it than `tolerance`.
template <class Distance>
bool holds(const SurfaceTree& tree, const Groups& groups, const std::vector<double>& of_first,
           const Distance& distance, double tolerance) {
  const CGAL::Side_of_triangle_mesh<Surface, Kernel> side(tree);
  const auto is_outside = [&](Vec3d p) { return side(to_point(p)) == CGAL::ON_UNBOUNDED_SIDE; };
  (void)is_outside(groups.points.front());  // builds what later calls share
  std::vector<char> held(groups.count());
  tbb::parallel_for(std::size_t{0}, groups.count(), [&](std::size_t g) {
    // The surface does not reach a group that is this far away: all are on one side.
    const bool far = of_first[g] > groups.diameter + tolerance;
    const std::size_t end = far ? groups.begin[g] + 1 : groups.begin[g + 1];
    held[g] = true;
    for (std::size_t i = groups.begin[g]; i < end && held[g]; ++i) {
      const Vec3d p = groups.points[i];
      held[g] = distance(p) <= tolerance || !is_outside(p);
    }
  });
  return std::find(held.begin(), held.end(), 0) == held.end();
}

/// From the boundary's points to the shell's mesh, at one resolution of that.
void compare_at(const Shell& shell, const TriangleMesh& mesh, const Groups& points, int resolution,
                ShellCheck& check) {
  const Vec3d extent(shell.hi - shell.lo);
  check.mesh_step = max_component(extent) / resolution;
  check.mesh_contained = false;
  check.support_to_shell = kInfinity;
  if (mesh.triangles.empty()) return;
  const Surface surface = to_surface(mesh);
  SurfaceTree tree(surface.faces().begin(), surface.faces().end(), surface);
  tree.accelerate_distance_queries();
  const auto distance = [&](Vec3d p) { return std::sqrt(tree.squared_distance(to_point(p))); };
  const std::vector<double> of_first = distances_of_firsts(points, distance);
  check.mesh_contained = holds(tree, points, of_first, distance, std::sqrt(3.0) * check.mesh_step);
  check.support_to_shell = greatest_distance(points, of_first, distance);
}

}  // namespace

void check_meshes(const Shell& shell, const Support& support, const TriangleMesh& boundary,
                  const ShellCheckOptions& options, ShellCheck& check) {
  const int log2 = coarsening(support, boundary, options.mesh_points);
  const double cube_diagonal = log2 > 0 ? std::sqrt(3.0) * std::exp2(log2) : 0;
  std::vector<Vec3d> chosen = boundary.vertices;
  if (log2 > 0) chosen = firsts(group(std::move(chosen), std::exp2(log2)));
  const Groups points = group(std::move(chosen), kGroupEdge);

  // A mesh has no walls thinner than its step. Where it seems to cut points off that the exact
  // signs found inside, a finer one decides.
  TriangleMesh mesh;
  int resolution = options.mesh_resolution;
  for (;; resolution = std::min(2 * resolution, kFinestMesh)) {
    mesh = make_mesh(shell, resolution);
    compare_at(shell, mesh, points, resolution, check);
    if (check.mesh_contained || !check.contained || resolution == kFinestMesh) break;
  }
  check.shell_volume_ratio = volume(mesh) / double(support.cells);

  // Distances change no faster than the place they are taken at, so their errors are those of the
  // places: of a point that a chosen one stands for, of the mesh that stands for the surface, and
  // of cubes that stand for cells. A point of a triangle is at most its longest edge / sqrt(3) from
  // the nearest corner; in half a square it is sqrt(1/2).
  const double to_surface = std::sqrt(3.0) * check.mesh_step;
  const double above = cube_diagonal + std::sqrt(0.5) + to_surface;
  check.support_to_shell += above;
  check.support_to_shell_excess = above + to_surface;
  check.shell_to_support = kInfinity;
  if (mesh.triangles.empty()) return;
  const double covered = cube_diagonal + longest_edge(mesh) / std::sqrt(3.0) + to_surface;
  check.shell_to_support = greatest_distance_to_cubes(mesh.vertices, support, log2) + covered;
  check.shell_to_support_excess = covered + check.mesh_step / 1000;  // how far vertices are off it
}

void compare_with_baselines(const Support& support, const TriangleMesh& boundary,
                            ShellCheck& check) {
  // Of the points on a line along x only the first and the last can be extreme.
  std::vector<Vec3d> sorted = boundary.vertices;
  std::sort(sorted.begin(), sorted.end(),
            [](Vec3d a, Vec3d b) { return std::tie(a.y, a.z, a.x) < std::tie(b.y, b.z, b.x); });
  std::vector<Point> ends;
  const Vec3d origin(support.lo);
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const auto same_line = [&](std::size_t j) {
      return j < sorted.size() && sorted[i].y == sorted[j].y && sorted[i].z == sorted[j].z;
    };
    if (!same_line(i + 1) || i == 0 || !same_line(i - 1))
      ends.push_back(to_point(sorted[i] - origin));
  }
  Surface hull;
  CGAL::convex_hull_3(ends.begin(), ends.end(), hull);
  const double cells = double(support.cells);
  check.hull_volume_ratio = CGAL::to_double(CGAL::Polygon_mesh_processing::volume(hull)) / cells;

  std::vector<Point> extreme;
  for (const auto v : hull.vertices()) extreme.push_back(hull.point(v));
  using Traits = CGAL::Approximate_min_ellipsoid_d_traits_3<Kernel, CGAL::MP_Float>;
  CGAL::Approximate_min_ellipsoid_d<Traits> ellipsoid(0.01, extreme.begin(), extreme.end());
  double product = 1;
  for (int axis = 0; axis < 3; ++axis) product *= ellipsoid.axes_lengths_begin()[axis];
  check.ellipsoid_volume_ratio = 4 * std::numbers::pi / 3 * product / cells;
}

}  // namespace pvol::detail
