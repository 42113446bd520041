// The directives of pbrt-v4. Pharr, Jakob, Humphreys. Physically Based Rendering, 4th edition.
// 2023.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "file/invertible.h"
#include "file/mesh_read.h"
#include "pbrt/pbrt_description.h"
#include "pbrt/pbrt_state.h"
#include "pbrt/pbrt_words.h"

namespace pvol::formats::detail {
namespace {

constexpr std::size_t kDeepestBlock = 64;  // blocks within each other
constexpr std::array kTargets{"shape", "light", "material", "medium", "texture"};

class PbrtParser {
 public:
  PbrtParser(const std::filesystem::path& file, ImportNotes& notes) : notes_(&notes), words_(file) {
    scene_.folder = file.parent_path();
    for (PbrtThing* t : {&scene_.film, &scene_.sampler, &scene_.filter, &scene_.integrator}) {
      t->where = words_.where();
    }
  }

  PbrtDescription read() {
    while (words_.next()) directive();
    if (!blocks_.empty()) {
      fail_at(blocks_.back().where, "a block without an end", "AttributeEnd or the like");
    }
    resolve_materials();
    scene_.files = words_.named();
    return std::move(scene_);
  }

 private:
  struct Block {
    PbrtState state;
    std::string end;  // the directive that ends it
    PbrtWhere where;
  };

  // Parameters.

  PbrtParameters parameters(const std::string& target = {}) {
    PbrtParameters all;
    for (PbrtParameter& p : words_.parameters()) all.add(std::move(p));
    const auto defaults = state_.defaults.find(target);
    if (defaults == state_.defaults.end()) return all;
    PbrtParameters joined = all;
    for (const PbrtParameter& p : defaults->second) {
      if (all.find(p.name) == nullptr) joined.add(p);
    }
    return joined;
  }

  PbrtThing thing(const std::string& target = {}) {
    const PbrtWhere where = words_.where();
    std::string type = words_.string("a type");
    return {std::move(type), parameters(target), where};
  }

  /// With its name, and its type among the parameters.
  std::pair<std::string, PbrtThing> named(const std::string& target) {
    const PbrtWhere where = words_.where();
    std::string name = words_.string("a name");
    PbrtThing t{"", parameters(target), where};
    t.type = t.parameters.word("type", "");
    return {std::move(name), std::move(t)};
  }

  // Directives.

  void directive() {
    if (words_.token().kind != PbrtToken::Kind::word) {
      fail_at(words_.where(), fmt::format("'{}'", shown(words_.token().text)),
              "a directive such as Shape");
    }
    const std::string name(words_.token().text);
    if (!transform(name) && !block(name) && !setting(name) && !content(name)) {
      fail_at(words_.where(), fmt::format("'{}'", shown(name)),
              "a directive of pbrt-v4 such as Shape, LightSource or MakeNamedMedium (scenes of "
              "pbrt-v3: pbrt --upgrade)");
    }
  }

  void apply(const Affine& map, const PbrtWhere& where, bool replaces = false) {
    if (!is_invertible(map)) {
      fail_at(where, "a transform without an inverse", "an invertible transform");
    }
    if (state_.sets_start) state_.ctm = replaces ? map : state_.ctm * map;
  }

  bool transform(const std::string& name) {
    const PbrtWhere where = words_.where();
    if (name == "Identity")
      apply({}, where, true);
    else if (name == "Translate")
      apply(translation(words_.vector()), where);
    else if (name == "Scale")
      apply(scaling(words_.vector()), where);
    else if (name == "Rotate") {
      const double degrees = words_.number();
      apply(rotation(degrees, words_.vector()), where);
    } else if (name == "LookAt") {
      const Vec3d eye = words_.vector(), target = words_.vector();
      apply(look_at(eye, target, words_.vector()), where);
    } else if (name == "Transform" || name == "ConcatTransform") {
      const auto map = affine_of(words_.matrix());
      if (!map) fail_at(where, "a matrix with a perspective", "a last row of 0, 0, 0, 1");
      apply(*map, where, name == "Transform");
    } else if (name == "CoordinateSystem") {
      systems_[words_.string("a name")] = state_.ctm;
    } else if (name == "CoordSysTransform") {
      const std::string system = words_.string("a name");
      const auto found = systems_.find(system);
      if (found == systems_.end()) {
        fail_at(where, fmt::format("\"{}\"", shown(system)),
                "a coordinate system that was defined before");
      }
      apply(found->second, where, true);
    } else if (name == "ActiveTransform") {
      const std::string which(words_.need("All, StartTime or EndTime").text);
      state_.sets_start = which != "EndTime";
      if (which != "All") {
        notes_->add(where,
                    "motion by ActiveTransform is left out: everything stays as at StartTime");
      }
    } else if (name == "TransformTimes") {
      words_.number(), words_.number();
    } else {
      return false;
    }
    return true;
  }

