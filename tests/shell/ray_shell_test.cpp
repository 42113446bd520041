#include "pvol/shell/ray_shell.h"

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <limits>

#include "support/effort.h"
#include "support/shell_samples.h"

namespace pvol {
namespace ray_shell_test {

using proof::Draw;
using proof::Vec3x;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double signed_log(Draw& draw, double lo, double hi) {
  return (draw.index(2) ? 1 : -1) * draw.log_uniform(lo, hi);
}

/// k (a . p + alpha) (b . p + beta).
Quadric product(double k, Vec3d a, double alpha, Vec3d b, double beta) {
  return {a * b * k, Vec3d{a.y * b.z + a.z * b.y, a.z * b.x + a.x * b.z, a.x * b.y + a.y * b.x} * k,
          (a * beta + b * alpha) * k, alpha * beta * k};
}

/// Anything: a side of a cloud, coefficients without order, planes, pairs of planes that meet or
/// fall together, cones, cylinders, constants.
Quadric any_quadric(Draw& draw) {
  const auto coefficient = [&] { return draw.index(3) ? signed_log(draw, 1e-6, 1e6) : 0; };
  const Vec3d a = draw.direction(), b = draw.direction(), at = draw.point(0.8);
  switch (draw.index(9)) {
    case 0: {
      Quadric q;
      for (int i = 0; i < 3; ++i) {
        q.square[i] = coefficient();
        q.mixed[i] = coefficient();
        q.linear[i] = coefficient();
      }
      q.constant = coefficient();
      return q;
    }
    case 1:
      return signed_log(draw, 1e-3, 1e3) * half_space(at, a);
    case 2:
      return product(signed_log(draw, 1e-3, 1e3), a, -dot(a, at), b, -dot(b, at));
    case 3:
      return product(signed_log(draw, 1e-3, 1e3), a, -dot(a, at), a, -dot(a, at));
    case 4: {  // a cone
      Quadric q = product(1, a, -dot(a, at), a, -dot(a, at));
      const Quadric ball = ellipsoid(at, Vec3d(1));
      q.square = q.square * 3.0 + ball.square;
      q.mixed = q.mixed * 3.0 + ball.mixed;
      q.linear = q.linear * 3.0 + ball.linear;
      q.constant = q.constant * 3.0 + ball.constant - 1;
      return signed_log(draw, 1e-3, 1e3) * q;
    }
    case 5:
      return {{-4, -4, 0}, {}, {}, draw.uniform(0, 1)};  // a cylinder along an axis
    case 6:
      return {{}, {}, {}, coefficient()};
    default:
      return proof::random_side(draw, draw.log_uniform(0.5, 50));
  }
}

Shell any_shell(Draw& draw) {
  Shell shell;
  shell.kind = draw.index(2) ? ShellKind::hard : ShellKind::soft;
  const Vec3l lo(draw.point(1000));
  shell.lo = lo;
  shell.hi = lo + Vec3l(1 + draw.index(200), 1 + draw.index(200), 1 + draw.index(200));
  shell.form.base = draw.index(8) ? ellipsoid(draw.point(0.2), Vec3d(draw.uniform(0.5, 1.5)),
                                              proof::random_rotation(draw))
                                  : any_quadric(draw);
  const bool bulges = draw.index(3) == 0;
  const bool wild = draw.index(3) == 0;
  const int most = draw.index(40) == 0 ? kMaxPerturbations : wild ? 4 : 12;
  const int count = draw.index(most + 1);
  for (int i = 0; i < count; ++i) {
    // Low, so that many of them leave something.
    const double steepness = draw.log_uniform(0.5, 50), low = draw.uniform(0, 0.4) * steepness;
    const Quadric side = proof::lowered(proof::random_side(draw, steepness), low);
    const Quadric q = wild ? any_quadric(draw) : side;
    const double sign = bulges && draw.index(2) ? 1 : -1;
    const double size = shell.kind == ShellKind::hard ? 1 : draw.log_uniform(1e-2, 1e2);
    shell.form.perturbations.push_back({{q, {}}, sign * size});
  }
  shell.form = round_to_float(shell.form);
  return shell;
}

/// A ray with its limits, and a point of it that deserves a look.
struct Segment {
  Ray ray;
  double t0 = 0, t1 = kInfinity;
  double t = 0;
};

/// In the shell's frame.
Vec3d point_in_box(Draw& draw, const Shell& shell) {
  return draw.point(1) * frame(shell).to_shell(Vec3d(shell.hi));
}

/// Points where the slack changes its sign, and some others if there are few.
std::vector<Vec3d> surface_points(Draw& draw, const Shell& shell) {
  std::vector<Vec3d> points;
  for (int n = 0; n < 400 && points.size() < 32; ++n) {
    Vec3d in = point_in_box(draw, shell), out = point_in_box(draw, shell);
    if (slack(shell, in) < 0) std::swap(in, out);
    if (slack(shell, in) < 0 || slack(shell, out) >= 0) continue;
    for (int i = 0; i < 60; ++i) {
      const Vec3d p = (in + out) * 0.5;
      (slack(shell, p) >= 0 ? in : out) = p;
    }
    points.push_back(in);
  }
  points.push_back(point_in_box(draw, shell));
  return points;
}

/// Of the free form or of the quadric whose value is the slack.
Vec3d slope(const Shell& shell, Vec3d p) {
  if (shell.kind == ShellKind::soft) return gradient(shell.form, p);
  const double s = slack(shell, p);
  for (const Perturbation& r : shell.form.perturbations) {
    if (std::abs(value(r.form.base, p)) == std::abs(s)) return gradient(r.form.base, p);
  }
  return gradient(shell.form.base, p);
}

Segment any_segment(Draw& draw, const Shell& shell, const std::vector<Vec3d>& surface) {
  const ShellFrame f = frame(shell);
  Vec3d p = point_in_box(draw, shell), d = draw.direction();
  const int kind = draw.index(8);
  if (kind < 4) p = surface[std::size_t(draw.index(int(surface.size())))];
  if (kind < 3) {  // tangent, as far as rounding lets it be
    const Vec3d n = slope(shell, p);
    const Vec3d across = cross(n, d);
    if (dot(across, across) > 0) d = normalize(across);
    if (kind == 1 && dot(n, n) > 0) p += n * (draw.log_uniform(1e-16, 1e-6) / dot(n, n));
  }
  if (kind == 4 || kind == 5) {  // parallel to a face or an axis
    const int axis = draw.index(3);
    d[axis] = draw.index(2) ? 0.0 : -0.0;
    if (kind == 5) d[(axis + 1) % 3] = -0.0;
    if (draw.index(2)) p[axis] = f.to_shell(Vec3d(draw.index(2) ? shell.lo : shell.hi))[axis];
  }
  if (kind == 6) {  // through edges and corners of the box
    for (int i = 0; i < 3; ++i) {
      if (draw.index(2)) p[i] = f.to_shell(Vec3d(draw.index(2) ? shell.lo : shell.hi))[i];
    }
  }
  Segment s;
  const double size = draw.index(2) ? 1 : draw.log_uniform(1e-6, 1e6);
  const double away = draw.index(4) == 0   ? 0
                      : draw.index(3) == 0 ? draw.log_uniform(10, 1e8)
                                           : draw.uniform(0.1, 5);
  s.ray = {f.to_index(p - d * away), d * (size * f.unit)};
  s.t = away / size;
  if (draw.index(3) == 0) s.t0 = s.t + draw.uniform(-2, 2) / size;
  if (draw.index(3) == 0) s.t1 = s.t + draw.uniform(-2, 2) / size;
  if (draw.index(50) == 0) s.t0 = s.t1 = s.t;
  return s;
}

/// Exact position in the shell's frame but for 2^-63 of the ray's reach.
struct Place {
  Vec3x p;
  long double error;
  bool in_box;
};
Place place(const Shell& shell, const Ray& ray, double t) {
  const ShellFrame f = frame(shell);
  const Vec3x step = Vec3x(ray.d) * static_cast<long double>(t), index = Vec3x(ray.o) + step;
  long double reach = 1;
  bool in_box = true;
  for (int i = 0; i < 3; ++i) {
    const long double error = 0x1p-62L * (std::abs(step[i]) + std::abs(index[i]));
    reach = std::max(reach, (std::abs(step[i]) + std::abs(index[i])) / f.unit);
    in_box = in_box && index[i] >= shell.lo[i] + error && index[i] <= shell.hi[i] - error;
  }
  return {(index - Vec3x(f.centre)) * (1 / static_cast<long double>(f.unit)), reach * 0x1p-61L,
          in_box};
}

/// Sum of the magnitudes of coefficients: a bound on values and half the slopes.
long double magnitude(const Quadric& q) {
  const auto sum = [](Vec3d v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); };
  return sum(q.square) + sum(q.mixed) + sum(q.linear) + std::abs(q.constant);
}
long double magnitude(const Shell& shell) {
  long double sum = magnitude(shell.form.base);
  for (const Perturbation& r : shell.form.perturbations) {
    const long double m = magnitude(r.form.base);
    sum += shell.kind == ShellKind::hard ? m : 4 * std::abs(r.strength) * m * m;
  }
  return sum;
}

struct Counts {
  std::atomic<std::uint64_t> points{0}, inside{0}, outside{0}, hits{0};
  std::atomic<std::uint64_t> lost{0};    ///< certainly inside, yet not in the spans
  std::atomic<std::uint64_t> beyond{0};  ///< in the spans, yet below -excess
  std::atomic<std::uint64_t> unruly{0};  ///< spans that do not ascend, or disagree with misses()
};

bool is_orderly(const std::vector<Span>& spans, const Segment& s) {
  double last = -kInfinity;
  for (const Span& span : spans) {
    if (!(span.t0 > last && span.t1 >= span.t0)) return false;
    last = span.t1;
  }
  return spans.empty() || (spans.front().t0 >= s.t0 && last <= s.t1);
}

void check_point(const Shell& shell, long double size, double excess, const Segment& s,
                 const std::vector<Span>& spans, double t, Counts& counts) {
  if (!(t >= s.t0 && t <= s.t1)) return;
  const bool held = std::any_of(spans.begin(), spans.end(),
                                [t](const Span& span) { return t >= span.t0 && t <= span.t1; });
  const Place at = place(shell, s.ray, t);
  const long double slack = proof::exact_slack(shell, at.p);
  const long double doubt = 4 * size * at.error;
  ++counts.points;
  if (slack > doubt && at.in_box) {
    ++counts.inside;
    counts.lost += !held;
  }
  if (slack < -doubt) {
    ++counts.outside;
    counts.beyond += held && slack < -excess - doubt;
  }
}

/// The place of interest, one at random, and one close to an end of a span on either side.
void check_segment(Draw& draw, const Shell& shell, const RayShell& ready, long double size,
                   const Segment& s, std::vector<Span>& spans, Counts& counts) {
  ready.intersect(s.ray, s.t0, s.t1, spans);
  counts.hits += !spans.empty();
  counts.unruly += ready.misses(s.ray, s.t0, s.t1) != spans.empty() || !is_orderly(spans, s);
  const ShellFrame f = frame(shell);
  const double excess = ready.excess(length(s.ray.o - f.centre));
  const double step = f.unit / length(s.ray.d);
  check_point(shell, size, excess, s, spans, s.t, counts);
  const double anywhere = s.t + draw.uniform(-1, 1) * step;
  if (draw.index(2)) check_point(shell, size, excess, s, spans, anywhere, counts);
  if (spans.empty()) return;
  const Span& one = spans[std::size_t(draw.index(int(spans.size())))];
  const double end = draw.index(2) ? one.t0 : one.t1;
  const double near = draw.index(3) ? draw.log_uniform(1e-16, 1e-2) * step : 0;
  const double between = draw.uniform(one.t0, one.t1);
  check_point(shell, size, excess, s, spans, draw.index(2) ? end - near : end + near, counts);
  if (draw.index(4) == 0) check_point(shell, size, excess, s, spans, between, counts);
}

TEST(RayShell, SpansHoldAllThatIsInsideAndLittleElseInMillionsOfSegments) {
  constexpr std::size_t kSegments = 5000;
  const std::size_t shells = proof::samples(std::size_t{2000});
  Counts counts;
  tbb::parallel_for(std::size_t{0}, shells, [&](std::size_t i) {
    Draw draw(1, i);
    const Shell shell = any_shell(draw);
    const RayShell ready(shell);
    const std::vector<Vec3d> surface = surface_points(draw, shell);
    const long double size = magnitude(shell);
    std::vector<Span> spans;
    for (std::size_t n = 0; n < kSegments; ++n) {
      const Segment s = any_segment(draw, shell, surface);
      check_segment(draw, shell, ready, size, s, spans, counts);
    }
  });
  EXPECT_EQ(counts.lost, 0u);
  EXPECT_EQ(counts.beyond, 0u);
  EXPECT_EQ(counts.unruly, 0u);
  // The oracle saw enough of both.
  EXPECT_GT(counts.inside, shells * kSegments / 5);
  EXPECT_GT(counts.outside, shells * kSegments / 5);
  EXPECT_GT(counts.hits, shells * kSegments / 5);
}

/// A ball of radius 3/4 in a box of 64^3 cells, with a dent and a bulge.
Shell sample_shell(ShellKind kind) {
  Shell s;
  s.kind = kind;
  s.lo = Vec3l(-32);
  s.hi = Vec3l(32);
  s.form.base = ellipsoid({}, Vec3d(0.75));
  s.form.perturbations = {{{ellipsoid({0, 0, 0.75}, Vec3d(0.25)), {}}, -1},
                          {{ellipsoid({-0.75, 0, 0}, Vec3d(0.25)), {}}, 1}};
  return s;
}

std::vector<Span> spans_of(const Shell& shell, const Ray& ray, double t0 = 0,
                           double t1 = kInfinity) {
  std::vector<Span> spans;
  RayShell(shell).intersect(ray, t0, t1, spans);
  EXPECT_EQ(RayShell(shell).misses(ray, t0, t1), spans.empty());
  return spans;
}

TEST(RayShell, FindsKnownSpans) {
  const Shell hard = sample_shell(ShellKind::hard);
  const auto along_z = spans_of(hard, {{0, 0, -100}, {0, 0, 1}});
  ASSERT_EQ(along_z.size(), 1u);  // ends at the dent
  EXPECT_NEAR(along_z[0].t0, 76, 1e-9);
  EXPECT_NEAR(along_z[0].t1, 116, 1e-9);
  const auto through_dent = spans_of(hard, {{-100, 0, 20}, {1, 0, 0}});
  ASSERT_EQ(through_dent.size(), 2u);  // before and behind it
  EXPECT_NEAR(through_dent[0].t0, 100 - std::sqrt(24 * 24 - 20 * 20), 1e-9);
  EXPECT_NEAR(through_dent[0].t1, 100 - std::sqrt(8 * 8 - 4 * 4), 1e-9);
  EXPECT_NEAR(through_dent[1].t0, 100 + std::sqrt(8 * 8 - 4 * 4), 1e-9);
  const auto along_x = spans_of(hard, {{-100, 0, 0}, {2, -0.0, 0}});
  ASSERT_EQ(along_x.size(), 1u);  // begins at the bulge; cut by the box
  EXPECT_NEAR(along_x[0].t0, 34, 1e-9);
  EXPECT_NEAR(along_x[0].t1, 62, 1e-9);
  const auto bulge_alone = spans_of(hard, {{-30, -100, 0}, {0, 1, 0}});
  ASSERT_EQ(bulge_alone.size(), 1u);
  EXPECT_NEAR(bulge_alone[0].t0, 100 - std::sqrt(64 - 36), 1e-9);
}

TEST(RayShell, SoftSpansEndWhereTheFormVanishes) {
  const Shell soft = sample_shell(ShellKind::soft);
  Draw draw(2);
  int ends = 0;
  for (int n = 0; n < 10000; ++n) {
    const Vec3d d = draw.direction();
    const Ray ray{draw.point(20) - d * 100.0, d};
    for (const Span& span : spans_of(soft, ray)) {
      for (const double t : {span.t0, span.t1}) {
        const Vec3d p = frame(soft).to_shell(ray.at(t));
        if (max_component(max(p, -p)) > 0.999) continue;  // cut by the box
        EXPECT_NEAR(value(soft.form, p), 0, 1e-8);
        ++ends;
      }
    }
  }
  EXPECT_GT(ends, 10000);
}

TEST(RayShell, HonoursTheLimitsOfTheRay) {
  for (const ShellKind kind : {ShellKind::hard, ShellKind::soft}) {
    const Shell s = sample_shell(kind);
    const Ray inside{{0, 0, 0}, {0, 1, 0}};  // in the ball for t in [-24, 24]
    const auto from_inside = spans_of(s, inside);
    ASSERT_EQ(from_inside.size(), 1u);
    EXPECT_EQ(from_inside[0].t0, 0);
    EXPECT_NEAR(from_inside[0].t1, 24, 1e-6);
    const auto part = spans_of(s, inside, -3, 5);
    ASSERT_EQ(part.size(), 1u);
    EXPECT_EQ(part[0].t0, -3);
    EXPECT_EQ(part[0].t1, 5);
    EXPECT_TRUE(spans_of(s, inside, 24.001, kInfinity).empty());
    EXPECT_TRUE(spans_of(s, inside, 5, -3).empty());
    EXPECT_EQ(spans_of(s, inside, 1, 1).size(), 1u);                          // a point
    EXPECT_EQ(spans_of(s, {{0, 0, 0}, {0, 0, 0}}, 0, kInfinity).size(), 1u);  // a ray that rests
    EXPECT_TRUE(spans_of(s, {{0, 31, 0}, {0, 0, 0}}, 0, kInfinity).empty());
    EXPECT_TRUE(spans_of(s, {{40, 0, 0}, {-0.0, 1, 0}}).empty());  // beside the box
  }
}

TEST(RayShell, TheOriginOfRaysMovesWithTheLattice) {
  Draw draw(4);
  const Shell s = sample_shell(ShellKind::hard);
  const Vec3l origin{1000003, -77, 12};
  Shell moved = s;
  moved.lo = s.lo + origin;
  moved.hi = s.hi + origin;
  const RayShell here(s), there(moved, origin);
  std::vector<Span> a, b;
  for (int n = 0; n < 1000; ++n) {
    const Ray ray{draw.point(60), draw.direction()};
    here.intersect(ray, 0, kInfinity, a);
    there.intersect(ray, 0, kInfinity, b);
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(a[i].t0, b[i].t0);
      EXPECT_EQ(a[i].t1, b[i].t1);
    }
  }
}

