// The verb `shells`: how tight a cloud's shell is, and whether it holds.
#include <iostream>

#include "json.h"
#include "pvol/error.h"
#include "pvol/shell/certificate.h"
#include "pvol/shell/tightness.h"
#include "shell_checks.h"
#include "shell_report.h"
#include "stats.h"

namespace pvol::cli {
namespace {

/// The certificate computed again from the density, and the tightness measured again.
struct Replay {
  Certificate certificate;
  ShellTightness tightness;
  double margin = 0;   ///< that rays need
  double seconds = 0;  ///< of the certificate
};

Replay replay(const Shell& shell, const Support& support) {
  Replay r;
  Stopwatch watch;
  r.certificate = certify(shell, support);
  r.seconds = watch.lap();
  r.tightness = measure_tightness(shell, support);
  r.margin = evaluator_margin(shell);
  return r;
}

/// Throws Error where the shell does not keep what the file promises.
void require_proof(const ShellsOptions& o, const Shell& shell, const Replay& r) {
  // Either search may end its tolerance away from the true minimum.
  const double promised = std::max(shell.certificate.bound - CertifyOptions{}.tolerance, r.margin);
  if (r.certificate.bound >= promised) return;
  throw Error(o.input.string() +
              ": the shell does not hold the cloud as promised: its slack is at "
              "least " +
              readable(r.certificate.bound) + ", expected " + readable(promised) +
              " or more. Fit it again, or drop it with pvol-fit --shells none.");
}

void report_text(const ShellsOptions& o, const Shell& shell, std::uint64_t bytes,
                 const std::optional<Replay>& r, const std::string& check) {
  std::cout << o.input.string() << ":\n";
  print_shell(std::cout, shell, bytes, "  ");
  if (r) {
    std::cout << "  verified: the proof was found again with "
              << readable_count(r->certificate.boxes) << " boxes in "
              << readable_seconds(r->seconds) << ", slack at least "
              << readable(r->certificate.bound) << " where rays need " << readable(r->margin)
              << "\n  measured again: volume " << readable(r->tightness.volume_ratio) << ", rays "
              << readable(r->tightness.hit_ratio) << '\n';
  }
  std::cout << check;
}

}  // namespace

int run_shells(const ShellsOptions& o) {
  if (formats::ending(o.input) != ".pvol") {
    throw UsageError(o.input.string() +
                     ": shells are kept in .pvol files; make one with pvol-fit "
                     "--shells auto");
  }
  const formats::PvolFile file = formats::read_pvol(o.input);
  if (!file.shell) {
    throw Error(o.input.string() + ": holds no shell; make one with pvol-fit --shells auto");
  }
  const Shell& shell = *file.shell;
  const std::uint64_t bytes = formats::measure_pvol(o.input).shell;
  std::optional<Replay> r;
  std::string check;
  if (o.verify || o.check) {
    const formats::Cloud cloud = formats::load_cloud(o.input);
    print_warnings("pvol-stats", cloud.report.warnings);
    const Support support = make_support(cloud.grid, cloud.pyramid);
    if (o.verify) {
      r = replay(shell, support);
      require_proof(o, shell, *r);
    }
    if (o.check) check = naming(o.input, [&] { return check_shell(shell, support); });
  }
  if (!o.json) {
    report_text(o, shell, bytes, r, check);
    return kSuccess;
  }
  Json j = to_json(shell, bytes);
  if (r) {
    Shell again = shell;
    again.certificate = r->certificate;
    again.tightness = r->tightness;
    j["verified"] = to_json(again, bytes);
    j["verified"]["seconds"] = r->seconds;
    j["verified"]["margin"] = r->margin;
  }
  if (!check.empty()) j["check"] = check;
  std::cout << to_text(j);
  return kSuccess;
}

}  // namespace pvol::cli
