// Lamps asked along flights: how places are drawn, other ways to the same picture, and when it
// pays.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "pvol/render/plan.h"
#include "render/path/lamps_along.h"
#include "render/plan/lamp_trial.h"
#include "support/messages.h"
#include "support/pictures.h"
#include "support/small_cloud.h"

namespace pvol::test {
namespace line_lamps_test {

using detail::EvenAngles;

const Ray kRay{{1, 2, 3}, normalize(Vec3d(1, -2, 0.5))};

TEST(EvenAngles, HaveTheirDensity) {
  for (const Vec3d lamp : {Vec3d(4, -1, 2), Vec3d(0, 0, 0), Vec3d(-30, 40, 7)}) {
    for (const Span span : {Span{0, 8}, Span{2.5, 2.75}, Span{1e-3, 1e4}}) {
      const EvenAngles angles(lamp, kRay, span);
      EXPECT_NEAR(angles.at(0), span.t0, 1e-9 * span.t1);
      EXPECT_NEAR(angles.at(1), span.t1, 1e-6 * span.t1);
      double before = angles.at(0);
      for (int k = 1; k <= 64; ++k) {
        const double share = k / 64.0, t = angles.at(share);
        EXPECT_GT(t, before);
        EXPECT_NEAR(angles.share_up_to(t), share, 1e-9);
        // The density, by the step over which its share grows by a little.
        const double near = angles.at(share - 0.5e-6), far = angles.at(share - 1.5e-6);
        EXPECT_NEAR(angles.pdf(angles.at(share - 1e-6)) * (near - far), 1e-6, 2e-9) << t;
        before = t;
      }
    }
  }
}

TEST(EvenAngles, AreFiniteOnARayThroughTheLamp) {
  const EvenAngles angles(kRay.at(3), kRay, {1, 8});
  for (int k = 0; k <= 64; ++k) {
    const double t = angles.at(k / 64.0);
    EXPECT_TRUE(t > 1 - 1e-6 && t < 8 + 1e-6) << t;
    EXPECT_TRUE(angles.pdf(t) > 0 && std::isfinite(angles.pdf(t))) << t;
  }
}

/// A lamp at the camera of a thin cloud that is very far away sees all of it at a tiny angle.
TEST(EvenAngles, OfALampFarBeforeTheSpanAreEvenByTheSquareOfTheDistance) {
  for (const double far : {1e2, 1e4, 1e6, 1e9}) {
    const EvenAngles angles(kRay.o, kRay, {far, far + 1});
    for (int k = 0; k <= 16; ++k) {
      const double t = angles.at(k / 16.0);
      EXPECT_NEAR(t - far, k / 16.0, 2 / far + 1e-6);
      EXPECT_NEAR(angles.share_up_to(t), k / 16.0, 1e-6);
      EXPECT_NEAR(angles.pdf(t), far * (far + 1) / (t * t), 1e-6);
    }
  }
}

/// Lamps in and around the small cloud, of every kind.
std::vector<Light> lamp_of_kind(int kind) {
  const Vec3d within{4, 3, 2}, beside{24, 20, 12};
  const Rgb color(30.0f, 20.0f, 10.0f);
  switch (kind) {
    case 0:
      return {PointLight{within, color}};
    case 1:
      return {PointLight{beside, color * 10.0f, "", 3}};
    case 2:
      return {
          SpotLight{.position = beside, .direction = within - beside, .intensity = color * 20.0f}};
    case 3:
      return {AreaLight{.position = beside,
                        .direction = within - beside,
                        .size = {4, 3},
                        .radiance = color * 2.0f}};
    case 4:
      return {Sun{{0, 1, 0}, Rgb(0.5f)}, PointLight{within, color}, PointLight{beside, color}};
    default:
      break;
  }
  std::vector<Light> many;
  for (int k = 0; k < 70; ++k) {
    many.push_back(PointLight{{-4.0 + k % 10, -3.0 + k / 10, 5}, color * 0.1f});
  }
  return many;
}
constexpr int kKinds = 6;

CloudScene lit_by(int kind, double extinction) {
  CloudScene s = cloud_scene();
  s.environment = ConstantSky{Rgb(0.01f)};
  s.lights = lamp_of_kind(kind);
  s.medium.extinction = extinction;
  s.medium.albedo = Rgb(0.8f);
  s.medium.g = 0.3;
  return s;
}

Film picture(const Volume& v, CloudScene s, LineLamps lines, std::uint64_t seed) {
  s.options.line_lamps = lines;
  s.options.seed = seed;
  return render({&v, 1}, s).film;
}

TEST(LineLamps, ShowTheSamePicture) {
  proof::Family family;
  std::uint64_t seed = 500, turn = 0;
  for (const double extinction : {0.02, 0.2, 2.0}) {
    ++turn;
    for (int kind = 0; kind < kKinds; ++kind) {
      for (const GuideUse guide : {GuideUse::off, GuideUse::on}) {
        seed += 2;
        if (!proof::has_turn(++turn + std::uint64_t(kind))) continue;
        CloudScene s = lit_by(kind, extinction);
        s.options.samples = proof::samples(600);
        s.options.guide = guide;
        const Volume v = make_volume(cloud().grid, build_pyramid(cloud().grid), s);
        compare(average(picture(v, s, LineLamps::on, seed)),
                average(picture(v, s, LineLamps::off, seed + 1)),
                std::to_string(kind) + " " + std::to_string(extinction), family);
      }
    }
  }
  EXPECT_TRUE(family.passes());
}

/// A bright sun among the lights changes nothing of what flights bring of a lamp, which is all that
/// is red.
TEST(LineLamps, BesideASunBringWhatTheyBringAlone) {
  CloudScene s = lit_by(0, 0.02);
  s.environment = ConstantSky{Rgb(0.0f)};
  s.lights = {PointLight{{4, 3, 2}, Rgb(60.0f, 0.0f, 0.0f)}};
  s.options.samples = proof::samples(8000);
  s.options.guide = GuideUse::off;
  const Volume v = make_volume(cloud().grid, build_pyramid(cloud().grid), s);
  Average alone = average(picture(v, s, LineLamps::on, 30));
  s.lights.push_back(Sun{{0, 1, 0}, Rgb(0.0f, 0.0f, 100.0f)});
  Average beside = average(picture(v, s, LineLamps::on, 31));
  alone.mean.z = alone.variance.z = beside.mean.z = beside.variance.z = 0;
  proof::Family family;
  compare(beside, alone, "red", family);
  EXPECT_TRUE(family.passes());
  EXPECT_LT(std::sqrt(beside.variance.x), 0.03 * beside.mean.x);
}

/// A lamp of each kind over a ground, of three colours; the green one is rarely drawn.
std::vector<Light> colourful_lamps() {
  const Vec3d beside{18, 14, 10};
  return {PointLight{{4, 3, 2}, Rgb(60.0f, 0.0f, 0.0f), "red"},
          PointLight{{-14, -6, 8}, Rgb(400.0f, 0.0f, 0.0f), "red", 1, false},
          SpotLight{.position = beside,
                    .direction = Vec3d(0, 0, 0) - beside,
                    .intensity = Rgb(0.0f, 6.0f, 0.0f),
                    .group = "green"},
          AreaLight{.position = {0, 16, -12},
                    .direction = {0, -1, 0.5},
                    .size = {6, 4},
                    .radiance = Rgb(0.0f, 0.0f, 15.0f),
                    .group = "blue",
                    .visible_camera = false}};
}
constexpr std::array kColours = {"red", "green", "blue"};
constexpr std::array kOrders = {"single", "multiple"};

double total(const Layer& layer, int channel) {
  double sum = 0;
  for (const Vec3d& s : layer.sums) sum += s[channel];
  return sum;
}

/// Of more than two lamps two are drawn, and count for all: each colour is what its one or two
/// lamps bring alone, by the number of scatterings and by group.
TEST(LineLamps, DrawnAmongSeveralBringByOrderWhatTheyBringAlone) {
  CloudScene all = lit_by(0, 0.06);
  all.environment = ConstantSky{Rgb(0.0f)};
  all.surfaces = {PlaneSurface{.point = {0, -16, 0}, .material = {.albedo = Rgb(0.6f)}}};
  all.lights = colourful_lamps();
  all.options.guide = GuideUse::off;
  all.options.aovs = {Aov::lights, Aov::scattering};
  all.options.samples = 200;
  const Volume v = make_volume(cloud().grid, build_pyramid(cloud().grid), all);
  std::array<std::array<proof::Moments, 2>, 3> of_all, of_one;  // by colour and order
  for (std::uint64_t seed = 1; seed <= proof::samples(48u); ++seed) {
    const Film together = picture(v, all, LineLamps::on, seed);
    for (int c = 0; c < 3; ++c) {
      CloudScene one = all;
      std::erase_if(one.lights, [&](const Light& light) {
        return std::visit([&](const auto& l) { return l.group != kColours[std::size_t(c)]; },
                          light);
      });
      const Film alone = picture(v, one, LineLamps::on, 1000 + seed);
      double orders = 0;
      for (std::size_t k = 0; k < kOrders.size(); ++k) {
        const double sum = total(layer(together, kOrders[k]), c);
        of_all[std::size_t(c)][k].add(sum);
        of_one[std::size_t(c)][k].add(total(layer(alone, kOrders[k]), c));
        orders += sum;
      }
      EXPECT_NEAR(total(layer(together, kColours[std::size_t(c)]), c), orders, 1e-5 * orders);
    }
  }
  proof::Family family;
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t k = 0; k < kOrders.size(); ++k) {
      const proof::Moments &a = of_all[c][k], &b = of_one[c][k];
      const double error = std::sqrt(a.variance_of_mean() + b.variance_of_mean());
      const std::string name = std::string(kColours[c]) + ", " + kOrders[k];
      family.add(name, proof::normal_p_value((a.mean() - b.mean()) / error));
      EXPECT_LT(error, (k == 0 ? 0.03 : 0.1) * b.mean()) << name;
    }
  }
  EXPECT_TRUE(family.passes());
}

