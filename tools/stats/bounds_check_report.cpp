// Wrong bounds, named.
#include <array>

#include "cli/cli.h"
#include "stats/bounds_report.h"

namespace pvol::cli {
namespace {

const char* name(WrongBound::Kind kind) {
  switch (kind) {
    case WrongBound::Kind::leaf:
      return "leaf";
    case WrongBound::Kind::uniform:
      return "uniform cube";
    case WrongBound::Kind::missing:
      break;
  }
  return "missing cube";
}

std::string text(Vec3l p) {
  return '(' + std::to_string(p.x) + ", " + std::to_string(p.y) + ", " + std::to_string(p.z) + ')';
}

std::string text(Vec3d p) {
  return '(' + readable(p.x) + ", " + readable(p.y) + ", " + readable(p.z) + ')';
}

std::string range(float lo, float hi) {
  return '[' + readable(double(lo)) + ", " + readable(double(hi)) + ']';
}

Box world_box(const WrongBound& w, const Affine& index_to_world) {
  return transform(index_to_world, Box{Vec3d(w.lo_cell), Vec3d(w.hi_cell)});
}

std::array<std::int64_t, 3> array(Vec3l v) { return {v.x, v.y, v.z}; }
std::array<double, 3> array(Vec3d v) { return {v.x, v.y, v.z}; }

}  // namespace

std::string describe(const WrongBound& w, const Affine& index_to_world) {
  const Box world = world_box(w, index_to_world);
  std::string s = name(w.kind);
  s += " of depth " + std::to_string(w.depth) + ", cells " + text(w.lo_cell) + " to " +
       text(w.hi_cell) + ", world " + text(world.lo) + " to " + text(world.hi) + ": ";
  if (w.kind == WrongBound::Kind::missing) {
    return s + "no bounds, but density up to " + readable(double(w.found_hi));
  }
  s +=
      "stored " + range(w.stored_lo, w.stored_hi) + ", samples in " + range(w.found_lo, w.found_hi);
  const double found = double(w.found_hi), stored = double(w.stored_hi);
  if (found > stored) s += ", majorant " + readable(100 * (found - stored) / found) + " % too low";
  if (w.stored_lo > w.found_lo) {
    const double lo = double(w.stored_lo);
    s += ", minorant " + readable(100 * (lo - double(w.found_lo)) / lo) + " % too high";
  }
  if (w.kind == WrongBound::Kind::uniform && w.found_lo != w.found_hi) s += ", not uniform";
  return s;
}

std::string describe(const WrongSupport& w) {
  return "density outside the box of the support: stored cells " + text(w.stored_lo) + " to " +
         text(w.stored_hi) + ", density in " + text(w.found_lo) + " to " + text(w.found_hi);
}

Json to_json(const BoundsCheck& check, const Affine& index_to_world) {
  Json j;
  j["holds"] = check.holds();
  j["leaves"] = check.leaves;
  j["uniform_cubes"] = check.uniform;
  j["wrong"] = Json::array();
  for (const WrongBound& w : check.wrong) {
    const Box world = world_box(w, index_to_world);
    j["wrong"].push_back({{"kind", name(w.kind)},
                          {"depth", w.depth},
                          {"cells", {array(w.lo_cell), array(w.hi_cell)}},
                          {"world", {array(world.lo), array(world.hi)}},
                          {"stored", {w.stored_lo, w.stored_hi}},
                          {"found", {w.found_lo, w.found_hi}},
                          {"off", w.off()}});
  }
  if (check.support) {
    const WrongSupport& w = *check.support;
    j["support"] = {{"stored", {array(w.stored_lo), array(w.stored_hi)}},
                    {"found", {array(w.found_lo), array(w.found_hi)}}};
  }
  return j;
}

}  // namespace pvol::cli
