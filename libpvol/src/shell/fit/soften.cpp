#include "shell/fit/soften.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "pvol/math/parallel.h"
#include "pvol/shell/certificate.h"
#include "shell/fit/adam.h"
#include "shell/fit/monomials.h"
#include "shell/fit/sampling.h"

namespace pvol::detail {
namespace {

constexpr int kIterations = 100;  // between ticks, for effort 1
constexpr std::size_t kMostBoundary = 8192, kMostTargets = 8192;
constexpr std::size_t kAdded = 512;       // boundary points found violated, at each tick
constexpr std::size_t kChunk = 1024;      // points that one task looks at
constexpr std::size_t kJudged = 1 << 15;  // empty cells by which results are compared

// How steep Q_i is at first, in units of the frame: soft enough to learn from all around it.
// Stiffer ones come closer to the hard shell but lead nowhere: they count as results only.
constexpr double kSteepness = 20;
constexpr double kStifferStarts[] = {80};
constexpr double kWidthBegin = 0.04, kWidthEnd = 0.003;
constexpr double kRateBegin = 0.003, kRateEnd = 0.0005;
constexpr double kProofTolerance = 1e-4;  // of results that are compared

/// Coefficients in a ball's frame, and their images as coefficients in the shell's.
struct LocalFrame {
  Affine from_local;
  std::array<QuadricTerms, 10> columns;

  explicit LocalFrame(const Affine& map) : from_local(map) {
    for (std::size_t k = 0; k < 10; ++k) {
      QuadricTerms unit{};
      unit[k] = 1;
      columns[k] = terms(transform(map, quadric(unit)));
    }
  }
  [[nodiscard]] QuadricTerms pull_back(const QuadricTerms& gradient) const {
    QuadricTerms local;
    for (std::size_t k = 0; k < 10; ++k) {
      local[k] = std::inner_product(gradient.begin(), gradient.end(), columns[k].begin(), 0.0);
    }
    return local;
  }
};

/// G = -F' over some points: values of each quadric, of G, and the gradient of a weighted sum of G
/// by all coefficients.
class Chunk {
 public:
  Chunk(Points points, std::size_t quadrics) : points_(std::move(points)), values_(quadrics) {
    pad(points_);
    for (std::vector<float>& v : values_) v.resize(points_.size());
    weights.resize(points_.size());
    sum.resize(points_.size());
  }

  void evaluate_at(const std::vector<Monomials>& forms) {
    evaluate(forms[0], points_, values_[0].data());
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = -values_[0][i];
    for (std::size_t j = 1; j < forms.size(); ++j) {
      std::vector<float>& v = values_[j];
      evaluate(forms[j], points_, v.data());
      for (std::size_t i = 0; i < sum.size(); ++i) {
        v[i] = std::max(0.0f, v[i]);
        sum[i] += v[i] * v[i];
      }
    }
  }

  /// Of sum_i weights[i] G(point i); the first also tells the sum of weights, as its last entry
  /// negated.
  void gradient(std::vector<QuadricTerms>& result) {
    for (std::size_t j = 0; j < values_.size(); ++j) {
      std::vector<float>& v = values_[j];
      for (std::size_t i = 0; i < v.size(); ++i) v[i] = weights[i] * (j == 0 ? -1 : 2 * v[i]);
      result[j] = moments(points_, v);
    }
  }

  std::vector<float> sum;      ///< G
  std::vector<float> weights;  ///< by which points count, set from outside

