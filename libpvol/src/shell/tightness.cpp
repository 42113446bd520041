#include "pvol/shell/tightness.h"

#include <array>
#include <atomic>
#include <bit>
#include <numbers>

#include "math/philox.h"
#include "pvol/math/parallel.h"
#include "pvol/shell/ray_shell.h"

namespace pvol {
namespace {

constexpr std::int64_t kLongest = 512;  // steps along the box's longest side
constexpr int kBrick = 32;              // steps along a side of what one task measures
constexpr std::uint64_t kSeed = 0x7469676874;

/// The volume inside a shell, in its frame, by descent through bricks of its box.
class VolumeMeter {
 public:
  explicit VolumeMeter(const Shell& shell) : shell_(shell), frame_(frame(shell)) {
    while (max_component(shell.hi - shell.lo) > kLongest * step_) step_ *= 2;
    for (int axis = 0; axis < 3; ++axis) {
      const std::int64_t extent = shell.hi[axis] - shell.lo[axis];
      bricks_[axis] = int((extent + kBrick * step_ - 1) / (kBrick * step_));
    }
  }

  double measure() const {
    std::vector<double> parts(std::size_t(bricks_.x) * std::size_t(bricks_.y) *
                              std::size_t(bricks_.z));
    const std::size_t count = shell_.form.perturbations.size();
    const Acting acting = count == 0 ? 0 : ~Acting{0} >> (64 - count);
    parallel_for(0, parts.size(), [&](std::size_t i) {
      const auto nx = std::size_t(bricks_.x), ny = std::size_t(bricks_.y);
      const Vec3l brick{std::int64_t(i % nx), std::int64_t(i / nx % ny), std::int64_t(i / nx / ny)};
      parts[i] = inside({brick * (kBrick * step_) + shell_.lo, kBrick * step_}, acting);
    });
    double sum = 0;
    for (const double part : parts) sum += part;
    return sum;
  }

 private:
  struct Cube {
    Vec3l lo;
    std::int64_t edge;
  };

  [[nodiscard]] Box box_of(const Cube& cube) const {
    return {frame_.to_shell(Vec3d(cube.lo)),
            frame_.to_shell(Vec3d(min(cube.lo + Vec3l(cube.edge), shell_.hi)))};
  }

  /// Bits of the perturbations that act somewhere in a box.
  using Acting = std::uint64_t;
  static_assert(kMaxPerturbations <= 64);

  [[nodiscard]] const Perturbation& perturbation(int i) const {
    return shell_.form.perturbations[std::size_t(i)];
  }

  /// Volume of the part of the cube inside the shell.
  [[nodiscard]] double inside(const Cube& cube, Acting acting) const {
    const Box box = box_of(cube);
    const Vec3d extent = box.extent();
    if (min_component(extent) <= 0) return 0;
    const double volume = extent.x * extent.y * extent.z;
    if (cube.edge == step_) return volume * share_of_points(box, acting);
    const Interval slack = slack_range(box, acting);
    if (slack.hi < 0) return 0;
    if (slack.lo >= 0) return volume;
    double sum = 0;
    const std::int64_t half = cube.edge / 2;
    for (int c = 0; c < 8; ++c) {
      sum += inside({cube.lo + Vec3l(c & 1, c >> 1 & 1, c >> 2) * half, half}, acting);
    }
    return sum;
  }

  /// Bounds on a quadric over a box from its centre, up to rounding: this is a measurement.
  static Interval range_about_centre(const Quadric& q, const Box& box) {
    const Vec3d c = box.centre(), h = box.extent() * 0.5, g = gradient(q, c);
    const auto size = [](Vec3d v) { return Vec3d{std::abs(v.x), std::abs(v.y), std::abs(v.z)}; };
    const double reach = dot(size(g), h) + dot(size(q.square), h * h) +
                         dot(size(q.mixed), Vec3d{h.y * h.z, h.z * h.x, h.x * h.y});
    const double v = value(q, c);
    return {v - reach, v + reach};
  }

  /// Bounds on the slack over the box; leaves out of `acting` what does not act there.
  Interval slack_range(const Box& box, Acting& acting) const {
    const bool hard = shell_.kind == ShellKind::hard;
    Interval united = range_about_centre(shell_.form.base, box);
    Interval apart(std::numeric_limits<double>::infinity());
    for (Acting rest = acting; rest != 0; rest &= rest - 1) {
      const Perturbation& r = perturbation(std::countr_zero(rest));
      const Interval q = range_about_centre(r.form.base, box);
      if (q.hi <= 0) {
        acting ^= rest & -rest;
      } else if (!hard) {
        united = united + Interval(r.strength) * square({std::max(0.0, q.lo), q.hi});
      } else if (r.strength > 0) {
        united = max(united, q);
      } else {
        apart = min(apart, -q);
      }
    }
    return min(united, apart);
  }

