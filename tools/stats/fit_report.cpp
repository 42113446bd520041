#include "stats/fit_report.h"

#include <fmt/format.h>

#include <cmath>
#include <iostream>

#include "cli/json.h"
#include "pvol/error.h"
#include "pvol/volume/make_volume.h"
#include "stats/shell_report.h"

namespace pvol::cli {
namespace {

std::uint64_t count_nodes(const Pyramid& p) {
  std::uint64_t n = 0;
  for (const auto& level : p.levels) n += level.size();
  return n;
}

std::size_t count_leaves(const Pyramid& p) { return p.empty() ? 0 : p.levels[0].size(); }
std::size_t depth(const Pyramid& p) { return p.empty() ? 0 : p.levels.size() - 1; }
Vec3l extent(const Pyramid& p) { return p.empty() ? Vec3l{} : p.support_hi - p.support_lo; }
Vec3d extent_world(const Fit& f) {
  if (f.file.pyramid.empty()) return {};
  return transform(f.loaded.grid.index_to_world, f.file.pyramid.support()).extent();
}

/// How far samples are off the exact ones.
std::string error_text(const QuantisationError& e) {
  if (e.absolute == 0) return ", exact for this cloud";
  return fmt::format(", biased: samples are off by up to {}, their sum by {} %",
                     readable(e.absolute), readable(100 * e.mass));
}

}  // namespace

void print_text(const FitOptions& o, const Fit& f) {
  const Pyramid& p = f.file.pyramid;
  const formats::GridReport& r = f.loaded.report;
  const formats::PvolSizes& bytes = f.bytes;
  const Vec3l cells = extent(p);
  const Vec3d world = extent_world(f);
  std::cout << fmt::format(
      "grid    {} ({}), {}largest density {}\n", r.grid, r.type,
      o.closed_form ? "" : fmt::format("{} active voxels, ", readable_count(r.active)),
      readable(double(o.closed_form ? p.scale : r.largest)));
  std::cout << fmt::format("support {} x {} x {} voxels, {} x {} x {} world units\n", cells.x,
                           cells.y, cells.z, readable(world.x), readable(world.y),
                           readable(world.z));
  std::cout << fmt::format("bounds  {} leaves of 8^3 voxels, {} nodes, octree depth {}\n",
                           readable_count(count_leaves(p)), readable_count(count_nodes(p)),
                           depth(p));
  if (f.file.codes) {
    std::cout << fmt::format("density {}{}\n", o.density, error_text(f.file.codes->error));
  }
  for (std::size_t i = 0; i < f.fields.size(); ++i) {
    const formats::GridReport& field = f.fields[i];
    std::cout << fmt::format("field   {} ({}), {} active voxels, largest value {}, {} leaves\n",
                             field.grid, field.type, readable_count(field.active),
                             readable(double(field.largest)),
                             readable_count(count_leaves(f.file.fields[i].pyramid)));
  }
  if (f.file.shell) print_shell(std::cout, *f.file.shell, bytes.shell, "shell   ");
  std::cout << f.check
            << fmt::format(
                   "bytes   {}: bounds {}, micro-bounds {}, shell {}, density {}, {}"
                   "header and metadata {}; the source has {}\n",
                   readable_bytes(bytes.total), readable_bytes(bytes.bounds),
                   readable_bytes(bytes.micro), readable_bytes(bytes.shell),
                   readable_bytes(bytes.density),
                   f.fields.empty() ? "" : "fields " + readable_bytes(bytes.fields) + ", ",
                   readable_bytes(bytes.header + bytes.metadata), readable_bytes(f.source_bytes))
            << fmt::format("time    read {}, bounds {}, shell {}, write {}\n",
                           readable_seconds(f.read_seconds), readable_seconds(f.bounds_seconds),
                           readable_seconds(f.shell_seconds), readable_seconds(f.write_seconds))
            << fmt::format("wrote   {}\n", o.output.string());
}

void print_line(const FitOptions& o, const Fit& f, const std::string& label) {
  const double seconds = f.read_seconds + f.bounds_seconds + f.shell_seconds + f.write_seconds;
  std::cout << fmt::format("{}: {} leaves of 8^3 voxels, {}, in {}; wrote {}", label,
                           readable_count(count_leaves(f.file.pyramid)),
                           readable_bytes(f.bytes.total), readable_seconds(seconds),
                           o.output.string())
            << std::endl;  // at once: it tells how far the sequence has come
}

void print_json(const FitOptions& o, const Fit& f) {
  const Pyramid& p = f.file.pyramid;
  const formats::GridReport& r = f.loaded.report;
  const Vec3l cells = extent(p);
  const Vec3d world = extent_world(f);
  Json j;
  if (o.frames.any()) j["frame"] = *o.frames.frame;
  j["input"] = o.input.string();
  j["output"] = o.output.string();
  j["grid"] = {{"name", r.grid},
               {"type", r.type},
               {"active_voxels", r.active},
               {"non_finite", r.non_finite},
               {"negative", r.negative},
               {"largest", o.closed_form ? p.scale : r.largest}};
  j["support_voxels"] = {cells.x, cells.y, cells.z};
  j["support_world"] = {world.x, world.y, world.z};
  j["fields"] = Json::array();
  for (std::size_t i = 0; i < f.fields.size(); ++i) {
    j["fields"].push_back({{"name", f.fields[i].grid},
                           {"type", f.fields[i].type},
                           {"active_voxels", f.fields[i].active},
                           {"largest", f.fields[i].largest},
                           {"leaves", count_leaves(f.file.fields[i].pyramid)}});
  }
  j["bounds"] = {{"leaves", count_leaves(p)}, {"nodes", count_nodes(p)}, {"depth", depth(p)}};
  j["density"] = {{"precision", o.closed_form ? "reference" : o.density}};
  if (f.file.codes) {
    const QuantisationError& e = f.file.codes->error;
    j["density"]["absolute_error"] = e.absolute;
    j["density"]["relative_error"] = e.relative;
    j["density"]["mass_error"] = e.mass;
    if (o.density == "fpn") j["density"]["tolerance"] = f.file.codes->how.tolerance;
  }
  if (!f.check.empty()) j["check"] = f.check;
  if (f.file.shell) j["shell"] = to_json(*f.file.shell, f.bytes.shell);
  j["bytes"] = {{"header", f.bytes.header}, {"metadata", f.bytes.metadata},
                {"bounds", f.bytes.bounds}, {"micro", f.bytes.micro},
                {"shell", f.bytes.shell},   {"density", f.bytes.density},
                {"fields", f.bytes.fields}, {"padding", f.bytes.padding()},
                {"total", f.bytes.total},   {"source", f.source_bytes}};
  j["seconds"] = {{"read", f.read_seconds},
                  {"bounds", f.bounds_seconds},
                  {"shell", f.shell_seconds},
                  {"write", f.write_seconds}};
  j["warnings"] = warnings(o, f);
  std::cout << to_text(j);
}

std::vector<std::string> warnings(const FitOptions& o, const Fit& f) {
  std::vector<std::string> all = f.loaded.report.warnings;
  const auto doubt = [&](std::string text) {
    all.push_back(fmt::format("{}: {}", o.input.string(), std::move(text)));
  };
  if (f.file.pyramid.empty() && f.fields.empty())
    doubt("the density is 0 everywhere, so the cloud is invisible");
  if (f.file.codes) {
    constexpr double kMostMass = 0.01;
    const QuantisationError& e = f.file.codes->error;
    if (std::abs(e.mass) > kMostMass) {
      doubt(fmt::format(
          "--density {} changes the cloud's mass by {} %, because most of the density is below the "
          "largest error; {}",
          o.density, readable(100 * e.mass),
          o.density == "fpn" ? "lower --density-tolerance, or use fp16" : "use fp16 or fp32"));
    }
    if (e.absolute == 0 && o.density == "fp16" && f.loaded.report.type == "half") {
      doubt(
          "its samples are halves already: --density fp32 is exact as well, and often needs fewer "
          "bytes");
    }
  }
  if (f.file.shell && o.shells != "auto") {
    const std::size_t made = f.file.shell->form.perturbations.size();
    if (made < std::size_t(std::stoi(o.shells))) {
      doubt(
          fmt::format("the shell has {} of {} perturbations: no further one removes an empty cell",
                      made, o.shells));
    }
  }
  try {
    validate_placement(f.loaded.grid.index_to_world, f.file.pyramid);
  } catch (const Error& e) {
    doubt(fmt::format("it cannot be rendered at its place in the world: {}", e.what()));
  }
  return all;
}

}  // namespace pvol::cli