 private:
  Points points_;
  std::vector<std::vector<float>> values_;
};

std::vector<Chunk> make_chunks(const Points& points, std::size_t quadrics) {
  std::vector<Chunk> chunks;
  for (std::size_t begin = 0; begin < points.size(); begin += kChunk) {
    Points part;
    const std::size_t end = std::min(points.size(), begin + kChunk);
    for (std::size_t i = begin; i < end; ++i) part.add(points[i]);
    chunks.emplace_back(std::move(part), quadrics);
  }
  return chunks;
}

std::vector<float> slack_below(const std::vector<Monomials>& forms, const Points& points) {
  std::vector<float> sum(points.size()), values(points.size());
  evaluate(forms[0], points, sum.data());
  for (float& s : sum) s = -s;
  for (std::size_t j = 1; j < forms.size(); ++j) {
    evaluate(forms[j], points, values.data());
    for (std::size_t i = 0; i < sum.size(); ++i) {
      const float inside = std::max(0.0f, values[i]);
      sum[i] += inside * inside;
    }
  }
  return sum;
}

class Softening {
 public:
  Softening(const Support& support, const SupportLattice& lattice,
            const std::vector<Quadric>& quadrics, int effort)
      : support_(support),
        lattice_(lattice),
        quadrics_(quadrics),
        judged_(thinned(lattice.empty, kJudged, 5)),
        looked_at_(thinned(lattice.boundary, kMostBoundary, 6)),
        iterations_(kIterations * effort),
        adam_(10 * quadrics.size()) {
    for (std::size_t j = 0; j < quadrics.size(); ++j) {
      Cluster removed;
      for (std::size_t i = 0; i < judged_.size(); ++i) {
        const Vec3d p(judged_[i]);
        if (j > 0 && value(quadrics[j], p) > 0) removed.add(p);
      }
      Affine from_local;
      if (removed.count > 0) {
        from_local = translation(removed.centre()) * scaling(Vec3d(removed.radius(lattice.edge)));
      }
      frames_.emplace_back(from_local);
    }
    targets_ = make_chunks(thinned(lattice.empty, kMostTargets, 7), quadrics.size());
  }

  FreeForm run(const std::function<void()>& tick) {
    for (const double steepness : kStifferStarts) {
      start(steepness);
      judge();
    }
    start(kSteepness);
    judge();
    for (int t = 0; t < kSoftTicks; ++t) {
      boundary_ = make_chunks(looked_at_, frames_.size());
      for (int i = 0; i < iterations_; ++i) {
        const double done = (t + double(i) / iterations_) / kSoftTicks;
        step(kWidthBegin * std::pow(kWidthEnd / kWidthBegin, done),
             kRateBegin * std::pow(kRateEnd / kRateBegin, done));
      }
      judge();
      tick();
    }
    return best_;
  }

 private:
  void start(double steepness) {
    parameters_.clear();
    for (std::size_t j = 0; j < frames_.size(); ++j) {
      const Quadric q = (j == 0 ? -1 : steepness) * quadrics_[j];
      const QuadricTerms local = terms(transform(inverse(frames_[j].from_local), q));
      parameters_.insert(parameters_.end(), local.begin(), local.end());
    }
  }

  [[nodiscard]] Quadric quadric(std::size_t j) const {
    QuadricTerms local;
    std::copy_n(parameters_.begin() + std::ptrdiff_t(10 * j), 10, local.begin());
    return transform(frames_[j].from_local, pvol::quadric(local));
  }
  [[nodiscard]] std::vector<Monomials> forms() const {
    std::vector<Monomials> result;
    for (std::size_t j = 0; j < frames_.size(); ++j) result.push_back(monomials(quadric(j)));
    return result;
  }

  template <class Visit>
  void for_all_chunks(const Visit& visit) {
    parallel_for(0, boundary_.size() + targets_.size(), [&](std::size_t c) {
      const bool first = c < boundary_.size();
      visit(first ? boundary_[c] : targets_[c - boundary_.size()], first, c);
    });
  }

  void step(double width, double rate) {
    const std::vector<Monomials> now = forms();
    for_all_chunks([&](Chunk& chunk, bool, std::size_t) { chunk.evaluate_at(now); });
    float most = -std::numeric_limits<float>::infinity();
    for (const Chunk& chunk : boundary_) most = std::max(most, std::ranges::max(chunk.sum));

    const float per_width = float(1 / width), per_reach = float(1 / (kNearGreatest * width));
    std::vector<std::vector<QuadricTerms>> parts(boundary_.size() + targets_.size(),
                                                 std::vector<QuadricTerms>(frames_.size()));
    for_all_chunks([&](Chunk& chunk, bool is_boundary, std::size_t c) {
      for (std::size_t i = 0; i < chunk.sum.size(); ++i) {
        const float above = chunk.sum[i] - most;
        if (is_boundary) {
          const float near = std::max(0.0f, 1 + above * per_reach);
          chunk.weights[i] = (near * near) * (near * near);
        } else {
          const float u = above * per_width, r = 1 / (1 + u * u);
          chunk.weights[i] = r * std::sqrt(r);
        }
      }
      chunk.gradient(parts[c]);
    });
    climb(parts, rate);
  }

