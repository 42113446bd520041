#include "extremes/extremes.h"

#include <algorithm>
#include <future>

#include "extremes/probes.h"
#include "pvol/error.h"

namespace pvol::extremes {
namespace {

/// `work`, or its refusal.
Outcome attempt(const std::function<Outcome()>& work) {
  try {
    return work();
  } catch (const Error& e) {
    return {Verdict::refused, e.what()};
  }
}

const char* mark(Verdict v) {
  switch (v) {
    case Verdict::exact:
      return "=";
    case Verdict::within:
      return "~";
    case Verdict::refused:
      return "x";
    case Verdict::wrong:
      break;
  }
  return "WRONG";
}

/// Outcomes of a quantity by decade.
using Row = std::vector<Outcome>;

Row outcomes(const Quantity& q) {
  Row row;
  for (int d = kFirstDecade; d <= kLastDecade; ++d) row.push_back(worst(q, d));
  return row;
}

/// Of all quantities, several at a time.
std::vector<Row> all_outcomes() {
  std::vector<std::future<Row>> rows;
  for (const Quantity& q : quantities()) rows.push_back(std::async([&q] { return outcomes(q); }));
  std::vector<Row> all;
  for (std::future<Row>& row : rows) all.push_back(row.get());
  return all;
}

/// What each end of a row refuses, once.
std::string refusals(const Quantity& q, const Row& row) {
  std::string text;
  for (const int way : {-1, 1}) {
    for (int d = way; d >= kFirstDecade && d <= kLastDecade; d += way) {
      const Outcome& o = row[std::size_t(d - kFirstDecade)];
      if (o.verdict != Verdict::refused) continue;
      text += "* " + q.name + ", from decade " + std::to_string(d) + ": " + o.note + "\n";
      break;
    }
  }
  return text;
}

}  // namespace

const std::vector<Setting>& settings() {
  static const std::vector<Setting> all = {
      {.name = "decomposition, ratio"},
      {.name = "decomposition, analog, micro-bounds of cells",
       .transmittance = Transmittance::analog,
       .micro_bounds = MicroBoundsUse::edge_1},
      {.name = "decomposition, residual ratio, nearest, micro-bounds",
       .transmittance = Transmittance::residual_ratio,
       .look_up = LookUp::nearest,
       .micro_bounds = MicroBoundsUse::edge_2},
      {.name = "delta, analog", .tracker = Tracker::delta, .transmittance = Transmittance::analog},
      {.name = "one majorant", .tracker = Tracker::delta_global},
      {.name = "weighted delta", .tracker = Tracker::weighted_delta},
      {.name = "weighted decomposition", .tracker = Tracker::weighted_decomposition},
      {.name = "regular", .tracker = Tracker::regular, .transmittance = Transmittance::regular},
      {.name = "tricubic", .look_up = LookUp::tricubic},
      {.name = "guided", .guide = GuideUse::on},
      {.name = "two volumes", .volumes = 2},
      {.name = "with a shell", .shell = true},
  };
  return all;
}

const std::vector<Quantity>& quantities() {
  static const std::vector<Quantity> all = {
      {"size of the world", "cloud, camera and free paths grow together: the same picture",
       world_unit},
      {"unit of density", "samples grow as extinction falls: the same picture", density_unit},
      {"brightness of lights", "the same picture, as many times as bright", brightness},
      {"distance from the origin, in voxels", "cloud and camera move together: the same picture",
       offset},
      {"optical depth of a voxel",
       "opacity of a cube of 16 voxels: 1 - exp(-16 times that); trackers alone are right up to "
       "1e12, "
       "see tests/track/flight_test.cpp",
       voxel_depth},
      {"length of the camera's way, in voxels", "opacity of the cube: 1 - exp(-2)",
       camera_distance},
      {"length of voxels over their width", "opacity across them: 1 - exp(-2)", flatness},
      {"mean cosine of scattering", "a cloud that absorbs nothing under a sky of 1: 1", cosine,
       true, cosine_text},
      {"albedo", "a cloud that emits 1 - albedo under a sky of 1: 1", albedo, true, albedo_text},
      {"voxel of a .pvol file", "the map comes back to the last bit", pvol_voxel, false},
      {"voxel of a .vdb file", "the map comes back to the last bit", vdb_voxel, false},
  };
  return all;
}

Outcome worst(const Quantity& quantity, int decade) {
  Outcome worst;
  for (const Setting& s : settings()) {
    Outcome o = attempt([&] { return quantity.at(decade, s); });
    if (o.verdict > worst.verdict) {
      if (quantity.of_settings && o.verdict != Verdict::refused) o.note = s.name + ": " + o.note;
      worst = std::move(o);
    }
    if (!quantity.of_settings) break;
  }
  return worst;
}

std::string page() {
  const std::vector<Row> rows = all_outcomes();
  std::string text =
      "# Extremes\n\nOne row for each quantity, one column for each power of ten of it.\n\n"
      "* `=`: to the last bit what it is at 1, or the closed form to 1e-6\n"
      "* `~`: the same but for rounding and chance\n* `x`: refused, with the reason below\n\n"
      "Written by the program `extremes` of tests/extremes; `ctest -R Extremes` compares. Each "
      "mark "
      "is the worst of these\nways to render:\n\n";
  for (const Setting& s : settings()) text += "* " + s.name + "\n";
  text += "\n| |";
  std::string line = "|---|";
  for (int d = kFirstDecade; d <= kLastDecade; ++d) {
    text += ' ' + std::to_string(d) + " |";
    line += "---|";
  }
  text += "\n" + line + "\n";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    text += "| " + quantities()[i].name + " |";
    for (const Outcome& o : rows[i]) text += std::string(" ") + mark(o.verdict) + " |";
    text += "\n";
  }
  text += "\nWhat a row compares:\n\n";
  for (const Quantity& q : quantities()) {
    text += "* " + q.name + ": " + q.about + ".";
    for (const int d : {-15, -1, 0, 1, 4, 15}) {
      if (!q.value) break;
      text += (d == -15 ? " Decade " : ", ") + std::to_string(d) + " is " + q.value(d);
    }
    text += "\n";
  }
  text += "\nRefusals:\n\n";
  for (std::size_t i = 0; i < rows.size(); ++i) text += refusals(quantities()[i], rows[i]);
  return text;
}

}  // namespace pvol::extremes
