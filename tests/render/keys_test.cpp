// Tables of keys: what they take, what they refuse and say of it, and that every table is whole.
#include "pvol/math/keys.h"

#include <gtest/gtest.h>

#include <cctype>
#include <cmath>
#include <set>
#include <sstream>

#include "pvol/density/quantise.h"
#include "pvol/error.h"
#include "pvol/render/placement.h"
#include "pvol/render/scene.h"
#include "support/messages.h"

namespace pvol {
namespace keys_test {

std::string refusal(const Limits& limits, const Value& value) {
  const auto r = refuse(limits, value);
  if (!r) return "";
  std::string text = r->expected;
  for (const std::size_t i : r->item) text += " at " + std::to_string(i);
  return text;
}

TEST(Limits, TakeWhatTheySayAndNameWhatTheyExpected) {
  const Limits half = number(Range{0, 1, true, false});
  EXPECT_EQ(refusal(half, 1.0), "");
  EXPECT_EQ(refusal(half, std::int64_t(1)), "");
  for (const double v : {0.0, -0.5, 1.5, std::nan(""), double(INFINITY)}) {
    EXPECT_TRUE(says(refusal(half, v), "limits.number_above_zero")) << v;
  }
  const Limits not_negative = number(Range::at_least(0));
  EXPECT_TRUE(says(refusal(not_negative, -1.0), "limits.number_least"));
  for (const double v : {std::nan(""), double(INFINITY)}) {
    EXPECT_TRUE(says(refusal(not_negative, v), "limits.finite_number_least")) << v;
  }
  EXPECT_TRUE(says(refusal(number(), "x"), "limits.finite_number"));
  EXPECT_TRUE(says(refusal(whole(1, 5), 2.0), "limits.whole_number"));
  EXPECT_TRUE(says(refusal(whole(1, 5), std::int64_t(6)), "limits.whole_number"));
  EXPECT_TRUE(says(refusal(whole(1, 5).or_word("none"), "many"), "limits.whole_number_none"));
  EXPECT_EQ(refusal(whole(1, 5).or_word("none"), "none"), "");
  EXPECT_TRUE(says(refusal(flag(), "on"), "limits.true_false"));
  EXPECT_TRUE(says(refusal(file_name(), ""), "limits.name"));
  EXPECT_TRUE(says(refusal(name_of<Precision>(), "fp7"), "limits.fp32_fp16_fp8"));
  EXPECT_TRUE(says(refusal(number(), Value()), "limits.finite_number"));
}

TEST(Limits, OfListsSayWhichItemIsToBlame) {
  const Limits colour = number(Range::closed(0, 1)).or_three();
  EXPECT_EQ(refusal(colour, 0.5), "");
  EXPECT_EQ(refusal(colour, Value::List{0.0, 1.0, 0.5}), "");
  EXPECT_TRUE(says(refusal(colour, 2.0), "limits.number_to_one"));
  EXPECT_TRUE(says(refusal(colour, Value::List{0.0, 1.0, 1.5}), "limits.number_of_three"));
  EXPECT_TRUE(says(refusal(colour, Value::List{0.0, 1.0}), "limits.number_or_three"));
  EXPECT_TRUE(says(refusal(colour, "red"), "limits.number_or_three"));
  EXPECT_TRUE(says(refusal(number().times({12, 16}), Value::List{}), "limits.array_numbers"));
  const Limits rows = number().times(2).in_rows();
  EXPECT_EQ(refusal(rows, Value::List{1.0, 2.0}), "");
  EXPECT_TRUE(says(refusal(rows, Value::List{Value::List{1.0, 2.0}, Value::List{3.0, "x"}}),
                   "limits.finite_number_in_list"));
  EXPECT_TRUE(
      says(refusal(rows, Value::List{Value::List{1.0, 2.0}, 3.0}), "limits.array_2_numbers"));
  EXPECT_TRUE(says(refusal(direction(), Value::List{0.0, 0.0, 0.0}), "limits.direction_not_zero"));
}

TEST(Limits, OfSetsTakeOneNameOrSeveral) {
  const Limits set = set_of<ShellUse>().or_word("none");
  EXPECT_EQ(refusal(set, "on"), "");
  EXPECT_EQ(refusal(set, "none"), "");
  EXPECT_EQ(refusal(set, Value::List{"on", "off"}), "");
  EXPECT_EQ(refusal(set, Value::List{}), "");
  EXPECT_EQ(refusal(set, "yes"), R"("none", "auto", "on" or "off", or an array of them)");
  EXPECT_EQ(refusal(set, 3.0), R"("none", "auto", "on" or "off", or an array of them)");
  EXPECT_EQ(refusal(set, Value::List{"on", "none"}), R"("auto", "on" or "off" at 1)");
  SetOf<ShellUse> uses;
  assign(uses, Value::List{"off", "on", "off"});
  EXPECT_EQ(uses, (SetOf<ShellUse>{ShellUse::on, ShellUse::off}));
  EXPECT_EQ(to_value(uses), Value(Value::List{"on", "off"}));
  assign(uses, "none");
  EXPECT_TRUE(uses.empty());
  EXPECT_TRUE(to_value(uses).nothing());
}

TEST(Limits, TextsOfCommandLinesBecomeValuesAndComeBack) {
  const std::pair<Limits, const char*> cases[] = {{whole(1, 9999).times(2, 'x'), "640x480"},
                                                  {whole(0, 9).times(4), "1,2,3,4"},
                                                  {number(), "0.125"},
                                                  {whole(0, 16).or_word("auto"), "auto"},
                                                  {whole(0, 16).or_word("auto"), "7"},
                                                  {name_of<MicroBoundsUse>(), "2"},
                                                  {set_of<ShellUse>(), "on"},
                                                  {set_of<ShellUse>(), "on,off"},
                                                  {flag(), "on"},
                                                  {flag(), "off"},
                                                  {any_text(), "density"}};
  for (const auto& [limits, text] : cases) {
    const Value value = parse_value(limits, text);
    EXPECT_EQ(refusal(limits, value), "") << text;
    EXPECT_EQ(command_text(limits, value), text);
  }
  EXPECT_EQ(parse_value(whole(1, 9999).times(2, 'x'), "640X480"),
            parse_value(whole(1, 9999).times(2, 'x'), "640x480"));
  for (const char* text : {"", "1x", "x", "1x2x3", "0x4", "1,2", "1.5x2", "axb"}) {
    EXPECT_NE(refusal(whole(1, 9999).times(2, 'x'), parse_value(whole(1, 9).times(2, 'x'), text)),
              "")
        << text;
  }
  EXPECT_EQ(parse_value(number(), "+1e3"), Value(1000.0));
}

TEST(Limits, SpeakTheLanguageOfCommandLines) {
  const auto told = [](const Limits& limits, const char* text) {
    const auto r = refuse(limits, parse_value(limits, text));
    return r ? command_expected(limits, *r) : "";
  };
  EXPECT_TRUE(says(told(flag(), "maybe"), "limits.off"));
  EXPECT_TRUE(says(told(name_of<ShellUse>(), "yes"), "limits.auto_off"));
  EXPECT_TRUE(says(told(whole(0, 23).or_word("auto"), "24"), "limits.auto_whole_number"));
  EXPECT_TRUE(says(told(set_of<ShellUse>().or_word("none"), "on,yes"), "limits.none_auto_off"));
  EXPECT_TRUE(says(told(whole(1, 9).times(2, 'x'), "3x0"), "limits.whole_number_of_two"));
  EXPECT_TRUE(says(told(number(Range::at_least(0)), "-1"), "limits.number_least"));
}

/// The entries of every table, each bound to a thing with its defaults.
struct Tables {
  RenderOptions options;
  Camera camera;
  Medium medium;
  Component component;
  Placement placement;
  std::optional<Quantisation> density = Quantisation{.precision = Precision::fpn};
  std::vector<Environment> skies = all_kinds<Environment>();
  std::vector<Light> lights = all_kinds<Light>();
  std::vector<PhaseFunction> phases = all_kinds<PhaseFunction>();