  /// One step of all parameters along the pull of the targets less that of the active boundary.
  void climb(const std::vector<std::vector<QuadricTerms>>& parts, double rate) {
    std::vector<QuadricTerms> active(frames_.size()), pull(frames_.size());
    for (std::size_t c = 0; c < parts.size(); ++c) {
      std::vector<QuadricTerms>& to = c < boundary_.size() ? active : pull;
      for (std::size_t j = 0; j < to.size(); ++j) {
        for (std::size_t k = 0; k < 10; ++k) to[j][k] += parts[c][j][k];
      }
    }
    const double share = pull[0][9] / active[0][9];
    std::vector<double> gradient;
    for (std::size_t j = 0; j < frames_.size(); ++j) {
      QuadricTerms sum;
      for (std::size_t k = 0; k < 10; ++k) sum[k] = pull[j][k] - share * active[j][k];
      const QuadricTerms local = frames_[j].pull_back(sum);
      gradient.insert(gradient.end(), local.begin(), local.end());
    }
    adam_.ascend(parameters_.data(), gradient.data(), rate);
  }

  [[nodiscard]] FreeForm free_form() const {
    FreeForm form{quadric(0), {}};
    for (std::size_t j = 1; j < frames_.size(); ++j) {
      form.perturbations.push_back({FreeForm{quadric(j), {}}, -1});
    }
    return form;
  }

  [[nodiscard]] double certified_slack(const FreeForm& form) const {
    Shell shell;
    shell.kind = ShellKind::soft;
    shell.lo = support_.lo;
    shell.hi = support_.hi;
    shell.form = form;
    return certify(shell, support_, {kProofTolerance}).bound;
  }

  /// Keeps the present form if it is the best so far, and looks at the worst boundary points.
  void judge() {
    const std::vector<Monomials> now = forms();
    const std::vector<float> boundary = slack_below(now, lattice_.boundary);
    const float most = *std::max_element(boundary.begin(), boundary.end());
    // What is proven counts: between boundary points, and inside the support, G may rise higher.
    const FreeForm form = free_form();
    const double above = std::max(double(most), -certified_slack(form));
    const std::vector<float> empty = slack_below(now, judged_);
    const auto removed =
        std::count_if(empty.begin(), empty.end(), [&](float g) { return double(g) > above; });
    if (removed > removed_) {
      removed_ = removed;
      best_ = form;
      best_.base.constant += above;
    }
    std::vector<std::uint32_t> order(boundary.size());
    std::iota(order.begin(), order.end(), 0u);
    const std::size_t count = std::min(kAdded, order.size());
    std::nth_element(order.begin(), order.begin() + std::ptrdiff_t(count - 1), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) {
                       return boundary[a] != boundary[b] ? boundary[a] > boundary[b] : a < b;
                     });
    for (std::size_t k = 0; k < count; ++k) looked_at_.add(lattice_.boundary[order[k]]);
  }

  const Support& support_;
  const SupportLattice& lattice_;
  const std::vector<Quadric>& quadrics_;
  Points judged_, looked_at_;
  int iterations_;
  std::vector<LocalFrame> frames_;
  std::vector<double> parameters_;  ///< ten of each quadric, in its frame
  Adam adam_;
  std::vector<Chunk> boundary_, targets_;
  FreeForm best_;
  std::ptrdiff_t removed_ = -1;
};

}  // namespace

FreeForm soften(const Support& support, const SupportLattice& lattice,
                const std::vector<Quadric>& quadrics, int effort,
                const std::function<void()>& tick) {
  return Softening(support, lattice, quadrics, effort).run(tick);
}

}  // namespace pvol::detail
