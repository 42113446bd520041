#include "stats/trade_variants.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <sstream>

#include "cli/cli.h"
#include "pvol/error.h"

namespace pvol::cli {
namespace {

const RenderOptions& own(const LoadedScene& loaded) { return loaded.file.scene.options; }

bool sampled(const LoadedScene& loaded) { return !loaded.clouds.front().recipe(); }

/// The level of the deepest cloud's leaves.
int leaf_level(const LoadedScene& loaded) {
  int depth = 0;
  for (const formats::Cloud& c : loaded.clouds) {
    depth = std::max(depth, int(c.pyramid.levels.size()) - 1);
  }
  return depth;
}

bool other_tracker(const LoadedScene& loaded, const Value& value) {
  const Tracker tracker = find_named<Tracker>(*value.word()).value();
  return tracker != own(loaded).tracker && !(is_weighted(tracker) && loaded.clouds.size() > 1);
}

bool has_lamps(const LoadedScene& loaded, const Value&) {
  return std::ranges::any_of(loaded.file.scene.lights,
                             [](const Light& l) { return !std::holds_alternative<Sun>(l); });
}

/// Another interpolant is another field: its picture is not the default's.
bool other_look_up(const LoadedScene& loaded, const Value& value) {
  const LookUp look_up = own(loaded).look_up;
  return look_up != LookUp::procedural && *value.word() != name(look_up);
}

ChangeCloud bound_again(const Value& value) {
  const LookUp look_up = find_named<LookUp>(*value.word()).value();
  return [look_up](formats::Cloud& c) {
    if (holds_for(c.pyramid.look_up, look_up)) return;
    c.pyramid = formats::build_bounds(c.grid(), c.metadata.source.file, look_up);
    c.micro.reset();
    c.shell.reset();  // proven for the support that the other interpolation has
  };
}

/// Clouds that were not rounded before.
bool exact(const LoadedScene& loaded, const Value&) {
  return std::all_of(loaded.clouds.begin(), loaded.clouds.end(), [](const formats::Cloud& c) {
    return !c.recipe() && c.metadata.quantisation.precision == Precision::fp32;
  });
}

ChangeCloud rounded(const Value& value) {
  const Quantisation how{.precision = find_named<Precision>(*value.word()).value()};
  return [how](formats::Cloud& c) { formats::quantise(c, how, c.metadata.source.file); };
}

ChangeCloud halved(const Value& value) {
  return [more = int(*value.whole())](formats::Cloud& c) {
    formats::coarsen(c, more, c.metadata.source.file);
  };
}

/// What a swept value of an option needs besides being set; options without a rule need nothing.
struct Rule {
  const char* key;
  bool (*matters)(const LoadedScene&, const Value&);  ///< whether it can, to this scene
  ChangeCloud (*cloud)(const Value&) = nullptr;
};
constexpr Rule kRules[] = {
    {"depth", [](const LoadedScene& l, const Value& v) { return *v.whole() <= leaf_level(l); }},
    {"tracker", other_tracker},
    {"shells",
     [](const LoadedScene& l, const Value&) {
       return std::any_of(l.clouds.begin(), l.clouds.end(),
                          [](const formats::Cloud& c) { return c.shell.has_value(); });
     }},
    {"line_lamps", has_lamps},
    {"interpolation", other_look_up, bound_again},
    {"density", exact, rounded},
    {"homogenise",
     [](const LoadedScene& l, const Value&) { return sampled(l) && !own(l).homogenise; }},
    {"preview", [](const LoadedScene& l, const Value&) { return sampled(l); }, halved},
    {"max_bounces",
     [](const LoadedScene& l, const Value& v) {
       return !own(l).max_bounces || *v.whole() < std::int64_t(*own(l).max_bounces);
     }},
};

const Rule* find_rule(std::string_view key) {
  const auto at = std::find_if(std::begin(kRules), std::end(kRules),
                               [&](const Rule& rule) { return rule.key == key; });
  return at == std::end(kRules) ? nullptr : &*at;
}

/// The values of a row's sweep; of depths with that of the deepest leaves.
std::vector<Value> swept_values(const LoadedScene& loaded, const Description& about) {
  std::vector<Value> values;
  std::istringstream words(about.sweep);
  for (std::string word; words >> word;) values.push_back(parse_value(about.limits, word));
  const Value last = std::int64_t(leaf_level(loaded));
  if (std::string_view(about.key) == "depth" &&
      std::find(values.begin(), values.end(), last) == values.end()) {
    values.push_back(last);
  }
  return values;
}

/// The scene's option set to the value; the density is no option of the scene's, and a preview's
/// clouds have been coarsened by the scene's own before.
Candidate make_candidate(const LoadedScene& loaded, const Description& about, const Value& value,
                         const Rule* rule) {
  Candidate c;
  const bool preview = std::string_view(about.key) == "preview";
  const Value shown = preview ? Value(*value.whole() + own(loaded).preview) : value;
  c.variant = {about.factor,
               fmt::format("{} {}", flag_of(about), command_text(about.limits, shown)),
               about.effect == Effect::bias || about.effect == Effect::field};
  c.scene = [key = std::string(about.key), value](Scene& s) {
    const Entries all = entries(s.options);
    if (const Entry* e = find_key(all, key)) (void)e->set(value);
  };
  if (rule && rule->cloud) c.cloud = rule->cloud(value);
  return c;
}

}  // namespace

Candidate default_candidate() { return {.variant = {"default", ""}}; }

std::vector<Candidate> single_candidates(const LoadedScene& loaded) {
  std::vector<Candidate> list;
  formats::SceneFile defaults;
  for (const Entry& e : formats::render_keys(defaults)) {
    if (*e.about.factor == 0) continue;
    const Rule* rule = find_rule(e.about.key);
    for (const Value& value : swept_values(loaded, e.about)) {
      if (rule && !rule->matters(loaded, value)) continue;
      list.push_back(make_candidate(loaded, e.about, value, rule));
    }
  }
  return list;
}

Candidate candidate(const LoadedScene& loaded, const std::string& key, const std::string& value) {
  formats::SceneFile defaults;
  const Entries all = formats::render_keys(defaults);
  const Entry* e = find_key(all, key);
  if (e == nullptr)
    throw Error(fmt::format("there is no option '{}'; see pvol-render --help", key));
  const Value parsed = parse_value(e->about.limits, value);
  if (const auto refusal = refuse(e->about.limits, parsed)) {
    throw Error(fmt::format("{}: found '{}', expected {}", key, value,
                            command_expected(e->about.limits, *refusal)));
  }
  return make_candidate(loaded, e->about, parsed, find_rule(key));
}

Candidate combine(const Candidate& a, const Candidate& b) {
  const auto both = [](const auto& first, const auto& second) {
    using F = std::decay_t<decltype(first)>;
    if (!first || !second) return first ? first : second;
    return F([first, second](auto& changed) { first(changed), second(changed); });
  };
  return {{fmt::format("{} + {}", a.variant.factor, b.variant.factor),
           fmt::format("{} {}", a.variant.option, b.variant.option),
           a.variant.biased || b.variant.biased},
          both(a.scene, b.scene),
          both(a.cloud, b.cloud)};
}

std::vector<Candidate> combinations(const std::vector<Candidate>& singles,
                                    const std::vector<measure::VariantResult>& results) {
  std::vector<measure::Variant> variants;
  for (const Candidate& c : singles) variants.push_back(c.variant);
  std::vector<Candidate> list;
  for (const std::vector<std::size_t>& parts : measure::combinations(variants, results)) {
    list.push_back(singles[parts[0]]);
    for (std::size_t i = 1; i < parts.size(); ++i) {
      list.back() = combine(list.back(), singles[parts[i]]);
    }
  }
  return list;
}

}  // namespace pvol::cli