  [[nodiscard]] bool holds(Vec3d p, Acting acting) const {
    const bool hard = shell_.kind == ShellKind::hard;
    double united = value(shell_.form.base, p);
    for (; acting != 0; acting &= acting - 1) {
      const Perturbation& r = perturbation(std::countr_zero(acting));
      const double q = value(r.form.base, p);
      if (q <= 0) continue;
      if (hard && r.strength < 0) return false;
      united = hard ? std::max(united, q) : united + r.strength * (q * q);
    }
    return united >= 0;
  }

  [[nodiscard]] double share_of_points(const Box& box, Acting acting) const {
    int count = 0;
    for (int c = 0; c < 8; ++c) {
      const Vec3d quarter{c & 1 ? 0.75 : 0.25, c & 2 ? 0.75 : 0.25, c & 4 ? 0.75 : 0.25};
      count += holds(box.lo + box.extent() * quarter, acting);
    }
    return count / 8.0;
  }

  const Shell& shell_;
  ShellFrame frame_;
  std::int64_t step_ = 1;  ///< in cells
  Vec3i bricks_;
};

/// The linear part of the map, or the unit where it keeps all angles: lines are then isotropic
/// already.
Affine shape_of(const Affine& map) {
  Affine linear = map;
  linear.t = Vec3d{};
  const double unit = std::cbrt(std::abs(determinant(linear)));
  constexpr double kEqual = 1e-9;
  Vec3d axes[3];
  for (int a = 0; a < 3; ++a) {
    Vec3d e;
    e[a] = 1;
    axes[a] = linear.vector(e) / unit;
  }
  bool similar = true;
  for (int a = 0; a < 3; ++a) {
    for (int b = a; b < 3; ++b) {
      similar = similar && std::abs(dot(axes[a], axes[b]) - (a == b)) < kEqual;
    }
  }
  return similar ? Affine{} : linear;
}

/// Lines through a box of index space, of the measure that is invariant under motions of the world:
/// a point of the surface, uniform by area there, and a direction inwards, by the cosine with the
/// normal there.
class Lines {
 public:
  Lines(const Box& box, const Affine& index_to_world)
      : box_(box), shape_(shape_of(index_to_world)), back_(inverse(shape_)) {
    for (int a = 0; a < 3; ++a) {
      Vec3d edge;
      edge[a] = box.extent()[a];
      edges_[a] = shape_.vector(edge);
    }
    for (int a = 0; a < 3; ++a) {
      areas_[a] = length(cross(edges_[(a + 1) % 3], edges_[(a + 2) % 3]));
    }
  }

  [[nodiscard]] Ray line(std::uint64_t index) const {
    Rng rng(kSeed, index, 0);
    const Philox::Block a = rng.block(), b = rng.block(), c = rng.block();
    double choice = to_uniform_double(a.lo) * (areas_.x + areas_.y + areas_.z);
    int axis = 0;
    while (axis < 2 && choice >= areas_[axis]) choice -= areas_[axis++];
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const bool high = a.hi >> 63;
    Ray line;
    line.o[axis] = high ? box_.hi[axis] : box_.lo[axis];
    line.o[u] = box_.lo[u] + box_.extent()[u] * to_uniform_double(b.lo);
    line.o[v] = box_.lo[v] + box_.extent()[v] * to_uniform_double(b.hi);
    // Around the face's inward normal in the world; the other two axes are the face's own where it
    // has right angles.
    const Vec3d normal = cross(edges_[u], edges_[v]) / areas_[axis];
    const Vec3d in = normal * ((dot(normal, edges_[axis]) > 0) == high ? -1.0 : 1.0);
    const Vec3d along = normalize(edges_[u]), across = cross(normal, along);
    const double sine2 = to_uniform_double(c.lo), sine = std::sqrt(sine2);
    const double angle = 2 * std::numbers::pi * to_uniform_double(c.hi);
    line.d = normalize(back_.vector(in * std::sqrt(1 - sine2) + along * (sine * std::cos(angle)) +
                                    across * (sine * std::sin(angle))));
    return line;
  }

