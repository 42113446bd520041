#include "pvol/form/ray_body.h"

#include <algorithm>

#include "pvol/error.h"
#include "pvol/form/roots.h"

namespace pvol {
namespace {

/// All forms of a body, in whatever part.
void collect(const Body& body, std::vector<const FreeForm*>& forms) {
  if (body.op == BodyOp::form) {
    for (const Perturbation& p : body.form.perturbations) {
      if (p.form.perturbations.empty()) continue;
      throw Error(
          "a perturbation that is itself perturbed has no surface in closed form; expected one "
          "level of perturbations");
    }
    forms.push_back(&body.form);
  }
  for (const Body& part : body.parts) collect(part, forms);
}

/// Q along a segment: c[0] + c[1] s + c[2] s^2.
[[nodiscard]] Quartic along(const Quadric& q, const Ray& segment) {
  const Quadric form{q.square, q.mixed, {}, 0};
  return {value(q, segment.o), dot(gradient(q, segment.o), segment.d), value(form, segment.d), 0,
          0};
}

[[nodiscard]] Quartic squared(const Quartic& q) {
  return {q[0] * q[0], 2 * q[0] * q[1], q[1] * q[1] + 2 * q[0] * q[2], 2 * q[1] * q[2],
          q[2] * q[2]};
}

}  // namespace

struct RayBody::Crossing {
  double s;
  const FreeForm* form;
};

RayBody::RayBody(const Body& body) : body_(body), view_(view(body_)), box_(bounds(body)) {
  collect(body_, forms_);
  const Vec3d extent = box_.extent();
  if (box_.empty()) return;
  if (!is_finite(box_.lo) || !is_finite(box_.hi) || !is_finite(extent)) {
    throw Error("the body is unbounded; intersect it with another one to give it a surface");
  }
  const Vec3d rim(1e-9 * max_component(extent));
  box_ = {box_.lo - rim, box_.hi + rim};
}

void RayBody::add_crossings(const FreeForm& form, const Ray& segment,
                            std::vector<Crossing>& all) const {
  std::vector<double> cuts{0, 1};
  std::vector<Quartic> bent;
  for (const Perturbation& p : form.perturbations) {
    bent.push_back(along(p.form.base, segment));
    const Roots borders = sign_changes(bent.back(), 0, 1);
    cuts.insert(cuts.end(), borders.all().begin(), borders.all().end());
  }
  std::sort(cuts.begin(), cuts.end());
  const Quartic base = along(form.base, segment);
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
    const double middle = 0.5 * (cuts[i] + cuts[i + 1]);
    Quartic sum = base;
    for (std::size_t k = 0; k < bent.size(); ++k) {
      if (!(value(bent[k], middle) > 0)) continue;
      const Quartic square = squared(bent[k]);
      for (std::size_t d = 0; d < sum.size(); ++d) {
        sum[d] += form.perturbations[k].strength * square[d];
      }
    }
    const Roots roots = sign_changes(sum, cuts[i], cuts[i + 1]);
    for (const double s : roots.all()) all.push_back({s, &form});
  }
}

std::optional<RayBody::Hit> RayBody::first_hit(const Ray& ray, double t0, double t1) const {
  const auto span = intersect(box_, ray, t0, t1);
  if (!span) return std::nullopt;
  const double length = span->t1 - span->t0;
  const Ray segment{ray.at(span->t0), ray.d * length};
  std::vector<Crossing> all;
  for (const FreeForm* form : forms_) add_crossings(*form, segment, all);
  std::sort(all.begin(), all.end(), [](const Crossing& a, const Crossing& b) { return a.s < b.s; });
  // What one form begins another may hold already: the value on either side tells.
  const auto inside = [&](std::size_t after) {
    const double from = after > 0 ? all[after - 1].s : 0,
                 to = after < all.size() ? all[after].s : 1;
    return value(view_, segment.at(0.5 * (from + to))) >= 0;
  };
  bool before = !all.empty() && inside(0);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool after = inside(i + 1);
    if (after != before) {
      return Hit{span->t0 + all[i].s * length, gradient(*all[i].form, segment.at(all[i].s))};
    }
    before = after;
  }
  return std::nullopt;
}

}  // namespace pvol
