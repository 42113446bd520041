// The verb `shells`: how tight a cloud's shell is, and whether it holds.
#include <fmt/format.h>

#include <iostream>

#include "cli/json.h"
#include "cli/load_scene.h"
#include "pvol/error.h"
#include "pvol/shell/recipe_support.h"
#include "pvol/shell/tightness.h"
#include "report/html.h"
#include "report/terminal.h"
#include "stats/shell_document.h"
#include "stats/shell_report.h"
#include "stats/stats.h"

namespace pvol::cli {
namespace {

ShellReplay replay(const Shell& shell, const Support& support, const Affine& index_to_world) {
  ShellReplay r;
  Stopwatch watch;
  r.certificate = certify(shell, support);
  r.seconds = watch.lap();
  r.tightness = measure_tightness(shell, support, kTightnessLines, index_to_world);
  r.margin = evaluator_margin(shell);
  return r;
}

/// Throws Error where the shell does not keep what the file promises.
void require_proof(const std::string& file, const Shell& shell, const ShellReplay& r) {
  // Either search may end its tolerance away from the true minimum.
  const double promised = std::max(shell.certificate.bound - CertifyOptions{}.tolerance, r.margin);
  if (r.certificate.bound >= promised) return;
  throw Error(fmt::format(
      "{}: the shell is not proven to contain the cloud: its slack is at least {:.4g}, expected "
      "{:.4g} or more; fit it again, or leave it out with pvol-fit --shells none",
      file, r.certificate.bound, promised));
}

Json report_json(const ShellReport& report) {
  Json j = to_json(report.shell, report.bytes);
  if (report.replay) {
    Shell again = report.shell;
    again.certificate = report.replay->certificate;
    again.tightness = report.replay->tightness;
    j["verified"] = to_json(again, report.bytes);
    j["verified"]["seconds"] = report.replay->seconds;
    j["verified"]["margin"] = report.replay->margin;
  }
  if (report.check) {
    const CheckedShell& check = *report.check;
    j["check"] = check.text;
    j["distances"] = {{"cloud_to_shell", check.cloud_to_shell},
                      {"shell_to_cloud", check.shell_to_cloud}};
    j["ellipsoid_volume_ratio"] = check.ellipsoid_volume_ratio;
    j["hull_volume_ratio"] = check.hull_volume_ratio;
  }
  return j;
}

/// Whatever takes the density.
void measure(const ShellsOptions& o, ShellReport& r) {
  r.cloud = load_cloud({"pvol-stats"}, o.input);
  const Support support = make_support(r.cloud.grid(), r.cloud.pyramid);
  if (o.verify) {
    r.replay = replay(r.shell, support, index_to_object(r.cloud.density));
    require_proof(r.file, r.shell, *r.replay);
  }
  if (o.check) r.check = naming(o.input, [&] { return check_shell(r.shell, support); });
  if (!o.html) return;
  r.probe = naming(o.input,
                   [&] { return measure::probe_shell(r.cloud.grid(), r.cloud.pyramid, r.shell); });
}

}  // namespace

int run_shells(const ShellsOptions& o) {
  if (o.html) check_output(*o.html, {".html", ".htm"});
  if (formats::ending(o.input) != ".pvol") {
    throw UsageError(o.input.string() +
                     ": shells are kept in .pvol files; make one with pvol-fit --shells auto");
  }
  const formats::PvolFile file = formats::read_pvol_grid(o.input, "");
  if (!file.shell) {
    throw Error(o.input.string() + ": holds no shell; make one with pvol-fit --shells auto");
  }
  ShellReport r;
  r.file = o.input.string();
  r.shell = *file.shell;
  r.bytes = formats::measure_pvol(o.input).shell;
  if (o.verify || o.check || o.html) measure(o, r);
  const report::Document document = shell_document(r);
  if (o.html) html::write_page(*o.html, document);
  std::cout << (o.json ? to_text(report_json(r)) : report::to_terminal(document));
  return kSuccess;
}

}  // namespace pvol::cli
