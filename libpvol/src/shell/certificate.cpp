#include "pvol/shell/certificate.h"

#include "form/taylor.h"
#include "pvol/shell/ray_shell.h"

namespace pvol {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// What matters in a box and in all parts of it: `end - begin` indices of terms, on a stack.
struct Active {
  std::size_t begin = 0, end = 0;
  bool united = true;          ///< the union of base and bulges may decide
  double dropped = kInfinity;  ///< least slack of what is left out
};

/// A lower bound on the slack over a box, and the place where the slack comes close to it.
struct Estimate {
  double bound;
  Vec3d where;
  Active active;
};

/// Slack of a soft shell: the value of its form.
class SoftSlack {
 public:
  explicit SoftSlack(const FreeForm& form) : form_(form) {}

  [[nodiscard]] std::size_t terms() const { return form_.perturbations.size(); }
  [[nodiscard]] double at(Vec3d p) const { return value(form_, p); }
  [[nodiscard]] double rounding(const Box& box) const { return rounding_error(form_, box); }

  Estimate estimate(Vec3d centre, Vec3d half, const Active& above, double /*cutoff*/,
                    std::vector<std::uint32_t>& stack) const {
    Active active{stack.size(), 0};
    TaylorSum sum(expand(form_.base, centre, half), half);
    for (std::size_t i = above.begin; i < above.end; ++i) {
      const std::uint32_t index = stack[i];
      const Perturbation& r = form_.perturbations[index];
      if (sum.add(r.strength, expand(r.form, centre, half))) stack.push_back(index);
    }
    active.end = stack.size();
    const Least least = sum.least();
    return {least.bound, centre + least.where, active};
  }

 private:
  const FreeForm& form_;
};

/// Slack of a hard shell: the least of -Q over dents and of the greatest of base and bulges.
class HardSlack {
 public:
  explicit HardSlack(const Shell& shell) : shell_(shell) {
    united_.push_back(shell.form.base);
    for (const Perturbation& r : shell.form.perturbations) {
      (r.strength > 0 ? united_ : outsides_).push_back(r.strength > 0 ? r.form.base : -r.form.base);
    }
  }

  [[nodiscard]] std::size_t terms() const { return outsides_.size(); }
  [[nodiscard]] double at(Vec3d p) const { return slack(shell_, p); }
  [[nodiscard]] double rounding(const Box& box) const {
    double most = 0;
    for (const Quadric& q : united_) most = std::max(most, rounding_error(q, box));
    for (const Quadric& q : outsides_) most = std::max(most, rounding_error(q, box));
    return most;
  }

  /// Leaves out what is certainly at least `cutoff`.
  Estimate estimate(Vec3d centre, Vec3d half, const Active& above, double cutoff,
                    std::vector<std::uint32_t>& stack) const {
    Estimate e{kInfinity, centre, {stack.size(), 0, above.united, above.dropped}};
    const auto lower = [&](double bound, Vec3d where) {
      if (bound < e.bound) e = {bound, centre + where, e.active};
    };
    if (above.united) {
      Least most{-kInfinity, {}};
      for (const Quadric& q : united_) {
        const Least l = least(q, centre, half);
        if (l.bound > most.bound) most = l;
      }
      e.active.united = most.bound < cutoff;
      if (!e.active.united) e.active.dropped = std::min(e.active.dropped, most.bound);
      lower(most.bound, most.where);
    }
    for (std::size_t i = above.begin; i < above.end; ++i) {
      const std::uint32_t index = stack[i];
      const Least l = least(outsides_[index], centre, half);
      if (l.bound < cutoff) {
        stack.push_back(index);
      } else {
        e.active.dropped = std::min(e.active.dropped, l.bound);
      }
      lower(l.bound, l.where);
    }
    e.active.end = stack.size();
    e.bound = std::min(e.bound, e.active.dropped);
    return e;
  }

 private:
  static Least least(const Quadric& q, Vec3d centre, Vec3d half) {
    const TaylorForm t = expand(q, centre, half);
    const Least l = pvol::least(t.local, half);
    return {l.bound + t.rest.lo, l.where};
  }

  const Shell& shell_;
  std::vector<Quadric> united_, outsides_;
};

/// A cube of index space that is a node of the support, or part of a full one.
struct Part {
  SupportNode node;
  Vec3d lo;
  int log2 = 0;
  Estimate estimate{};
};

/// Depth first, the least bound first, so that the least slack is known early.
template <class Slack>
class Descent {
 public:
  Descent(const Slack& slack, const Support& support, const ShellFrame& frame,
          const CertifyOptions& options)
      : slack_(slack), support_(support), frame_(frame), options_(options) {}