/// A lamp that stands for a sun, and those at the cloud: it must not take the digits of their
/// places from them, wherever in the list it is.
TEST(LineLamps, FarAwayLeaveThoseNearByTheirPlaces) {
  proof::Family family;
  CloudScene s = lit_by(0, 0.05);
  s.lights = {PointLight{Vec3d(1e8), Rgb(1e17f)}};
  for (const Vec3d near : {Vec3d(14, 2, 0), Vec3d(-9, 12, 3), Vec3d(0, -13, 8)}) {
    s.lights.push_back(PointLight{near, Rgb(400.0f, 300.0f, 200.0f)});
  }
  s.options.samples = proof::samples(2000);
  s.options.guide = GuideUse::off;
  const Volume v = make_volume(cloud().grid, build_pyramid(cloud().grid), s);
  compare(average(picture(v, s, LineLamps::on, 900)), average(picture(v, s, LineLamps::off, 901)),
          "first", family);
  EXPECT_TRUE(family.passes());
}

/// What they are for: thin smoke with a lamp in it, and beside it.
TEST(LineLamps, AreLessNoisyInThinSmoke) {
  for (const int kind : {0, 2}) {
    CloudScene s = lit_by(kind, 0.02);
    s.options.samples = 256;
    s.options.guide = GuideUse::off;
    const Volume v = make_volume(cloud().grid, build_pyramid(cloud().grid), s);
    const Vec3d lines = average(picture(v, s, LineLamps::on, 3)).variance;
    const Vec3d ends = average(picture(v, s, LineLamps::off, 4)).variance;
    EXPECT_LT(lines.x, ends.x / 4) << kind;
  }
}

