// The grammar of usda text: https://openusd.org, "USDA file format".
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <vector>

#include "usda/usda_prim.h"
#include "usda/usda_value.h"

namespace pvol::formats::detail {
namespace {

constexpr std::size_t kDeepestPrim = 128;  // prims within each other

constexpr std::array kListOperations{"add", "append", "prepend", "delete", "reorder"};
// The strongest first.
constexpr std::array kArcs{"inherits", "references", "payload", "specializes", "subLayers"};
constexpr std::array kOrders{"rootPrims", "nameChildren", "properties"};
/// Metadata that something is made of.
constexpr std::array kKept{
    "active",        "clips",         "defaultPrim",        "framesPerSecond",
    "metersPerUnit", "startTimeCode", "timeCodesPerSecond", "renderSettingsPrimPath",
    "upAxis",        "variants"};
/// Metadata of attributes that are of use here.
constexpr std::array kKeptOfAttributes{"bindMaterialAs", "interpolation"};
constexpr std::array kPropertyWords{"custom", "uniform", "varying", "config"};

bool is_in(const auto& words, const UsdToken& token) {
  return token.kind == UsdToken::Kind::word && std::ranges::find(words, token.text) != words.end();
}

bool is_bracket(const UsdToken& token) {
  constexpr std::string_view kBrackets = "()[]{}";
  return token.kind == UsdToken::Kind::mark && kBrackets.find(token.text) != kBrackets.npos;
}

/// Items as a layer says them: all there are, or what an operation does with them.
template <class Item>
void take_items(UsdList<Item>& list, std::string_view operation, const std::vector<Item>& items) {
  if (operation == "reorder") return;
  if (operation.empty()) list.replaces = true;
  std::vector<Item>& to = operation == "delete"                         ? list.gone
                          : operation == "append" || operation == "add" ? list.last
                                                                        : list.first;
  to.insert(to.end(), items.begin(), items.end());
}

/// Those of a value; none where it is None, or something else.
std::vector<UsdTarget> targets_in(const UsdValue& value) {
  const auto* targets = std::get_if<UsdTargets>(&value);
  return targets == nullptr ? std::vector<UsdTarget>{} : targets->all;
}
std::vector<std::string> strings_in(const UsdValue& value) {
  const auto* strings = std::get_if<UsdStrings>(&value);
  return strings == nullptr ? std::vector<std::string>{} : strings->all;
}
std::vector<double> finite_numbers_in(const UsdValue& value) {
  const auto* numbers = std::get_if<UsdNumbers>(&value);
  std::vector<double> all = numbers == nullptr ? std::vector<double>{} : numbers->all;
  std::erase_if(all, [](double x) { return !std::isfinite(x); });
  return all;
}

class UsdParser {
 public:
  UsdParser(const std::filesystem::path& file, ImportNotes& notes) : notes_(&notes), in_(file) {}

  UsdPrim read() {
    UsdPrim root;
    root.where = in_.where();
    if (in_.peek().is('(')) metadata(root);
    while (in_.peek().kind != UsdToken::Kind::end) {
      if (separator() || child(root)) continue;
      if (in_.peek().is("reorder")) (void)in_.take();
      if (!order()) in_.fail("def, over or class");
    }
    return root;
  }

 private:
  bool separator() { return in_.take_if(';') || in_.take_if(','); }

  /// An order of names, which is of no use here.
  bool order() {
    if (!is_in(kOrders, in_.peek())) return false;
    (void)in_.take();
    in_.need('=', "= and names");
    (void)read_value(in_);
    return true;
  }

  std::string string(const std::string& expected) {
    if (in_.peek().kind != UsdToken::Kind::string) in_.fail(expected);
    return unescaped(in_.take().text);
  }

  // Paths of the prim at hand.

  [[nodiscard]] std::string absolute_path(const std::string& path) const {
    if (path.empty() || path.starts_with('/')) return path;
    const std::filesystem::path whole(path_ + '/' + path);
    std::string text = whole.lexically_normal().generic_string();
    if (text.size() > 1 && text.ends_with('/')) text.pop_back();
    return text;
  }