  std::vector<Entries> all() {
    std::vector<Entries> tables{entries(options),   entries(camera),    entries(medium),
                                entries(component), entries(placement), entries(density)};
    for (Environment& sky : skies) tables.push_back(entries(sky));
    for (Light& light : lights) tables.push_back(entries(light));
    for (PhaseFunction& phase : phases) tables.push_back(entries(phase));
    return tables;
  }
};

TEST(Keys, AreLowerCaseWithHelpAndOnceInATable) {
  Tables tables;
  for (const Entries& table : tables.all()) {
    std::set<std::string> seen;
    for (const Entry& e : table) {
      const std::string key = e.about.key, help = e.about.help;
      EXPECT_TRUE(seen.insert(key).second) << key;
      EXPECT_FALSE(key.empty());
      for (const char c : key) EXPECT_TRUE(std::islower(c) || std::isdigit(c) || c == '_') << key;
      ASSERT_FALSE(help.empty()) << key;
      EXPECT_TRUE(std::isupper(help.front()) && help.back() != '.') << key << ": " << help;
      EXPECT_FALSE(metavar_of(e.about).empty()) << key;
    }
  }
}

TEST(Keys, TakeTheirOwnDefaultsAndWhatTheyAreSweptOver) {
  Tables tables;
  for (const Entries& table : tables.all()) {
    for (const Entry& e : table) {
      const Value value = e.value();
      if (!value.nothing() && e.about.limits.shape != Limits::Shape::file) {
        EXPECT_FALSE(e.set(value)) << e.about.key;
        EXPECT_EQ(e.value(), value) << e.about.key;
      }
      std::istringstream words(e.about.sweep);
      for (std::string word; words >> word;) {
        const Value swept = parse_value(e.about.limits, word);
        EXPECT_FALSE(e.set(swept)) << e.about.key << ' ' << word;
        EXPECT_EQ(e.value(), swept) << e.about.key << ' ' << word;
      }
      EXPECT_EQ(*e.about.factor == 0, *e.about.sweep == 0) << e.about.key;
    }
  }
}

TEST(Keys, RefuseAndChangeNothing) {
  RenderOptions options;
  const Entries all = entries(options);
  for (const auto& [key, text] : {std::pair{"depth", "24"},
                                  {"majorant_scale", "1001"},
                                  {"majorant_scale", "0.33"},
                                  {"preview", "9"},
                                  {"seed", "9223372036854775808"},
                                  {"spp", "0"},
                                  {"size", "0x9"},
                                  {"max_bounces", "4294967296"},
                                  {"threads", "4097"},
                                  {"homogenise", "nan"}}) {
    const Entry& e = *find_key(all, key);
    EXPECT_TRUE(e.set(parse_value(e.about.limits, text))) << key << ' ' << text;
  }
  EXPECT_EQ(options, RenderOptions{});
}

TEST(Keys, SayWhatHelpNeeds) {
  const RenderOptions options;
  const auto help = [&](const char* key) { return help_of(*find_key(entries(options), key)); };
  EXPECT_TRUE(says(help("depth"), "limits.octree_depth"));
  EXPECT_TRUE(says(help("size"), "limits.size_image_pixels"));
  EXPECT_TRUE(says(help("spp"), "limits.samples_per_pixel"));
  EXPECT_NE(help("background").find("[on]"), std::string::npos);
  EXPECT_TRUE(says(help("tracker"), "limits.how_free_paths"));
  EXPECT_EQ(flag_of(find_key(entries(options), "micro_bounds")->about), "--micro-bounds");
  EXPECT_EQ(metavar_of(find_key(entries(options), "micro_bounds")->about), "auto|none|2|1|codes");
}

TEST(Keys, OfAKindComeWithTheirMember) {
  Component component;
  EXPECT_FALSE(find_key(entries(component), "g")->set(-0.25));
  EXPECT_EQ(component.phase, PhaseFunction(HenyeyGreenstein(-0.25)));
  const Component constant = component;
  EXPECT_EQ(find_key(entries(constant), "g")->value(), Value(-0.25));
  component.share = 2;
  EXPECT_THROW(require_limits("medium", entries(component)), Error);
}

TEST(Keys, OfFloatsAreWrittenInAsFewDigitsAsBringThemBack) {
  const Component component{.albedo = {0.9f, 0.8f, 1.0f / 3}};
  EXPECT_EQ(plain_text(find_key(entries(component), "albedo")->value()), "0.9,0.8,0.33333334");
}

}  // namespace keys_test
}  // namespace pvol