 private:
  Box box_;
  Affine shape_, back_;
  Vec3d edges_[3];  // of the box in the world
  Vec3d areas_;     // of its faces across each axis
};

/// Entry into the first occupied cell of the node along the ray, with t in [t0, t1]; infinite if it
/// meets none.
double first_entry(const Support& support, const SupportNode& node, const Ray& ray) {
  constexpr double kNowhere = std::numeric_limits<double>::infinity();
  const Vec3d lo(node.lo);
  const Box box{lo, lo + Vec3d(double(std::int64_t(1) << node.log2))};
  const std::optional<Span> span = intersect(box, ray, 0, kNowhere);
  if (!span) return kNowhere;
  if (node.full) return span->t0;
  const SupportChildren halves = children(support, node);
  std::array<const SupportNode*, 8> octant{};
  for (int i = 0; i < halves.count; ++i) {
    const SupportNode& half = halves.node[std::size_t(i)];
    const int code =
        (half.lo.x > node.lo.x) + 2 * (half.lo.y > node.lo.y) + 4 * (half.lo.z > node.lo.z);
    octant[std::size_t(code)] = &half;
  }
  // In an order in which nothing comes before what the ray meets earlier.
  const int flip = (ray.d.x < 0) + 2 * (ray.d.y < 0) + 4 * (ray.d.z < 0);
  for (int c = 0; c < 8; ++c) {
    const SupportNode* half = octant[std::size_t(c ^ flip)];
    if (half == nullptr) continue;
    const double t = first_entry(support, *half, ray);
    if (t < kNowhere) return t;
  }
  return kNowhere;
}

struct Hits {
  std::uint64_t shell = 0, support = 0;
};

Hits count_hits(const Shell& shell, const Support& support, std::uint64_t lines,
                const Affine& index_to_world) {
  const RayShell rays(shell);
  const Box box{Vec3d(shell.lo), Vec3d(shell.hi)};
  const Lines random(box, index_to_world);
  const SupportNode top = root(support);
  const double through = length(box.extent());
  std::atomic<std::uint64_t> in_shell = 0, in_support = 0;
  parallel_parts(0, lines, 256, [&](std::size_t begin, std::size_t end) {
    std::vector<Span> spans;
    Hits hits;
    for (std::size_t i = begin; i != end; ++i) {
      const Ray line = random.line(i);
      hits.support += first_entry(support, top, line) <= through;
      rays.intersect(line, 0, through, spans);
      hits.shell += !spans.empty();
    }
    in_shell += hits.shell;
    in_support += hits.support;
  });
  return {in_shell, in_support};
}

}  // namespace

ShellTightness measure_tightness(const Shell& shell, const Support& support, std::uint64_t lines,
                                 const Affine& index_to_world) {
  const Vec3d extent(shell.hi - shell.lo);
  const double cells = double(support.cells);
  ShellTightness t;
  t.box_volume_ratio = extent.x * extent.y * extent.z / cells;
  t.volume_ratio = VolumeMeter(shell).measure() * std::pow(frame(shell).unit, 3) / cells;
  const Hits hits = count_hits(shell, support, lines, index_to_world);
  const double met = double(std::max<std::uint64_t>(1, hits.support));
  t.hit_ratio = double(hits.shell) / met;
  t.box_hit_ratio = double(lines) / met;
  return t;
}

std::optional<double> standard_error_of_hits(double hit_ratio, double box_hit_ratio,
                                             std::uint64_t lines) {
  constexpr double kFewest = 30;
  const double met = double(lines) / box_hit_ratio;
  if (!(met >= kFewest)) return std::nullopt;
  return std::sqrt(std::max(0.0, hit_ratio * (hit_ratio - 1)) / met);
}

std::optional<Span> first_and_last(const Support& support, const Ray& ray) {
  if (support.empty()) return std::nullopt;
  const SupportNode top = root(support);
  const double first = first_entry(support, top, ray);
  if (std::isinf(first)) return std::nullopt;
  // Backwards from behind everything: the first entry there is the last exit here.
  const Vec3d lo(top.lo);
  const Box cube{lo, lo + Vec3d(double(std::int64_t(1) << top.log2))};
  const double end = intersect(cube, ray, 0, std::numeric_limits<double>::infinity())->t1;
  const double last = end - first_entry(support, top, {ray.at(end), -ray.d});
  return Span{first, std::max(first, last)};
}

}  // namespace pvol
