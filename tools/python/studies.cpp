#include "python/studies.h"

#include <utility>

#include "cli/load_scene.h"
#include "pvol/error.h"
#include "pvol/measure/compare.h"
#include "stats/image_report.h"
#include "stats/study_clock.h"
#include "stats/trade_report.h"
#include "stats/trade_variants.h"

namespace pvol::python {
namespace {

constexpr std::uint32_t kReferenceRounds = 16;

cli::LoadedScene load(const SceneRequest& request) {
  formats::SceneFile file = read_request(request);
  for (std::size_t i = 0; i < request.in_memory.size(); ++i) {
    if (request.in_memory[i]) file.volumes[i] = request.in_memory[i]->given;
  }
  const formats::SceneFile as_read = file;
  std::size_t number = 0;
  cli::SceneOptions o;
  o.input = request.file;
  o.force = request.force;
  return cli::load_scene(std::move(file), o, cli::kPixelsOfStudy, [&](formats::SceneVolume& v) {
    const std::size_t i = number++;
    if (i < request.in_memory.size() && request.in_memory[i]) return *request.in_memory[i]->cloud;
    return cli::load_cloud({"pvol", true}, v, false, as_read);
  });
}

std::vector<cli::Candidate> candidates_of(const TradeRequest& request,
                                          const cli::LoadedScene& loaded) {
  std::vector<cli::Candidate> all{cli::default_candidate()};
  if (request.variants.empty()) {
    for (cli::Candidate& c : cli::single_candidates(loaded)) all.push_back(std::move(c));
  }
  for (const Variant& variant : request.variants) {
    if (variant.empty())
      throw Error(
          "variants: found one that sets nothing; leave it out, since the default is always "
          "measured");
    cli::Candidate c = cli::candidate(loaded, variant[0].first, variant[0].second);
    for (std::size_t k = 1; k < variant.size(); ++k) {
      c = cli::combine(c, cli::candidate(loaded, variant[k].first, variant[k].second));
    }
    all.push_back(std::move(c));
  }
  return all;
}

measure::SweepOptions options_of(const TradeRequest& request, const Stop& stop) {
  measure::SweepOptions o;
  o.clock = cli::clock_seconds;
  o.interrupted = [&stop] { return stop.load(); };
  o.remedy = "raise the budget or make the picture smaller";
  if (request.samples > 0) o.most_samples = request.samples;
  return o;
}

/// Stops at the samples that are enough, where they are limited.
Film render_reference(const TradeRequest& request, const cli::LoadedScene& loaded,
                      const Stop& stop) {
  measure::SweepOptions o = options_of(request, stop);
  o.budget = cli::kReferencePart * request.budget;
  o.seed = cli::kReferenceSeed;
  std::uint64_t left = std::uint64_t(kReferenceRounds) * o.most_samples;
  const auto stopped = [&stop] { return stop.load(); };
  const bool limited = request.samples > 0;
  o.interrupted = [&, limited] { return stop || (limited && left == 0); };
  return measure::render_reference(o, [&](const measure::RunRequest& r) {
    measure::Run run = cli::render_changed(loaded, {}, {}, r, 0, stopped);
    left -= std::min<std::uint64_t>(left, r.samples);
    return run;
  });
}

}  // namespace

std::string compare_text(const Picture& a, const Picture& b) {
  cli::ImageReport report{"a", "b", {}, {}, measure::compare(a.film, b.film)};
  report.a.film = a.film;
  report.b.film = b.film;
  return cli::to_text(cli::to_json(report));
}

TradeRows measure_trade(const TradeRequest& request, const Stop& stop) {
  const double begin = cli::clock_seconds();
  cli::StudyReport report;
  report.loaded = load(request.scene);
  report.name = request.scene.file.string();
  report.budget = request.budget;
  measure::Study& study = report.study;
  study.picture_pixels = double(report.loaded.picture_width) * report.loaded.picture_height;
  measure::set_reference(study, render_reference(request, report.loaded, stop));

  const std::vector<cli::Candidate> candidates = candidates_of(request, report.loaded);
  std::vector<std::string> names;
  std::vector<measure::Variant> variants;
  for (const cli::Candidate& c : candidates) {
    names.push_back(cli::label(c.variant));
    variants.push_back(c.variant);
  }
  measure::SweepOptions o = options_of(request, stop);
  o.budget = request.budget - (cli::clock_seconds() - begin);
  o.pixels = study.reference.pixels.size();
  const auto render = [&](const measure::RunRequest& r) {
    const cli::Candidate& c = candidates[r.setting];
    return cli::render_changed(report.loaded, c.scene, c.cloud, r, 1, o.interrupted);
  };
  study.rows = measure::make_rows(variants, measure::sweep(names, o, render));
  measure::judge(study);
  return {cli::to_text(cli::trade_json(report).at("settings")), report.loaded.warnings};
}

}  // namespace pvol::python
