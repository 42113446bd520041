#include "view/controls.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string_view>
#include <utility>

#include "pvol/error.h"

namespace pvol::viewer {
namespace {

using cli::Json;

// --- sections -----------------------------------------------------------------------------------

/// An entry for which kind of a closed set there is.
template <class Variant>
Entry kind_entry(Variant& thing, const char* key, const char* help) {
  static const std::vector<Variant> kinds = all_kinds<Variant>();
  static const std::vector<std::string_view> words = [] {
    std::vector<std::string_view> all;
    for (const Variant& kind : kinds) all.emplace_back(kind_name(kind));
    return all;
  }();
  return {{.key = key, .limits = {.words = words}, .help = help},
          [&thing] { return Value(kind_name(thing)); },
          [&thing](const Value& v) {
            if (*v.word() == kind_name(thing)) return;
            thing = *std::ranges::find_if(
                kinds, [&](const Variant& kind) { return *v.word() == kind_name(kind); });
          }};
}

/// A component's own keys, with its phase function's kind and keys.
Entries component_entries(Component& c, bool first) {
  Entries all = entries(c);
  if (first) all = without(std::move(all), "share");  // the rest that others leave
  std::erase_if(all, [](const Entry& e) { return e.about.limits.extra == expect_true; });
  const auto place = std::ranges::find_if(
      all, [](const Entry& e) { return std::string_view(e.about.key) == "albedo"; });
  all.insert(place + 1, kind_entry(c.phase, "phase", "Kind of phase function"));
  return all;
}

void add_volume(formats::SceneVolume& v, std::size_t number, std::size_t count,
                std::vector<Section>& all) {
  const std::string id = fmt::format("volume[{}]", number);
  const std::string name = v.file.filename().string();
  const std::string title = count > 1 ? fmt::format("{} ({})", name, number) : name;
  Component& first = v.medium.components.front();
  all.push_back({id + ".medium", title, joined(entries(v.medium), component_entries(first, true))});
  for (std::size_t i = 1; i < v.medium.components.size(); ++i) {
    all.push_back({fmt::format("{}.component[{}]", id, i + 1),
                   fmt::format("{}: component {}", title, i + 1),
                   component_entries(v.medium.components[i], false)});
  }
  if (v.fire) all.push_back({id + ".fire", title + ": fire", entries(*v.fire)});
  all.push_back({id + ".density", title + ": density", entries(v.density_map)});
  if (v.albedo_field && v.albedo_field->grid != formats::kNoGrid) {
    all.push_back({id + ".albedo_field", title + ": albedo", entries(*v.albedo_field)});
  }
  if (v.velocity) all.push_back({id + ".motion", title + ": motion", entries(*v.velocity)});
}

/// Sections of a list, numbered by kind as they are in files.
template <class Variant>
void add_list(std::vector<Variant>& list, std::vector<Section>& all) {
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string kind = kind_name(list[i]);
    const auto is_alike = [&](const Variant& v) { return kind == kind_name(v); };
    const auto here = list.begin() + std::ptrdiff_t(i);
    const auto number = 1 + std::count_if(list.begin(), here, is_alike);
    std::string title = kind;
    title.front() = char(std::toupper(static_cast<unsigned char>(title.front())));
    if (std::ranges::count_if(list, is_alike) > 1) title += fmt::format(" {}", number);
    all.push_back({fmt::format("{}[{}]", kind, number), title, entries(list[i]), true});
  }
}

// --- as JSON ------------------------------------------------------------------------------------

/// Whole numbers beyond it are no numbers of a page's scripts.
constexpr std::int64_t kMostExact = std::int64_t(1) << 53;

Json to_json(const Value& value) {
  if (value.nothing()) return nullptr;
  if (const auto* on = std::get_if<bool>(&value.data)) return *on;
  if (const auto whole = value.whole()) {
    return std::abs(*whole) < kMostExact ? Json(*whole) : Json(std::to_string(*whole));
  }
  // A float as the short decimal that it stands for.
  if (const auto* f = std::get_if<float>(&value.data)) return std::stod(number_text(*f));
  if (const auto number = value.number()) return *number;
  if (const std::string* word = value.word()) return *word;
  Json list = Json::array();
  for (const Value& item : *value.list()) list.push_back(to_json(item));
  return list;
}

/// Values are lists of lists at most.
Value to_value(const Json& json, int depth = 0) {
  constexpr int kDeepest = 2;
  if (json.is_boolean()) return json.get<bool>();
  if (json.is_number_integer()) return json.get<std::int64_t>();
  if (json.is_number()) return json.get<double>();
  if (json.is_string()) return json.get<std::string>();
  if (!json.is_array() || depth == kDeepest) {
    throw Error("found what is no value, expected a number, a word or a list of them");
  }
  Value::List list;
  for (const Json& item : json) list.push_back(to_value(item, depth + 1));
  return list;
}

const char* unit_of(std::string_view metavar) {
  struct Unit {
    std::string_view metavar;
    const char* unit;
  };
  constexpr Unit kUnits[] = {{"DEGREES", "°"}, {"MM", "mm"}, {"K", "K"}, {"SECONDS", "s"}};
  const auto* const found = std::ranges::find(kUnits, metavar, &Unit::metavar);
  return found == std::end(kUnits) ? "" : found->unit;
}

/// How a page shows it.
const char* shape_of(const Limits& l) {
  using Shape = Limits::Shape;
  using Layout = Limits::Layout;
  if (l.extra == expect_direction) return "direction";
  if (l.layout == Layout::one_or_three) return "colour";
  if (l.layout == Layout::list_or_rows) return "rows";
  if (l.layout == Layout::set) return "set";
  if (l.layout == Layout::list) return "list";
  switch (l.shape) {
    case Shape::flag:
      return "flag";
    case Shape::whole:
      return "whole";
    case Shape::number:
      return "number";
    case Shape::word:
      return "word";
    case Shape::text:
    case Shape::file:
      break;
  }
  return "text";
}

/// The largest number of a value, by its size; 0 without any.
double size_of(const Value& value) {
  if (const auto number = value.number()) return std::abs(*number);
  double most = 0;
  if (const Value::List* list = value.list()) {
    for (const Value& item : *list) most = std::max(most, size_of(item));
  }
  return most;
}

/// In three digits.
double rounded(double v) { return std::strtod(fmt::format("{:.3g}", v).c_str(), nullptr); }

/// Ends of a slider: those of the limits where they are near each other, else a hundred times less
/// and more than the value, by its logarithm; none for lists and for what may be negative at will.
Json slider_of(const Limits& l, const Value& value) {
  constexpr double kNear = 1000, kFactor = 100;
  const bool is_whole = l.shape == Limits::Shape::whole;
  const bool is_one = l.layout == Limits::Layout::one || l.layout == Limits::Layout::one_or_three;
  if (!is_one || (!is_whole && l.shape != Limits::Shape::number)) return nullptr;
  const double lo = is_whole ? double(l.least) : l.range.lo;
  const double hi = is_whole ? double(l.most) : l.range.hi;
  if (hi - lo <= kNear) return {{"lo", lo}, {"hi", hi}, {"log", false}};
  if (!(lo >= 0)) return nullptr;
  const double middle = size_of(value) > 0 ? size_of(value) : 1;
  const double least = std::max(is_whole ? 1.0 : rounded(middle / kFactor), lo);
  return {{"lo", least}, {"hi", std::min(rounded(middle * kFactor), hi)}, {"log", true}};
}

Json describe(const Entry& e) {
  const Limits& l = e.about.limits;
  const Value value = e.get();
  Json j = {{"key", e.about.key},      {"help", e.about.help},
            {"expected", expected(l)}, {"unit", unit_of(e.about.metavar)},
            {"shape", shape_of(l)},    {"value", to_json(value)},
            {"words", l.all_words()},  {"biased", e.about.effect == Effect::bias}};
  if (!l.nothing.empty()) j["nothing"] = l.nothing;
  if (Json slider = slider_of(l, value); !slider.is_null()) j["slider"] = std::move(slider);
  return j;
}

// --- changes ------------------------------------------------------------------------------------

/// Strengths that are set are no longer left to choose.
void note_given(formats::SceneFile& scene, const std::string& id, const std::string& key) {
  for (std::size_t i = 0; i < scene.volumes.size(); ++i) {
    if (!id.starts_with(fmt::format("volume[{}].", i + 1))) continue;
    if (key == "extinction") scene.volumes[i].has_extinction = true;
    if (key == "intensity") scene.volumes[i].has_intensity = true;
  }
}

void set_value(formats::SceneFile& scene, const Json& change) {
  const std::string id = change.at("section"), key = change.at("key");
  for (Section& section : sections_of(scene)) {
    if (section.id != id) continue;
    const Entry* entry = find_key(section.entries, key);
    if (!entry) break;
    const Limits& l = entry->about.limits;
    const Json& json = change.at("value");
    Value value = to_value(json);
    const bool is_text = l.shape == Limits::Shape::text || l.shape == Limits::Shape::file;
    if (json.is_string() && !is_text) value = parse_value(l, json.get<std::string>());
    if (const auto refusal = entry->set(value)) {
      throw Error(fmt::format("{}: found {}, expected {}", key, json.dump(), refusal->expected));
    }
    note_given(scene, id, key);
    if (id == "camera" && key == "fov") scene.scene.camera.focal_length.reset();  // it came first
    return;
  }
  throw Error(fmt::format("the scene has no {} in '{}'; load the page again", key, id));
}

/// Where the camera is, so that what is added is seen.
template <class Thing>
void place_at(const Camera& camera, Thing& thing) {
  if constexpr (requires { thing.position; }) thing.position = camera.position;
}

/// Adds a thing of this kind behind others of it, as files have them; whether there is such a kind.
template <class Variant>
bool add(const std::string& kind, const Camera& camera, std::vector<Variant>& list) {
  for (Variant thing : all_kinds<Variant>()) {
    if (kind != kind_name(thing)) continue;
    std::visit([&](auto& t) { place_at(camera, t); }, thing);
    const auto last = std::find_if(list.rbegin(), list.rend(),
                                   [&](const Variant& v) { return v.index() <= thing.index(); });
    list.insert(last.base(), std::move(thing));
    return true;
  }
  return false;
}

/// Removes the thing of this section; whether it is in the list.
template <class Variant>
bool remove(const std::string& id, std::vector<Variant>& list) {
  std::vector<Section> sections;
  add_list(list, sections);
  for (std::size_t i = 0; i < sections.size(); ++i) {
    if (sections[i].id != id) continue;
    list.erase(list.begin() + std::ptrdiff_t(i));
    return true;
  }
  return false;
}

}  // namespace