  void begin(const char* end) {
    if (blocks_.size() == kDeepestBlock) {
      fail_at(words_.where(), "a block within 64 others", "fewer levels of blocks");
    }
    blocks_.push_back({state_, end, words_.where()});
  }

  void end(const std::string& name) {
    if (blocks_.empty() || blocks_.back().end != name) {
      fail_at(words_.where(), name,
              blocks_.empty() ? "a block that was begun before" : blocks_.back().end);
    }
    const Affine ctm = blocks_.back().state.ctm;
    const bool sets_start = blocks_.back().state.sets_start;
    if (name == "TransformEnd")
      state_.ctm = ctm, state_.sets_start = sets_start;
    else
      state_ = std::move(blocks_.back().state);
    blocks_.pop_back();
    if (name == "ObjectEnd") in_object_ = false;
  }

  bool block(const std::string& name) {
    if (name == "AttributeBegin")
      begin("AttributeEnd");
    else if (name == "TransformBegin")
      begin("TransformEnd");
    else if (name == "ObjectBegin") {
      if (in_object_) fail_at(words_.where(), "an object within an object", "ObjectEnd before it");
      begin("ObjectEnd");
      words_.string("a name");
      in_object_ = true;
    } else if (name == "AttributeEnd" || name == "TransformEnd" || name == "ObjectEnd") {
      end(name);
    } else if (name == "ObjectInstance") {
      const PbrtWhere where = words_.where();
      const std::string object = words_.string("a name");
      notes_->add(where, fmt::format("instances of the object \"{}\" are left out", shown(object)));
    } else if (name == "WorldBegin") {
      state_.ctm = {};
      state_.sets_start = true;
      systems_["world"] = {};
    } else if (name == "Attribute") {
      const std::string target = words_.string("a target");
      const PbrtWhere where = words_.where();
      for (PbrtParameter& p : words_.parameters()) {
        state_.defaults[target].push_back(std::move(p));
      }
      if (std::ranges::find(kTargets, target) == kTargets.end()) {
        fail_at(where, fmt::format("\"{}\"", shown(target)),
                "shape, light, material, medium or texture");
      }
    } else {
      return false;
    }
    return true;
  }

  /// What holds for the whole picture, or goes on in another file.
  bool setting(const std::string& name) {
    const PbrtWhere where = words_.where();
    if (name == "Camera") {
      camera();
    } else if (name == "Film")
      scene_.film = thing();
    else if (name == "Sampler")
      scene_.sampler = thing();
    else if (name == "PixelFilter")
      scene_.filter = thing();
    else if (name == "Integrator")
      scene_.integrator = thing();
    else if (name == "Accelerator")
      (void)thing();
    else if (name == "ColorSpace") {
      const std::string space = words_.string("a colour space");
      if (space != "srgb") {
        notes_->add(where,
                    fmt::format("colours of \"{}\" are taken as those of srgb", shown(space)));
      }
    } else if (name == "Option") {
      for (const PbrtParameter& option : words_.parameters()) {
        notes_->add(where, fmt::format("the option \"{}\" is left out", shown(option.name)));
      }
    } else if (name == "ReverseOrientation") {
      state_.reversed = !state_.reversed;
    } else if (name == "Include" || name == "Import") {
      words_.include(words_.string("a file"), where);
    } else {
      return false;
    }
    return true;
  }

