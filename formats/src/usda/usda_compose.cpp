#include "usda/usda_compose.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "pvol/error.h"
#include "usda/usda_merge.h"

namespace pvol::formats::detail {
namespace {

constexpr std::size_t kMostLayers = 4096;
constexpr std::size_t kLongestChain = 64;   // of arcs, each of which leads to the next
constexpr std::size_t kMostArcs = 4095;     // of a prim
constexpr std::size_t kDeepestStage = 256;  // prims within each other
constexpr std::size_t kMostCopied = std::size_t(1) << 28;  // bytes, by arcs

bool is_usd_text(const std::filesystem::path& file) {
  const std::string ending = file.extension().string();
  return ending == ".usda" || ending == ".usd";
}

/// Choices of variants of a prim; "" where none is made.
std::string chosen_variant(const UsdPrim& prim, const std::string& set) {
  const auto found = prim.metadata.find("variants");
  if (found == prim.metadata.end()) return "";
  const auto* choices = std::get_if<UsdDictionary>(&found->second.value);
  if (choices == nullptr) return "";
  const auto choice = choices->words.find(set);
  return choice == choices->words.end() ? "" : choice->second;
}

class UsdComposer {
 public:
  explicit UsdComposer(ImportNotes& notes) : notes_(&notes) {}

  UsdPrim compose(const std::filesystem::path& file) {
    const std::string name = std::filesystem::absolute(file).lexically_normal().string();
    UsdPrim root = layers_of(file, name, {name});
    settle(root);
    layers_.emplace(name, std::make_shared<const UsdPrim>(root));
    for (UsdPrim& prim : root.children) expand(prim, '/' + prim.name, 1);
    return root;
  }

 private:
  using Chain = std::vector<std::string>;

  // Layers.

  /// A layer with its sublayers, of which each is weaker than those before. `chain` has the files
  /// that lead here.
  UsdPrim layers_of(const std::filesystem::path& file, const std::string& name,
                    const Chain& chain) {
    UsdPrim root = parse_usda(file, *notes_);
    for (UsdPrim& prim : root.children) lead_to(prim, file.string(), name);
    for (const UsdArc& arc : arcs_of(root)) {
      const bool again = std::ranges::find(chain, arc.target.asset) != chain.end();
      if (again || chain.size() == kLongestChain) {
        fail_at(arc.where, fmt::format("{} as a layer of itself", usd_shown(arc.target.asset)),
                "layers that do not lead to each other, and 64 levels of them at most");
      }
      if (!can_follow(arc)) continue;
      Chain longer = chain;
      longer.push_back(arc.target.asset);
      UsdPrim weaker = layers_of(arc.target.asset, name, longer);
      weaker.metadata.clear();  // those of the first layer hold for the scene
      merge(root, std::move(weaker));
    }
    return root;
  }

  /// What a sublayer finds in itself, it finds in all layers of the stack.
  static void lead_to(UsdPrim& prim, const std::string& from, const std::string& to) {
    if (from == to) return;
    for (auto& [kind, list] : prim.arcs) {
      for (std::vector<UsdArc>* arcs : {&list.first, &list.last, &list.gone}) {
        for (UsdArc& arc : *arcs) {
          if (arc.target.asset == from) arc.target.asset = to;
        }
      }
    }
    for (UsdPrim& child : prim.children) lead_to(child, from, to);
    for (UsdPrim& variant : prim.variants) lead_to(variant, from, to);
  }

  /// What layers do with each other's arcs ends with their stack: arcs from elsewhere, which are
  /// weaker, come after them.
  static void settle(UsdPrim& prim) {
    for (auto& [kind, list] : prim.arcs) list = {.first = items_of(list)};
    for (UsdPrim& child : prim.children) settle(child);
    for (UsdPrim& variant : prim.variants) settle(variant);
  }

  /// Takes the arcs of a prim, the strongest first.
  static std::vector<UsdArc> arcs_of(UsdPrim& prim) {
    std::vector<UsdArc> all;
    for (const auto& [kind, list] : std::exchange(prim.arcs, {})) {
      const std::vector<UsdArc> arcs = items_of(list);
      all.insert(all.end(), arcs.begin(), arcs.end());
    }
    return all;
  }

  bool can_follow(const UsdArc& arc) {
    const std::filesystem::path file = arc.target.asset;
    const std::string shown = usd_shown(file.filename().string());
    std::error_code ignored;
    std::string fault;
    if (!is_usd_text(file)) {
      fault = "it is no usda text (USD: usdcat --flatten makes one file of text of all)";
    } else if (!std::filesystem::is_regular_file(file, ignored)) {
      fault = "there is no such file";
    } else if (++read_ > kMostLayers) {
      fail_at(arc.where, fmt::format("{} after 4096 layers", shown), "fewer layers");
    }
    if (!fault.empty()) notes_->add(arc.where, fmt::format("{} is left out: {}", shown, fault));
    return fault.empty();
  }

