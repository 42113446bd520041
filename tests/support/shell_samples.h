// Clouds and shells for tests: random, shaped like those of real clouds, and nasty.
#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "pvol/math/rng.h"
#include "pvol/shell/certificate.h"

namespace pvol::proof {

/// Uniform numbers from a fixed seed.
class Draw {
 public:
  explicit Draw(std::uint64_t seed, std::uint64_t stream = 0) : rng_(seed, stream, 0) {}

  double uniform(double lo, double hi) {
    return lo + (hi - lo) * to_uniform_double(rng_.block().lo);
  }
  double log_uniform(double lo, double hi) { return std::exp(uniform(std::log(lo), std::log(hi))); }
  int index(int count) { return int(uniform(0, count)); }
  Vec3d point(double size) {
    const double x = uniform(-size, size), y = uniform(-size, size), z = uniform(-size, size);
    return {x, y, z};
  }
  Vec3d direction() {
    const double z = uniform(-1, 1), angle = uniform(0, 6.283185307179586);
    const double r = std::sqrt(1 - z * z);
    return {r * std::cos(angle), r * std::sin(angle), z};
  }

 private:
  Rng rng_;
};

/// A rotation by random angles.
inline Affine random_rotation(Draw& draw) {
  Affine a;
  const Vec3d n = draw.direction();
  orthonormal_basis(n, a.m[0], a.m[1]);
  a.m[2] = n;
  return a;
}

/// Cells of a heap of `balls` overlapping balls within `size` cells.
inline std::vector<Vec3l> ball_cells(Draw& draw, int size, int balls) {
  struct Ball {
    Vec3d centre;
    double radius;
  };
  std::vector<Ball> heap;
  Vec3d at(0.5 * size);
  for (int i = 0; i < balls; ++i) {
    const double radius = size * draw.uniform(0.06, 0.18);
    heap.push_back({min(max(at, Vec3d(radius)), Vec3d(size - radius)), radius});
    at = heap[std::size_t(draw.index(i + 1))].centre + draw.direction() * (0.16 * size);
  }
  std::vector<Vec3l> cells;
  for (std::int64_t x = 0; x < size; ++x) {
    for (std::int64_t y = 0; y < size; ++y) {
      for (std::int64_t z = 0; z < size; ++z) {
        const Vec3d p = Vec3d(Vec3l(x, y, z)) + Vec3d(0.5);
        for (const Ball& b : heap) {
          if (length(p - b.centre) > b.radius) continue;
          cells.push_back({x, y, z});
          break;
        }
      }
    }
  }
  return cells;
}

/// An ellipsoid or a half-space near the unit sphere, with values up to `steepness`.
inline Quadric random_side(Draw& draw, double steepness) {
  const Vec3d at = draw.direction() * draw.uniform(0.6, 1.1);
  if (draw.index(4) == 0) return steepness * half_space(at, at + draw.direction() * 0.3);
  const Vec3d radii{draw.uniform(0.2, 0.7), draw.uniform(0.2, 0.7), draw.uniform(0.2, 0.7)};
  return (0.2 * steepness) * ellipsoid(at, radii, random_rotation(draw));
}

inline Quadric lowered(Quadric q, double by) {
  q.constant -= by;
  return q;
}

/// The slack of a shell in long double, from the definition.
using Vec3x = Vec3<long double>;
inline long double exact_value(const Quadric& q, Vec3x p) {
  const Vec3x products{p.y * p.z, p.z * p.x, p.x * p.y};
  return dot(Vec3x(q.square), p * p) + dot(Vec3x(q.mixed), products) + dot(Vec3x(q.linear), p) +
         q.constant;
}
inline long double exact_value(const FreeForm& form, Vec3x p) {
  long double sum = exact_value(form.base, p);
  for (const Perturbation& r : form.perturbations) {
    const long double q = std::max(0.0L, exact_value(r.form, p));
    sum += r.strength * q * q;
  }
  return sum;
}
inline long double exact_slack(const Shell& shell, Vec3x p) {
  if (shell.kind == ShellKind::soft) return exact_value(shell.form, p);
  long double inside = exact_value(shell.form.base, p), outside = -1e4000L;
  for (const Perturbation& r : shell.form.perturbations) {
    long double& most = r.strength > 0 ? inside : outside;
    most = std::max(most, exact_value(r.form.base, p));
  }
  return std::min(inside, -outside);
}

/// A shell around the support as a fit might make it: each dent of a hard shell, and the whole form
/// of a soft one, is lowered or raised until all cells are inside by about `margin`.
inline Shell fitted_shell(Draw& draw, const Support& support, ShellKind kind, int perturbations,
                          double margin = 1e-5) {
  Shell shell;
  shell.kind = kind;
  shell.lo = support.lo;
  shell.hi = support.hi;
  shell.form.base = ellipsoid({}, Vec3d(1.2), random_rotation(draw));
  const CertifyOptions quick{1e-4, -3};
  for (int i = 0; i < perturbations; ++i) {
    const Quadric q = random_side(draw, draw.uniform(2, 8));
    if (kind == ShellKind::soft) {
      shell.form.perturbations.push_back({{q, {}}, draw.uniform(0, 1) < 0.7 ? -1.0 : 0.3});
      continue;
    }
    const double most = certify_above({q, {}}, support, frame(shell), quick).bound;
    shell.form.perturbations.push_back({{lowered(q, most + margin), {}}, -1});
  }
  shell.form = round_to_float(shell.form);
  const CertifyOptions fine{1e-6, -5};
  const double bound = certify(shell, support, fine).bound;
  if (bound < margin) shell.form.base = lowered(shell.form.base, bound - 2 * margin);
  shell.form = round_to_float(shell.form);
  return shell;
}

}  // namespace pvol::proof
