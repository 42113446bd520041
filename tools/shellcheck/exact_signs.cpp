#include "exact_signs.h"

#include <CGAL/Gmpq.h>
#include <CGAL/Interval_nt.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <vector>

namespace pvol::detail {
namespace {

using Rational = CGAL::Gmpq;
using Enclosure = CGAL::Interval_nt<false>;  ///< needs a Protector in scope: it rounds upward

template <class N>
using Point = std::array<N, 3>;

/// A quadric over exact numbers or over enclosures of them.
template <class N>
struct ExactQuadric {
  Point<N> square, mixed, linear;
  N constant{0};

  ExactQuadric() = default;
  explicit ExactQuadric(const Quadric& q) : constant(q.constant) {
    for (int i = 0; i < 3; ++i) {
      const auto k = std::size_t(i);
      square[k] = N(q.square[i]), mixed[k] = N(q.mixed[i]), linear[k] = N(q.linear[i]);
    }
  }

  [[nodiscard]] N operator()(const Point<N>& p) const {
    return p[0] * (square[0] * p[0] + mixed[2] * p[1] + mixed[1] * p[2] + linear[0]) +
           p[1] * (square[1] * p[1] + mixed[0] * p[2] + linear[1]) +
           p[2] * (square[2] * p[2] + linear[2]) + constant;
  }
  /// Second derivatives.
  [[nodiscard]] N hessian(std::size_t i, std::size_t j) const {
    return i == j ? N(2) * square[i] : mixed[3 - i - j];
  }
};

/// A shell over exact numbers or over enclosures of them.
template <class N>
struct ExactShell {
  ShellKind kind;
  ExactQuadric<N> base;
  std::vector<ExactQuadric<N>> quadrics;
  std::vector<N> strengths;
  std::vector<bool> bulges;
  Point<N> twice_centre;
  N unit{1};

  explicit ExactShell(const Shell& shell) : kind(shell.kind), base(shell.form.base) {
    for (const Perturbation& r : shell.form.perturbations) {
      quadrics.emplace_back(r.form.base);
      strengths.emplace_back(r.strength);
      bulges.push_back(r.strength > 0);
    }
    double power = 1;
    while (2 * power < double(max_component(shell.hi - shell.lo))) power *= 2;
    unit = N(power);
    for (int i = 0; i < 3; ++i) {
      twice_centre[std::size_t(i)] = N(double(shell.lo[i] + shell.hi[i]));
    }
  }

  [[nodiscard]] Point<N> to_shell(const Point<N>& index) const {
    Point<N> p;
    for (std::size_t i = 0; i < 3; ++i) p[i] = (N(2) * index[i] - twice_centre[i]) / (N(2) * unit);
    return p;
  }
  [[nodiscard]] Point<N> to_index(const Point<N>& p) const {
    Point<N> x;
    for (std::size_t i = 0; i < 3; ++i) x[i] = p[i] * unit + twice_centre[i] / N(2);
    return x;
  }

