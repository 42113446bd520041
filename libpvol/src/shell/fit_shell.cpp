#include "pvol/shell/fit_shell.h"

#include <string>

#include "pvol/error.h"
#include "pvol/shell/certificate.h"
#include "pvol/shell/tightness.h"
#include "shell/fit/dents.h"
#include "shell/fit/soften.h"

namespace pvol {
namespace {

constexpr int kMostEffort = 10;

// Numbers of perturbations that are compared where none is asked for, and by how many lines.
constexpr int kCandidates[] = {0, 1, 2, 4, 8, 16, 32};
constexpr std::uint64_t kLines = 1 << 14;

int most_perturbations(ShellKind kind) {
  return kind == ShellKind::hard ? kMaxPerturbations : kMaxSoftPerturbations;
}

void check(const Support& support, const ShellOptions& options) {
  if (support.empty()) {
    throw Error("the cloud has no occupied cell to fit a shell to; expected density above 0");
  }
  const int most = most_perturbations(options.kind);
  const int wanted = options.perturbations.value_or(0);
  if (wanted < 0 || wanted > most) {
    throw Error(std::to_string(wanted) + " perturbations requested, but a " +
                (options.kind == ShellKind::hard ? "hard" : "soft") + " shell has 0 to " +
                std::to_string(most) + ".");
  }
  if (options.effort < 1 || options.effort > kMostEffort) {
    throw Error("found an effort of " + std::to_string(options.effort) + ", expected 1 to " +
                std::to_string(kMostEffort) + ".");
  }
}

/// Counts steps for the caller.
class Steps {
 public:
  Steps(const FitProgress& progress, std::uint64_t total) : progress_(progress), total_(total) {}
  void tick(std::uint64_t steps = 1) {
    done_ = std::min(total_, done_ + steps);
    if (progress_) progress_(done_, total_);
  }
  void finish() {
    if (done_ < total_) tick(total_ - done_);
  }

 private:
  const FitProgress& progress_;
  std::uint64_t total_, done_ = 0;
};

Shell make_shell(const Support& support, ShellKind kind, FreeForm form) {
  Shell shell;
  shell.kind = kind;
  shell.lo = support.lo;
  shell.hi = support.hi;
  shell.form = std::move(form);
  return shell;
}

/// The hard shell that the first quadrics of a greedy fit leave over.
Shell carve(const Support& support, const std::vector<Quadric>& quadrics, std::size_t count) {
  FreeForm form;
  form.base.constant = 1;  // everywhere inside: the box alone
  if (!quadrics.empty()) form.base = -quadrics[0];
  for (std::size_t j = 1; j < std::min(count, quadrics.size()); ++j) {
    form.perturbations.push_back({FreeForm{quadrics[j], {}}, -1});
  }
  return make_shell(support, ShellKind::hard, std::move(form));
}

/// Lets the surface out by at least `by`, in units of the slack.
void loosen(Shell& shell, double by) {
  const auto up = [&](double constant) {
    return double(std::nextafter(float(constant + by), std::numeric_limits<float>::infinity()));
  };
  shell.form.base.constant = up(shell.form.base.constant);
  if (shell.kind == ShellKind::soft) return;
  for (Perturbation& r : shell.form.perturbations) {
    Quadric& q = r.form.base;
    q.constant = r.strength < 0 ? -up(-q.constant) : up(q.constant);
  }
}

/// Certifies the coefficients as they will be stored; what is missing is made up for.
void certify_or_loosen(Shell& shell, const Support& support) {
  constexpr int kAttempts = 8;
  shell.form = round_to_float(shell.form);
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    shell.certificate = certify(shell, support);
    const double missing = evaluator_margin(shell) - shell.certificate.bound;
    if (missing <= 0) return;
    loosen(shell, (1 << attempt) * missing);
  }
  throw Error("no shell of this cloud could be certified: its slack stays at " +
              std::to_string(shell.certificate.bound) +
              ". Fit with fewer perturbations, or without a shell.");
}

/// The number of perturbations that costs least, from a fit that is extended as long as it may pay.
std::size_t count_that_pays(detail::Dents& dents, const Support& support,
                            const ShellOptions& options, Steps& steps) {
  const ShellKind kind = options.kind;
  std::size_t best = 1;
  double least = std::numeric_limits<double>::infinity();
  for (const int k : kCandidates) {
    if (test_cost(kind, k) >= least) break;
    while (int(dents.quadrics().size()) <= k) {
      if (!dents.add()) break;
      steps.tick();
    }
    const std::vector<Quadric>& quadrics = dents.quadrics();
    const Shell shell = carve(support, quadrics, quadrics.size());
    const double cost =
        expected_cost(measure_tightness(shell, support, kLines, options.index_to_world), kind,
                      int(shell.form.perturbations.size()));
    if (cost < least) least = cost, best = quadrics.size();
    if (int(quadrics.size()) <= k) break;
  }
  return best;
}

}  // namespace

Shell fit_shell(const Support& support, const ShellOptions& options, const FitProgress& progress) {
  check(support, options);
  const bool soft = options.kind == ShellKind::soft;
  const int wanted = options.perturbations.value_or(kCandidates[std::size(kCandidates) - 1]);
  const auto quadrics = std::uint64_t(wanted) + 1;
  Steps steps(progress, 2 * quadrics + (soft ? detail::kSoftTicks : 0) + 1);

  detail::Dents dents(support, options.effort);
  if (options.perturbations) {
    for (std::uint64_t j = 0; j < quadrics && dents.add(); ++j) steps.tick();
  } else {
    dents.keep(count_that_pays(dents, support, options, steps));
  }
  for (std::size_t j = 0; j < dents.quadrics().size(); ++j) {
    dents.refit(j);
    steps.tick();
  }
  Shell shell = carve(support, dents.quadrics(), dents.quadrics().size());
  if (soft) {
    shell.kind = ShellKind::soft;
    if (dents.quadrics().size() > 1) {
      shell.form = detail::soften(support, dents.lattice(), dents.quadrics(), options.effort,
                                  [&] { steps.tick(); });
    }
  }
  certify_or_loosen(shell, support);
  shell.tightness = measure_tightness(shell, support, kTightnessLines, options.index_to_world);
  steps.finish();
  return shell;
}

double expected_cost(const ShellTightness& tightness, ShellKind kind, int perturbations) {
  return test_cost(kind, perturbations) +
         kFalseHitCost * (tightness.hit_ratio - 1) / tightness.box_hit_ratio;
}

}  // namespace pvol
