// The table of pairs: every two features of scenes together, against paths by definition.
#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "support/effort.h"
#include "support/error_of.h"
#include "support/meshes.h"
#include "support/messages.h"
#include "support/moving_places.h"
#include "support/pictures.h"
#include "support/reference_tracer.h"

namespace pvol::test {
namespace feature_pairs_test {

/// A ball of uneven density about (8, 8, 8).
const Field& tuft() {
  static const Field f = make_field("tuft", {0, 0, 0}, {16, 16, 16}, [](Vec3i p) {
    const Vec3d d = (Vec3d(p) - Vec3d(7.7)) / 7.5;
    const double bumps = 0.3 * std::sin(0.9 * p.x) * std::sin(0.7 * p.y + 1) * std::sin(0.8 * p.z);
    return std::clamp(2 * (1 - dot(d, d) + bumps), 0.0, 1.0);
  });
  return f;
}
/// A column above its middle.
const Field& flame() {
  static const Field f = make_field("flame", {3, 8, 4}, {9, 14, 9}, [](Vec3i p) {
    const Vec3d d = (Vec3d(p) - Vec3d(7, 14, 8)) * Vec3d(0.25, 0.14, 0.25);
    return std::max(0.0, 1 - dot(d, d));
  });
  return f;
}

ReferenceFire burning() { return {&flame(), 0.2, Rgb(3.0f, 1.5f, 0.5f)}; }

const Field& nothing() {
  static const Field f = make_field("nothing", {0, 0, 0}, {8, 8, 8}, [](Vec3i) { return 0.0; });
  return f;
}

ReferenceVolume volume_of(double extinction, Rgb albedo, double g) {
  ReferenceVolume v{&tuft()};
  v.medium = {extinction, {Component{1, albedo, HenyeyGreenstein(g)}}};
  return v;
}

/// A cloud in the sun, under a faint sky that the camera does not see; its optical thickness is
/// about 4.
ReferenceScene plain() {
  ReferenceScene r;
  r.scene.camera = Camera{{30, 26, 44}, {8, 8, 8}};
  r.scene.camera.fov = 17;
  r.scene.environment = ConstantSky{Rgb(0.1f, 0.15f, 0.3f)};
  r.scene.lights = {Sun{{0.6, 0.8, 0.35}, Rgb(3.0f, 2.5f, 2.0f), 0}};
  RenderOptions& o = r.scene.options;
  o.width = o.height = 8;
  o.threads = 1;
  o.filter = PixelFilter::box;
  o.guide = GuideUse::off;
  o.background = false;
  r.volumes = {volume_of(0.4, Rgb(0.95f, 0.9f, 0.7f), 0.4)};
  return r;
}

/// What a scene may have, applied to the plain one. Of features of one kind a scene has one.
struct Feature {
  std::string kind, name;
  std::function<void(ReferenceScene&)> add;
};

/// Sets an option of the render.
template <class T, class U>
std::function<void(ReferenceScene&)> option(T RenderOptions::*member, U value) {
  return [=](ReferenceScene& r) { r.scene.options.*member = value; };
}

/// In the order in which they are added: volumes, and then what becomes of the first of them.
const std::vector<Feature>& features() {
  using R = ReferenceScene;
  static const std::vector<Feature> all{
      {"volumes", "two volumes",
       [](R& r) {
         ReferenceVolume other = volume_of(0.15, Rgb(0.6f, 0.8f, 0.95f), -0.2);
         other.places = alone(shifted({7, 3, -4}, {7, 3, -4}));
         r.volumes.push_back(other);
       }},
      {"places", "instances",
       [](R& r) {
         Placement small = scaled(Vec3d(0.7, 0.9, 0.6));
         small.translate = Vec3d(-7, 6, 5);
         r.volumes[0].places.push_back(place_of(between(small, small), MovingMap{}));
       }},
      {"places", "a moving place",
       [](R& r) {
         r.scene.camera.shutter = {0, 1};
         r.volumes[0].places = alone(between(
             turned({0, 1, 0}, 0), {.rotate = {{{0, 1, 0}, 40}}, .translate = Vec3d(6, 2, 0)}));
       }},
      {"motion", "velocities",
       [](R& r) {
         r.scene.camera.shutter = {0, 1};
         r.volumes[0].velocity = [](Vec3d x) {
           return Vec3d(4, 0.3 * (x.x - 8), -0.2 * (x.y - 5));
         };
       }},
      {"samples", "shared samples", [](R& r) { r.volumes[0].share_samples = true; }},
      {"density", "a mapped density",
       [](R& r) {
         r.volumes[0].map.scale = 1.5;
         r.volumes[0].map.power = 2;
       }},
      {"look-up", "tricubic", option(&RenderOptions::look_up, LookUp::tricubic)},
      {"look-up", "nearest", option(&RenderOptions::look_up, LookUp::nearest)},
      {"extinction", "extinction by channel",
       [](R& r) { r.volumes[0].medium.extinction_color = Rgb(1.0f, 0.6f, 0.2f); }},
      {"albedo", "an albedo grid",
       [](R& r) {
         r.volumes[0].albedo = [](Vec3d x) {
           return Vec3d(0.6 + 0.012 * (x.x - 8), 0.9, 0.5 - 0.007 * (x.y + x.z - 16));
         };
       }},
      {"medium", "glow",
       [](R& r) { r.volumes[0].medium.components[0].emission = Rgb(6.0f, 3.0f, 1.0f); }},
      {"medium", "two components",
       [](R& r) {
         auto& components = r.volumes[0].medium.components;
         components[0].share = 0.6;
         components.push_back({0.4, Rgb(0.99f, 0.5f, 0.8f), Rayleigh{}});
       }},
      {"fire", "a fire", [](R& r) { r.volumes[0].fire = burning(); }},
      {"fire", "a fire alone",
       [](R& r) {
         r.volumes[0].field = &nothing();
         r.volumes[0].fire = burning();
       }},
      {"lights", "a spot",
       [](R& r) {
         r.scene.lights.push_back(SpotLight{.position = {-6, 30, 10},
                                            .direction = {14, -22, -2},
                                            .intensity = Rgb(3e3f, 2e3f, 1e3f),
                                            .angle = 30,
                                            .blend = 0.5});
       }},
      {"lights", "lamps",
       [](R& r) {
         r.scene.lights = {PointLight{{20, 22, 14}, Rgb(300.0f, 200.0f, 100.0f), "", 2},
                           AreaLight{.position = {0, 25, 8},
                                     .direction = {0.3, -1, 0},
                                     .size = {6, 4},
                                     .radiance = Rgb(30.0f)}};
       }},
      {"lights", "many lamps",
       [](R& r) {
         r.scene.lights.clear();
         for (int i = 0; i < 72; ++i) {
           const double turn = 0.7 * i, up = 4 + 0.2 * i;
           r.scene.lights.push_back(PointLight{
               {8 + 16 * std::cos(turn), up, 8 + 16 * std::sin(turn)},
               Rgb(1.0f + float(i % 5), 2.0f + float(i % 3), 2.0f + float(i % 7)) * 5.0f});
         }
       }},
      {"lights", "a disc", [](R& r) { std::get<Sun>(r.scene.lights[0]).angle = 40; }},
      {"sky", "a gradient", [](R& r) { r.scene.environment = GradientSky{}; }},
      {"sky", "a picture of a sky",
       [](R& r) {
         r.scene.environment = ImageSky{4,
                                        2,
                                        {Rgb(0.2f), Rgb(4.0f, 3.0f, 2.0f), Rgb(0.3f), Rgb(0.1f),
                                         Rgb(0.2f, 0.3f, 0.1f), Rgb(0.1f), Rgb(0.1f), Rgb(0.2f)}};
       }},
      {"ground", "a plane",
       [](R& r) {
         r.scene.surfaces.push_back(PlaneSurface{{0, -2, 0}, {0, 1, 0}, {Rgb(0.6f, 0.5f, 0.3f)}});
       }},
      {"ground", "a shadow catcher",
       [](R& r) {
         r.scene.surfaces.push_back(PlaneSurface{
             {0, -2, 0}, {0, 1, 0}, {Rgb(0.6f, 0.5f, 0.3f), Visibility::shadow_catcher}});
         r.scene.options.background = true;
       }},
      {"ball", "a holdout",
       [](R& r) {
         r.scene.surfaces.push_back(BallSurface{{9, 9, 12}, 3, {Rgb(0.7f), Visibility::holdout}});
         r.scene.options.background = true;
       }},
      {"ball", "a ball",
       [](R& r) {
         r.scene.surfaces.push_back(BallSurface{{9, 9, 12}, 3, {Rgb(0.7f)}});
       }},
      {"mesh", "a mesh",
       [](R& r) {
         MeshSurface mesh;
         mesh.mesh = std::make_shared<const TriangleMesh>(square_mesh(5));
         mesh.place.rotate = {{{1, 0, 0}, 60}};
         mesh.place.translate = Vec3d(4, 10, 4);
         mesh.material.albedo = Rgb(0.2f, 0.5f, 0.8f);
         r.scene.surfaces.push_back(mesh);
       }},
      {"ball", "a moving ball",
       [](R& r) {
         r.scene.camera.shutter = {0, 1};
         BallSurface ball{{9, 9, 12}, 3, {Rgb(0.7f)}};
         ball.to = BallPlace{{3, 12, 11}};
         r.scene.surfaces.push_back(ball);
       }},
      {"ball", "a ball that casts no shadow",
       [](R& r) {
         Material material{Rgb(0.7f)};
         material.visible_shadow = false;
         r.scene.surfaces.push_back(BallSurface{{9, 9, 12}, 3, material});
       }},
      {"mesh", "a card that the camera and scattered light pass",
       [](R& r) {
         MeshSurface card;
         card.mesh = std::make_shared<const TriangleMesh>(square_mesh(6));
         card.place.rotate = {{{1, 0, 0}, 80}};
         card.place.translate = Vec3d(6, 14, 8);
         card.material.visible_camera = card.material.visible_light = false;
         r.scene.surfaces.push_back(card);
       }},
      {"mesh", "a moving mesh",
       [](R& r) {
         r.scene.camera.shutter = {0, 1};
         MeshSurface mesh;
         mesh.mesh = std::make_shared<const TriangleMesh>(square_mesh(5));
         mesh.place.rotate = {{{1, 0, 0}, 60}};
         mesh.place.translate = Vec3d(4, 10, 4);
         mesh.to = mesh.place;
         mesh.to->rotate[0].degrees = 100, mesh.to->translate = Vec3d(7, 8, 6);
         mesh.material.albedo = Rgb(0.2f, 0.5f, 0.8f);
         r.scene.surfaces.push_back(mesh);
       }},
      {"camera", "a moving camera",
       [](R& r) {
         Camera& c = r.scene.camera;
         c.shutter = {0, 1};
         const Vec3d way(5, -2, -3);
         c.to = CameraPlace{c.position + way, c.target + way, c.up};
       }},
      {"bounces", "two scatterings at most", option(&RenderOptions::max_bounces, 2u)},
      {"background", "a background", option(&RenderOptions::background, true)},
      {"guide", "guided", option(&RenderOptions::guide, GuideUse::on)},
      {"tracker", "delta", option(&RenderOptions::tracker, Tracker::delta)},
      {"tracker", "weighted delta", option(&RenderOptions::tracker, Tracker::weighted_delta)},
      {"tracker", "weighted decomposition",
       option(&RenderOptions::tracker, Tracker::weighted_decomposition)},
      {"tracker", "majorants that do not hold",
       [](R& r) {
         r.scene.options.tracker = Tracker::weighted_delta;
         r.scene.options.majorant_scale = 0.7;
       }},
      {"tracker", "regular", option(&RenderOptions::tracker, Tracker::regular)},
      {"shadow rays", "ratio", option(&RenderOptions::transmittance, Transmittance::ratio)},
      {"shadow rays", "residual ratio",
       option(&RenderOptions::transmittance, Transmittance::residual_ratio)},
      {"shadow rays", "closed form", option(&RenderOptions::transmittance, Transmittance::regular)},
      {"micro-bounds", "micro-bounds",
       option(&RenderOptions::micro_bounds, MicroBoundsUse::edge_1)},
      {"emission", "emission along flights",
       option(&RenderOptions::line_emission, LineEmission::on)},
      {"lamps", "lamps along flights",
       [](R& r) {
         r.scene.lights.push_back(PointLight{{13, 10, 6}, Rgb(20.0f, 30.0f, 60.0f)});
         r.scene.options.line_lamps = LineLamps::on;
       }},
  };
  return all;
}

/// Two features that go together in no scene, by the key of the message (support/messages.h).
struct Refused {
  std::string a, b, message;
};
const std::vector<Refused>& refused() {
  static const std::vector<Refused> all{
      {"velocities", "regular", "motion.volume_motion_no_closed"},
      {"velocities", "closed form", "motion.regular_tracking_regular"},
      {"velocities", "majorants that do not hold", "motion.bounds_without_factor"},
      {"shared samples", "tricubic", "density.shared_interpolation"},
      {"a mapped density", "regular", "density.regular_tracking_regular"},
      {"a mapped density", "closed form", "density.regular_tracking_regular"},
      {"tricubic", "regular", "interpolation.regular_of_two"},
      {"tricubic", "closed form", "interpolation.regular_of_two"},
      {"extinction by channel", "regular", "albedo.regular_of_three"},
      {"guided", "majorants that do not hold", "limits.guide_weights_grow"},
  };
  return all;
}
const Refused* refusal_of(const Feature& a, const Feature& b) {
  for (const Refused& r : refused()) {
    if ((r.a == a.name && r.b == b.name) || (r.a == b.name && r.b == a.name)) return &r;
  }
  return nullptr;
}

/// The table, pair by pair, and what it adds up to.
class Table {
 public:
  /// A scene of either feature, or of one where both are the same.
  void check(const Feature& a, const Feature& b) {
    ReferenceScene r = plain();
    a.add(r);
    if (&a != &b) b.add(r);
    const std::string name = &a == &b ? a.name : a.name + " and " + b.name;
    r.scene.options.seed = ++count_;
    r.scene.options.samples = proof::samples(kSamples, kParts);
    const Refused* refusal = refusal_of(a, b);
    try {
      const Film film = render(make_volumes(r), r.scene).film;
      EXPECT_EQ(refusal, nullptr) << name << " is refused no longer";
      compare(film, r, name, {&a, &b});
    } catch (const Error& e) {
      if (refusal == nullptr) {
        ADD_FAILURE() << name << ": " << e.what();
      } else {
        EXPECT_TRUE(says(e.what(), refusal->message)) << name;
      }
    }
  }

