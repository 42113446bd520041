#include "stats/study_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <utility>

#include "report/film_pictures.h"

namespace pvol::cli {
namespace {

/// Words with what a shell would split or expand in quotes.
std::string quoted(const std::string& word) {
  constexpr const char* kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./=,:+@%";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

}  // namespace

std::vector<std::string> words_of(const SceneOptions& o, const LoadedScene& loaded) {
  std::vector<std::string> words;
  if (!o.grid.grid.empty()) words.insert(words.end(), {"--grid", o.grid.grid});
  for (const std::string& s : o.sets) words.insert(words.end(), {"--set", s});
  if (o.extinction || o.thickness) {
    const double extinction = loaded.file.volumes.front().medium.extinction;
    words.insert(words.end(), {"--set", fmt::format("medium.extinction={:.17g}", extinction)});
  }
  if (o.force) words.emplace_back("--force");
  return words;
}

std::string render_command(const StudyReport& report, const std::string& option, double samples) {
  std::string text = "pvol-render " + quoted(report.name);
  for (const std::string& word : report.given) text += ' ' + quoted(word);
  if (!option.empty()) text += ' ' + option;
  const auto whole = std::uint32_t(std::min(samples, 4294967295.0));
  return fmt::format("{} --spp {} -o picture.exr", text, whole);
}

std::string label(const measure::Variant& variant) {
  return variant.option.empty() ? "default" : variant.option;
}

std::vector<const measure::Row*> good_rows(const measure::Study& study) {
  std::vector<const measure::Row*> rows;
  for (const measure::Row& r : study.rows) {
    if (r.good()) rows.push_back(&r);
  }
  return rows;
}

std::vector<report::Content> left_out_lines(const measure::Study& study) {
  std::vector<report::Content> lines;
  for (const measure::Row& r : study.rows) {
    if (r.good()) continue;
    lines.push_back(
        report::Text{fmt::format("{}: left out: {}", label(r.variant), r.measured.left_out)});
  }
  return lines;
}

std::vector<report::Content> lookup_part(const std::vector<const measure::Row*>& rows,
                                         std::string_view before,
                                         std::vector<report::Figure> figures) {
  std::vector<NamedFilm> films;
  for (const measure::Row* r : rows) {
    films.push_back({fmt::format("{}{}", before, label(r->variant)), &r->measured.counted_film});
  }
  const LookupMaps maps = lookup_maps(films);
  figures.insert(figures.end(), maps.figures.begin(), maps.figures.end());
  return {
      report::Heading{"Where the density is looked up"},
      report::Text{fmt::format("Look-ups a sample, by pixel, on one logarithmic scale from 0 to "
                               "{:.4g}.",
                               maps.most)},
      report::Figures{std::move(figures)}};
}

Json to_json(const measure::Estimate& e) {
  return {{"value", e.value}, {"low", e.low}, {"high", e.high}, {"coverage", e.coverage}};
}

Json scene_json(const StudyReport& report) {
  const RenderOptions& o = report.loaded.file.scene.options;
  return {{"file", report.name},
          {"extinction", report.loaded.file.volumes.front().medium.extinction},
          {"mean_optical_thickness", report.loaded.facts.front().mean_optical_thickness},
          {"size", {o.width, o.height}}};
}

}  // namespace pvol::cli
