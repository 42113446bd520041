#include "usda/usda_value.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

namespace pvol::formats::detail {
namespace {

constexpr int kDeepestValue = 16;       // brackets within each other
constexpr int kDeepestDictionary = 64;  // dictionaries
constexpr int kDeepestSkipped = 256;    // of what is passed

/// What a value holds; of one kind, if all is well.
struct Gathered {
  UsdNumbers numbers{};
  UsdStrings strings{};
  UsdTargets targets{};
  bool none = false;
};

void gather_word(std::string_view word, Gathered& all) {
  if (word == "None" || word == "AnimationBlock") {
    all.none = true;
  } else if (word == "true" || word == "false" || word == "True" || word == "False") {
    all.numbers.all.push_back(word == "true" || word == "True");
  } else {
    all.strings.all.emplace_back(word);
  }
}

/// A file, a prim or both; in arcs with a shift of their time.
void gather_target(UsdTokens& in, bool says_arcs, Gathered& all) {
  UsdTarget target;
  if (in.peek().kind == UsdToken::Kind::asset) target.asset = in.take().text;
  const bool is_prim = target.asset.empty() || says_arcs;
  if (is_prim && in.peek().kind == UsdToken::Kind::path) target.path = in.take().text;
  if (says_arcs && in.peek().is('(')) {
    skip_enclosed(in);
    target.is_retimed = true;
  }
  all.targets.all.push_back(std::move(target));
}

void gather(UsdTokens& in, bool says_arcs, int depth, Gathered& all) {
  const UsdToken& next = in.peek();
  if (next.is('(') || next.is('[')) {
    if (depth == kDeepestValue) {
      fail_at(in.where(), "a value within 16 others", "fewer levels of brackets");
    }
    const char close = in.take().is('(') ? ')' : ']';
    while (!in.take_if(close)) {
      gather(in, says_arcs, depth + 1, all);
      if (!in.peek().is(close)) in.need(',', fmt::format(", or {}", close));
    }
    return;
  }
  switch (next.kind) {
    case UsdToken::Kind::number:
      all.numbers.all.push_back(in.take().number);
      break;
    case UsdToken::Kind::word:
      gather_word(in.take().text, all);
      break;
    case UsdToken::Kind::string:
      all.strings.all.push_back(unescaped(in.take().text));
      break;
    case UsdToken::Kind::asset:
    case UsdToken::Kind::path:
      gather_target(in, says_arcs, all);
      break;
    default:
      in.fail("a value");
  }
}

/// type name = value ... ; in the tables that some metadata are, key: value.
UsdDictionary read_dictionary(UsdTokens& in, int depth) {
  if (depth == kDeepestDictionary) {
    fail_at(in.where(), "a dictionary within 64 others", "fewer levels");
  }
  UsdDictionary all;
  in.need('{', "{");
  while (!in.take_if('}')) {
    if (in.take_if(';') || in.take_if(',')) continue;
    std::string name;
    while (!in.peek().is('=') && !in.peek().is(':')) {
      const UsdToken t = in.take();
      const bool says = t.kind != UsdToken::Kind::mark || t.is('[') || t.is(']');
      if (!says || t.kind == UsdToken::Kind::end) {
        fail_at(in.where(t), fmt::format("'{}'", usd_shown(t.text)), "a name and =");
      }
      if (t.kind != UsdToken::Kind::mark) name = t.text;
      if (name.ends_with(':')) break;  // key: value
    }
    if (!name.ends_with(':')) (void)in.take();
    if (in.peek().is('{')) {
      (void)read_dictionary(in, depth + 1);
      continue;
    }
    const UsdValue value = read_value(in, true);
    const auto* strings = std::get_if<UsdStrings>(&value);
    if (strings != nullptr && strings->all.size() == 1) all.words[name] = strings->all.front();
  }
  return all;
}

}  // namespace

UsdValue read_value(UsdTokens& in, bool says_arcs) {
  if (in.peek().is('{')) return read_dictionary(in, 0);
  const UsdWhere where = in.where();
  Gathered all;
  gather(in, says_arcs, 0, all);
  const int kinds = int(!all.numbers.all.empty()) + int(!all.strings.all.empty()) +
                    int(!all.targets.all.empty()) + int(all.none);
  if (kinds > 1) fail_at(where, "a value of several kinds", "one kind, as only numbers");
  if (all.none) return UsdNone{};
  if (!all.strings.all.empty()) return std::move(all.strings);
  if (!all.targets.all.empty()) return std::move(all.targets);
  return std::move(all.numbers);
}

std::vector<std::pair<double, UsdValue>> read_samples(UsdTokens& in) {
  std::vector<std::pair<double, UsdValue>> all;
  in.need('{', "{ and samples, as 1: value");
  while (!in.take_if('}')) {
    if (in.peek().kind != UsdToken::Kind::number) in.fail("a time, or }");
    const double time = in.take().number;
    in.need(':', ": and the value at that time");
    all.emplace_back(time, read_value(in));
    if (!in.peek().is('}')) in.need(',', ", or }");
  }
  std::ranges::stable_sort(all, {}, &std::pair<double, UsdValue>::first);
  return all;
}

void skip_enclosed(UsdTokens& in) {
  std::string open;
  do {
    const UsdToken t = in.take();
    if (t.kind == UsdToken::Kind::end) in.fail("a closing bracket");
    if (t.is('(') || t.is('[') || t.is('{')) {
      if (int(open.size()) == kDeepestSkipped) {
        fail_at(in.where(t), "a bracket within 256 others", "fewer levels");
      }
      open += t.is('(') ? ')' : t.is('[') ? ']' : '}';
    } else if (t.is(')') || t.is(']') || t.is('}')) {
      if (open.empty() || !t.is(open.back())) {
        fail_at(in.where(t), fmt::format("'{}'", t.text), "the bracket that was opened last");
      }
      open.pop_back();
    }
  } while (!open.empty());
}

}  // namespace pvol::formats::detail
