// The verb `shells`: how tight a cloud's shell is, and whether it holds.
#include <iostream>

#include "cli/json.h"
#include "pvol/error.h"
#include "pvol/shell/recipe_support.h"
#include "pvol/shell/tightness.h"
#include "stats/shell_page.h"
#include "stats/shell_report.h"
#include "stats/stats.h"

namespace pvol::cli {
namespace {

ShellReplay replay(const Shell& shell, const Support& support) {
  ShellReplay r;
  Stopwatch watch;
  r.certificate = certify(shell, support);
  r.seconds = watch.lap();
  r.tightness = measure_tightness(shell, support);
  r.margin = evaluator_margin(shell);
  return r;
}

/// Throws Error where the shell does not keep what the file promises.
void require_proof(const ShellsOptions& o, const Shell& shell, const ShellReplay& r) {
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
                 const std::optional<ShellReplay>& r, const std::optional<CheckedShell>& check) {
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
  if (check) std::cout << check->text;
}

}  // namespace

int run_shells(const ShellsOptions& o) {
  if (o.html) check_output(*o.html, {".html", ".htm"});
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
  std::optional<ShellReplay> r;
  std::optional<CheckedShell> check;
  if (o.verify || o.check || o.html) {
    const formats::Cloud cloud = formats::load_cloud(o.input);
    print_warnings("pvol-stats", cloud.report.warnings);
    const Support support = make_support(cloud.grid, cloud.pyramid);
    if (o.verify) {
      r = replay(shell, support);
      require_proof(o, shell, *r);
    }
    if (o.check) check = naming(o.input, [&] { return check_shell(shell, support); });
    if (o.html) {
      const measure::ShellProbe probe =
          naming(o.input, [&] { return measure::probe_shell(cloud.grid, cloud.pyramid, shell); });
      html::write_page(*o.html, shell_page(o.input.string(), cloud, bytes, probe, r, check));
    }
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
  if (check) {
    j["check"] = check->text;
    j["distances"] = {{"cloud_to_shell", check->cloud_to_shell},
                      {"shell_to_cloud", check->shell_to_cloud}};
    j["ellipsoid_volume_ratio"] = check->ellipsoid_volume_ratio;
    j["hull_volume_ratio"] = check->hull_volume_ratio;
  }
  std::cout << to_text(j);
  return kSuccess;
}

}  // namespace pvol::cli
