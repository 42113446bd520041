// The lane kernels against flights one by one, and against themselves.
#include "render/engine/wavefront/wavefront.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "pvol/math/direction.h"
#include "render/engine/wavefront/phase_batch.h"
#include "render/plan/choose_wavefront.h"
#include "support/lit_scenes.h"
#include "support/messages.h"
#include "support/pictures.h"
#include "support/simd_kernels.h"
#include "support/traced_picture.h"
#include "support/wavefront_shots.h"

namespace pvol::test {
namespace wavefront_test {

/// What the guide's cases lack.
std::vector<Case> more_cases() {
  std::vector<Case> all;
  const auto add = [&](const std::string& name, const auto& change) {
    CloudScene s = sunny();
    change(s);
    all.push_back({name, s});
  };
  add("nearest", [](CloudScene& s) { s.options.look_up = LookUp::nearest; });
  add("micro-bounds of cells",
      [](CloudScene& s) { s.options.micro_bounds = MicroBoundsUse::edge_1; });
  add("micro-bounds of 2^3",
      [](CloudScene& s) { s.options.micro_bounds = MicroBoundsUse::edge_2; });
  add("no micro-bounds", [](CloudScene& s) { s.options.micro_bounds = MicroBoundsUse::none; });
  add("two lobes", [](CloudScene& s) {
    s.medium.others = {{0.999, Rgb(0.99f), TwoLobes{}, Rgb(0.0f)}};
  });
  add("narrow lobes, as many forward as backward", [](CloudScene& s) {
    const TwoLobes lobes{HenyeyGreenstein(0.8), HenyeyGreenstein(-0.8), 0.5};
    s.medium.others = {{0.999, Rgb(0.99f), lobes, Rgb(0.0f)}};
  });
  add("skewed and turned", [](CloudScene& s) {
    s.medium.object_to_world =
        Affine{{Vec3d{0.02, 0.004, 0}, {0, 0.03, -0.01}, {0.005, 0, 0.025}}, {7, -3, 2}};
    s.medium.extinction = 16;
  });
  // Shadow rays of very different lengths, most of which pass through null collisions.
  add("a lamp within and one far away", [](CloudScene& s) {
    s.lights = {PointLight{{9, 9, 9}, Rgb(20.0f)}, PointLight{{60, 70, 80}, Rgb(9e3f)}};
    s.environment = ConstantSky{Rgb(0.0f)};
    s.options.transmittance = Transmittance::analog;
  });
  add("shadow rays by ratio",
      [](CloudScene& s) { s.options.transmittance = Transmittance::ratio; });
  add("shadow rays by ratio, to a lamp within", [](CloudScene& s) {
    s.options.transmittance = Transmittance::ratio;
    s.options.look_up = LookUp::nearest;
    s.lights = {PointLight{{9, 9, 9}, Rgb(20.0f)}};
  });
  add("absorbing", [](CloudScene& s) { s.medium.albedo = Rgb(0.0f); });
  // Paths are long, and all they bring is found after many roulettes.
  add("black sky, thick", [](CloudScene& s) {
    s.environment = ConstantSky{Rgb(0.0f)};
    s.medium.extinction = 6;
  });
  return all;
}

/// What may change a path, or what is made of it, though hardly its mean: for comparisons of bytes.
std::vector<Case> further_cases() {
  std::vector<Case> all;
  const auto add = [&](const std::string& name, const auto& change) {
    CloudScene s = sunny();
    change(s);
    all.push_back({name, s});
  };
  add("thin", [](CloudScene& s) { s.medium.extinction = 0.01; });
  add("thick", [](CloudScene& s) {
    s.medium.extinction = 40;
    s.options.max_bounces = 30;
  });
  add("no scattering but once", [](CloudScene& s) { s.options.max_bounces = 1; });
  add("no background", [](CloudScene& s) { s.options.background = false; });
  add("counted", [](CloudScene& s) { s.options.count = true; });
  add("a wide filter", [](CloudScene& s) { s.options.filter = PixelFilter::gaussian; });
  add("a crop of later samples", [](CloudScene& s) {
    s.options.crop_x = 3, s.options.crop_y = 5;
    s.options.crop_width = 9, s.options.crop_height = 7;
    s.options.first_sample = 1000;
  });
  add("all layers", [](CloudScene& s) {
    for (const AovRow& row : kAovs) s.options.aovs.add(row.aov);
  });
  add("deep", [](CloudScene& s) { s.options.deep = true; });
  add("parallel rays", [](CloudScene& s) {
    s.camera = Camera{{8, 8, 60}, {8, 8, 8}};
    s.camera.kind = CameraKind::orthographic;
    s.camera.ortho_scale = 30;
  });
  add("all directions, from within", [](CloudScene& s) {
    s.camera = Camera{{8, 8, 8}, {8, 8, 0}};
    s.camera.kind = CameraKind::latlong;
  });
  add("a lens", [](CloudScene& s) {
    s.camera = Camera{{8, 8, 60}, {8, 8, 8}};
    s.camera.f_stop = 0.02, s.camera.focus_distance = 40;
  });
  add("many lights", [](CloudScene& s) {
    for (int i = 0; i < 40; ++i) {
      s.lights.emplace_back(
          PointLight{direction_on_spiral(i, 40) * 40.0, Rgb(50.0f, 80.0f, 99.0f)});
    }
  });
  add("droplets alone", [](CloudScene& s) {
    s.medium.others = {{0.999, Rgb(1.0f), Droplets(12), Rgb(0.0f)}};
  });
  add("nothing at all", [](CloudScene& s) { s.medium.extinction = 1e-30; });
  return all;
}

/// Every case, guided where it can be and plain, in turns that begin with `first`.
template <class Visit>
void visit_scenes(GuideUse first, const Visit& visit, std::vector<Case> further = {}) {
  std::vector<Case> all = cases();
  for (Case& c : more_cases()) all.push_back(std::move(c));
  for (Case& c : further) all.push_back(std::move(c));
  std::size_t number = 0;
  for (const Case& c : all) {
    std::vector<GuideUse> guides = guides_in_turn(number++, first);
    if (c.scene.options.max_bounces) guides = {GuideUse::off};  // not together
    for (const GuideUse guide : guides) {
      CloudScene scene = c.scene;
      scene.options.guide = guide;
      visit(name_of(c.name, guide), scene);
    }
  }
}

Film render_with(KernelKind kernel, const Volume& v, CloudScene s) {
  s.options.kernel = kernel;
  return render(v, s).film;
}

TEST(WavefrontKernels, HaveTheMeansOfFlightsOneByOne) {
  const std::vector<KernelKind> kernels = simd_kernels();
  if (kernels.empty()) GTEST_SKIP() << "the machine has no SIMD kernel";
  proof::Family family;
  proof::Moments deviations;
  visit_scenes(GuideUse::on, [&](const std::string& name, CloudScene s) {
    s.options.samples = proof::samples(300);
    const Volume v = volume_of(s);
    const Film scalar = render_with(KernelKind::scalar, v, s);
    s.options.samples = proof::samples(600);
    s.options.seed = 2;
    // The narrowest, which may round otherwise, and the widest.
    const bool alone = kernels.size() == 1;
    for (const KernelKind kernel : alone ? kernels : std::vector{kernels.front(), kernels.back()}) {
      const Film lanes = render_with(kernel, v, s);
      const std::string what = name + ", " + pvol::name(kernel);
      compare(scalar, lanes, what, family);
      deviations.add(compare(average(lanes), average(scalar), what + ", again", family));
    }
  });
  add_all_together(deviations, family);
  EXPECT_TRUE(family.passes());
}

TEST(PhaseBatch, AnswerForEachLaneAsItsPhaseFunctionDoes) {
  const std::vector<detail::MediumComponent> all{{0.5f, Rgb(1.0f), Rgb(0.0f), Draine(0.4, 3)},
                                                 {1, Rgb(1.0f), Rgb(0.0f), Droplets(9)}};
  detail::PhaseBatch lanes;
  for (std::uint32_t k = 0; k < detail::kMostLanes; ++k) {
    const Vec3f from(direction_on_spiral(int(k), 16)), to(direction_on_spiral(15 - int(k), 16));
    for (int axis = 0; axis < 3; ++axis)
      lanes.from[axis][k] = from[axis], lanes.to[axis][k] = to[axis];
    lanes.u[k] = float(k) / 16, lanes.azimuth[k] = float(15 - k) / 16;
    lanes.component[k] = k % 2;
  }
  const auto at = [](const float(&v)[3][detail::kMostLanes], std::size_t k) {
    return Vec3f(v[0][k], v[1][k], v[2][k]);
  };
  detail::PhaseBatch found = lanes;
  detail::find_densities(all, detail::kMostLanes, found);
  detail::sample_directions(all, detail::kMostLanes, lanes);
  for (std::size_t k = 0; k < detail::kMostLanes; ++k) {
    const PhaseFunction& phase = all[k % 2].phase;
    EXPECT_EQ(found.pdf[k], pdf_phase(phase, at(found.from, k), at(found.to, k)));
    const PhaseSample s = sample_phase(phase, at(lanes.from, k), lanes.u[k], lanes.azimuth[k]);
    EXPECT_EQ(at(lanes.to, k), s.direction);
    EXPECT_EQ(lanes.pdf[k], s.pdf);
  }
}

TEST(WavefrontKernels, OfEveryWidthGiveTheSameBytes) {
  const std::vector<KernelKind> kernels = fusing_kernels();
  if (kernels.size() < 2) GTEST_SKIP() << "the machine has one SIMD kernel at most";
  visit_scenes(
      GuideUse::off,
      [&](const std::string& name, CloudScene s) {
        s.options.samples = 5;
        const Volume v = volume_of(s);
        const Film a = render_with(kernels[0], v, s), b = render_with(kernels[1], v, s);
        EXPECT_TRUE(same_bytes(a, b)) << name;
        EXPECT_EQ(a.layers.size(), b.layers.size());
        for (std::size_t k = 0; k < a.layers.size(); ++k) {
          EXPECT_EQ(a.layers[k].sums, b.layers[k].sums) << name << ": " << a.layers[k].name;
        }
      },
      further_cases());
}

/// Which samples and pixels are traced together is a matter of threads, passes
/// and crops.
TEST(WavefrontKernels, CompanyChangesNoBit) {
  for (const KernelKind kernel : kernels_to_try()) {
    visit_scenes(GuideUse::on, [&](const std::string& name, CloudScene s) {
      s.options.samples = 20;
      const Volume v = volume_of(s);
      const Film whole = render_with(kernel, v, s);
      CloudScene part = s;
      part.options.threads = 7;
      EXPECT_TRUE(same_bytes(whole, render_with(kernel, v, part))) << name;
      part.options.crop_x = 5, part.options.crop_y = 6;
      part.options.crop_width = 3, part.options.crop_height = 4;
      const Film crop = render_with(kernel, v, part);
      for (int y = 0; y < 4; ++y) {
        for (int x = 0; x < 3; ++x) {
          EXPECT_TRUE(same_bytes(crop.at(x, y), whole.at(5 + x, 6 + y))) << name;
        }
      }
    });
  }
}

TEST(WavefrontKernels, MicroBoundsAndCountsChangeNoBit) {
  for (const KernelKind kernel : simd_kernels()) {
    CloudScene s = sunny();
    s.options.samples = 10;
    s.options.micro_bounds = MicroBoundsUse::none;
    const Volume without = volume_of(s);
    const Film plain = render_with(kernel, without, s);
    for (const MicroBoundsUse use :
         {MicroBoundsUse::edge_2, MicroBoundsUse::edge_1, MicroBoundsUse::codes}) {
      for (const bool count : {false, true}) {
        s.options.micro_bounds = use;
        s.options.count = count;
        EXPECT_TRUE(same_bytes(plain, render_with(kernel, volume_of(s), s)));
      }
    }
  }
}

TEST(WavefrontKernels, CountWhatFlightsOneByOneCount) {
  for (const KernelKind kernel : simd_kernels()) {
    for (const GuideUse guide : {GuideUse::on, GuideUse::off}) {
      CloudScene s = sunny();
      s.options.count = true;
      s.options.guide = guide;
      s.options.samples = 400;
      s.options.transmittance = Transmittance::analog;
      s.options.micro_bounds = MicroBoundsUse::edge_2;
      const Volume v = volume_of(s);
      s.options.kernel = KernelKind::scalar;
      const Counts a = render(v, s).counts;
      s.options.kernel = kernel;
      const RenderResult r = render(v, s);
      const Counts& b = r.counts;
      const auto near = [](std::uint64_t x, std::uint64_t y) {
        return std::abs(double(x) / double(y) - 1) < 0.1;
      };
      EXPECT_PRED2(near, a.collisions, b.collisions);
      EXPECT_PRED2(near, a.shadow_rays, b.shadow_rays);
      // Leaves have bounds as tight as larger cubes, but are not cut off at the
      // support's box.
      EXPECT_LE(b.path.null_collisions, a.path.null_collisions + a.path.null_collisions / 4);
      EXPECT_LE(b.path.lookups, a.path.lookups + a.path.lookups / 20);
      EXPECT_GT(b.path.null_collisions, a.path.null_collisions / 4);
      EXPECT_GT(b.path.lookups, a.path.lookups / 4);
      EXPECT_EQ(b.path.bounds_tests >= b.collisions, true);
      std::uint64_t collisions = 0, lookups = 0, segments = 0;
      for (std::size_t i = 0; i < r.film.pixels.size(); ++i) {
        collisions += r.film.count(i, PixelCounter::collisions);
        lookups += r.film.count(i, PixelCounter::lookups);
        segments += r.film.count(i, PixelCounter::segments);
      }
      EXPECT_EQ(collisions, b.collisions);
      EXPECT_EQ(lookups, b.path.lookups + b.shadow.lookups);
      EXPECT_EQ(segments, b.path.segments + b.shadow.segments);
    }
  }
}

/// The picture of guided paths whose importance is `value(row)` along `axis(row)`, and `away` times
/// that against it.
template <class Value, class Axis>
Average guided_by(KernelKind kernel, const Volume& v, CloudScene s, const Value& value,
                  const Axis& axis, float away) {
  s.options.kernel = kernel;
  s.options.guide = GuideUse::on;
  const RenderPlan p = plan(std::span(&v, 1), s.scene(), {.forecast = false});
  detail::PathSetup setup(p);
  detail::CoarseCells cells = detail::make_coarse_cells(v);
  PagedVector<detail::Importance::Row> rows(cells.count());
  detail::LightAxes axes;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    for (std::size_t j = 0; j < detail::kDirectionNodes; ++j) {
      rows[k].at[j] = value(k) * std::lerp(1.0f, away, float(j) / (detail::kDirectionNodes - 1));
    }
    axes.by_row.push_back(axis(k));
  }
  std::vector<float> importances(rows.size() * (setup.light.sources.size() + 1), 1.0f);
  setup.importance = std::make_shared<const detail::Importance>(
      std::move(cells), std::move(axes), HenyeyGreenstein(0.5), std::move(rows),
      std::move(importances));
  return average(traced_picture(setup, s.options));
}

/// Where importance jumps from cell to cell, paths go through a roulette or are
/// split at every turn, and are turned towards another side.
TEST(WavefrontKernels, WeightsOutliveAnyImportance) {
  const std::vector<KernelKind> kernels = simd_kernels();
  if (kernels.empty()) GTEST_SKIP() << "the machine has no SIMD kernel";
  proof::Family family;
  for (const Rgb albedo : {Rgb(0.99f), Rgb(0.99f, 0.9f, 0.95f)}) {  // one lobe, any medium
    CloudScene s = sunny();
    s.medium.g = 0;
    s.medium.albedo = albedo;
    s.options.samples = proof::samples(20'000);
    const Volume v = volume_of(s);
    const auto even = [](std::size_t) { return 1.0f; };
    const auto up = [](std::size_t) { return Vec3f(0, 1, 0); };
    const Average flat = guided_by(kernels.back(), v, s, even, up, 1);
    s.options.seed = 2;
    const auto jumps = [](std::size_t row) {
      constexpr float kValues[] = {0.25f, 1, 4};
      return kValues[mix64(row) % 3];
    };
    const auto anywhere = [](std::size_t row) {
      return Vec3f(direction_on_spiral(int(mix64(row) % 512), 512));
    };
    for (const float away : {1.0f, 0.1f}) {
      const Average jumping = guided_by(kernels.back(), v, s, jumps, anywhere, away);
      compare(jumping, flat,
              "albedo " + std::to_string(albedo.y) + ", away " + std::to_string(away), family);
    }
  }
  EXPECT_TRUE(family.passes());
}

TEST(WavefrontKernels, BouncesAreLimited) {
  for (const KernelKind kernel : simd_kernels()) {
    proof::Family family;
    for (const std::uint32_t limit : {0u, 1u, 3u}) {
      CloudScene s = sunny();
      s.options.guide = GuideUse::off;
      s.options.max_bounces = limit;
      s.options.samples = proof::samples(400);
      const Volume v = volume_of(s);
      compare(render_with(KernelKind::scalar, v, s), render_with(kernel, v, s),
              "limit " + std::to_string(limit), family);
    }
    EXPECT_TRUE(family.passes());
  }
}

TEST(ChooseWavefront, FlightsGoOneByOneWhereLanesDoNotServeAndItIsSaid) {
  CloudScene s = sunny();
  s.options.tracker = Tracker::delta;
  const std::vector<Volume> volumes = make_volumes(puff(), std::vector{s.medium}, s);
  for (const KernelKind kernel : simd_kernels()) {
    s.options.kernel = kernel;
    const RenderPlan p = plan(volumes, s.scene(), {.forecast = false});
    EXPECT_EQ(p.kernel.kind, kernel);
    EXPECT_TRUE(says(p.one_by_one.front(), "plan.tracker_not_decomposition"));
  }
}

}  // namespace wavefront_test
}  // namespace pvol::test
