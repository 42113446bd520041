#include "toml/recipe_body.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "pvol/density/recipe.h"
#include "pvol/error.h"

namespace pvol::formats {
namespace {

/// Rotation about x, then y, then z, angles in degrees.
Affine rotation(Vec3d degrees) {
  Affine result;
  for (int axis = 0; axis < 3; ++axis) {
    const double angle = degrees[axis] * std::numbers::pi / 180;
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    Affine turn;
    turn.m[std::size_t(u)][u] = turn.m[std::size_t(v)][v] = std::cos(angle);
    turn.m[std::size_t(v)][u] = std::sin(angle);
    turn.m[std::size_t(u)][v] = -std::sin(angle);
    result = turn * result;
  }
  return result;
}

/// A quadric, and the factor that makes its values about distances from the surface.
struct Shape {
  Quadric quadric;
  double to_distance = 1;
};

Shape read_ellipsoid(const TomlTable& table) {
  table.require({"centre", "radii"});
  const Vec3d radii = *table.number_or_vector("radii", Range::closed(1e-30, 1e30));
  const Vec3d degrees = table.vector("rotation").value_or(Vec3d{});
  const Affine turn = degrees == Vec3d{} ? Affine{} : rotation(degrees);
  // 1 - |p/r|^2 falls by 2/r for each unit of distance, fastest along the shortest axis.
  return {ellipsoid(*table.vector("centre"), radii, turn), 0.5 * min_component(radii)};
}

Shape read_coefficients(const TomlTable& table) {
  table.require({"coefficients"});
  const std::vector<double> c = *table.numbers("coefficients", 10);
  return {{{c[0], c[1], c[2]}, {c[3], c[4], c[5]}, {c[6], c[7], c[8]}, c[9]}};
}

Shape read_half_space(const TomlTable& table) {
  table.require({"point", "inward"});
  return {half_space(*table.vector("point"), *table.direction("inward"))};
}

/// What a shape is for, which decides what keys stand beside its own.
enum class Role { form, perturbation, mask };

Shape read_shape(const TomlTable& table, Role role) {
  const auto allow = [&](auto... own) {
    switch (role) {
      case Role::form:
        return table.allow_only(
            {"shape", own..., "steepness", "perturbation", "scale", "rotate", "translate"});
      case Role::perturbation:
        return table.allow_only({"shape", own..., "strength", "perturbation"});
      case Role::mask:
        return table.allow_only({"shape", own..., "steepness"});
    }
  };
  table.require({"shape"});
  const std::string shape = *table.word("shape", {"ellipsoid", "half-space", "quadric"});
  if (shape == "ellipsoid") {
    allow("centre", "radii", "rotation");
    return read_ellipsoid(table);
  }
  if (shape == "half-space") {
    allow("point", "inward");
    return read_half_space(table);
  }
  allow("coefficients");
  return read_coefficients(table);
}

double read_steepness(const TomlTable& table) {
  return table.number("steepness", Range::above(0)).value_or(1);
}

/// The perturbations of a form, and theirs.
std::vector<Perturbation> read_perturbations(const TomlTable& table, int level = 1) {
  std::vector<Perturbation> result;
  for (const TomlTable* p : table.tables("perturbation")) {
    if (level > kDeepestTree) {
      throw Error(fmt::format("{}: there are more than {} levels of perturbations; expected fewer",
                              p->where, kDeepestTree));
    }
    p->require({"strength"});
    const Quadric quadric = read_shape(*p, Role::perturbation).quadric;
    result.push_back({{quadric, read_perturbations(*p, level + 1)}, *p->number("strength")});
  }
  return result;
}

FreeForm read_form(const TomlTable& table) {
  const Shape shape = read_shape(table, Role::form);
  return {shape.to_distance * shape.quadric, read_perturbations(table)};
}

/// The body where the table puts it: scaled, then turned, then moved. Its values are scaled by the
/// least factor, so that they are distances where they were, or less.
Body placed(const Body& body, const TomlTable& table) {
  const auto scale = table.number_or_vector("scale", Range::closed(1e-10, 1e10));
  const auto rotate = table.vector("rotate"), translate = table.vector("translate");
  const double steepness = read_steepness(table);
  if (!scale && !rotate && !translate) return steepness * body;
  const Vec3d factor = scale.value_or(Vec3d(1));
  const Affine map = translation(translate.value_or(Vec3d{})) * rotation(rotate.value_or(Vec3d{})) *
                     scaling(factor);
  return steepness * min_component(factor) * transform(map, body);
}

/// "65536 forms ...".
std::string limit() {
  return fmt::format("{} forms and perturbations in all, counting each use of a named body",
                     kMostQuadrics);
}

Body united(std::vector<Body> parts) {
  if (parts.size() == 1) return std::move(parts.front());
  return {BodyOp::join, std::move(parts)};
}

}  // namespace

BodyReader::BodyReader(const TomlTable& root) : named_(root.table("body")) {
  if (named_ == nullptr) return;
  for (const TomlValue& member : named_->members) {
    if (done_.contains(member.key)) continue;
    open_ = {member.key};
    done_[member.key] = united(read_all(*named_, member.key));
  }
  open_.clear();
}

Body BodyReader::read(const TomlTable& table) {
  const bool shape = table.has("shape"), use = table.has("use"), op = table.has("op");
  if (int(shape) + int(use) + int(op) != 1) {
    if (!shape && !use && !op) table.fail("shape", "a shape, or use = a named body, or an op");
    table.fail(use ? "use" : "op", "only one of shape, use and op");
  }
  if (op) return placed(read_tree(table), table);
  if (use) return placed(read_used(table), table);
  const FreeForm form = read_form(table);
  quadrics_ += count_quadrics(form);
  if (quadrics_ > kMostQuadrics) throw Error(table.where + ": there are more than " + limit());
  return placed(form, table);
}

std::vector<Body> BodyReader::read_all(const TomlTable& parent, std::string_view key) {
  std::vector<Body> bodies;
  for (const TomlTable* table : parent.tables(key)) bodies.push_back(read(*table));
  return bodies;
}

Body BodyReader::read_used(const TomlTable& table) {
  table.allow_only({"use", "steepness", "scale", "rotate", "translate"});
  const std::string name = *table.string("use");
  if (named_ == nullptr || !named_->has(name)) {
    table.fail("use", "the name of a body that the file defines as [[body.NAME]]");
  }
  if (std::find(open_.begin(), open_.end(), name) != open_.end()) {
    table.fail("use", "a body that does not contain this one");
  }
  if (open_.size() >= std::size_t(kDeepestTree)) {
    table.fail("use", fmt::format("at most {} bodies that use one another", kDeepestTree));
  }
  if (const auto known = done_.find(name); known != done_.end()) {
    quadrics_ += count_quadrics(known->second);
  } else {
    open_.push_back(name);
    done_[name] = united(read_all(*named_, name));
    open_.pop_back();
  }
  // Uses of nothing would cost nothing of the limit below, and double without end.
  if (count_quadrics(done_[name]) == 0) table.fail("use", "a body with a form");
  if (quadrics_ > kMostQuadrics) table.fail("use", "at most " + limit());
  return done_[name];
}

Body BodyReader::read_tree(const TomlTable& table) {
  table.allow_only({"op", "part", "steepness", "scale", "rotate", "translate"});
  const std::string op = *table.word("op", {"union", "intersection", "difference"});
  std::vector<Body> parts = read_all(table, "part");
  if (parts.empty()) table.fail("part", "at least one part");
  return {op == "union"          ? BodyOp::join
          : op == "intersection" ? BodyOp::intersection
                                 : BodyOp::difference,
          std::move(parts)};
}

Quadric read_mask(const TomlTable& table) {
  const Shape shape = read_shape(table, Role::mask);
  return read_steepness(table) * shape.to_distance * shape.quadric;
}

}  // namespace pvol::formats
