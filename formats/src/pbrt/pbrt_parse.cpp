// The directives of pbrt-v4. Pharr, Jakob, Humphreys. Physically Based Rendering, 4th edition.
// 2023.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "file/mesh_read.h"
#include "file/parse_number.h"
#include "pbrt/pbrt_description.h"
#include "pbrt/pbrt_state.h"
#include "pvol/error.h"

namespace pvol::formats::detail {
namespace {

constexpr std::size_t kDeepest = 64;      // files that include each other, and attributes
constexpr std::size_t kMostFiles = 4096;  // read in all: a few lines could ask for endless work

constexpr std::array kNumeric{"integer", "float",  "point2",  "vector2", "point3", "point",
                              "vector3", "vector", "normal3", "normal",  "rgb",    "blackbody"};
constexpr std::array kOthers{"bool", "string", "texture", "spectrum"};

bool is_one_of(const auto& names, std::string_view name) {
  return std::ranges::find(names, name) != names.end();
}

class PbrtParser {
 public:
  PbrtParser(const std::filesystem::path& file, PbrtNotes& notes) : notes_(&notes) {
    scene_.folder = file.parent_path();
    files_.emplace_back(file);
    for (PbrtThing* t : {&scene_.film, &scene_.sampler, &scene_.filter, &scene_.integrator}) {
      t->where = files_.back().where();
    }
  }

  PbrtDescription read() {
    while (next()) directive();
    if (!blocks_.empty()) {
      fail_at(blocks_.back().where, "a block that is not ended", "its AttributeEnd or the like");
    }
    return std::move(scene_);
  }

 private:
  struct Block {
    PbrtState state;
    std::string end;  // the directive that ends it
    PbrtWhere where;
  };

  // Tokens.

  /// Moves on to the next token; false at the end of the last file.
  bool next() {
    if (ahead_) {
      ahead_ = false;
      return true;
    }
    while (!files_.empty()) {
      if (const auto found = files_.back().next()) {
        token_ = *found;
        return true;
      }
      last_ = files_.back().where();
      files_.pop_back();
    }
    return false;
  }

  /// The next token, which must be there.
  const PbrtToken& need(const char* expected) {
    if (!next()) fail_at(last_, "the end of the file", expected);
    return token_;
  }

  bool next_is(PbrtToken::Kind kind) {
    ahead_ = next();
    return ahead_ && token_.kind == kind;
  }

  double number() {
    const PbrtToken& t = need("a number");
    const auto value = t.kind == PbrtToken::Kind::word ? parse_number(t.text) : std::nullopt;
    if (!value || !std::isfinite(*value)) {
      fail_at(t.where, fmt::format("'{}'", shown(t.text)), "a finite number");
    }
    return *value;
  }

  Vec3d vector() {
    const double x = number(), y = number();
    return {x, y, number()};
  }

  std::string string(const char* expected) {
    const PbrtToken& t = need(expected);
    if (t.kind != PbrtToken::Kind::string) {
      fail_at(t.where, fmt::format("'{}'", shown(t.text)),
              std::string(expected) + " in quotation marks");
    }
    return std::string(t.text);
  }

  std::vector<double> sixteen() {
    const bool bracket = next_is(PbrtToken::Kind::open);
    if (bracket) next();
    std::vector<double> all(16);
    for (double& n : all) n = number();
    if (bracket && need("]").kind != PbrtToken::Kind::close) {
      fail_at(token_.where, fmt::format("'{}'", shown(token_.text)), "16 numbers and then ]");
    }
    return all;
  }

  // Parameters.

  void value(PbrtParameter& p) {
    const PbrtToken& t = token_;
    const bool strings = !is_one_of(kNumeric, p.type);
    if (t.kind == PbrtToken::Kind::string && strings) {
      p.strings.emplace_back(t.text);
    } else if (t.kind == PbrtToken::Kind::word && p.type == "bool" &&
               (t.text == "true" || t.text == "false")) {
      p.strings.emplace_back(t.text);
    } else {
      const auto n = t.kind == PbrtToken::Kind::word ? parse_number(t.text) : std::nullopt;
      if (!n || !std::isfinite(*n) || (strings && p.type != "spectrum")) {
        fail_at(t.where, fmt::format("'{}'", shown(t.text)),
                fmt::format("a value of \"{} {}\"", p.type, shown(p.name)));
      }
      p.numbers.push_back(*n);
    }
  }

