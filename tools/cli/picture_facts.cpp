#include "cli/picture_facts.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "cli/cli.h"

namespace pvol::cli {

Json to_json(const Value& value) {
  if (const auto* on = std::get_if<bool>(&value.data)) return *on ? "on" : "off";
  if (const auto whole = value.whole()) return *whole;
  if (const auto number = value.number()) return *number;
  if (const std::string* word = value.word()) return *word;
  Json list = Json::array();
  for (const Value& item : *value.list()) list.push_back(to_json(item));
  return list;
}

std::string attribute_text(const Value& value) {
  const Json j = to_json(value);
  return j.is_string() ? j.get<std::string>() : j.dump();
}

std::string attribute(const std::map<std::string, std::string>& all, const std::string& name) {
  const auto found = all.find(name);
  return found == all.end() ? "" : found->second;
}

std::array<std::string, 2> first_difference(const std::string& a, const std::string& b,
                                            const std::vector<std::string_view>& keys) {
  std::istringstream in_a(a), in_b(b);
  const auto next = [&](std::istringstream& in) {
    std::string line;
    const auto is_left_out = [&](std::string_view key) { return line.starts_with(key); };
    do {
      line.clear();
      std::getline(in, line);
    } while (in && std::ranges::any_of(keys, is_left_out));
    return line;
  };
  do {
    const std::string x = next(in_a), y = next(in_b);
    if (x != y) return {x, y};
  } while (in_a || in_b);
  return {};
}

std::string part_text(const RenderOptions& o) {
  return o.part_end > 0 ? fmt::format("samples {}:{}", o.part_begin, o.part_end) : "";
}

std::string progress_text(std::uint64_t samples, std::uint64_t wanted) {
  return wanted == 0 ? std::to_string(samples) : fmt::format("{} of {}", samples, wanted);
}

std::string noise_text(const Film& film) {
  const std::optional<double> of_pixels = pixel_noise(film), of_mean = relative_noise(film);
  if (!of_pixels || !of_mean) return "noise unknown so far";
  return fmt::format("noise {} % ({} % of the mean)", readable(100 * *of_pixels),
                     readable(100 * *of_mean));
}

void describe_film(const Film& film, std::uint64_t samples, std::uint64_t wanted,
                   const std::optional<FilteredPicture>& filtered,
                   std::map<std::string, std::string>& attributes) {
  attributes["pvol:samples"] = progress_text(samples, wanted);
  if (const std::optional<double> noise = relative_noise(film)) {
    attributes["pvol:relative_noise"] = fmt::format("{:.6g}", *noise);
  }
  if (const std::optional<double> noise = pixel_noise(film)) {
    attributes["pvol:pixel_noise"] = fmt::format("{:.6g}", *noise);
  }
  if (filtered) describe_error(*filtered, attributes);
}

void describe_error(const FilteredPicture& filtered,
                    std::map<std::string, std::string>& attributes) {
  attributes["pvol:estimated_error"] = fmt::format("{:.6g}", filtered.relative_error);
  attributes["pvol:estimated_error_deviation"] =
      fmt::format("{:.6g}", filtered.relative_error_deviation);
  attributes["pvol:fireflies"] = std::to_string(filtered.fireflies);
}

bool wants_filter(const std::map<std::string, std::string>& attributes) {
  const auto is_on = [&](const char* name) {
    const auto found = attributes.find(name);
    return found != attributes.end() && found->second == "on";
  };
  return is_on(kWishForFilter) || is_on("pvol:denoised");
}

void describe_filter(bool filtered, std::map<std::string, std::string>& attributes) {
  attributes["pvol:denoised"] = filtered ? "on" : "off";
  attributes.erase(kWishForFilter);
  // As describe_bias has it: the filter is the last of its reasons.
  constexpr std::string_view kYes = "yes: ", kReason = "denoised";
  std::string& biased = attributes["pvol:biased"];
  if (biased.ends_with(kReason)) biased.erase(biased.size() - kReason.size());
  if (biased.ends_with(", ")) biased.erase(biased.size() - 2);
  if (filtered) {
    biased = biased.starts_with(kYes) && biased != kYes ? biased + ", " : std::string(kYes);
    biased += kReason;
  } else if (biased == kYes) {
    biased = "no";
  }
}

formats::ExrOptions exr_options(const PictureLayout& layout, const Scene& scene) {
  // What a filter made says how much it errs.
  AovSet aovs = scene.options.aovs;
  if (layout.filtered) aovs.add(Aov::variance), aovs.add(Aov::samples);
  return {.aovs = aovs,
          .opaque = scene.options.background,
          .multipart = layout.multipart,
          .pixels = layout.pixels,
          .compression = layout.compression,
          .camera = scene.camera};
}

}  // namespace pvol::cli
