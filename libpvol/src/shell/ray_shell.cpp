#include "pvol/shell/ray_shell.h"

#include <array>

#include "form/bernstein.h"

namespace pvol {
namespace {

// Everything is scaled so that magnitudes of values are at most 1. All rounding errors of a
// polynomial and of its roots together stay below kRounding (THEORY.md, T7.3).
constexpr double kRounding = 0x1p-44;
constexpr double kUlp = 0x1p-52;
// Beyond it quadrics are no longer blurred in proportion.
constexpr double kMostBlur = 0x1p-13;
// A root of a quartic is isolated to kIsolation; its slope is at most 8.
constexpr double kQuarticExcess = 0x1p-40;

double largest(Vec3d v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

/// Sum of the magnitudes of the coefficients: bounds |Q| and half the slope where |p_i| <= 1.
double magnitude(const Quadric& q) {
  const auto sum = [](Vec3d v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); };
  return sum(q.square) + sum(q.mixed) + sum(q.linear) + std::abs(q.constant);
}

/// The least power of two above x; 1 for 0.
double power_above(double x) { return x > 0 ? std::ldexp(1, std::ilogb(x) + 1) : 1; }

/// How far points of a ray are off in the shell's frame: origin and product are rounded once each,
/// and so is their sum. `reach`: |o - centre| + |t d|.
double position_error(double reach) { return kUlp * (reach + 2); }

/// A quadric and its first-order change by errors of the position.
double blur_of(double error) { return 3 * error + kRounding; }

/// Insertion sort: there are a handful, most often.
template <class T, class Less>
void sort_few(T* begin, T* end, const Less& less) {
  for (T* i = begin; i < end; ++i) {
    const T moved = *i;
    T* to = i;
    for (; to > begin && less(moved, to[-1]); --to) *to = to[-1];
    *to = moved;
  }
}

/// Ascending, disjoint parts of [0, 1] left of the union of cuts; stops when visit returns false.
template <class Visit>
void visit_gaps(Part01* begin, Part01* end, const Visit& visit) {
  sort_few(begin, end, [](const Part01& x, const Part01& y) { return x.a < y.a; });
  double cursor = 0;
  for (const Part01* c = begin; c != end; ++c) {
    if (!(c->a < c->b)) continue;
    if (c->a > cursor && !visit(cursor, c->a)) return;
    cursor = std::max(cursor, c->b);
  }
  if (cursor <= 1) visit(cursor, 1.0);
}

constexpr std::size_t kMostCuts = 2 * std::size_t(kMaxPerturbations + 1);

struct Cuts {
  std::array<Part01, kMostCuts + 2> part;
  std::size_t count = 0;
  void add(const Positive& p) {
    for (int i = 0; i < p.count; ++i) part[count++] = p.part[std::size_t(i)];
  }
};

bool is_all(const Positive& p) { return p.count == 1 && p.part[0].a < 0 && p.part[0].b > 1; }

}  // namespace

/// The part of a ray in the box, s in [0, 1], and the monomials of its ends.
struct RayShell::Segment {
  double t0, t1, blur;
  // Polar forms of (x^2, y^2, z^2, yz, zx, xy, x, y, z, 1) at (start, start), (start, end) and
  // (end, end): dotted with a quadric's coefficients they give its Bernstein coefficients.
  std::array<std::array<double, kTerms>, 3> polar;
};

/// Bernstein coefficients of a block's quadrics.
struct RayShell::Controls {
  Lanes b[3];
  Lanes greatest;  ///< of the three: nowhere above it
};

namespace {

std::array<double, 10> polar_form(Vec3d p, Vec3d q) {
  return {p.x * q.x,
          p.y * q.y,
          p.z * q.z,
          0.5 * (p.y * q.z + p.z * q.y),
          0.5 * (p.z * q.x + p.x * q.z),
          0.5 * (p.x * q.y + p.y * q.x),
          0.5 * (p.x + q.x),
          0.5 * (p.y + q.y),
          0.5 * (p.z + q.z),
          1};
}

}  // namespace

RayShell::RayShell(const Shell& shell, Vec3l origin) : kind_(shell.kind) {
  const ShellFrame f = frame(shell);
  lo_ = Vec3d(shell.lo - origin);
  hi_ = Vec3d(shell.hi - origin);
  centre_ = (lo_ + hi_) * 0.5;
  to_unit_ = 1 / f.unit;
  const std::vector<Perturbation>& perturbations = shell.form.perturbations;
  if (kind_ == ShellKind::hard) {
    const auto add_scaled = [&](const Quadric& q) {
      const double unit = power_above(magnitude(q));
      scale_ = std::max(scale_, unit);
      add((1 / unit) * q, 1);
    };
    add_scaled(-shell.form.base);
    for (const Perturbation& r : perturbations) {
      if (r.strength > 0) add_scaled(-r.form.base);
    }
    united_ = count_;
    for (const Perturbation& r : perturbations) {
      if (r.strength < 0) add_scaled(r.form.base);
    }
    return;
  }
  // An error of the share e in Q becomes one of less than 4 e in Q^2.
  double sum = magnitude(shell.form.base);
  for (const Perturbation& r : perturbations) {
    const double m = magnitude(r.form.base);
    sum += 4 * std::abs(r.strength) * (m * m);
  }
  scale_ = power_above(sum);
  add((1 / scale_) * shell.form.base, 1);
  for (const Perturbation& r : perturbations) {
    const double unit = power_above(magnitude(r.form.base));
    add((1 / unit) * r.form.base, r.strength * (unit * unit / scale_));
  }
}

void RayShell::add(const Quadric& q, double weight) {
  const int lane = count_ % kLanes;
  if (lane == 0) {
    blocks_.push_back({});
    blocks_.back().coefficient[kTerms - 1] -= 1;  // spare lanes are never positive
  }
  const QuadricTerms c = terms(q);
  for (int i = 0; i < kTerms; ++i) blocks_.back().coefficient[i][lane] = c[std::size_t(i)];
  weights_.push_back(weight);
  ++count_;
}

/// False where the ray certainly misses the box. Quotients are rounded twice: moving them outward
/// by four times as much makes sure of the box.
bool RayShell::clip(const Ray& ray, double t0, double t1, Segment& segment) const {
  constexpr double kMostTime = 0x1p1000;
  t0 = std::max(t0, -kMostTime);
  t1 = std::min(t1, kMostTime);
  for (int axis = 0; axis < 3; ++axis) {
    const double o = ray.o[axis], d = ray.d[axis];
    if (d == 0) {
      if (o < lo_[axis] || o > hi_[axis]) return false;
      continue;
    }
    const double a = (lo_[axis] - o) / d, b = (hi_[axis] - o) / d;
    const double enter = std::min(a, b), leave = std::max(a, b);
    t0 = std::max(t0, enter - std::abs(enter) * (2 * kUlp));
    t1 = std::min(t1, leave + std::abs(leave) * (2 * kUlp));
  }
  if (!(t0 <= t1)) return false;
  segment.t0 = t0;
  segment.t1 = t1;
  const Vec3d from = ray.o - centre_, start = (from + ray.d * t0) * to_unit_,
              end = (from + ray.d * t1) * to_unit_;
  const double far = std::max(std::abs(t0), std::abs(t1));
  segment.blur = blur_of(position_error((largest(from) + far * largest(ray.d)) * to_unit_));
  segment.polar = {polar_form(start, start), polar_form(start, end), polar_form(end, end)};
  return true;
}

void RayShell::evaluate(const Segment& segment, std::size_t block, Controls& controls) const {
  const Block& c = blocks_[block];
  Lanes b0{}, b1{}, b2{};
  for (std::size_t i = 0; i < kTerms; ++i) {
    b0 += c.coefficient[i] * segment.polar[0][i];
    b1 += c.coefficient[i] * segment.polar[1][i];
    b2 += c.coefficient[i] * segment.polar[2][i];
  }
  const Lanes larger = b0 > b1 ? b0 : b1;
  controls = {{b0, b1, b2}, larger > b2 ? larger : b2};
}

/// visit(a, b) for each part of [0, 1] inside the shell.
template <class Visit>
void RayShell::visit_hard(const Segment& segment, const Visit& visit) const {
  Cuts cuts, insides;  // insides: of base and bulges, where there are bulges
  Controls controls;
  for (std::size_t block = 0; block < blocks_.size(); ++block) {
    evaluate(segment, block, controls);
    const auto& b = controls.b;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      // Cuts shrink by the errors of everything, so that they never reach a point inside.
      const int index = int(block * kLanes + lane);
      const bool is_united = united_ > 1 && index < united_;
      if (!is_united && controls.greatest[lane] <= segment.blur) continue;
      const double b0 = b[0][lane] - segment.blur, b1 = b[1][lane] - segment.blur,
                   b2 = b[2][lane] - segment.blur;
      const Positive outside = positive(b0, b1, b2);
      if (is_united) {
        Cuts one;
        one.add(outside);
        visit_gaps(one.part.data(), one.part.data() + one.count, [&](double x, double y) {
          insides.part[insides.count++] = {x == 0 ? -1 : x, y == 1 ? 2 : y};
          return true;
        });
      } else if (is_all(outside)) {
        return;
      } else {
        cuts.add(outside);
      }
      if (united_ > 1 && index + 1 == united_) {
        visit_gaps(insides.part.data(), insides.part.data() + insides.count,
                   [&](double x, double y) {
                     cuts.part[cuts.count++] = {x == 0 ? -1 : x, y == 1 ? 2 : y};
                     return true;
                   });
      }
    }
  }
  visit_gaps(cuts.part.data(), cuts.part.data() + cuts.count, visit);
}