  [[nodiscard]] N slack(const Point<N>& p) const {
    using std::max, std::min;
    N inside = base(p);
    if (kind == ShellKind::soft) {
      for (std::size_t i = 0; i < quadrics.size(); ++i) {
        const N q = max(N(0), quadrics[i](p));
        inside = inside + strengths[i] * CGAL::square(q);
      }
      return inside;
    }
    for (std::size_t i = 0; i < quadrics.size(); ++i) {
      if (bulges[i]) inside = max(inside, quadrics[i](p));
    }
    for (std::size_t i = 0; i < quadrics.size(); ++i) {
      if (!bulges[i]) inside = min(inside, N(-quadrics[i](p)));
    }
    return inside;
  }
};

template <class N>
Point<N> point(Vec3d v) {
  return {N(v.x), N(v.y), N(v.z)};
}

/// Solves a p = b by Cramer's rule over the rows and columns of `axes`; the others of p are kept.
/// False where the matrix is singular.
bool solve(const ExactQuadric<Rational>& q, const std::vector<std::size_t>& axes,
           Point<Rational>& p) {
  const std::size_t n = axes.size();
  std::array<std::array<Rational, 4>, 3> m;  // n rows: second derivatives, then the right-hand side
  for (std::size_t r = 0; r < n; ++r) {
    Rational rest = -q.linear[axes[r]];
    for (std::size_t j = 0; j < 3; ++j) {
      const bool free = std::find(axes.begin(), axes.end(), j) != axes.end();
      if (!free) rest -= q.hessian(axes[r], j) * p[j];
    }
    for (std::size_t c = 0; c < n; ++c) m[r][c] = q.hessian(axes[r], axes[c]);
    m[r][n] = rest;
  }
  for (std::size_t c = 0; c < n; ++c) {
    std::size_t pivot = c;
    while (pivot < n && m[pivot][c] == 0) ++pivot;
    if (pivot == n) return false;
    std::swap(m[pivot], m[c]);
    for (std::size_t r = 0; r < n; ++r) {
      if (r == c || m[r][c] == 0) continue;
      const Rational factor = m[r][c] / m[c][c];
      for (std::size_t k = c; k <= n; ++k) m[r][k] -= factor * m[c][k];
    }
  }
  for (std::size_t r = 0; r < n; ++r) p[axes[r]] = m[r][n] / m[r][r];
  return true;
}

/// Calls `visit` with each place where the greatest value of q over a box may lie: corners, and the
/// critical points inside edges, faces and the box.
template <class Visit>
void for_each_candidate(const ExactQuadric<Rational>& q, const Point<Rational>& lo,
                        const Point<Rational>& hi, const Visit& visit) {
  for (int code = 0; code < 27; ++code) {
    const int state[3] = {code % 3, code / 3 % 3, code / 9};  // low end, high end or free
    std::vector<std::size_t> free;
    Point<Rational> p;
    bool possible = true;
    for (std::size_t i = 0; i < 3; ++i) {
      if (state[i] < 2) {
        p[i] = state[i] == 0 ? lo[i] : hi[i];
      } else {
        free.push_back(i);
        possible = possible && q.square[i] < 0;  // else the greatest value lies on a side as well
      }
    }
    if (!possible || !solve(q, free, p)) continue;
    for (const std::size_t i : free) possible = possible && lo[i] <= p[i] && p[i] <= hi[i];
    if (possible) visit(p);
  }
}

class Signs {
 public:
  Signs(const Shell& shell, const Support& support, ShellCheck& check)
      : shell_(shell), support_(support), check_(check), exact_(shell), enclosing_(shell) {}

  /// The lower bounds of the slack at the points (index space), after all signs were decided, the
  /// tightest `rational` of them by rationals.
  std::vector<double> check_points(const std::vector<Vec3d>& points, std::uint64_t rational);
  /// The critical point of each quadric where it lies in an occupied cell.
  void check_critical_points();
  /// The greatest value of each quadric that must not be positive, over these cells.
  void check_cells(const std::vector<Vec3l>& cells);

 private:
  void check_exactly(const Point<Rational>& p);
  void add_witness(const Point<Rational>& p, const Rational& slack);
  [[nodiscard]] std::string cause(const Point<Rational>& p) const;
  void check_cell(const ExactQuadric<Rational>& q, const ExactQuadric<Enclosure>& enclosing,
                  Vec3l cell);

