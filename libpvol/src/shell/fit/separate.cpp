#include "shell/fit/separate.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "shell/fit/adam.h"
#include "shell/fit/monomials.h"
#include "shell/fit/sampling.h"

namespace pvol::detail {
namespace {

using Coefficients = std::array<double, 9>;  // of the monomials but 1

Monomials to_float(const Coefficients& w) {
  Monomials m{};
  for (std::size_t i = 0; i < w.size(); ++i) m[i] = float(w[i]);
  return m;
}

Quadric to_quadric(const Coefficients& w, double constant) {
  return {{w[0], w[1], w[2]}, {w[3], w[4], w[5]}, {w[6], w[7], w[8]}, constant};
}

/// Points in the frame of a ball.
void add_local(Points& local, const Seed& seed, Vec3f p) {
  local.add(Vec3f((Vec3d(p) - seed.centre) / seed.radius));
}

/// `count` of the points, or all, in the frame of a ball.
Points subset(const Points& all, const Seed& seed, std::size_t count, std::uint64_t key) {
  Points chosen;
  for (const std::uint32_t i : spread(all.size(), count, key)) add_local(chosen, seed, all[i]);
  pad(chosen);
  return chosen;
}

class Search {
 public:
  Search(const Points& boundary, const Points& targets, const Seed& seed,
         const SearchEffort& effort, std::uint64_t key)
      : all_boundary_(boundary),
        seed_(seed),
        effort_(effort),
        boundary_(subset(boundary, seed, effort.boundary, 2 * key)),
        targets_(subset(targets, seed, effort.targets, 2 * key + 1)),
        adam_(9) {
    const Affine to_local = scaling(Vec3d(1 / seed.radius)) * translation(-seed.centre);
    const Quadric q = transform(to_local, seed.quadric);
    std::copy_n(terms(q).begin(), w_.size(), w_.begin());
  }

  Quadric run() {
    const int parts = effort_.rounds + 1;
    for (int part = 0; part < parts; ++part) {
      if (part > 0) add_violated();
      const int end = effort_.iterations * (part + 1) / parts;
      for (int i = effort_.iterations * part / parts; i < end; ++i) {
        const double done = double(i) / effort_.iterations;
        step(effort_.width_begin * std::pow(effort_.width_end / effort_.width_begin, done),
             effort_.rate_begin * std::pow(effort_.rate_end / effort_.rate_begin, done));
      }
    }
    return to_shell();
  }

 private:
  /// With unit slope where it touches the boundary, on average.
  [[nodiscard]] Quadric to_shell() const {
    const Affine from_local = translation(seed_.centre) * scaling(Vec3d(seed_.radius));
    return seed_.radius * transform(from_local, to_quadric(w_, 0));
  }

  void step(double width, double rate) {
    const Monomials q = to_float(w_);
    values_.resize(boundary_.size());
    const float most = evaluate(q, boundary_, values_.data());
    const QuadricTerms active =
        moments_near(boundary_, values_, most, float(1 / (kNearGreatest * width)));
    const QuadricTerms pull = moments_of_slopes(q, targets_, most, float(1 / width));

    Coefficients gradient;
    for (std::size_t k = 0; k < 9; ++k) {
      gradient[k] = pull[k] - pull[9] * (active[k] / active[9]);
    }
    adam_.ascend(w_.data(), gradient.data(), rate);
    // Values count in distances from the surface: unit slope where it touches the boundary.
    const double slope = std::sqrt(mean_square_gradient(to_quadric(w_, 0), active));
    if (slope > 0) {
      for (double& w : w_) w /= slope;
    }
  }

  /// The worst of all boundary points, as far as they lie above the greatest that is looked at.
  void add_violated() {
    constexpr std::size_t kMostAdded = 600;
    std::vector<float> values(all_boundary_.size());
    evaluate(monomials(to_shell()), all_boundary_, values.data());
    std::vector<std::size_t> order(values.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const std::size_t count = std::min(kMostAdded, order.size());
    std::nth_element(order.begin(), order.begin() + std::ptrdiff_t(count - 1), order.end(),
                     [&](std::size_t a, std::size_t b) {
                       return values[a] != values[b] ? values[a] > values[b] : a < b;
                     });
    for (std::size_t k = 0; k < count; ++k) add_local(boundary_, seed_, all_boundary_[order[k]]);
    pad(boundary_);
  }

  const Points& all_boundary_;
  Seed seed_;
  SearchEffort effort_;
  Points boundary_, targets_;  // in the seed's frame
  Coefficients w_{};
  Adam adam_;
  std::vector<float> values_;
};

}  // namespace

Separation separate(const Points& boundary, const Points& targets, const Seed& seed,
                    const SearchEffort& effort, std::uint64_t key) {
  Separation result;
  result.quadric = Search(boundary, targets, seed, effort, key).run();
  result.quadric.constant -= double(greatest(monomials(result.quadric), boundary));
  result.removed = count_positive(monomials(result.quadric), targets);
  return result;
}

}  // namespace pvol::detail
