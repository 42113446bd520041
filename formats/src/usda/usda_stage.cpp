#include "usda/usda_stage.h"
#include "file/invertible.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

namespace pvol::formats::detail {
namespace {

constexpr std::size_t kMostInstances = std::size_t(1) << 18;

constexpr std::array kGroups{"", "Xform", "Scope", "SkelRoot"};
constexpr std::array kLightTypes{"DistantLight",  "DomeLight",  "DomeLight_1",   "SphereLight",
                                 "RectLight",     "DiskLight",  "CylinderLight", "PortalLight",
                                 "GeometryLight", "PluginLight"};
constexpr std::array kSurfaceTypes{"Mesh", "Sphere", "Cube", "Plane"};
/// What others refer to, and name if they leave it out, or what has no picture.
constexpr std::array kQuiet{"Material",          "Shader",          "NodeGraph", "OpenVDBAsset",
                            "Field3DAsset",      "GeomSubset",      "RenderVar", "RenderPass",
                            "HoudiniFieldAsset", "HoudiniLayerInfo"};

bool is_any_of(const auto& types, const std::string& type) {
  return std::ranges::find(types, type) != types.end();
}

/// Which material is bound, and whether that holds against what prims within say.
struct Binding {
  std::string material{};
  bool is_strong = false;
};

/// What holds for all that is within a prim.
struct Above {
  UsdPlace place{};
  bool is_visible = true;
  std::string purpose = "default";
  Binding for_all{}, for_full{};  ///< pictures of all purposes, and full ones, which come first

  /// Things that stand for others in a viewer (proxy, guide) are not rendered.
  [[nodiscard]] bool is_seen() const {
    return is_visible && purpose != "proxy" && purpose != "guide";
  }
  [[nodiscard]] const std::string& material() const {
    return for_full.material.empty() ? for_all.material : for_full.material;
  }
};

/// The outermost binding that is strong counts, else the innermost one.
void take_binding(Binding& binding, const UsdView& view, const std::string& name) {
  const std::vector<std::string> bound = view.paths(name);
  if (bound.empty() || binding.is_strong) return;
  const std::map<std::string, std::string>& words = view.find(name)->words;
  const auto strength = words.find("bindMaterialAs");
  binding = {bound.front(),
             strength != words.end() && strength->second == "strongerThanDescendants"};
}

class UsdWalk {
 public:
  UsdWalk(UsdStage& stage, ImportNotes& notes) : stage_(&stage), notes_(&notes) {}

  void walk(const UsdPrim& prim, const std::string& path, Above above) {
    // Neither opinions about what is not there, nor classes, nor what is switched off.
    if (prim.specifier != UsdPrim::Specifier::def || number_of(prim, "active", 1) == 0) return;
    if (is_any_of(kQuiet, prim.type)) return;
    const UsdView view = stage_->view(prim);
    inherit(view, above);
    note_collections(prim, path);
    if (prim.metadata.contains("clips")) notes_->add(prim.where, "value clips are left out");
    if (!is_invertible(above.place.now) || !is_invertible(above.place.later)) {
      notes_->add(prim.where,
                  fmt::format("{} is left out: its transform has no inverse", usd_shown(path)));
      return;
    }
    if (prim.type == "PointInstancer") {
      if (above.is_seen()) instance(view, above);
      return;
    }
    add(prim, path, above);
    for (const UsdPrim& child : prim.children) walk(child, path + '/' + child.name, above);
  }

 private:
  /// Place, visibility, purpose and material.
  void inherit(const UsdView& view, Above& above) {
    const UsdXform xform = xform_of(view);
    above.place = xform.resets ? xform.place : above.place * xform.place;
    if (view.word("visibility", "inherited") == "invisible") above.is_visible = false;
    above.purpose = view.word("purpose", above.purpose);
    take_binding(above.for_all, view, "material:binding");
    take_binding(above.for_full, view, "material:binding:full");
  }

  void note_collections(const UsdPrim& prim, const std::string& path) {
    for (const auto& [name, attribute] : prim.attributes) {
      if (!name.starts_with("material:binding:collection") || attribute->targets.empty()) continue;
      notes_->add(attribute->where,
                  fmt::format("{} of {} is left out; expected a material:binding of each prim",
                              usd_shown(name), usd_shown(path)));
    }
  }

