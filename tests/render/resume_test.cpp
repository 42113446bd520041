// Renders that were stopped anywhere and go on, and parts of pictures: to the bits of one render.
#include <gtest/gtest.h>

#include <atomic>
#include <functional>

#include "pvol/error.h"
#include "support/pictures.h"
#include "support/small_cloud.h"

namespace pvol {
namespace resume_test {

using test::cloud;
using test::cloud_scene;
using test::CloudScene;
using test::make_volume;
using test::same_bytes;

/// All that a film has, to the bit.
void expect_same(const Film& a, const Film& b, const std::string& what) {
  EXPECT_TRUE(same_bytes(a, b)) << what;
  EXPECT_EQ(a.remainders, b.remainders) << what;
  EXPECT_EQ(a.counts, b.counts) << what;
  ASSERT_EQ(a.layers.size(), b.layers.size()) << what;
  for (std::size_t k = 0; k < a.layers.size(); ++k) {
    EXPECT_EQ(a.layers[k].sums, b.layers[k].sums) << what << ' ' << a.layers[k].name;
    EXPECT_EQ(a.layers[k].weights, b.layers[k].weights) << what << ' ' << a.layers[k].name;
  }
}

/// A scene with its cloud made ready, so that many renders of it are cheap.
struct Shot {
  CloudScene scene;
  std::vector<Volume> volumes;
  RenderPlan planned;