  PbrtParameter parameter() {
    const std::string_view said = token_.text;
    const std::size_t begin = said.find_first_not_of(" \t");
    const std::size_t end = std::min(said.find_first_of(" \t", begin), said.size());
    const std::size_t name = said.find_first_not_of(" \t", end);
    PbrtParameter p{.type = {}, .name = {}, .where = token_.where, .numbers = {}, .strings = {}};
    if (begin != said.npos) p.type = said.substr(begin, end - begin);
    if (name != said.npos) {
      p.name = said.substr(name, said.find_last_not_of(" \t") + 1 - name);
    }
    if (p.name.empty() || (!is_one_of(kNumeric, p.type) && !is_one_of(kOthers, p.type))) {
      fail_at(p.where, fmt::format("\"{}\"", shown(said)),
              "a parameter as \"float fov\", of type integer, float, point2, point3, vector3, "
              "normal, rgb, blackbody, spectrum, bool, string or texture");
    }
    if (need("the parameter's value").kind != PbrtToken::Kind::open) {
      value(p);
      return p;
    }
    while (need("]").kind != PbrtToken::Kind::close) value(p);
    return p;
  }

  PbrtParameters parameters(const std::string& target = {}) {
    PbrtParameters all;
    while (next_is(PbrtToken::Kind::string)) {
      next();
      all.add(parameter());
    }
    const auto defaults = state_.defaults.find(target);
    if (defaults == state_.defaults.end()) return all;
    PbrtParameters joined = all;
    for (const PbrtParameter& p : defaults->second) {
      if (all.find(p.name) == nullptr) joined.add(p);
    }
    return joined;
  }

  PbrtThing thing(const std::string& target = {}) {
    const PbrtWhere where = token_.where;
    std::string type = string("a type");
    return {std::move(type), parameters(target), where};
  }

  /// With its name, and its type among the parameters.
  std::pair<std::string, PbrtThing> named(const std::string& target) {
    const PbrtWhere where = token_.where;
    std::string name = string("a name");
    PbrtThing t{"", parameters(target), where};
    t.type = t.parameters.word("type", "");
    return {std::move(name), std::move(t)};
  }

  // Directives.

  void directive() {
    if (token_.kind != PbrtToken::Kind::word) {
      fail_at(token_.where, fmt::format("'{}'", shown(token_.text)), "a directive such as Shape");
    }
    const std::string name(token_.text);
    if (!transform(name) && !block(name) && !setting(name) && !content(name)) {
      fail_at(token_.where, fmt::format("'{}'", shown(name)),
              "a directive of pbrt-v4 such as Shape, LightSource or MakeNamedMedium (scenes of "
              "pbrt-v3: pbrt --upgrade)");
    }
  }

  void apply(const Affine& map, const PbrtWhere& where, bool replaces = false) {
    if (!is_invertible(map)) {
      fail_at(where, "a transform that cannot be undone", "one that keeps volumes");
    }
    if (state_.sets_start) state_.ctm = replaces ? map : state_.ctm * map;
  }

  bool transform(const std::string& name) {
    const PbrtWhere where = token_.where;
    if (name == "Identity")
      apply({}, where, true);
    else if (name == "Translate")
      apply(translation(vector()), where);
    else if (name == "Scale")
      apply(scaling(vector()), where);
    else if (name == "Rotate") {
      const double degrees = number();
      apply(rotation(degrees, vector()), where);
    } else if (name == "LookAt") {
      const Vec3d eye = vector(), target = vector();
      apply(look_at(eye, target, vector()), where);
    } else if (name == "Transform" || name == "ConcatTransform") {
      const auto map = affine_of(sixteen());
      if (!map) fail_at(where, "a matrix with a perspective", "a last row of 0, 0, 0, 1");
      apply(*map, where, name == "Transform");
    } else if (name == "CoordinateSystem") {
      systems_[string("a name")] = state_.ctm;
    } else if (name == "CoordSysTransform") {
      const std::string system = string("a name");
      const auto found = systems_.find(system);
      if (found == systems_.end()) {
        fail_at(where, fmt::format("\"{}\"", shown(system)), "a coordinate system named before");
      }
      apply(found->second, where, true);
    } else if (name == "ActiveTransform") {
      const std::string which(need("All, StartTime or EndTime").text);
      state_.sets_start = which != "EndTime";
      if (which != "All") {
        notes_->add(where, "motion by ActiveTransform is left out: things stand as at StartTime");
      }
    } else if (name == "TransformTimes") {
      number(), number();
    } else {
      return false;
    }
    return true;
  }

  void begin(const char* end) {
    if (blocks_.size() == kDeepest) {
      fail_at(token_.where, "a block within 64 others", "fewer levels of blocks");
    }
    blocks_.push_back({state_, end, token_.where});
  }