  void add(const UsdPrim& prim, const std::string& path, const Above& above) {
    std::vector<UsdItem>* to = list_of(prim.type, above.is_seen());
    if (to == nullptr) {
      if (above.is_seen() && !is_any_of(kGroups, prim.type)) name_unmapped(prim);
      return;
    }
    instances_in_all_ += instances_.size();
    if (instances_in_all_ > kMostInstances) {
      fail_at(prim.where, "more than 262144 instances of volumes", "fewer");
    }
    to->push_back({&prim, path, above.place, above.material(), instances_});
  }

  void name_unmapped(const UsdPrim& prim) {
    notes_->add(prim.where, fmt::format("{} of type \"{}\" are left out{}",
                                        in_prototype_ ? "instances" : "prims", usd_shown(prim.type),
                                        in_prototype_ ? ": only volumes are instanced" : ""));
  }

  std::vector<UsdItem>* list_of(const std::string& type, bool is_seen) {
    if (type == "Volume" && is_seen) return &stage_->volumes;
    if (in_prototype_) return nullptr;
    if (type == "Camera") return &stage_->cameras;
    if (type == "RenderSettings") return &stage_->settings;
    if (type == "RenderProduct") return &stage_->products;
    if (!is_seen) return nullptr;
    if (is_any_of(kLightTypes, type)) return &stage_->lights;
    if (is_any_of(kSurfaceTypes, type)) return &stage_->surfaces;
    return nullptr;
  }

  /// Volumes of prototypes become instances; all else of them is named.
  void instance(const UsdView& view, const Above& above) {
    const std::vector<std::string> prototypes = view.paths("prototypes");
    if (in_prototype_) {
      notes_->add(view.where(), "a PointInstancer in a prototype of another one is left out");
      return;
    }
    in_prototype_ = true;
    const std::vector<std::vector<UsdPlace>> places =
        instances_of(view, prototypes.size(), *notes_);
    for (std::size_t i = 0; i < prototypes.size(); ++i) {
      const UsdPrim* prototype = stage_->find(prototypes[i]);
      if (prototype == nullptr || places[i].empty()) continue;
      instances_.clear();
      for (const UsdPlace& p : places[i]) instances_.push_back(above.place * p);
      Above inside;
      inside.for_all = above.for_all, inside.for_full = above.for_full;
      walk(*prototype, prototypes[i], inside);
    }
    instances_.clear();
    in_prototype_ = false;
    view.ignore("extent");
    view.note_unused(*notes_);
  }

  UsdStage* stage_;
  ImportNotes* notes_;
  bool in_prototype_ = false;
  std::vector<UsdPlace> instances_{};  // of the prototype at hand
  std::size_t instances_in_all_ = 0;
};

/// The time of the first sample; infinite without one.
double first_sample(const UsdPrim& prim) {
  double first = std::numeric_limits<double>::infinity();
  for (const auto& [name, attribute] : prim.attributes) {
    const auto& samples = attribute->content->samples;
    if (!samples.empty()) first = std::min(first, samples.front().first);
  }
  for (const UsdPrim& child : prim.children) first = std::min(first, first_sample(child));
  return first;
}

double first_frame(const UsdPrim& root) {
  const double first = number_of(root, "startTimeCode", first_sample(root));
  return std::isfinite(first) ? first : 0;
}

double positive(const UsdPrim& root, const char* metadatum, double otherwise) {
  const double value = number_of(root, metadatum, otherwise);
  if (value > 0 && std::isfinite(value)) return value;
  fail_at(root.metadata.at(metadatum).where, fmt::format("{} = {}", metadatum, value),
          "a number above 0");
}

}  // namespace

const UsdPrim* UsdStage::find(const std::string& path) const { return root.at(path); }

UsdStage stage_of(UsdPrim root, std::optional<int> frame, ImportNotes& notes) {
  UsdStage stage;
  stage.root = std::move(root);
  stage.is_chosen = frame.has_value();
  stage.frame = frame ? *frame : first_frame(stage.root);
  stage.z_up = word_of(stage.root, "upAxis") == "Z";
  stage.metres = positive(stage.root, "metersPerUnit", 0.01);
  stage.fps =
      positive(stage.root, "timeCodesPerSecond", number_of(stage.root, "framesPerSecond", 24));
  UsdWalk walk(stage, notes);
  for (const UsdPrim& prim : stage.root.children) walk.walk(prim, '/' + prim.name, {});
  return stage;
}

}  // namespace pvol::formats::detail
