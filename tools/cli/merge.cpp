#include "cli/merge.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <iostream>
#include <limits>
#include <map>
#include <mutex>
#include <set>
#include <tuple>

#include "cli/coverage.h"
#include "cli/filter_picture.h"
#include "cli/picture_facts.h"
#include "pvol/error.h"
#include "pvol/formats/film_file.h"
#include "pvol/formats/scene_file.h"

namespace pvol::cli {
namespace {

using formats::FilmPiece;

/// A file, and what it says without its pixels.
struct Part {
  std::filesystem::path file;
  formats::PictureHeader header;
  Film window;
  formats::FilmRecord record;
  bool adaptive = false;
  std::uint32_t first_sample = 0, samples = 0;  ///< of each pixel of the whole, as its scene says
};

std::string attribute(const Part& p, const std::string& name) {
  const auto found = p.header.attributes.find(name);
  if (found == p.header.attributes.end()) {
    throw Error(fmt::format("{}: has no {}; pvol-render did not write it", p.file.string(), name));
  }
  return found->second;
}

formats::SceneFile scene_of(const Part& p) {
  return formats::parse_scene(attribute(p, "pvol:scene"), p.file.string() + ": pvol:scene");
}

Part open_part(const std::filesystem::path& file) {
  const formats::FilmReader reader(file);
  Part p{file, formats::read_picture_header(file), reader.window(), reader.record()};
  const RenderOptions r = scene_of(p).scene.options;
  p.adaptive = is_adaptive(r), p.first_sample = r.first_sample, p.samples = r.samples;
  return p;
}

/// By seed, place and samples: files may be named in any order.
bool comes_before(const Part& a, const Part& b) {
  const auto key = [](const Part& p) {
    const FilmPiece first = p.record.pieces.empty() ? FilmPiece{} : p.record.pieces.front();
    return std::tuple(first.seed, first.y, first.x, first.begin, p.file);
  };
  return key(a) < key(b);
}

bool same_layers(const Film& a, const Film& b) {
  return std::ranges::equal(a.layers, b.layers, {}, &Layer::name, &Layer::name);
}

/// Throws Error unless all parts are of one picture.
void check_same(const std::vector<Part>& parts) {
  const Part& first = parts.front();
  const auto refuse = [&](const Part& p, const std::string& why) {
    throw Error(fmt::format("{} and {} are not parts of one picture: {}", first.file.string(),
                            p.file.string(), why));
  };
  std::set<std::string> makers;
  for (const Part& p : parts) {
    if (p.record.key != first.record.key) {
      // Parts may differ in these.
      const auto [its, other] =
          first_difference(attribute(first, "pvol:scene"), attribute(p, "pvol:scene"),
                           {"crop =", "seed =", "spp =", "first_sample ="});
      if (its == other) refuse(p, "the contents of their clouds, or of other files, differ");
      refuse(p, fmt::format("the scene of one has '{}', that of the other '{}'", its, other));
    }
    if (p.window.width != first.window.width || p.window.height != first.window.height) {
      refuse(p, "their images differ in size");
    }
    if (!same_layers(p.window, first.window)) refuse(p, "they have different layers (--aov)");
    if (attribute(p, "pvol:noise") != attribute(first, "pvol:noise")) {
      refuse(p, fmt::format("--noise is {} and {}", attribute(first, "pvol:noise"),
                            attribute(p, "pvol:noise")));
    }
    if (wants_filter(p.header.attributes) != wants_filter(first.header.attributes)) {
      refuse(p, "one of them was made with --denoise, the other was not");
    }
    makers.insert(attribute(p, "pvol:kernel_used") + " of version " + attribute(p, "pvol:version"));
  }
  if (makers.size() > 1) {
    print_warnings(kConvertTool,
                   {fmt::format("the parts were made by several kernels or versions, {}: the "
                                "picture is correct, but may differ in bits from one run",
                                fmt::join(makers, ", "))});
  }
}

/// All pieces, and the part that each comes from.
struct Pieces {
  std::vector<FilmPiece> all;
  std::vector<std::size_t> part;
};

Pieces pieces_of(const std::vector<Part>& parts) {
  Pieces p;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    for (const FilmPiece& piece : parts[i].record.pieces) {
      p.all.push_back(piece);
      p.part.push_back(i);
    }
  }
  return p;
}

void refuse_doubled(const std::vector<Part>& parts, const Pieces& pieces) {
  const std::optional<Doubled> twice = find_doubled(pieces.all);
  if (!twice) return;
  throw Error(fmt::format("{} and {} both have {}; leave one of them out",
                          parts[pieces.part[twice->a]].file.string(),
                          parts[pieces.part[twice->b]].file.string(), describe(twice->both)));
}

/// The picture that the parts are of: its window, and the samples of each seed.
FilmPiece whole_of(const MergeGiven& o, const std::vector<Part>& parts) {
  FilmPiece whole;
  whole.width = parts.front().window.width, whole.height = parts.front().window.height;
  if (!o.crop.empty()) {
    whole.x = o.crop[0], whole.y = o.crop[1], whole.width = o.crop[2], whole.height = o.crop[3];
  }
  if (parts.front().adaptive) return whole;
  whole.begin = parts.front().first_sample;
  for (const Part& p : parts) {
    whole.begin = std::min(whole.begin, p.first_sample);
    whole.end = std::max(whole.end, p.first_sample + p.samples);
  }
  return whole;
}

/// Throws Error unless all is there, of each seed.
void refuse_missing(const std::vector<Part>& parts, const Pieces& pieces, FilmPiece whole,
                    const std::set<std::uint64_t>& seeds) {
  constexpr const char* kAdvice = "; --partial merges the parts that exist";
  for (std::size_t i = 0; i < pieces.all.size(); ++i) {
    if (pieces.all[i].complete) continue;
    const Part& p = parts[pieces.part[i]];
    throw Error(fmt::format("{} is not finished: it has {} samples; render it with --resume{}",
                            p.file.string(), attribute(p, "pvol:samples"), kAdvice));
  }
  for (const std::uint64_t seed : seeds) {
    whole.seed = seed;
    const std::optional<Missing> missing = find_missing(pieces.all, whole);
    if (!missing) continue;
    throw Error(fmt::format(
        "no part has {}{}{}", describe(missing->first),
        missing->pixels > 1 ? fmt::format("; {} pixels lack samples in all", missing->pixels) : "",
        kAdvice));
  }
}

/// One piece of each seed, for pieces of which nothing is missing.
std::vector<FilmPiece> wholes_of(FilmPiece whole, const std::set<std::uint64_t>& seeds) {
  std::vector<FilmPiece> all;
  whole.complete = true;
  for (const std::uint64_t seed : seeds) {
    whole.seed = seed;
    all.push_back(whole);
  }
  return all;
}

/// Throws Error where pixels do not have the samples that the parts say of them, or more than their
/// numbers count.
void check_counts(const Film& film, const FilmPiece& whole, std::size_t seeds) {
  const std::uint64_t wanted = std::uint64_t(whole.end - whole.begin) * seeds;
  for (std::size_t i = 0; i < film.pixels.size() && whole.end > 0; ++i) {
    if (film.pixels[i].samples == wanted) continue;
    throw Error(fmt::format(
        "pixel {},{} has {} samples of {}: a part is damaged, or there are more "
        "than 4294967295",
        film.x + int(i % std::size_t(film.crop_width)),
        film.y + int(i / std::size_t(film.crop_width)), film.pixels[i].samples, wanted));
  }
}

/// A film of a window, with the layers of a part, all 0.
Film empty_film(const Film& part, const FilmPiece& window) {
  Film film{part.width, part.height, window.x, window.y, window.width, window.height, {}};
  film.pixels.resize(std::size_t(window.width) * std::size_t(window.height));
  for (const Layer& like : part.layers) {
    Layer& layer = film.layers.emplace_back(Layer{like.name, {}, like.components});
    layer.least = like.least;
    layer.sums.assign(film.pixels.size(), layer.least ? Vec3d(kNothingMet) : Vec3d{});
    if (!like.weights.empty()) layer.weights.resize(film.pixels.size());
  }
  film.first_sample = window.begin;
  film.color_space = part.color_space;
  keep_exact_sums(film);
  return film;
}

/// Reads parts on all threads, some rows at a time; sums know no order.
Film add_up(const MergeGiven& o, const std::vector<Part>& parts, const FilmPiece& window) {
  constexpr int kRows = 64;
  Film film = empty_film(parts.front().window, window);
  StageLine stage("merging", o.common.quiet);
  std::mutex adding;
  std::size_t begun = 0;
  tbb::parallel_for(std::size_t(0), parts.size(), [&](std::size_t i) {
    {
      const std::scoped_lock lock(adding);
      stage.show(fmt::format("merging part {} of {}", ++begun, parts.size()));
    }
    formats::FilmReader reader(parts[i].file);
    const int height = reader.window().crop_height;
    for (int y = 0; y < height; y += kRows) {
      const Film rows = reader.rows(y, std::min(kRows, height - y));
      const std::scoped_lock lock(adding);
      add_part(film, rows);
    }
  });
  return film;
}

/// The smallest window that has all pieces.
FilmPiece hull_of(const std::vector<FilmPiece>& pieces, FilmPiece hull) {
  int right = 0, below = 0;
  hull.x = hull.y = std::numeric_limits<int>::max();
  for (const FilmPiece& p : pieces) {
    hull.x = std::min(hull.x, p.x), hull.y = std::min(hull.y, p.y);
    right = std::max(right, p.x + p.width), below = std::max(below, p.y + p.height);
  }
  hull.width = right - hull.x, hull.height = below - hull.y;
  return hull;
}

/// What the parts make, as far as it is there.
struct Whole {
  FilmPiece piece;
  std::set<std::uint64_t> seeds;
  Pieces pieces;
};

/// Throws Error for parts that do not go together and, but for partial merges, make no whole.
Whole check_whole(const MergeGiven& o, const std::vector<Part>& parts) {
  check_same(parts);
  Whole w{whole_of(o, parts), {}, pieces_of(parts)};
  for (const FilmPiece& p : w.pieces.all) w.seeds.insert(p.seed);
  refuse_doubled(parts, w.pieces);
  if (!o.partial) refuse_missing(parts, w.pieces, w.piece, w.seeds);
  return w;
}

/// The scene of the whole as one render has it.
void describe_whole(const Whole& whole, bool cropped, formats::SceneFile& scene,
                    std::map<std::string, std::string>& attributes) {
  RenderOptions& r = scene.scene.options;
  const FilmPiece& p = whole.piece;
  r.crop_x = r.crop_y = r.crop_width = r.crop_height = 0;
  if (cropped) r.crop_x = p.x, r.crop_y = p.y, r.crop_width = p.width, r.crop_height = p.height;
  r.seed = *whole.seeds.begin();
  if (!is_adaptive(r)) r.first_sample = p.begin, r.samples = p.end - p.begin;
  const Entries keys = entries(r);
  for (const char* key : {"crop", "seed", "first_sample", "spp"}) {
    attributes[std::string("pvol:") + key] = attribute_text(find_key(keys, key)->value());
  }
  attributes["pvol:scene"] = formats::to_toml(scene);
  attributes.erase("pvol:part");
  if (whole.seeds.size() > 1) {
    attributes["pvol:seeds"] =
        Json(std::vector<std::uint64_t>(whole.seeds.begin(), whole.seeds.end())).dump();
  }
}

/// Samples of the film, and those that the whole has; 0 where that is not known.
std::pair<std::uint64_t, std::uint64_t> count_samples(const Film& film, const FilmPiece& whole,
                                                      std::size_t seeds, bool complete) {
  std::uint64_t n = 0;
  for (const PixelSums& p : film.pixels) n += p.samples;
  if (complete) return {n, n};
  const auto pixels = std::uint64_t(whole.width) * std::uint64_t(whole.height);
  return {n, pixels * (whole.end - whole.begin) * seeds};
}

/// Throws UsageError for names that do not go together.
void check_names(const MergeGiven& o) {
  check(o.output);
  for (const std::filesystem::path& part : o.parts) {
    if (!same_file(part, o.output.exr)) continue;
    throw UsageError(fmt::format(
        "{} is both a part and the output; choose another name for the output", part.string()));
  }
}

void check_crop(const MergeGiven& o, const Film& image) {
  if (o.crop.empty()) return;
  const int x = o.crop[0], y = o.crop[1], width = o.crop[2], height = o.crop[3];
  if (x >= 0 && y >= 0 && width > 0 && height > 0 && width <= image.width - x &&
      height <= image.height - y) {
    return;
  }
  throw UsageError(fmt::format(
      "--crop: found {},{},{},{}, expected x, y, width and height inside the image of {} x {} "
      "pixels",
      x, y, width, height, image.width, image.height));
}

/// A film that is put together, on its way into files.
struct Merged {
  Film film;
  std::optional<FilteredPicture> filtered;
  formats::SceneFile scene;
  std::map<std::string, std::string> attributes;
};

/// With the header that one render writes.
Merged finish(const MergeGiven& o, const Part& first, const Whole& whole, Film film) {
  Merged m{std::move(film), {}, scene_of(first), first.header.attributes};
  std::erase_if(m.attributes, [](const auto& a) { return !a.first.starts_with("pvol:"); });
  m.attributes.erase("pvol:relative_noise");
  m.attributes.erase("pvol:pixel_noise");
  m.attributes.erase("pvol:estimated_error");
  m.attributes.erase("pvol:estimated_error_deviation");
  m.attributes.erase("pvol:fireflies");
  describe_whole(whole, !o.crop.empty(), m.scene, m.attributes);
  const bool denoise = wants_filter(m.attributes);
  if (denoise && !o.partial) m.filtered = filter_picture(m.film, m.scene.scene.options, {});
  describe_filter(m.filtered.has_value(), m.attributes);
  if (denoise && !m.filtered) m.attributes[kWishForFilter] = "on";
  const auto [samples, wanted] = count_samples(m.film, whole.piece, whole.seeds.size(), !o.partial);
  describe_film(m.film, samples, wanted, m.filtered, m.attributes);
  return m;
}

/// Laid out as the parts are.
void write(const MergeGiven& o, const Part& first, Whole whole, const Merged& m) {
  const formats::PictureHeader& like = first.header;
  formats::ExrOptions layout = exr_options(
      PictureLayout{m.filtered.has_value(), like.multipart, like.pixels, like.compression},
      m.scene.scene);
  const bool part = o.partial || !o.crop.empty();
  if (o.sums == KeepSums::automatic ? part : o.sums == KeepSums::on) {
    std::vector<FilmPiece>& pieces = whole.pieces.all;
    if (!o.partial) pieces = wholes_of(whole.piece, whole.seeds);
    std::ranges::sort(pieces, {}, [](const FilmPiece& p) {
      return std::tuple(p.seed, p.y, p.x, p.begin, p.end, p.height, p.width);
    });
    layout.sums = {&m.film, {.key = first.record.key, .pieces = std::move(pieces)}};
  }
  const Film& picture = m.filtered ? m.filtered->film : m.film;
  formats::write_exr(o.output.exr, picture, m.attributes, layout);
  save_png(o.output, picture, m.scene.scene.options.background);
}

}  // namespace

int merge(const MergeGiven& o) {
  check_names(o);
  formats::use_exr_threads(0);
  std::vector<Part> parts;
  for (const std::filesystem::path& file : o.parts) parts.push_back(open_part(file));
  std::ranges::sort(parts, comes_before);
  check_crop(o, parts.front().window);
  const Whole whole = check_whole(o, parts);
  const bool all = !o.partial || !o.crop.empty();
  const FilmPiece window = all ? whole.piece : hull_of(whole.pieces.all, whole.piece);
  Film film = add_up(o, parts, window);
  if (!o.partial) check_counts(film, whole.piece, whole.seeds.size());
  const Merged m = finish(o, parts.front(), whole, std::move(film));
  write(o, parts.front(), whole, m);
  if (o.common.quiet) return kSuccess;
  std::cerr << fmt::format("{}: {} parts, {} samples, {}; wrote {}\n", kConvertTool, parts.size(),
                           m.attributes.at("pvol:samples"), noise_text(m.film),
                           o.output.exr.string());
  return kSuccess;
}

}  // namespace pvol::cli