  const Shell& shell_;
  const Support& support_;
  ShellCheck& check_;
  ExactShell<Rational> exact_;
  ExactShell<Enclosure> enclosing_;
};

std::string Signs::cause(const Point<Rational>& p) const {
  if (shell_.kind == ShellKind::hard) {
    for (std::size_t i = 0; i < exact_.quadrics.size(); ++i) {
      if (!exact_.bulges[i] && exact_.quadrics[i](p) > 0) return "dent " + std::to_string(i);
    }
  }
  return "the form";
}

void Signs::add_witness(const Point<Rational>& p, const Rational& slack) {
  const double value = CGAL::to_double(slack);
  if (check_.witness && check_.witness->value <= value) return;
  const Point<Rational> x = exact_.to_index(p);
  const Vec3d index{CGAL::to_double(x[0]), CGAL::to_double(x[1]), CGAL::to_double(x[2])};
  check_.witness = ShellWitness{index, cause(p), value};
}

void Signs::check_exactly(const Point<Rational>& p) {
  ++check_.points, ++check_.rational;
  const Rational slack = exact_.slack(p);
  if (slack < 0) add_witness(p, slack);
}

std::vector<double> Signs::check_points(const std::vector<Vec3d>& points, std::uint64_t rational) {
  std::vector<double> least(points.size());
  std::vector<std::size_t> order(points.size());
  enum Sign : char { inside, outside, open };
  std::vector<Sign> sign(points.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, points.size(), 1024),
                    [&](const auto& range) {
                      const Enclosure::Protector round_upward;
                      for (std::size_t i = range.begin(); i < range.end(); ++i) {
                        const Enclosure slack =
                            enclosing_.slack(enclosing_.to_shell(point<Enclosure>(points[i])));
                        least[i] = slack.inf();
                        sign[i] = slack.inf() >= 0 ? inside : slack.sup() < 0 ? outside : open;
                        order[i] = i;
                      }
                    });
  tbb::parallel_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::tie(least[a], a) < std::tie(least[b], b);
  });
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::size_t i = order[k];
    if (k < rational || sign[i] == open || (sign[i] == outside && !check_.witness)) {
      check_exactly(exact_.to_shell(point<Rational>(points[i])));
    } else {
      ++check_.points;
    }
  }
  return least;
}

void Signs::check_critical_points() {
  std::vector<ExactQuadric<Rational>> all = exact_.quadrics;
  all.push_back(exact_.base);
  for (const ExactQuadric<Rational>& q : all) {
    Point<Rational> p;
    if (!solve(q, {0, 1, 2}, p)) continue;
    const Point<Rational> x = exact_.to_index(p);
    Vec3l cell;
    bool near = true;
    for (int i = 0; i < 3; ++i) {
      const double v = CGAL::to_double(x[std::size_t(i)]);
      near = near && v > double(support_.lo[i]) - 1 && v < double(support_.hi[i]) + 1;
      if (near) cell[i] = std::int64_t(std::floor(v));
    }
    // Rounded to double the point may seem to lie in a cell next to its own, one that touches it
    // but for rounding: a false alarm is ruled out by comparing exactly.
    const auto holds = [&](Vec3l c) {
      for (int i = 0; i < 3; ++i) {
        const Rational& v = x[std::size_t(i)];
        if (v < Rational(double(c[i])) || v > Rational(double(c[i] + 1))) return false;
      }
      return is_occupied(support_, c);
    };
    bool inside = false;
    for (int n = 0; near && !inside && n < 27; ++n) {
      inside = holds(cell + Vec3l(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1));
    }
    if (inside) check_exactly(p);
  }
}

void Signs::check_cell(const ExactQuadric<Rational>& q, const ExactQuadric<Enclosure>& enclosing,
                       Vec3l cell) {
  const Vec3d lo(cell), hi(cell + Vec3l(1));
  {
    const Enclosure::Protector round_upward;
    const Point<Enclosure> box =
        enclosing_.to_shell({Enclosure(lo.x, hi.x), Enclosure(lo.y, hi.y), Enclosure(lo.z, hi.z)});
    if (enclosing(box).sup() <= 0) return;
  }
  const Point<Rational> from = exact_.to_shell(point<Rational>(lo));
  const Point<Rational> to = exact_.to_shell(point<Rational>(hi));
  for_each_candidate(q, from, to, [&](const Point<Rational>& p) {
    if (q(p) > 0) check_exactly(p);
  });
}