  void make_absolute(UsdValue& value) const {
    auto* targets = std::get_if<UsdTargets>(&value);
    if (targets == nullptr) return;
    for (UsdTarget& t : targets->all) t.path = absolute_path(t.path);
  }

  // Metadata.

  void metadata(UsdPrim& prim) {
    in_.need('(', "(");
    while (!in_.take_if(')')) {
      if (separator()) continue;
      if (in_.peek().kind == UsdToken::Kind::string) {
        (void)in_.take();  // a comment
      } else {
        metadatum(prim);
      }
    }
  }

  void metadatum(UsdPrim& prim) {
    std::string_view operation;
    if (is_in(kListOperations, in_.peek())) operation = in_.take().text;
    if (in_.peek().kind != UsdToken::Kind::word) in_.fail("a metadatum such as kind = ..., or )");
    const UsdToken name = in_.take();
    in_.need('=', fmt::format("= and the value of {}", usd_shown(name.text)));
    UsdValue value = read_value(in_, true);
    make_absolute(value);
    const auto* arc = std::ranges::find(kArcs, name.text);
    if (arc != kArcs.end()) {
      const std::ptrdiff_t kind = arc - kArcs.begin();
      take_items(prim.arcs[kind], operation, arcs_in(value, in_.where(name), kind, operation));
    } else if (name.text == "apiSchemas") {
      take_items(prim.schemas, operation, strings_in(value));
    } else if (name.text == "inactiveIds") {
      take_items(prim.inactive, operation, finite_numbers_in(value));
    } else if (is_in(kKept, name) && operation.empty()) {
      prim.metadata.try_emplace(std::string(name.text),
                                UsdMetadatum{std::move(value), in_.where(name)});
    }
  }

  [[nodiscard]] std::vector<UsdArc> arcs_in(const UsdValue& value, const UsdWhere& where,
                                            std::ptrdiff_t kind, std::string_view operation) {
    std::vector<UsdArc> arcs;
    const std::filesystem::path folder = in_.file().parent_path();
    for (UsdTarget& t : targets_in(value)) {
      const std::filesystem::path file = t.asset.empty() ? in_.file() : folder / t.asset;
      t.asset = std::filesystem::absolute(file).lexically_normal().string();
      if (t.is_retimed && operation != "delete") {
        notes_->add(where, "the shifted time of a layer is left out");
      }
      arcs.push_back({std::move(t), kind, where});
    }
    return arcs;
  }

  /// What stands in brackets after an attribute, of which a few words are kept.
  void metadata(UsdAttribute& attribute) {
    if (!in_.take_if('(')) return;
    while (!in_.take_if(')')) {
      if (is_bracket(in_.peek())) {
        skip_enclosed(in_);
        continue;
      }
      const UsdToken name = in_.take();
      if (name.kind == UsdToken::Kind::end) in_.fail("a closing bracket");
      if (!is_in(kKeptOfAttributes, name) || !in_.take_if('=')) continue;
      if (in_.peek().kind == UsdToken::Kind::string) {
        attribute.words[std::string(name.text)] = unescaped(in_.take().text);
      }
    }
  }

  // Prims.

  bool child(UsdPrim& parent) {
    UsdPrim prim;
    prim.where = in_.where();
    if (in_.peek().is("def")) {
      prim.specifier = UsdPrim::Specifier::def;
    } else if (in_.peek().is("class")) {
      prim.specifier = UsdPrim::Specifier::pattern;
    } else if (!in_.peek().is("over")) {
      return false;
    }
    (void)in_.take();
    if (in_.peek().kind == UsdToken::Kind::word) prim.type = in_.take().text;
    prim.name = string("a type or a name in quotation marks");
    if (parent.child(prim.name) != nullptr) {
      fail_at(prim.where, fmt::format("\"{}\" a second time", usd_shown(prim.name)),
              "prims of different names");
    }
    body(prim);
    parent.add(std::move(prim));
    return true;
  }

  void body(UsdPrim& prim) {
    if (++depth_ > kDeepestPrim) fail_at(prim.where, "a prim within 128 others", "fewer levels");
    const std::size_t outside = path_.size();
    path_ += '/' + prim.name;
    if (in_.peek().is('(')) metadata(prim);
    block(prim);
    path_.resize(outside);
    --depth_;
  }