  explicit Shot(CloudScene s) : scene(std::move(s)) {
    volumes.push_back(make_volume(cloud().grid, build_pyramid(cloud().grid), scene));
    planned = plan(volumes, scene.scene(), {.force = true, .forecast = false});
  }
  [[nodiscard]] Film whole() const { return render(planned).film; }
};

/// Stops when so many samples are there, again and again, until the film is complete. Returns how
/// often it was stopped.
int render_in_steps(const Shot& shot, std::uint64_t step, Film& film) {
  int stops = -1;
  for (bool complete = false; !complete; ++stops) {
    std::uint64_t before = 0;
    for (const PixelSums& p : film.pixels) before += p.samples;
    RenderResult r =
        resume(shot.planned, std::move(film),
               {[&](std::uint64_t done, std::uint64_t) { return done < before + step; }, {}, {}});
    film = std::move(r.film);
    complete = r.complete;
  }
  return stops;
}

std::vector<std::pair<std::string, CloudScene>> scenes() {
  CloudScene plain = cloud_scene();
  plain.options.samples = 24;
  std::vector<std::pair<std::string, CloudScene>> all{{"plain", plain}};
  const auto add = [&](const std::string& name, const std::function<void(CloudScene&)>& change) {
    all.emplace_back(name, plain);
    change(all.back().second);
  };
  add("scalar", [](CloudScene& s) { s.options.kernel = KernelKind::scalar; });
  add("guided", [](CloudScene& s) { s.options.guide = GuideUse::on; });
  add("cropped", [](CloudScene& s) {
    s.options.crop_x = 3, s.options.crop_y = 1, s.options.crop_width = 5, s.options.crop_height = 7;
  });
  add("some samples", [](CloudScene& s) {
    s.options.first_sample = 100, s.options.part_begin = 7, s.options.part_end = 20;
  });
  add("layers", [](CloudScene& s) {
    for (const Aov a : {Aov::lights, Aov::scattering, Aov::halves, Aov::depth, Aov::nearest,
                        Aov::position, Aov::normal, Aov::albedo, Aov::lookups}) {
      s.options.aovs.add(a);
    }
  });
  add("adaptive", [](CloudScene& s) { s.options.noise = 0.08; });
  add("adaptive, scalar and counted", [](CloudScene& s) {
    s.options.noise = 0.08, s.options.kernel = KernelKind::scalar, s.options.count = true;
  });
  return all;
}

TEST(Resume, GivesTheBitsOfOneRenderWhereverThatStopped) {
  for (const auto& [name, scene] : scenes()) {
    const Shot shot(scene);
    const Film whole = shot.whole();
    for (const std::uint64_t step : {100u, 777u, 1500u}) {
      Film film;
      const int stops = render_in_steps(shot, step, film);
      if (step == 100) {
        EXPECT_GT(stops, 0) << name;
      }
      expect_same(film, whole, name);
    }
  }
}

/// A step after which the pilot of some pixels is done, and of others not.
TEST(Resume, OfNeedsGoesOnInTheMiddleOfThePilotAndAfterIt) {
  CloudScene s = cloud_scene();
  s.options.noise = 0.05;
  const Shot shot(s);
  const Film whole = shot.whole();
  ASSERT_TRUE(whole.needs);
  bool in_pilot = false, after_pilot = false;
  for (std::uint64_t step = 200; step < 12 * 12 * 40; step += 900) {
    RenderResult r = resume(
        shot.planned, {}, {[&](std::uint64_t done, std::uint64_t) { return done < step; }, {}, {}});
    (r.film.needs ? after_pilot : in_pilot) = true;
    const Film film = resume(shot.planned, std::move(r.film), {}).film;
    expect_same(film, whole, std::to_string(step));
  }
  EXPECT_TRUE(in_pilot);
  EXPECT_TRUE(after_pilot);
}

TEST(Resume, OfAFinishedFilmDoesNothing) {
  for (const auto& [name, scene] : scenes()) {
    const Shot shot(scene);
    const Film whole = shot.whole();
    RenderResult again = resume(shot.planned, whole, {});
    EXPECT_TRUE(again.complete) << name;
    expect_same(again.film, whole, name);
  }
}

TEST(Resume, RefusesFilmsOfOtherPictures) {
  const Shot shot(cloud_scene());
  const Film film = shot.whole();
  const auto refuses = [&](const std::function<void(Film&)>& change) {
    Film other = film;
    change(other);
    EXPECT_THROW((void)resume(shot.planned, other, {}), Error);
  };
  refuses([](Film& f) { f.remainders = {}; });
  refuses([](Film& f) { ++f.first_sample; });
  refuses([](Film& f) { ++f.width; });
  refuses([](Film& f) { f.color_space = ColorSpace::acescg; });
  refuses([](Film& f) { f.crop_width = 6, f.crop_height = 24; });
  refuses([](Film& f) {
    f.layers.push_back({"sky", std::vector<Vec3d>(f.pixels.size())});
    keep_exact_sums(f);
  });
}

/// Films of so many samples keep all digits.
TEST(Resume, GoesOnBeyondWhatIsPacked) {
  CloudScene s = cloud_scene();
  s.options.width = s.options.height = 1;
  s.options.samples = kMostPacked + 200;
  const Shot shot(s);
  const Film whole = shot.whole();
  Film film;
  EXPECT_GT(render_in_steps(shot, kMostPacked / 4, film), 3);
  expect_same(film, whole, "many samples");
  s.options.samples = kMostPacked / 2;
  Film sum = Shot(s).whole();
  EXPECT_TRUE(sum.remainders.whole.empty());
  s.options.first_sample = s.options.samples;
  s.options.samples = kMostPacked + 200 - s.options.samples;
  add_samples(sum, Shot(s).whole());
  expect_same(sum, whole, "two parts");
}

/// Whoever wants the film gets it in the middle of a pass too, with whole tiles, and leaves no
/// trace in it.
TEST(Resume, ShowsTheFilmInTheMiddleOfPasses) {
  CloudScene s = cloud_scene();
  s.options.width = s.options.height = 80;
  s.options.samples = 16;
  s.options.threads = 1;
  const Shot shot(s);
  const Film whole = shot.whole();
  int shown = 0, uneven = 0;
  std::atomic<std::uint64_t> done = 0;
  const auto pass_done = [&](const Film& film) {
    ++shown;
    std::uint32_t least = ~0u, most = 0;
    for (const PixelSums& p : film.pixels) {
      least = std::min(least, p.samples), most = std::max(most, p.samples);
    }
    if (least != most) ++uneven;
  };
  const Film film = resume(shot.planned, {},
                           {[&](std::uint64_t n, std::uint64_t) {
                              done = n;
                              return true;
                            },
                            pass_done, [&] { return done % 2 == 0; }})
                        .film;
  EXPECT_GT(shown, 6) << "there are six passes";
  EXPECT_GT(uneven, 0);
  expect_same(film, whole, "shown");
}

/// Parts of the samples and of the pixels, with everything decided for the whole.
TEST(Parts, HaveThePixelsOfTheWhole) {
  for (const auto& [name, scene] : scenes()) {
    if (scene.options.noise || scene.options.crop_width > 0 || scene.options.part_end > 0) continue;
    const Shot shot(scene);
    const Film whole = shot.whole();
    Film sum = crop_of(whole, 0, 0, 12, 12);
    for (PixelSums& p : sum.pixels) p = {};
    sum.counts.clear();
    for (Layer& layer : sum.layers) {
      if (layer.least) layer.sums.assign(sum.pixels.size(), Vec3d(kNothingMet));
    }
    keep_exact_sums(sum);
    struct Part {
      int x, y, width, height;
      std::uint32_t begin, end;
    };
    // In no order; guided paths know no crop.
    for (const Part& p :
         {Part{5, 0, 7, 12, 3, 24}, Part{0, 4, 5, 8, 3, 24}, Part{0, 0, 12, 12, 1, 3},
          Part{0, 0, 5, 4, 3, 24}, Part{0, 0, 12, 12, 0, 1}}) {
      CloudScene part = scene;
      part.options.crop_x = p.x, part.options.crop_y = p.y;
      part.options.crop_width = p.width, part.options.crop_height = p.height;
      part.options.part_begin = p.begin, part.options.part_end = p.end;
      add_part(sum, Shot(part).whole());
    }
    expect_same(sum, whole, name);
  }
}

TEST(Parts, AdaptiveFollowThePilotOfTheWhole) {
  for (const KernelKind kernel : {KernelKind::automatic, KernelKind::scalar}) {
    CloudScene s = cloud_scene();
    s.options.noise = 0.06;
    s.options.kernel = kernel;
    const Film whole = Shot(s).whole();

    s.options.part_end = kPilot;
    const Film pilot = Shot(s).whole();
    EXPECT_FALSE(pilot.needs);
    for (const PixelSums& p : pilot.pixels) EXPECT_EQ(p.samples, kPilot);
    s.options.part_end = 0;

    Film sum = crop_of(whole, 0, 0, 12, 12);
    for (PixelSums& p : sum.pixels) p = {};
    sum.counts.clear();
    keep_exact_sums(sum);
    for (const auto& [x, y, width, height] :
         {std::array{0, 0, 12, 5}, std::array{0, 5, 3, 7}, std::array{3, 5, 9, 7}}) {
      CloudScene part = s;
      part.options.crop_x = x, part.options.crop_y = y;
      part.options.crop_width = width, part.options.crop_height = height;
      const Shot shot(part);
      add_part(sum, resume(shot.planned, begin_by_pilot(shot.planned, pilot), {}).film);
    }
    expect_same(sum, whole, name(kernel));
  }
}

TEST(Parts, AdaptiveRefuseOtherPilots) {
  CloudScene s = cloud_scene();
  s.options.noise = 0.03;
  const Shot shot(s);
  s.options.part_end = kPilot;
  const Film pilot = Shot(s).whole();
  EXPECT_NO_THROW((void)begin_by_pilot(shot.planned, pilot));
  EXPECT_THROW((void)begin_by_pilot(shot.planned, crop_of(pilot, 0, 0, 12, 6)), Error);
  EXPECT_THROW((void)begin_by_pilot(shot.planned, shot.whole()), Error) << "all samples";
  Film aces = pilot;
  aces.color_space = ColorSpace::acescg;
  EXPECT_THROW((void)begin_by_pilot(shot.planned, aces), Error);
  CloudScene even = cloud_scene();
  EXPECT_THROW((void)begin_by_pilot(Shot(even).planned, pilot), Error) << "not adaptive";
}

TEST(Parts, OfFilmsLieInThem) {
  const Film film = Shot(cloud_scene()).whole();
  const Film part = crop_of(film, 2, 3, 4, 5);
  Film later = film;
  later.first_sample = 77;
  EXPECT_EQ(crop_of(later, 2, 3, 4, 5).first_sample, 77u);
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 4; ++x) {
      EXPECT_TRUE(same_bytes(part.at(x, y), film.at(x + 2, y + 3)));
      EXPECT_EQ(part.remainders.pixels[part.index(x, y)],
                film.remainders.pixels[film.index(x + 2, y + 3)]);
    }
  }
  Film to = film;
  EXPECT_NO_THROW(add_part(to, part));
  for (const auto& change : std::vector<std::function<void(Film&)>>{
           [](Film& f) { f.x = 9; }, [](Film& f) { f.y = -1; }, [](Film& f) { f.width = 13; },
           [](Film& f) { f.remainders = {}; },
           [](Film& f) {
             f.layers.push_back({"sky", {}});
           }}) {
    Film other = part;
    change(other);
    EXPECT_THROW(add_part(to, other), Error);
  }
}

TEST(Parts, OfSamplesAreThoseThatThePictureHas) {
  const auto valid = [](std::uint32_t begin, std::uint32_t end, std::optional<double> noise) {
    RenderOptions o;
    o.samples = 64, o.noise = noise;
    o.part_begin = begin, o.part_end = end;
    return !misfit(o);
  };
  RenderOptions limited;  // has no number of samples, but where noise asks for a pilot
  limited.time = 4, limited.part_end = kPilot;
  EXPECT_TRUE(misfit(limited));
  limited.noise = 0.1;
  EXPECT_FALSE(misfit(limited));
  EXPECT_TRUE(valid(0, 0, {}));
  EXPECT_TRUE(valid(0, 64, {}));
  EXPECT_TRUE(valid(63, 64, {}));
  EXPECT_FALSE(valid(0, 65, {}));
  EXPECT_FALSE(valid(5, 5, {}));
  EXPECT_FALSE(valid(5, 0, {}));
  EXPECT_TRUE(valid(0, 16, 0.1));
  EXPECT_FALSE(valid(0, 17, 0.1));
  EXPECT_FALSE(valid(1, 16, 0.1));
}

}  // namespace resume_test
}  // namespace pvol