// An instance is one affine map: rays are carried into index space, and neither coefficients nor
// certificate nor intervals know of it.
TEST(RayShell, SpansAreTheSameUnderPlacementsOfAnyScale) {
  for (const ShellKind kind : {ShellKind::hard, ShellKind::soft}) {
    const Shell shell = sample_shell(kind);
    const RayShell ready(shell);
    Draw draw(5);
    std::vector<Span> plain, placed;
    int compared = 0;
    for (int n = 0; n < 20000; ++n) {
      const double scale = draw.log_uniform(1e-6, 1e6);
      const Affine world = translation(draw.point(100) * scale) * proof::random_rotation(draw) *
                           scaling(Vec3d(scale));
      const Affine to_index = inverse(world);
      const Ray ray{draw.point(60), draw.direction()};
      const Vec3d world_direction = world.vector(ray.d);
      const Ray in_world{world.point(ray.o), world_direction / length(world_direction)};
      ready.intersect(ray, 0, kInfinity, plain);
      ready.intersect({to_index.point(in_world.o), to_index.vector(in_world.d)}, 0, kInfinity,
                      placed);
      // Rays that all but touch the surface may gain or lose a span by rounding.
      const auto is_short = [](const Span& s) { return s.t1 - s.t0 < 1e-3; };
      plain.erase(std::remove_if(plain.begin(), plain.end(), is_short), plain.end());
      placed.erase(std::remove_if(placed.begin(), placed.end(),
                                  [&](const Span& s) { return s.t1 - s.t0 < 1e-3 * scale; }),
                   placed.end());
      ASSERT_EQ(plain.size(), placed.size());
      for (std::size_t i = 0; i < plain.size(); ++i) {
        EXPECT_NEAR(placed[i].t0 / scale, plain[i].t0, 1e-7);
        EXPECT_NEAR(placed[i].t1 / scale, plain[i].t1, 1e-7);
        ++compared;
      }
    }
    EXPECT_GT(compared, 1000);
  }
}

TEST(RayShell, ExcessGrowsWithTheDistanceAndStaysSmall) {
  for (const ShellKind kind : {ShellKind::hard, ShellKind::soft}) {
    const RayShell ready(sample_shell(kind));
    EXPECT_LT(ready.excess(100), 1e-6);
    EXPECT_LT(ready.excess(1e8), 1e-2);
    EXPECT_LT(ready.excess(100), ready.excess(1e6));
    EXPECT_EQ(ready.excess(1e18), kInfinity);
  }
  // From there spans are those of the box.
  const Shell s = sample_shell(ShellKind::hard);
  const auto far = spans_of(s, {{-1e18, 0, 0}, {1, 0, 0}});
  ASSERT_EQ(far.size(), 1u);
  EXPECT_LE(far[0].t0, 1e18 - 32);
  EXPECT_GE(far[0].t1, 1e18 + 32);
}

}  // namespace ray_shell_test
}  // namespace pvol