  [[nodiscard]] ::testing::AssertionResult passes() {
    for (const auto& [feature, excess] : of_feature_) {
      add_all_together(excess, feature + ", in all scenes", family_);
    }
    add_all_together(all_, "all scenes", family_);
    return family_.passes();
  }

 private:
  static constexpr std::uint32_t kSamples = 640, kOfReference = 160;
  /// On a commit, an error of 2 % in a feature is seven standard errors of all scenes that have it.
  /// With fewer samples, quarters of pictures of a fire alone have too few for the normal law.
  static constexpr std::uint32_t kParts = 8;

  std::uint64_t count_ = 0;
  proof::Family family_;
  std::map<std::string, proof::Moments> of_feature_;  // deviations of pictures that have it
  proof::Moments all_;

  /// By how many standard deviations the picture exceeds the reference, whose channels are
  /// independent of each other.
  static double excess_of(const Average& picture, const Average& reference) {
    double difference = 0, deviation = 0, variance = 0;
    for (int c = 0; c < 3; ++c) {
      const double weight = 1 / reference.mean[c];
      difference += weight * (picture.mean[c] - reference.mean[c]);
      deviation += weight * std::sqrt(picture.variance[c]);
      variance += weight * weight * reference.variance[c];
    }
    return difference / std::sqrt(deviation * deviation + variance);
  }

  void compare(const Film& film, const ReferenceScene& r, const std::string& name,
               std::initializer_list<const Feature*> features) {
    const Film reference =
        reference_film(r, proof::samples(kOfReference, kParts), proof::seeded(1000 + count_));
    pvol::test::compare(film, reference, name, family_);
    const double excess = excess_of(average(film), average(reference));
    all_.add(excess);
    for (const Feature* f : features) of_feature_[f->name].add(excess);
  }
};

/// On each commit every feature with half of the others: in turns that no two groups of features
/// are kept apart by.
TEST(FeaturePairs, HaveTheMeansOfPathsByDefinition) {
  Table table;
  const auto& all = features();
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = i; j < all.size(); ++j) {
      if (i != j && all[i].kind == all[j].kind) continue;
      const bool is_turn = (j - i) % 4 < 2 || refusal_of(all[i], all[j]) != nullptr;
      if (is_turn || proof::runs_all()) table.check(all[i], all[j]);
    }
  }
  EXPECT_TRUE(table.passes());
}

}  // namespace feature_pairs_test
}  // namespace pvol::test
