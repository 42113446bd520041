#include "cli/scene_line.h"

#include <fmt/format.h>

#include "pvol/formats/scene_file.h"
#include "pvol/render/aov.h"

namespace pvol::cli {
namespace {

void set_options(const std::map<std::string, std::string>& options, const Entries& entries) {
  for (const Entry& e : entries) {
    const auto given = options.find(e.about.key);
    if (given == options.end()) continue;
    const auto refusal = e.set(parse_value(e.about.limits, given->second));
    if (refusal) {
      throw UsageError(fmt::format("{}: found '{}', expected {}", flag_of(e.about), given->second,
                                   command_expected(e.about.limits, *refusal)));
    }
    if (*e.about.goes_with == 0) continue;
    const Entry& other = *find_key(entries, e.about.goes_with);
    if (other.value() == Value(e.about.of_value)) continue;
    throw UsageError(
        fmt::format("{} needs {} {}", flag_of(e.about), flag_of(other.about), e.about.of_value));
  }
}

/// Throws UsageError for an option that does not go with the others or with the scene.
void check_together(const std::map<std::string, std::string>& options, const Entries& entries,
                    const RenderOptions& o) {
  const auto wrong = misfit(o);
  if (!wrong) return;
  for (const char* key : wrong->keys) {
    const auto given = options.find(key);
    if (given == options.end()) continue;
    throw UsageError(fmt::format("{}: found '{}', expected {}",
                                 flag_of(find_key(entries, key)->about), given->second,
                                 wrong->expected));
  }
}

}  // namespace

void add_scene_options(const CommandLine& app, std::map<std::string, std::string>& options) {
  // The tolerance shows its default where it has one.
  formats::SceneFile defaults{.density = Quantisation{.precision = Precision::fpn}};
  for (const Entry& e : formats::render_keys(defaults)) {
    const auto keep = [&options, key = std::string(e.about.key)](const std::string& text) {
      options[key] = text;
    };
    app.add_option_function(flag_of(e.about), keep, help_of(e))
        .type_name(metavar_of(e.about))
        .check(fits(e.about.limits));
  }
}

void apply_options(const std::map<std::string, std::string>& options, formats::SceneFile& scene) {
  const Entries entries = formats::render_keys(scene);
  set_options(options, entries);
  const auto has = [&](const char* key) { return options.contains(key); };
  RenderOptions& o = scene.scene.options;
  if (has("spp") && !has("noise") && !has("time")) o.noise.reset(), o.time.reset();
  check_together(options, entries, o);
}

std::vector<ManualPart> scene_manual() {
  std::vector<ManualPart> parts;
  parts.push_back({"SCENE FILE",
                   false,
                   "A scene is a TOML file of these sections; only [volume] is required. Colours "
                   "are one number or three, file names are relative to the scene file, and --set "
                   "SECTION.KEY=VALUE replaces a value.",
                   {}});
  for (const formats::SectionManual& section : formats::describe_sections()) {
    ManualPart& part = parts.emplace_back(ManualPart{section.heading, true, section.about, {}});
    for (const auto& line : section.lines) {
      const std::string otherwise = line.otherwise.empty() ? "" : "; default " + line.otherwise;
      part.terms.emplace_back(line.key,
                              fmt::format("{}. Value: {}{}.", line.help, line.expected, otherwise));
    }
  }
  ManualPart& layers = parts.emplace_back(
      ManualPart{"LAYERS",
                 false,
                 "Layers that --aov adds to R, G, B and A in the .exr. Channels are LAYER.R, "
                 "LAYER.G and LAYER.B or, for single numbers, LAYER.Y.",
                 {}});
  for (const AovRow& r : kAovs) {
    const std::string units = *r.units != 0 ? fmt::format(" ({})", r.units) : "";
    layers.terms.emplace_back(r.name, fmt::format("{}{}: {}.", r.meaning, units, r.sums));
  }
  return parts;
}

}  // namespace pvol::cli