  void end(const std::string& name) {
    if (blocks_.empty() || blocks_.back().end != name) {
      fail_at(token_.where, name, blocks_.empty() ? "a block begun before" : blocks_.back().end);
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
      if (in_object_) fail_at(token_.where, "an object within an object", "ObjectEnd before it");
      begin("ObjectEnd");
      string("a name");
      in_object_ = true;
    } else if (name == "AttributeEnd" || name == "TransformEnd" || name == "ObjectEnd") {
      end(name);
    } else if (name == "ObjectInstance") {
      const PbrtWhere where = token_.where;
      const std::string object = string("a name");
      notes_->add(where, fmt::format("instances of the object \"{}\" are left out", shown(object)));
    } else if (name == "WorldBegin") {
      state_.ctm = {};
      state_.sets_start = true;
      systems_["world"] = {};
    } else if (name == "Attribute") {
      const std::string target = string("a target");
      const PbrtWhere where = token_.where;
      while (next_is(PbrtToken::Kind::string)) {
        next();
        state_.defaults[target].push_back(parameter());
      }
      if (!is_one_of(std::array{"shape", "light", "material", "medium", "texture"}, target)) {
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
    const PbrtWhere where = token_.where;
    if (name == "Camera") {
      const Affine to_world = inverse(state_.ctm);
      systems_["camera"] = to_world;
      scene_.camera_medium = state_.outside;
      scene_.camera = PbrtPlaced{thing(), to_world};
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
      const std::string space = string("a colour space");
      if (space != "srgb") {
        notes_->add(where,
                    fmt::format("colours of \"{}\" are taken as those of srgb", shown(space)));
      }
    } else if (name == "Option") {
      (void)need("an option");
      const PbrtParameter option = parameter();
      notes_->add(where, fmt::format("the option \"{}\" is left out", shown(option.name)));
    } else if (name == "ReverseOrientation") {
      state_.reversed = !state_.reversed;
    } else if (name == "Include" || name == "Import") {
      include(string("a file"), where);
    } else {
      return false;
    }
    return true;
  }

  /// Names are relative to the folder of the first file, as pbrt has it, else of the one at hand.
  void include(const std::string& name, const PbrtWhere& where) {
    std::filesystem::path file = scene_.folder / name;
    if (!std::filesystem::exists(file)) file = files_.back().file().parent_path() / name;
    if (files_.size() == kDeepest || ++read_ == kMostFiles) {
      fail_at(where, fmt::format("\"{}\" after {} files", shown(name), read_),
              "files that do not include each other, 4096 at most");
    }
    try {
      files_.emplace_back(file);
    } catch (const Error& e) {
      throw Error(where.text() + ": " + e.what());
    }
  }

  /// Things that the scene is made of.
  bool content(const std::string& name) {
    const PbrtWhere where = token_.where;
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
    } else if (name == "MakeNamedMaterial") {
      auto [key, material] = named("material");
      materials_.insert_or_assign(std::move(key), std::move(material));
    } else if (name == "NamedMaterial") {
      const std::string key = string("a name");
      const auto found = materials_.find(key);
      if (found == materials_.end()) {
        fail_at(where, fmt::format("\"{}\"", shown(key)), "a material named before");
      }
      state_.material = found->second;
    } else if (name == "MakeNamedMedium") {
      medium();
    } else if (name == "MediumInterface") {
      state_.inside = string("the name of a medium");
      state_.outside = state_.inside;
      if (next_is(PbrtToken::Kind::string)) state_.outside = string("the name of a medium");
    } else if (name == "Texture") {
      std::string key = string("a name");
      const std::string kind = string("float or spectrum");
      scene_.textures.insert_or_assign(std::move(key), thing("texture"));
    } else if (name == "Shape") {
      shape();
    } else {
      return false;
    }
    return true;
  }

  void medium() {
    const PbrtWhere where = token_.where;
    auto [key, medium] = named("medium");
    const bool again =
        std::ranges::any_of(scene_.media, [&](const auto& m) { return m.first == key; });
    if (again) fail_at(where, fmt::format("medium \"{}\" again", shown(key)), "each medium once");
    scene_.media.emplace_back(std::move(key), PbrtPlaced{std::move(medium), state_.ctm});
  }

  void shape() {
    const PbrtThing what = thing("shape");
    if (in_object_) return;  // its instances are named
    scene_.shapes.push_back({{what, state_.ctm},
                             state_.material,
                             state_.inside,
                             state_.outside,
                             state_.area_light,
                             state_.reversed});
  }

  PbrtNotes* notes_;
  PbrtDescription scene_;
  std::vector<PbrtTokens> files_;  // that are being read, the outermost first
  std::size_t read_ = 1;
  PbrtToken token_{};
  bool ahead_ = false;  // whether token_ is still to be taken
  PbrtWhere last_;
  PbrtState state_{.ctm = {}, .material = {.type = "diffuse", .parameters = {}, .where = {}}};
  std::vector<Block> blocks_;
  bool in_object_ = false;
  std::map<std::string, Affine> systems_;
  std::map<std::string, PbrtThing> materials_;
};

}  // namespace

PbrtDescription parse_pbrt(const std::filesystem::path& file, PbrtNotes& notes) {
  return PbrtParser(file, notes).read();
}

}  // namespace pvol::formats::detail