template <class Visit>
void RayShell::visit_soft(const Segment& segment, const Visit& visit) const {
  /// Where a perturbation begins or ends to act.
  struct Event {
    double s;
    Quartic change;
  };
  std::array<Event, 2 * kMostCuts> events;
  std::size_t count = 0;
  Quartic sum{};
  double most = segment.blur;
  Controls controls;
  for (std::size_t block = 0; block < blocks_.size(); ++block) {
    evaluate(segment, block, controls);
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const std::size_t index = block * kLanes + lane;
      const double greatest = controls.greatest[lane];
      if (greatest <= 0 && index > 0) continue;
      const double b0 = controls.b[0][lane], b1 = controls.b[1][lane], b2 = controls.b[2][lane];
      if (index == 0) {
        sum = elevated(b0 + segment.blur, b1 + segment.blur, b2 + segment.blur);
        most += greatest;
        continue;
      }
      const double weight = weights_[index];
      if (weight > 0) most += weight * (greatest * greatest);
      Quartic change = squared(b0, b1, b2);
      for (double& c : change) c *= weight;
      const Positive active = positive(b0, b1, b2);
      for (int i = 0; i < active.count; ++i) {
        const Part01& part = active.part[std::size_t(i)];
        if (part.a < 0) {
          for (std::size_t k = 0; k < 5; ++k) sum[k] += change[k];
        } else {
          events[count++] = {part.a, change};
        }
        if (part.b > 1) continue;
        events[count++] = {part.b, change};
        for (double& c : events[count - 1].change) c = -c;
      }
    }
  }
  if (most < 0) return;
  std::array<const Event*, 2 * kMostCuts> order;
  for (std::size_t i = 0; i < count; ++i) order[i] = &events[i];
  sort_few(order.data(), order.data() + count,
           [](const Event* x, const Event* y) { return x->s < y->s; });
  double from = 0;
  for (std::size_t i = 0; i <= count; ++i) {
    const double to = i < count ? order[i]->s : 1;
    if (to > from || (to == from && count == 0)) {
      if (!visit_positive(restrict_to(sum, from, to), from, to, visit)) return;
      from = to;
    }
    if (i < count) {
      for (std::size_t k = 0; k < 5; ++k) sum[k] += order[i]->change[k];
    }
  }
}

