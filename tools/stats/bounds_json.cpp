// The report of the verb `bounds` for scripts.
#include "stats/bounds_report.h"

namespace pvol::cli {
namespace {

Json json_of(const CollisionCost& c) { return {{"even", c.even}, {"dense", c.dense}}; }

Json json_of(const ClassStatistics& c) {
  return {{"leaves", c.leaves}, {"volume_voxels", c.volume}, {"mass", c.mass}};
}

Json json_of(const VolumeFacts& f) {
  return {{"largest_extinction", f.largest_extinction},
          {"shortest_free_path", f.shortest_free_path},
          {"mean_optical_thickness", f.mean_optical_thickness},
          {"largest_optical_thickness", f.largest_optical_thickness},
          {"depth", f.depth}};
}

/// Only the bins between the first and the last that hold something.
Json json_of(const Distribution& d) {
  std::size_t begin = 0, end = Distribution::kBins;
  while (begin < end && d.share[begin] == 0) ++begin;
  while (end > begin && d.share[end - 1] == 0) --end;
  Json shares = Json::array();
  for (std::size_t i = begin; i < end; ++i) shares.push_back(d.share[i]);
  return {{"quantiles", d.quantiles}, {"below", d.below},
          {"above", d.above},         {"first_edge", Distribution::edge(begin)},
          {"bins_per_octave", 4},     {"shares", shares}};
}

Json json_of(const TwoDistributions& d) {
  return {{"by_volume", json_of(d.by_volume)}, {"by_mass", json_of(d.by_mass)}};
}

Json json_of(const measure::PathCosts& c) {
  return {{"lookups", c.lookups.value}, {"lookups_half_width", c.lookups.half_width},
          {"tentative", c.tentative},   {"bounds_tests", c.bounds_tests},
          {"segments", c.segments},     {"collisions", c.counts.collisions}};
}

Json json_of(const measure::Probe& p) {
  return {{"extinction", p.extinction},
          {"volume", json_of(p.facts)},
          {"per_collision",
           {{"delta", json_of(p.delta)},
            {"decomposition", json_of(p.decomposition)},
            {"squeezed", json_of(p.squeezed)}}},
          {"memory_bytes",
           {{"field", p.facts.field_bytes},
            {"octree", p.facts.octree_bytes},
            {"micro_bounds", p.squeezed.micro_bytes}}}};
}

Json depths_of(const BoundsReport& r) {
  Json depths = Json::array();
  for (std::size_t i = 0; i < r.bounds.depths.size(); ++i) {
    const DepthStatistics& d = r.bounds.depths[i];
    const DepthDistributions& more = r.distributions[i];
    depths.push_back({{"depth", d.depth},
                      {"edge_voxels", d.edge},
                      {"nodes", d.nodes},
                      {"leaves", d.leaves},
                      {"mean_hi_over_mean", d.mean_hi},
                      {"mean_lo_over_mean", d.mean_lo},
                      {"majorant_over_mass", json_of(d.tightness.majorant)},
                      {"residual_over_mass", json_of(d.tightness.residual)},
                      {"hi_over_mean", json_of(more.hi)},
                      {"lo_over_mean", json_of(more.lo)},
                      {"gap_over_mean", json_of(more.gap)}});
  }
  return depths;
}

}  // namespace

Json to_json(const BoundsReport& r) {
  const BoundsStatistics& s = r.bounds;
  Json j;
  j["file"] = r.file;
  j["grid"] = r.cloud.report.grid;
  j["largest_density"] = r.cloud.pyramid.scale;
  j["mass"] = s.mass;
  j["depths"] = depths_of(r);
  j["classes"] = {
      {"empty", json_of(s.empty)}, {"uniform", json_of(s.uniform)}, {"mixed", json_of(s.mixed)}};
  j["skipped_share_of_box"] = r.empty_share_of_box;
  j["lookups_per_collision"]["delta_global"] = json_of(s.global_majorant);
  if (!s.depths.empty()) {
    j["lookups_per_collision"]["delta_leaves"] = json_of(s.depths.back().tightness.majorant);
    j["lookups_per_collision"]["decomposition_leaves"] =
        json_of(s.depths.back().tightness.residual);
  }
  if (r.cut) {
    j["lookups_per_collision"]["delta_cut"] = json_of(r.cut->tightness.majorant);
    j["lookups_per_collision"]["decomposition_cut"] = json_of(r.cut->tightness.residual);
    j["extinction"] = r.cut->extinction;
    j["volume"] = json_of(r.cut->facts);
  }
  if (r.probe) j["measured"] = json_of(*r.probe);
  for (const BoundsReport::Field& f : r.fields) {
    j["fields"].push_back({{"name", f.name},
                           {"largest", f.largest},
                           {"leaves", f.leaves},
                           {"majorant_over_mean", f.tightness.majorant.even},
                           {"gap_over_mean", f.tightness.residual.even},
                           {"verified", f.verified}});
  }
  if (r.check) j["verified"] = to_json(*r.check, r.cloud.grid().index_to_world);
  if (r.bytes) {
    j["bytes"] = {
        {"header", r.bytes->header}, {"metadata", r.bytes->metadata}, {"bounds", r.bytes->bounds},
        {"micro", r.bytes->micro},   {"shell", r.bytes->shell},       {"density", r.bytes->density},
        {"fields", r.bytes->fields}, {"padding", r.bytes->padding()}, {"total", r.bytes->total}};
  }
  return j;
}

}  // namespace pvol::cli