std::vector<Section> sections_of(formats::SceneFile& scene) {
  std::vector<Section> all;
  for (std::size_t i = 0; i < scene.volumes.size(); ++i) {
    add_volume(scene.volumes[i], i + 1, scene.volumes.size(), all);
  }
  add_list(scene.scene.lights, all);
  Environment& sky = scene.scene.environment;
  all.push_back(
      {"environment", "Sky", joined({kind_entry(sky, "type", "Kind of sky")}, entries(sky))});
  add_list(scene.scene.surfaces, all);
  Entries camera = entries(scene.scene.camera);
  // Those of a camera that frames the clouds, and what position, target and up say already.
  for (const char* key : {"azimuth", "elevation", "zoom", "matrix"}) {
    camera = without(std::move(camera), key);
  }
  all.push_back({"camera", "Camera", std::move(camera)});
  Entries render = formats::render_keys(scene);
  std::erase_if(render, [](const Entry& e) { return !e.about.in_scenes; });
  all.push_back({"render", "Render", std::move(render)});
  return all;
}

Json describe_controls(formats::SceneFile& scene) {
  Json all = Json::array();
  for (const Section& section : sections_of(scene)) {
    Json keys = Json::array();
    for (const Entry& e : section.entries) keys.push_back(describe(e));
    all.push_back({{"id", section.id},
                   {"title", section.title},
                   {"removable", section.removable},
                   {"keys", std::move(keys)}});
  }
  return all;
}

std::vector<std::string> kinds_to_add() {
  std::vector<std::string> kinds;
  for (const Light& light : all_kinds<Light>()) kinds.emplace_back(kind_name(light));
  kinds.insert(kinds.end(), {PlaneSurface::kName, BallSurface::kName});
  return kinds;
}

void edit(formats::SceneFile& scene, const Json& change) {
  Scene& s = scene.scene;
  if (change.contains("add")) {
    const std::string kind = change["add"];
    if (std::ranges::count(kinds_to_add(), kind) == 0) {
      throw Error(fmt::format("found '{}', expected {}", kind, listed(kinds_to_add())));
    }
    if (!add(kind, s.camera, s.lights)) (void)add(kind, s.camera, s.surfaces);
    return;
  }
  if (change.contains("remove")) {
    const std::string id = change["remove"];
    if (remove(id, s.lights) || remove(id, s.surfaces)) return;
    throw Error(fmt::format("the scene has no '{}'; load the page again", id));
  }
  set_value(scene, change);
}

}  // namespace pvol::viewer
