#include "pvol/render/cost_map.h"

#include <algorithm>
#include <numeric>

#include "pvol/render/render.h"
#include "render/film/adaptive_samples.h"
#include "render/path/path_setup.h"
#include "render/plan/forecast.h"
#include "render/scene/small_picture.h"

namespace pvol {
namespace {

/// The scene in a small picture.
Scene small_scene(const RenderPlan& plan, int cells) {
  Scene s = plan.scene;
  RenderOptions& o = s.options;
  o = detail::in_small(o, cells);
  o.samples = kPilot;
  o.noise.reset(), o.time.reset();
  o.first_sample = 0;
  o.kernel = KernelKind::automatic;  // counting may want another than the picture
  o.aovs = {};
  o.aovs.add(Aov::collisions);
  o.deep = false;
  return s;
}

/// Samples that each pixel of the small picture stands for.
std::vector<double> samples_of(const Film& film, const RenderOptions& o) {
  if (!is_adaptive(o)) return std::vector(film.pixels.size(), double(o.samples));
  const AdaptiveSamples needs = detail::find_adaptive_samples(film, o.noise);
  std::vector<double> all;
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    const double wanted = o.noise ? needs.samples[detail::colour_of(film, i)] : expected_samples(o);
    all.push_back(std::max(double(kPilot), double(needs.share[i]) * wanted));
  }
  return all;
}

/// What a sample costs in each pixel, in nanoseconds: kernels that follow many paths at once save
/// more on the paths than on what a sample takes in any case (tests/bench/FARM.md).
std::vector<double> costs_of(const Film& film, KernelKind kernel) {
  const double in_any_case = kernel == KernelKind::scalar ? detail::kSampleCost : 110;
  const double share = detail::share_of_time(kernel);
  std::vector<double> all;
  for (const float scalar : detail::sample_costs(film)) {
    all.push_back(in_any_case + share * (double(scalar) - detail::kSampleCost));
  }
  return all;
}

}  // namespace

PixelRect rendered_part(const RenderOptions& options) {
  const detail::ImagePart p = detail::image_part(options);
  return {p.x, p.y, p.width, p.height};
}

CostMap map_cost(const RenderPlan& plan, int cells) {
  const RenderOptions& large = plan.scene.options;
  const Scene scene = small_scene(plan, cells);
  const double paths = double(large.width) * large.height * expected_samples(large);
  const Film film =
      render(pvol::plan(plan.volumes, scene, {.force = true, .forecast = false, .paths = paths}))
          .film;
  CostMap map;
  map.cell_width = double(large.width) / film.width;
  map.cell_height = double(large.height) / film.height;
  map.left = film.x * map.cell_width;
  map.top = film.y * map.cell_height;
  map.columns = film.crop_width;
  map.rows = film.crop_height;
  const std::vector<double> costs = costs_of(film, plan.kernel.kind);
  const std::vector<double> samples = samples_of(film, large);
  const double mean = std::accumulate(costs.begin(), costs.end(), 0.0) / double(costs.size());
  const double unit = map.cell_width * map.cell_height / mean;
  for (std::size_t i = 0; i < costs.size(); ++i) {
    map.work.push_back(unit * costs[i] * samples[i]);
    if (is_adaptive(large)) map.pilot_work.push_back(unit * costs[i] * kPilot);
  }
  return map;
}

CostSums::CostSums(const CostMap& map, const std::vector<double>& work)
    : left_(map.left),
      top_(map.top),
      cell_width_(map.cell_width),
      cell_height_(map.cell_height),
      columns_(map.columns),
      rows_(map.rows),
      below_(std::size_t(map.columns + 1) * std::size_t(map.rows + 1)) {
  const auto corner = [&](int i, int j) -> double& {
    return below_[std::size_t(j) * std::size_t(columns_ + 1) + std::size_t(i)];
  };
  for (int j = 0; j < rows_; ++j) {
    double row = 0;
    for (int i = 0; i < columns_; ++i) {
      row += work[std::size_t(j) * std::size_t(columns_) + std::size_t(i)];
      corner(i + 1, j + 1) = corner(i + 1, j) + row;
    }
  }
}

double CostSums::of(const PixelRect& p) const {
  const double right = p.x + p.width, bottom = p.y + p.height;
  return before(right, bottom) - before(p.x, bottom) - before(right, p.y) + before(p.x, p.y);
}

double CostSums::before(double x, double y) const {
  const double u = std::clamp((x - left_) / cell_width_, 0.0, double(columns_));
  const double v = std::clamp((y - top_) / cell_height_, 0.0, double(rows_));
  const int i = std::min(int(u), columns_ - 1), j = std::min(int(v), rows_ - 1);
  const double a = u - i, b = v - j;
  const double* const c = &below_[std::size_t(j) * std::size_t(columns_ + 1) + std::size_t(i)];
  const double* const d = c + columns_ + 1;
  return (1 - b) * ((1 - a) * c[0] + a * c[1]) + b * ((1 - a) * d[0] + a * d[1]);
}

}  // namespace pvol