  void block(UsdPrim& prim) {
    in_.need('{', "{ and what the prim has");
    while (!in_.take_if('}')) {
      if (!separator() && !child(prim) && !variant_set(prim)) property(prim);
    }
  }

  bool variant_set(UsdPrim& prim) {
    if (!in_.peek().is("variantSet")) return false;
    (void)in_.take();
    const std::string set = string("the name of a variant set");
    in_.need('=', "= and the variants");
    in_.need('{', "{ and the variants");
    while (!in_.take_if('}')) {
      UsdPrim variant;
      variant.where = in_.where();
      variant.type = set;
      variant.name = string("the name of a variant, or }");
      if (++depth_ > kDeepestPrim) fail_at(variant.where, "variants within 128 others", "fewer");
      if (in_.peek().is('(')) metadata(variant);
      block(variant);
      --depth_;
      prim.variants.push_back(std::move(variant));
    }
    return true;
  }

  // Attributes and relationships.

  void property(UsdPrim& prim) {
    std::string_view operation;
    if (is_in(kListOperations, in_.peek())) operation = in_.take().text;
    if (operation == "reorder" && order()) return;
    while (is_in(kPropertyWords, in_.peek())) (void)in_.take();
    const UsdWhere where = in_.where();
    if (in_.peek().kind != UsdToken::Kind::word) {
      in_.fail("an attribute such as float radius = 1, a prim, or }");
    }
    std::string type(in_.take().text);
    if (in_.take_if('[')) {
      in_.need(']', "] of an array's type");
      type += "[]";
    }
    if (in_.peek().kind != UsdToken::Kind::word) in_.fail("the name of the attribute");
    const std::string_view whole = in_.take().text;
    const std::size_t dot = std::min(whole.rfind('.'), whole.size());
    const std::string name(whole.substr(0, dot)), part(whole.substr(dot));
    UsdAttribute attribute = known(prim, name, type, where);
    if (in_.take_if('=')) {
      assign(attribute, name, part, operation);
    } else if (part.empty()) {
      metadata(attribute);
    } else {
      in_.fail(fmt::format("= and the value of {}", usd_shown(whole)));
    }
    prim.attributes[name] = std::make_shared<const UsdAttribute>(std::move(attribute));
  }

  /// Its value, samples and connections stand apart.
  static UsdAttribute known(const UsdPrim& prim, const std::string& name, const std::string& type,
                            const UsdWhere& where) {
    const auto found = prim.attributes.find(name);
    if (found != prim.attributes.end()) return *found->second;
    UsdAttribute attribute;
    attribute.type = type, attribute.where = where;
    return attribute;
  }

  void assign(UsdAttribute& attribute, const std::string& name, const std::string& part,
              std::string_view operation) {
    const bool is_value = part.empty() || part == ".default";
    UsdContent content;
    if (part == ".timeSamples") {
      content.samples = read_samples(in_);
      content.value = attribute.content->value;
    } else if (part == ".connect" || (is_value && attribute.type == "rel")) {
      UsdValue value = read_value(in_);
      make_absolute(value);
      take_items(attribute.targets, operation, targets_in(value));
    } else if (part == ".spline") {
      notes_->add(attribute.where, fmt::format("the spline of {} is left out", usd_shown(name)));
      skip_enclosed(in_);
    } else if (is_value) {
      content.value = read_value(in_);
      make_absolute(*content.value);
      content.samples = attribute.content->samples;
    } else {
      fail_at(attribute.where, fmt::format("'{}'", usd_shown(part)),
              ".timeSamples, .connect, .default or .spline");
    }
    if (!content.empty()) {
      attribute.content = std::make_shared<const UsdContent>(std::move(content));
    }
    metadata(attribute);
  }

  ImportNotes* notes_;
  UsdTokens in_;
  std::string path_{};  // of the prim at hand
  std::size_t depth_ = 0;
};

}  // namespace

UsdPrim parse_usda(const std::filesystem::path& file, ImportNotes& notes) {
  return UsdParser(file, notes).read();
}

}  // namespace pvol::formats::detail