template <class Visit>
void RayShell::visit_parts(const Segment& segment, const Visit& visit) const {
  if (!(segment.blur < kMostBlur)) {
    visit(0.0, 1.0);
  } else if (kind_ == ShellKind::hard) {
    visit_hard(segment, visit);
  } else {
    visit_soft(segment, visit);
  }
}

bool RayShell::misses(const Ray& ray, double t0, double t1) const {
  Segment segment;
  if (!clip(ray, t0, t1, segment)) return true;
  bool missed = true;
  visit_parts(segment, [&](double, double) { return missed = false; });
  return missed;
}

void RayShell::intersect(const Ray& ray, double t0, double t1, std::vector<Span>& spans) const {
  spans.clear();
  Segment segment;
  if (!clip(ray, t0, t1, segment)) return;
  const double length = segment.t1 - segment.t0;
  const double margin = 4 * kUlp * std::max(std::abs(segment.t0), std::abs(segment.t1));
  visit_parts(segment, [&](double a, double b) {
    const double begin = a > 0 ? segment.t0 + (a * length - margin) : segment.t0;
    const double end = b < 1 ? segment.t0 + (b * length + margin) : segment.t1;
    const Span span{std::max(begin, segment.t0), std::min(end, segment.t1)};
    if (!spans.empty() && span.t0 <= spans.back().t1) {
      spans.back().t1 = std::max(spans.back().t1, span.t1);
    } else {
      spans.push_back(span);
    }
    return true;
  });
}

double RayShell::excess(double distance) const {
  const double half = 0.5 * largest(hi_ - lo_);
  // |t d| is at most |o - centre| and the half extent once more.
  const double error = position_error((2 * distance + 3 * half) * to_unit_);
  const double blur = blur_of(error);
  if (!(blur < kMostBlur)) return std::numeric_limits<double>::infinity();
  return scale_ * (4 * blur + (kind_ == ShellKind::soft ? kQuarticExcess : kRounding));
}

}  // namespace pvol