/// Limits of scatterings and layers by their number count those along flights, too.
TEST(LineLamps, AreCountedAsScatterings) {
  CloudScene s = lit_by(0, 0.05);
  s.options.samples = proof::samples(2000);
  const Volume v = make_volume(cloud().grid, build_pyramid(cloud().grid), s);
  s.options.max_bounces = 0;
  s.environment = ConstantSky{Rgb(0.0f)};
  EXPECT_EQ(average(picture(v, s, LineLamps::on, 1)).mean, Vec3d(0.0)) << "nothing scatters";
  s.options.max_bounces = 1;
  proof::Family family;
  const Average once = average(picture(v, s, LineLamps::on, 5));
  compare(once, average(picture(v, s, LineLamps::off, 6)), "once", family);
  EXPECT_GT(once.mean.x, 0);
  EXPECT_TRUE(family.passes());
}

/// The volumes whose flights ask lamps, and why.
std::pair<std::vector<bool>, Decision> choice(std::span<const Volume> volumes,
                                              const CloudScene& s) {
  const RenderPlan p = plan(volumes, s.scene());
  const auto found = std::ranges::find(p.decisions, "lamps", &Decision::what);
  return {p.line_lamps, found == p.decisions.end() ? Decision{} : *found};
}
std::pair<bool, Decision> choice(const CloudScene& s) {
  const Volume v = make_volume(cloud().grid, build_pyramid(cloud().grid), s);
  const auto [all, why] = choice({&v, 1}, s);
  return {all.at(0), why};
}

