#include "pvol/shell/shell.h"

#include <algorithm>
#include <cmath>

namespace pvol {
namespace {

/// GCC 12 takes a pair of conversions to float and back for a copy where it vectorises two at once;
/// `volatile` keeps it from doing so.
double rounded(double v) {
  const volatile float f = float(v);
  return double(f);
}
Vec3d rounded(Vec3d v) { return {rounded(v.x), rounded(v.y), rounded(v.z)}; }
Quadric rounded(const Quadric& q) {
  return {rounded(q.square), rounded(q.mixed), rounded(q.linear), rounded(q.constant)};
}

bool is_finite(const Quadric& q) {
  using pvol::is_finite;
  return is_finite(q.square) && is_finite(q.mixed) && is_finite(q.linear) &&
         std::isfinite(q.constant);
}

bool is_finite(const FreeForm& form) {
  return is_finite(form.base) &&
         std::all_of(form.perturbations.begin(), form.perturbations.end(),
                     [](const auto& r) { return is_finite(r.form) && std::isfinite(r.strength); });
}

double hard_slack(const FreeForm& form, Vec3d p) {
  double inside = value(form.base, p), outside = std::numeric_limits<double>::infinity();
  for (const Perturbation& r : form.perturbations) {
    const double q = value(r.form.base, p);
    if (r.strength > 0) {
      inside = std::max(inside, q);
    } else {
      outside = std::min(outside, -q);
    }
  }
  return std::min(inside, outside);
}

}  // namespace

ShellFrame frame(Vec3l lo, Vec3l hi) {
  ShellFrame f;
  f.centre = (Vec3d(lo) + Vec3d(hi)) * 0.5;
  while (2 * f.unit < double(max_component(hi - lo))) f.unit *= 2;
  return f;
}

double slack(const Shell& shell, Vec3d p) {
  return shell.kind == ShellKind::hard ? hard_slack(shell.form, p) : value(shell.form, p);
}

bool contains(const Shell& shell, Vec3d index) {
  return Box{Vec3d(shell.lo), Vec3d(shell.hi)}.contains(index) &&
         slack(shell, frame(shell).to_shell(index)) >= 0;
}

FreeForm round_to_float(const FreeForm& form) {
  FreeForm result{rounded(form.base), {}};
  for (const Perturbation& r : form.perturbations) {
    result.perturbations.push_back({round_to_float(r.form), rounded(r.strength)});
  }
  return result;
}

std::optional<std::string> validate(const Shell& shell) {
  if (min_component(shell.hi - shell.lo) <= 0) return "its box is empty";
  const std::vector<Perturbation>& perturbations = shell.form.perturbations;
  if (perturbations.size() > std::size_t(kMaxPerturbations)) {
    return "it has " + std::to_string(perturbations.size()) + " perturbations; expected at most " +
           std::to_string(kMaxPerturbations) + " are possible";
  }
  if (!is_finite(shell.form) || shell.form != round_to_float(shell.form)) {
    return "a coefficient is not a finite float";
  }
  for (const Perturbation& r : perturbations) {
    if (!r.form.perturbations.empty()) return "a perturbation is itself perturbed";
    if (shell.kind == ShellKind::hard && std::abs(r.strength) != 1) {
      return "a strength of a hard shell is " + std::to_string(r.strength) + ", expected 1 or -1";
    }
  }
  const Certificate& c = shell.certificate;
  if (!(std::isfinite(c.bound) && c.bound > 0)) {
    return "its certificate's bound is " + std::to_string(c.bound) + ", expected more than 0";
  }
  return std::nullopt;
}

}  // namespace pvol
