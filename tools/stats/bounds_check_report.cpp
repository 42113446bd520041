// Wrong bounds, named.
#include <fmt/format.h>

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

std::string text(Vec3l p) { return fmt::format("({}, {}, {})", p.x, p.y, p.z); }
std::string text(Vec3d p) { return fmt::format("({:.4g}, {:.4g}, {:.4g})", p.x, p.y, p.z); }

std::string range(float lo, float hi) {
  return fmt::format("[{:.4g}, {:.4g}]", double(lo), double(hi));
}

Box world_box(const WrongBound& w, const Affine& index_to_world) {
  return transform(index_to_world, Box{Vec3d(w.lo_cell), Vec3d(w.hi_cell)});
}

std::array<std::int64_t, 3> array(Vec3l v) { return {v.x, v.y, v.z}; }
std::array<double, 3> array(Vec3d v) { return {v.x, v.y, v.z}; }

}  // namespace

std::string describe(const WrongBound& w, const Affine& index_to_world) {
  const Box world = world_box(w, index_to_world);
  std::string s =
      fmt::format("{} of depth {}, cells {} to {}, world {} to {}: ", name(w.kind), w.depth,
                  text(w.lo_cell), text(w.hi_cell), text(world.lo), text(world.hi));
  const double found = double(w.found_hi), stored = double(w.stored_hi);
  if (w.kind == WrongBound::Kind::missing) {
    return s + fmt::format("no bounds, but density up to {:.4g}", found);
  }
  s += fmt::format("stored {}, samples in {}", range(w.stored_lo, w.stored_hi),
                   range(w.found_lo, w.found_hi));
  if (found > stored)
    s += fmt::format(", majorant {:.4g} % too low", 100 * (found - stored) / found);
  if (w.stored_lo > w.found_lo) {
    const double lo = double(w.stored_lo);
    s += fmt::format(", minorant {:.4g} % too high", 100 * (lo - double(w.found_lo)) / lo);
  }
  if (w.kind == WrongBound::Kind::uniform && w.found_lo != w.found_hi) s += ", not uniform";
  return s;
}

std::string describe(const WrongSupport& w) {
  return fmt::format(
      "density outside the box of the support: stored cells {} to {}, density in {} to {}",
      text(w.stored_lo), text(w.stored_hi), text(w.found_lo), text(w.found_hi));
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
