#include "pvol/render/placement.h"

#include <numbers>

#include "pvol/math/moving_map.h"

namespace pvol {
namespace {

Affine rotation(const Turn& turn) {
  return rotation_about(normalize(turn.axis), turn.degrees * (std::numbers::pi / 180));
}

double number_at(const Value& list, std::size_t i) { return *(*list.list())[i].number(); }

}  // namespace

Affine Placement::map() const {
  if (matrix) return *matrix;
  Affine map;
  if (scale) map = scaling(*scale);
  for (const Turn& turn : rotate) map = rotation(turn) * map;
  if (translate) map = translation(*translate) * map;
  return map;
}

const char* expect_axes(const Value& value) {
  Placement p;
  assign_turns(p, value);
  for (const Turn& turn : p.rotate) {
    if (!is_finite(normalize(turn.axis))) return "an axis that is not zero";
  }
  return nullptr;
}

const char* expect_affine(const Value& value) {
  if (value.list()->size() == 12) return nullptr;
  const bool affine = number_at(value, 12) == 0 && number_at(value, 13) == 0 &&
                      number_at(value, 14) == 0 && number_at(value, 15) == 1;
  return affine ? nullptr : "a last row of 0, 0, 0, 1, with the translation in the last column";
}

Value turns_value(const Placement& p) {
  if (p.rotate.empty()) return {};
  Value::List rows;
  for (const Turn& t : p.rotate) {
    rows.push_back(Value::List{t.axis.x, t.axis.y, t.axis.z, t.degrees});
  }
  return rows;
}

void assign_turns(Placement& p, const Value& value) {
  p.rotate.clear();
  const bool several = value.list()->front().list() != nullptr;
  for (const Value& row : several ? *value.list() : Value::List{value}) {
    p.rotate.push_back(
        {{number_at(row, 0), number_at(row, 1), number_at(row, 2)}, number_at(row, 3)});
  }
}

Value matrix_value(const Placement& p) {
  if (!p.matrix) return {};
  Value::List numbers;
  for (int row = 0; row < 3; ++row) {
    const Vec3d r = p.matrix->m[std::size_t(row)];
    for (const double v : {r.x, r.y, r.z, p.matrix->t[row]}) numbers.emplace_back(v);
  }
  return numbers;
}

void assign_matrix(Placement& p, const Value& value) {
  Affine& map = p.matrix.emplace();
  for (std::size_t row = 0; row < 3; ++row) {
    map.m[row] = {number_at(value, row * 4), number_at(value, row * 4 + 1),
                  number_at(value, row * 4 + 2)};
    map.t[int(row)] = number_at(value, row * 4 + 3);
  }
}

std::optional<Misfit> misfit(const Placement& p) {
  if (p.matrix && (p.scale || !p.rotate.empty() || p.translate)) {
    return Misfit{{"scale", "rotate", "translate"},
                  "either matrix, or scale, rotate and translate"};
  }
  const Affine back = inverse(p.map());
  if (is_finite(back.m[0]) && is_finite(back.m[1]) && is_finite(back.m[2])) return std::nullopt;
  return Misfit{{"matrix", "scale"}, "an invertible placement, with no scale of 0"};
}

}  // namespace pvol
