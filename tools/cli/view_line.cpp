#include "cli/view_line.h"

#include <fmt/format.h>

#include <array>
#include <optional>

#include "cli/cli.h"
#include "cli/load_scene.h"
#include "pvol/render/camera.h"

namespace pvol::cli {
namespace {

/// Azimuth and elevation of a camera that frames the clouds, as --view gives them: by a word, or in
/// degrees. Nothing for another text.
std::optional<std::array<std::string, 2>> parse_view(const std::string& view) {
  struct Named {
    const char *name, *azimuth, *elevation;
  };
  constexpr Named kViews[] = {{"front", "0", "0"},   {"right", "90", "0"}, {"side", "90", "0"},
                              {"back", "180", "0"},  {"left", "-90", "0"}, {"top", "0", "90"},
                              {"bottom", "0", "-90"}};
  for (const Named& v : kViews) {
    if (view == v.name) return {{v.azimuth, v.elevation}};
  }
  const std::size_t comma = view.find(',');
  if (comma == std::string::npos) return std::nullopt;
  return {{view.substr(0, comma), view.substr(comma + 1)}};
}

Check is_view(const Entries& camera) {
  const auto degrees = [&](const char* key) {
    return fits(find_key(camera, key)->about.limits.or_word(""));
  };
  return {
      [azimuth = degrees("azimuth"), elevation = degrees("elevation")](const std::string& text) {
        const auto view = parse_view(text);
        if (!view) {
          return fmt::format(
              "found '{}', expected front, right, side, back, left, top, bottom, or degrees "
              "about up and above, such as 45,20",
              text);
        }
        const std::string fault = azimuth.fault((*view)[0]);
        return fault.empty() ? elevation.fault((*view)[1]) : fault;
      },
      "front right side back left top bottom"};
}

}  // namespace

void add_view(const CommandLine& app, FlagSets& sets) {
  Camera defaults;
  const Entries all = entries(defaults);
  app.add_option_function(
         "--view",
         [&sets](const std::string& text) {
           const auto [azimuth, elevation] = parse_view(text).value();
           sets.emplace_back("camera.azimuth=" + azimuth, "--view " + text);
           sets.emplace_back("camera.elevation=" + elevation, "--view " + text);
         },
         "Direction from which the camera that frames the clouds looks: front, right, side, back, "
         "left, top, bottom, or degrees about up from the front and above, such as 45,20 [a little "
         "above the front]")
      .type_name("NAME|AZ,EL")
      .check(is_view(all));
  for (const char* key : {"zoom", "fov"}) {
    const Entry& e = *find_key(all, key);
    app.add_option_function(
           flag_of(e.about),
           [&sets, key](const std::string& text) {
             sets.emplace_back(fmt::format("camera.{}={}", key, text),
                               fmt::format("--{} {}", key, text));
           },
           help_of(e))
        .type_name(metavar_of(e.about))
        .check(fits(e.about.limits));
  }
  const Limits up = find_key(all, "up")->about.limits;
  app.add_option_function(
         "--up",
         [&sets](const std::string& text) {
           const bool axis = text == "y" || text == "z";
           sets.emplace_back(axis ? "world.up=\"" + text + '"' : "camera.up=[" + text + ']',
                             "--up " + text);
         },
         "Axis that is up, y or z, for camera, sky and the default sun; or, for the camera alone, "
         "any direction [y]")
      .type_name("y|z|X,Y,Z")
      .check({[up](const std::string& text) {
        const auto refusal = refuse(up, parse_value(up, text));
        if (text == "y" || text == "z" || !refusal) return std::string();
        return fmt::format("found '{}', expected y, z or {}", text, command_expected(up, *refusal));
      }});
}

void add_to(std::vector<std::string>& sets, std::map<std::string, std::string>& flags_of_sets,
            const FlagSets& of_flags) {
  for (const auto& [set, flag] : of_flags) {
    sets.push_back(set);
    flags_of_sets.emplace(set, flag);
  }
}

formats::SceneFile read_scene_as_set(const std::filesystem::path& input,
                                     const std::vector<std::string>& sets,
                                     const std::map<std::string, std::string>& flags_of_sets,
                                     const std::string& grid) {
  try {
    return read_scene(input, sets, grid);
  } catch (const UsageError& e) {
    const std::string text = e.what();
    for (const auto& [set, flag] : flags_of_sets) {
      const std::string as_set = "--set " + set;
      if (text.starts_with(as_set)) throw UsageError(flag + text.substr(as_set.size()));
    }
    throw;
  }
}

}  // namespace pvol::cli
