#include "render/light/emission/collision_limit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "bounds/octree_children.h"
#include "math/philox.h"
#include "pvol/volume/emitter.h"
#include "pvol/volume/phase.h"
#include "volume/cell_look_up.h"

namespace pvol::detail {
namespace {

/// A line through a fire, in steps of one length.
struct FireLine {
  static constexpr int kSteps = 64;
  struct Step {
    double emitted;        ///< luminance
    double depth;          ///< optical
    double transmittance;  ///< up to its middle
    /// Luminance that a collision there brings.
    [[nodiscard]] double source() const {
      return depth > 0 ? emitted / depth : std::numeric_limits<double>::infinity();
    }
  };
  std::array<Step, kSteps> steps;
  double cells;  ///< length
};

/// Points of the leaves of a fire, evenly among them, in the world.
std::vector<Vec3d> points_of(const VolumeField& fire, Rng& rng) {
  constexpr std::size_t kLeaves = 512, kPoints = 4;  // of a leaf
  std::vector<Box> leaves;
  for_bricks(fire.octree, fire.octree.nodes[0], Vec3i(0), [&](Vec3i low, int edge, std::uint32_t) {
    leaves.push_back({Vec3d(low), Vec3d(low + Vec3i(edge))});
  });
  const Affine to_world = inverse(fire.world_to_cells);
  const std::size_t stride = (leaves.size() + kLeaves - 1) / kLeaves;
  std::vector<Vec3d> points;
  for (std::size_t i = 0; i < leaves.size(); i += stride) {
    for (std::size_t k = 0; k < kPoints; ++k) {
      const auto [x, y, z, spare] = rng.uniform4();
      const Box& leaf = leaves[i];
      points.push_back(to_world.point(leaf.lo + (leaf.hi - leaf.lo) * Vec3d(x, y, z)));
    }
  }
  return points;
}

FireLine follow(const Volume& volume, const Ray& ray, const Span& span) {
  const double step = (span.t1 - span.t0) / FireLine::kSteps;
  const Affine& to_cells = volume.density.world_to_cells;
  FireLine line{.steps = {}, .cells = length(to_cells.vector(ray.d)) * (span.t1 - span.t0)};
  double before = 0;
  for (int i = 0; i < FireLine::kSteps; ++i) {
    const Vec3d at = ray.at(span.t0 + (i + 0.5) * step);
    const double depth = step * double(extinction_in_cells(volume, to_cells.point(at)));
    line.steps[std::size_t(i)] = {step * double(luminance(emission_at(*volume.fire, at))), depth,
                                  std::exp(-before - 0.5 * depth)};
    before += depth;
  }
  return line;
}

/// Lines through points that shine, in proportion to their light.
std::vector<FireLine> lines_through(const Volume& volume) {
  constexpr std::uint64_t kKey = 0x66697265;
  constexpr int kLines = 64;
  const VolumeField& fire = volume.fire->field;
  Rng rng(kKey, 0, 0);
  const std::vector<Vec3d> points = points_of(fire, rng);
  std::vector<double> power;
  for (const Vec3d& p : points) power.push_back(double(luminance(emission_at(*volume.fire, p))));
  const double all = std::accumulate(power.begin(), power.end(), 0.0);
  std::vector<FireLine> lines;
  if (!(all > 0)) return lines;
  const double before = 2 * length(fire.world_box.hi - fire.world_box.lo);
  double below = 0;
  std::size_t at = 0;
  for (int i = 0; i < kLines; ++i) {
    while (at + 1 < points.size() && below + power[at] < (i + 0.5) / kLines * all)
      below += power[at++];
    const Vec3d d(sample_phase(HenyeyGreenstein{0}, Vec3f(0, 0, 1), rng));
    const Ray ray{points[at] - d * before, d};
    const auto span = intersect(fire.world_box, ray, 0, std::numeric_limits<double>::infinity());
    if (span) lines.push_back(follow(volume, ray, *span));
  }
  return lines;
}

/// Of what a ray gathers along the line if collisions bring light up to `most`, and flights the
/// rest: with a the latter up to t and r the source, E[x^2] = the integral of
/// T (2 a (j_flights + j_collisions) + r j_collisions).
double second_moment(const FireLine& line, double most) {
  double sum = 0, gathered = 0;
  for (const FireLine::Step& s : line.steps) {
    const double source = s.source();
    const bool collides = source <= most;
    const double middle = collides ? gathered : gathered + 0.5 * s.emitted;
    sum += s.transmittance * s.emitted * (2 * middle + (collides ? source : 0.0));
    if (!collides) gathered += s.emitted;
  }
  return sum;
}

/// Nanoseconds of a ray along the line, about, whose points are looked up in lanes.
double cost(const FireLine& line, double most, int points) {
  constexpr double kRay = 300, kCollision = 450, kLeaf = 10, kPoint = 8;
  double collided = 0, lines = 0;
  for (const FireLine::Step& s : line.steps) {
    collided += s.transmittance * -std::expm1(-s.depth);
    lines += s.emitted > 0 && s.source() > most ? s.transmittance / FireLine::kSteps : 0.0;
  }
  return kRay + kCollision * collided +
         lines * line.cells / kLeafEdge * (kLeaf + kPoint * double(points));
}

}  // namespace

double brightest_at_collisions(const Volume& volume, int points) {
  const std::vector<FireLine> lines = lines_through(volume);
  double largest = 0;
  for (const FireLine& line : lines) {
    for (const FireLine::Step& s : line.steps) {
      if (s.depth > 0) largest = std::max(largest, s.source());
    }
  }
  constexpr double kMargin = 4;  // what no line met may be brighter
  constexpr int kHalvings = 16;
  double best = 0, least = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= kHalvings + 1; ++i) {
    const double most = i > kHalvings ? 0 : std::ldexp(kMargin * largest, -i);
    double moment = 0, time = 0;
    for (const FireLine& line : lines) {
      moment += second_moment(line, most);
      time += cost(line, most, points);
    }
    if (moment * time < least) best = most, least = moment * time;
  }
  return best;
}

}  // namespace pvol::detail