  void camera() {
    const Affine to_world = inverse(state_.ctm);
    systems_["camera"] = to_world;
    scene_.camera_medium = state_.outside;
    scene_.camera = PbrtPlaced{thing(), to_world};
    for (auto& [key, medium] : scene_.media) {
      // pbrt's rendering space, the world moved by the camera's place, is not known before.
      medium.place = translation(to_world.t) * medium.place;
      if (medium.type == "homogeneous") continue;  // it stands where its shapes do
      notes_->add(medium.where,
                  fmt::format("medium \"{}\" is made before the camera: as in pbrt, its "
                              "place counts from that of the camera",
                              shown(key)));
    }
  }

  /// Things that the scene is made of.
  bool content(const std::string& name) {
    const PbrtWhere where = words_.where();
    if (name == "LightSource") {
      PbrtPlaced light{thing("light"), state_.ctm};
      if (in_object_)
        notes_->add(where, "lights of objects are left out");
      else
        scene_.lights.push_back(std::move(light));
    } else if (name == "AreaLightSource") {
      state_.area_light = thing("light");
    } else if (name == "Material") {
      state_.material = thing("material");
      state_.material_name.reset();
    } else if (name == "MakeNamedMaterial") {
      auto [key, material] = named("material");
      const auto [at, is_new] = materials_.try_emplace(std::move(key), std::move(material));
      if (!is_new) {
        fail_at(where, fmt::format("material \"{}\" a second time", shown(at->first)),
                "each material once");
      }
    } else if (name == "NamedMaterial") {
      state_.material_name = words_.string("a name");
      state_.material = {.type = {}, .parameters = {}, .where = where};
    } else if (name == "MakeNamedMedium") {
      medium();
    } else if (name == "MediumInterface") {
      state_.inside = words_.string("the name of a medium");
      state_.outside = state_.inside;
      if (words_.next_is(PbrtToken::Kind::string))
        state_.outside = words_.string("the name of a medium");
    } else if (name == "Texture") {
      std::string key = words_.string("a name");
      const std::string kind = words_.string("float or spectrum");
      scene_.textures.insert_or_assign(std::move(key), thing("texture"));
    } else if (name == "Shape") {
      shape();
    } else {
      return false;
    }
    return true;
  }

  void medium() {
    const PbrtWhere where = words_.where();
    auto [key, medium] = named("medium");
    const bool again =
        std::ranges::any_of(scene_.media, [&key = key](const auto& m) { return m.first == key; });
    if (again)
      fail_at(where, fmt::format("medium \"{}\" a second time", shown(key)), "each medium once");
    scene_.media.emplace_back(std::move(key), PbrtPlaced{std::move(medium), state_.ctm});
  }

  void shape() {
    const PbrtThing what = thing("shape");
    if (in_object_) return;  // its instances are named
    scene_.shapes.push_back({{what, state_.ctm},
                             state_.material,
                             state_.material_name,
                             state_.inside,
                             state_.outside,
                             state_.area_light,
                             state_.reversed});
  }

  /// A material may be made after shapes that name it.
  void resolve_materials() {
    for (PbrtShape& shape : scene_.shapes) {
      if (!shape.material_name) continue;
      const auto found = materials_.find(*shape.material_name);
      if (found == materials_.end()) {
        fail_at(shape.material.where, fmt::format("\"{}\"", shown(*shape.material_name)),
                "a material that MakeNamedMaterial defines");
      }
      shape.material = found->second;
    }
  }

  ImportNotes* notes_;
  PbrtWords words_;
  PbrtDescription scene_;
  PbrtState state_{.ctm = {}, .material = {.type = "diffuse", .parameters = {}, .where = {}}};
  std::vector<Block> blocks_;
  bool in_object_ = false;
  std::map<std::string, Affine> systems_;
  std::map<std::string, PbrtThing> materials_;
};

}  // namespace

PbrtDescription parse_pbrt(const std::filesystem::path& file, ImportNotes& notes) {
  return PbrtParser(file, notes).read();
}

}  // namespace pvol::formats::detail