  Certificate run() {
    result_ = {kInfinity, 0, support_.root_log2};
    if (support_.empty()) return result_;
    for (std::size_t i = 0; i < slack_.terms(); ++i) stack_.push_back(std::uint32_t(i));
    const SupportNode top = root(support_);
    Part whole{top, Vec3d(top.lo), top.log2, {-kInfinity, {}, {0, stack_.size()}}};
    estimate(whole, whole.estimate);
    visit(whole);
    const Box box{frame_.to_shell(Vec3d(support_.lo)), frame_.to_shell(Vec3d(support_.hi))};
    result_.bound = round_down(result_.bound - slack_.rounding(box));
    return result_;
  }

 private:
  /// At or above it nothing more is to be found out.
  [[nodiscard]] double cutoff() const {
    return std::min(options_.enough, known_ - options_.tolerance);
  }

  void estimate(Part& part, const Estimate& above) {
    // Exact: multiples of 2^-deepest cells below 2^24.
    const Vec3d half_edge(std::ldexp(0.5, part.log2));
    const Vec3d centre = frame_.to_shell(part.lo + half_edge), half = half_edge * (1 / frame_.unit);
    part.estimate = slack_.estimate(centre, half, above.active, cutoff(), stack_);
    part.estimate.bound = std::max(part.estimate.bound, above.bound);
    if (part.node.full) known_ = std::min(known_, slack_.at(part.estimate.where));
    ++result_.boxes;
    result_.depth = std::min(result_.depth, part.log2);
  }

  void visit(const Part& part) {
    if (part.estimate.bound >= cutoff() || part.log2 <= options_.deepest) {
      result_.bound = std::min(result_.bound, part.estimate.bound);
      return;
    }
    const std::size_t mark = stack_.size();
    std::array<Part, 8> parts;
    const std::size_t count = divide(part, parts);
    for (std::size_t i = 0; i < count; ++i) estimate(parts[i], part.estimate);
    std::array<const Part*, 8> order;
    for (std::size_t i = 0; i < count; ++i) order[i] = &parts[i];
    std::stable_sort(order.begin(), order.begin() + count, [](const Part* a, const Part* b) {
      return a->estimate.bound < b->estimate.bound;
    });
    for (std::size_t i = 0; i < count; ++i) visit(*order[i]);
    stack_.resize(mark);
  }

  std::size_t divide(const Part& part, std::array<Part, 8>& parts) const {
    const int log2 = part.log2 - 1;
    if (!part.node.full) {
      const SupportChildren c = children(support_, part.node);
      for (std::size_t i = 0; i < std::size_t(c.count); ++i) {
        parts[i] = {c.node[i], Vec3d(c.node[i].lo), log2};
      }
      return std::size_t(c.count);
    }
    const double edge = std::ldexp(1, log2);
    for (unsigned i = 0; i < 8; ++i) {
      const Vec3d step{double(i & 1), double(i >> 1 & 1), double(i >> 2)};
      parts[i] = {part.node, part.lo + step * edge, log2};
    }
    return 8;
  }

  const Slack& slack_;
  const Support& support_;
  ShellFrame frame_;
  CertifyOptions options_;
  double known_ = kInfinity;  ///< least slack found at a point of the support
  Certificate result_;
  std::vector<std::uint32_t> stack_;
};

}  // namespace

Certificate certify(const Shell& shell, const Support& support, const CertifyOptions& options) {
  if (shell.kind == ShellKind::hard) {
    return Descent(HardSlack(shell), support, frame(shell), options).run();
  }
  return Descent(SoftSlack(shell.form), support, frame(shell), options).run();
}

Certificate certify_above(const FreeForm& form, const Support& support, const ShellFrame& frame,
                          const CertifyOptions& options) {
  FreeForm negative = form;
  negative.base = -form.base;
  for (Perturbation& r : negative.perturbations) r.strength = -r.strength;
  Certificate c = Descent(SoftSlack(negative), support, frame, options).run();
  c.bound = -c.bound;
  return c;
}

double evaluator_margin(const Shell& shell) {
  return RayShell(shell).excess(2 * length(Vec3d(shell.hi - shell.lo)));
}

}  // namespace pvol