  /// The layers of a file that an arc leads to; null, and named, where it cannot be followed.
  std::shared_ptr<const UsdPrim> layers_at(const UsdArc& arc) {
    const std::string& file = arc.target.asset;
    const auto found = layers_.find(file);
    if (found != layers_.end()) return found->second;
    std::shared_ptr<const UsdPrim> layers;
    if (can_follow(arc)) {
      try {
        UsdPrim root = layers_of(file, file, {file});
        settle(root);
        layers = std::make_shared<const UsdPrim>(std::move(root));
      } catch (const Error& e) {
        throw Error(arc.where.text() + ": " + e.what());
      }
    }
    layers_.emplace(file, layers);
    return layers;
  }

  // Prims.

  /// The path of what an arc leads to in its layers; "" where it is not said.
  static std::string path_in(const UsdPrim& layers, const UsdTarget& target) {
    if (!target.path.empty()) return target.path;
    const std::string prim = word_of(layers, "defaultPrim");
    return prim.empty() || prim.starts_with('/') ? prim : '/' + prim;
  }

  /// An arc, and the arcs that led to it.
  struct Step {
    UsdArc arc;
    Chain chain;
  };

  static std::vector<Step> steps_of(UsdPrim& prim, const Chain& chain) {
    std::vector<Step> steps;
    for (UsdArc& arc : arcs_of(prim)) steps.push_back({std::move(arc), chain});
    return steps;
  }

  static void insert(std::vector<Step>& steps, std::size_t at, const std::vector<Step>& more) {
    steps.insert(steps.begin() + std::ptrdiff_t(at), more.begin(), more.end());
  }

  /// Merges chosen variants, and drops the others; returns what they are made of.
  static std::vector<Step> choose_variants(UsdPrim& prim, const Chain& chain) {
    while (!prim.variants.empty()) {
      for (UsdPrim& variant : std::exchange(prim.variants, {})) {
        if (chosen_variant(prim, variant.type) != variant.name) continue;
        variant.type.clear();
        merge(prim, std::move(variant));
      }
    }
    return steps_of(prim, chain);
  }

  /// Makes of a prim at a path all that it is, and of its children.
  void expand(UsdPrim& prim, const std::string& path, std::size_t depth) {
    if (depth > kDeepestStage) fail_at(prim.where, "a prim within 256 others", "fewer levels");
    std::vector<Step> steps = steps_of(prim, {});
    std::set<std::string> done;
    for (std::size_t i = 0;; ++i) {
      if (i == steps.size() || steps[i].arc.kind > 0) {  // only classes are stronger than variants
        insert(steps, i, choose_variants(prim, i < steps.size() ? steps[i].chain : Chain{}));
      }
      if (i == steps.size()) break;
      if (steps.size() > kMostArcs) fail_at(prim.where, "4096 references of a prim", "fewer");
      const Step step = steps[i];
      const std::shared_ptr<const UsdPrim> layers = layers_at(step.arc);
      if (!layers) continue;
      const std::string from = path_in(*layers, step.arc.target);
      const UsdPrim* source = layers->at(from);
      if (source == nullptr) {
        notes_->add(step.arc.where,
                    fmt::format("the prim <{}> is left out: {} has none of its own of that name",
                                usd_shown(from), usd_shown(step.arc.target.asset)));
        continue;
      }
      const std::string key = step.arc.target.asset + '<' + from + '>';
      refuse_cycle(step, key, from);
      if (!done.insert(key).second) continue;
      take_in(prim, *source, from, path, step.arc);
      Chain longer = step.chain;
      longer.push_back(key);
      insert(steps, i + 1, steps_of(prim, longer));
    }
    above_.insert(done.begin(), done.end());
    for (UsdPrim& child : prim.children) expand(child, path + '/' + child.name, depth + 1);
    for (const std::string& key : done) above_.erase(key);
  }

  void refuse_cycle(const Step& step, const std::string& key, const std::string& from) const {
    const bool again =
        std::ranges::find(step.chain, key) != step.chain.end() || above_.contains(key);
    if (again || step.chain.size() == kLongestChain) {
      fail_at(step.arc.where, fmt::format("<{}>, which leads to itself", usd_shown(from)),
              "references without a circle, and 64 in a row at most");
    }
  }

  void take_in(UsdPrim& prim, const UsdPrim& source, const std::string& from, const std::string& to,
               const UsdArc& arc) {
    copied_ += bytes_of(source);
    if (copied_ > kMostCopied) {
      fail_at(arc.where, "references that take more than 256 MiB", "fewer or smaller ones");
    }
    UsdPrim copy = source;
    move_targets(copy, from, to);
    // A prim that inherits a class, or refers to one, is none.
    if (copy.specifier == UsdPrim::Specifier::pattern) copy.specifier = UsdPrim::Specifier::over;
    merge(prim, std::move(copy));
  }

  ImportNotes* notes_;
  std::map<std::string, std::shared_ptr<const UsdPrim>> layers_{};  // by file
  std::size_t read_ = 0, copied_ = 0;
  std::set<std::string> above_{};  // arcs that prims around the one at hand have followed
};

}  // namespace

UsdPrim compose_usda(const std::filesystem::path& file, ImportNotes& notes) {
  return UsdComposer(notes).compose(file);
}

}  // namespace pvol::formats::detail
