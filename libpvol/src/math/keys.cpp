#include "pvol/math/keys.h"

#include <algorithm>

#include "pvol/error.h"

namespace pvol {
namespace {

std::string bar_separated(const Limits& limits) {
  if (limits.shape == Limits::Shape::flag) return "on|off";
  std::string text;
  for (const std::string_view w : limits.all_words()) {
    if (!text.empty()) text += '|';
    text += w;
  }
  return text;
}

}  // namespace

std::string flag_of(const Description& about) {
  std::string text = "--";
  text += about.key;
  std::replace(text.begin(), text.end(), '_', '-');
  return text;
}

std::string metavar_of(const Description& about) {
  constexpr std::size_t kShort = 20;
  if (*about.metavar != 0) return about.metavar;
  if (about.limits.layout == Limits::Layout::set) return "NAME,...";
  const std::string words = bar_separated(about.limits);
  return words.size() <= kShort ? words : "NAME";
}

std::string help_of(const Entry& entry) {
  const Description& about = entry.about;
  std::string text = about.help;
  if (metavar_of(about).starts_with("NAME")) {
    const auto words = about.limits.all_words();
    text += " (" + listed({words.begin(), words.end()}) + ")";
  }
  if (const std::string ends = ends_of(about.limits); !ends.empty()) text += " (" + ends + ")";
  const std::string otherwise =
      *about.otherwise != 0 ? about.otherwise : command_text(about.limits, entry.value());
  return otherwise.empty() ? text : text + " [" + otherwise + "]";
}

Value Entry::value() const {
  Value v = get();
  if (v.nothing() && !about.limits.nothing.empty()) return std::string(about.limits.nothing);
  return v;
}

std::optional<Refusal> Entry::set(const Value& value) const {
  auto refusal = refuse(about.limits, value);
  if (!refusal) assign(value);
  return refusal;
}

const Entry* find_key(const Entries& all, std::string_view key) {
  const auto at =
      std::find_if(all.begin(), all.end(), [&](const Entry& e) { return e.about.key == key; });
  return at == all.end() ? nullptr : &*at;
}

Entries without(Entries all, std::string_view key) {
  std::erase_if(all, [&](const Entry& e) { return e.about.key == key; });
  return all;
}

Entries joined(Entries a, const Entries& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

void require_limits(const std::string& what, const Entries& all) {
  for (const Entry& e : all) {
    const Value value = e.value();
    if (value.nothing()) continue;
    const auto refusal = refuse(e.about.limits, value);
    if (!refusal) continue;
    const Value* found = &value;
    for (const std::size_t i : refusal->item) found = &(*found->list())[i];
    throw Error(what + ": " + e.about.key + " is " + plain_text(*found) + "; expected " +
                refusal->expected);
  }
}

}  // namespace pvol