void Signs::check_cells(const std::vector<Vec3l>& cells) {
  if (shell_.kind != ShellKind::hard) return;
  for (std::size_t i = 0; i < exact_.quadrics.size(); ++i) {
    if (exact_.bulges[i]) continue;
    for (const Vec3l& cell : cells) check_cell(exact_.quadrics[i], enclosing_.quadrics[i], cell);
  }
  check_.cells = cells.size();
}

/// Every n-th of the boundary's points, and the low corners of the octree's nodes inside, of the
/// least size that makes no more of them.
std::vector<Vec3d> chosen_points(const Support& support, const TriangleMesh& boundary,
                                 std::uint64_t most) {
  std::vector<Vec3d> points;
  const std::size_t stride = std::size_t((boundary.vertices.size() + most - 1) / most);
  for (std::size_t i = 0; i < boundary.vertices.size(); i += stride) {
    points.push_back(boundary.vertices[i]);
  }
  int finest = 0;
  while (support.cells >> (3 * finest) > most / 4) ++finest;
  std::vector<SupportNode> open{root(support)};
  while (!open.empty()) {
    const SupportNode node = open.back();
    open.pop_back();
    if (node.log2 > finest) {
      const SupportChildren below = children(support, node);
      for (int i = 0; i < below.count; ++i) open.push_back(below.node[std::size_t(i)]);
    } else if (node.full) {
      points.push_back(Vec3d(node.lo));
    }
  }
  return points;
}

/// The occupied cells that touch the tightest points, ascending.
std::vector<Vec3l> tightest_cells(const Support& support, const std::vector<Vec3d>& points,
                                  const std::vector<double>& slack, std::size_t count) {
  std::vector<std::size_t> order(points.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  count = std::min(count, order.size());
  std::partial_sort(
      order.begin(), order.begin() + std::ptrdiff_t(count), order.end(),
      [&](std::size_t a, std::size_t b) { return std::tie(slack[a], a) < std::tie(slack[b], b); });
  std::vector<Vec3l> cells;
  for (std::size_t k = 0; k < count; ++k) {
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3l cell = Vec3l(points[order[k]]) - Vec3l(corner & 1, corner >> 1 & 1, corner >> 2);
      if (is_occupied(support, cell)) cells.push_back(cell);
    }
  }
  std::sort(cells.begin(), cells.end(),
            [](Vec3l a, Vec3l b) { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); });
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  return cells;
}

/// Points 1/4 cell apart in these cells.
std::vector<Vec3d> fine_points(const std::vector<Vec3l>& cells) {
  std::vector<Vec3d> points;
  for (const Vec3l& cell : cells) {
    for (int i = 0; i < 125; ++i) {
      points.push_back(Vec3d(cell) + Vec3d(i % 5, i / 5 % 5, i / 25) * 0.25);
    }
  }
  return points;
}

}  // namespace

void check_signs(const Shell& shell, const Support& support, const TriangleMesh& boundary,
                 const ShellCheckOptions& options, ShellCheck& check) {
  Signs signs(shell, support, check);
  const std::vector<Vec3d> points = chosen_points(support, boundary, options.points);
  const std::vector<double> slack = signs.check_points(points, options.rational_points);
  const auto count = std::size_t(options.rational_points);
  signs.check_points(fine_points(tightest_cells(support, points, slack, count / 10 + 1)), 0);
  signs.check_cells(tightest_cells(support, points, slack, count));
  signs.check_critical_points();

  const Box box{Vec3d(shell.lo), Vec3d(shell.hi)};
  for (const Vec3d v : boundary.vertices) {
    if (!box.contains(v)) {
      check.witness = ShellWitness{v, "the box", 0};
      break;
    }
  }
  check.contained = !check.witness;
}

}  // namespace pvol::detail