TEST(LineLamps, AreChosenWhereCloudsAreThin) {
  const auto [thin, why_thin] = choice(lit_by(0, 0.02));
  EXPECT_TRUE(thin);
  EXPECT_TRUE(says(why_thin.reason, "plan.lamps_thin")) << why_thin.reason;
  const auto [thick, why_thick] = choice(lit_by(0, 2));
  EXPECT_FALSE(thick);
  EXPECT_TRUE(says(why_thick.reason, "plan.lamps_thick")) << why_thick.reason;
  CloudScene by_day = lit_by(2, 0.02);
  by_day.environment = ConstantSky{Rgb(5.0f)};
  const auto [day, why_day] = choice(by_day);
  EXPECT_FALSE(day);
  EXPECT_TRUE(says(why_day.reason, "plan.lamps_little")) << why_day.reason;
  CloudScene within = lit_by(0, 0.02);
  within.environment = ConstantSky{Rgb(5.0f)};
  EXPECT_FALSE(choice(within).first) << "the sky is most of the noise";
  CloudScene deep = lit_by(0, 0.02);
  deep.options.deep = true;
  const auto [not_deep, why_not] = choice(deep);
  EXPECT_FALSE(not_deep);
  EXPECT_TRUE(says(why_not.reason, "plan.lamps_deep")) << why_not.reason;
  deep.options.line_lamps = LineLamps::on;
  EXPECT_THROW((void)choice(deep), Error);
  CloudScene none = lit_by(0, 0.02);
  none.lights = {Sun{{0, 1, 0}, Rgb(0.5f)}};
  EXPECT_EQ(choice(none).second.what, "") << "suns are no lamps";
}

/// What a thick cloud in the haze takes of the lamp's light, and of what the camera sees of it.
TEST(LineLamps, AreChosenByWhatIsSeenOfThem) {
  const CloudScene haze = lit_by(0, 0.02);
  const auto beside = [&](double size, double albedo, std::size_t number) {
    CloudScene s = lit_by(0, 2 / size);
    s.medium.albedo = Rgb(float(albedo));
    s.medium.object_to_world = translation({4, 0, 0}) * scaling(Vec3d(size));
    Volume cloud_beside = make_volume(cloud().grid, build_pyramid(cloud().grid), s);
    for (std::size_t k = 1; k < number; ++k) {
      cloud_beside.further_places.push_back(translation({0, 0, 0.01 * double(k)}));
    }
    const std::vector<Volume> both = {make_volume(cloud().grid, build_pyramid(cloud().grid), haze),
                                      std::move(cloud_beside)};
    return choice(both, haze);
  };
  using Chosen = std::vector<bool>;
  EXPECT_EQ(beside(0.01, 0.9, 1).first, (Chosen{true, false})) << "it is small";
  EXPECT_EQ(beside(0.01, 0.9, 400).first, (Chosen{true, false})) << "they are";
  const auto [black, why] = beside(1, 0.001, 1);
  EXPECT_EQ(black, (Chosen{false, false})) << "the lamp is behind it";
  EXPECT_TRUE(says(why.reason, "plan.lamps_little")) << why.reason;
  CloudScene set = haze;
  set.options.line_lamps = LineLamps::on;
  const Volume one = make_volume(cloud().grid, build_pyramid(cloud().grid), set);
  EXPECT_TRUE(says(choice({&one, 1}, set).second.reason, "plan.as_set"));
}

/// The variance of a sample, averaged over a picture's pixels.
double noise(const Film& film) {
  double sum = 0;
  for (const PixelSums& p : film.pixels) sum += noise_of(p) * double(p.samples);
  return sum / double(film.pixels.size());
}

/// A ball, whose light has a second moment at collisions, too, that few paths would see.
TEST(LampTrial, KnowsTheNoiseOfLampsAtCollisions) {
  for (const double extinction : {0.004, 0.05}) {
    CloudScene s = lit_by(0, extinction);
    s.lights = {PointLight{.position = {4, 3, 2},
                           .intensity = Rgb(30.0f, 20.0f, 10.0f),
                           .radius = 0.5,
                           .visible_camera = false}};
    s.options.guide = GuideUse::off;
    s.options.line_lamps = LineLamps::on;
    s.options.samples = 4096;
    const Volume v = make_volume(cloud().grid, build_pyramid(cloud().grid), s);
    const double known = detail::try_lamps(plan({&v, 1}, s.scene()), 64).variance_at_collisions;
    const double measured = noise(picture(v, s, LineLamps::off, 32));
    EXPECT_LT(std::abs(std::log(known / measured)), std::log(1.3))
        << extinction << ": " << known << " for " << measured;
  }
}

}  // namespace line_lamps_test
}  // namespace pvol::test
