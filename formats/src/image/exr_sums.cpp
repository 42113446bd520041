#include "image/exr_sums.h"

#include <fmt/format.h>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfPartType.h>
#include <ImfStringAttribute.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "image/exr_check.h"
#include "image/exr_out.h"
#include "image/exr_threads.h"
#include "pvol/error.h"

namespace pvol::formats::detail {
namespace {

using Json = nlohmann::json;

constexpr int kVersion = 2;
constexpr const char* kRecord = "pvol:film";
constexpr std::size_t kLongestRecord = 1 << 26;  // bytes; of some 300 000 pieces
constexpr std::size_t kMostLayers = 1 << 12;

/// What adaptive sampling still wants is for samples to come.
PlaneChoice choice_of(const Film& film, const FilmRecord& record) {
  const auto counts = [](const PixelCounts& c) { return c != PixelCounts{}; };
  const bool complete = std::ranges::all_of(record.pieces, &FilmPiece::complete);
  return {std::ranges::any_of(film.counts, counts), film.needs.has_value() && !complete};
}

Json to_json(const FilmPiece& p) {
  return {{"seed", p.seed},
          {"window", {p.x, p.y, p.width, p.height}},
          {"begin", p.begin},
          {"end", p.end},
          {"complete", p.complete}};
}

Json to_json(const Film& film, const FilmRecord& record) {
  Json j = {{"version", kVersion},
            {"key", record.key},
            {"first_sample", film.first_sample},
            {"counts", choice_of(film, record).counts}};
  for (const FilmPiece& p : record.pieces) j["pieces"].push_back(to_json(p));
  j["layers"] = Json::array();
  for (const Layer& l : film.layers) {
    j["layers"].push_back({{"name", l.name},
                           {"components", l.components},
                           {"weights", !l.weights.empty()},
                           {"least", l.least}});
  }
  if (choice_of(film, record).needs) j["needs"] = film.needs->samples;
  return j;
}

FilmPiece to_piece(const Json& j) {
  FilmPiece p;
  j.at("seed").get_to(p.seed);
  const auto window = j.at("window").get<std::array<int, 4>>();
  p.x = window[0], p.y = window[1], p.width = window[2], p.height = window[3];
  j.at("begin").get_to(p.begin), j.at("end").get_to(p.end);
  j.at("complete").get_to(p.complete);
  return p;
}

Layer to_layer(const Json& j, bool& weights) {
  Layer l;
  j.at("name").get_to(l.name);
  j.at("components").get_to(l.components);
  j.at("least").get_to(l.least);
  j.at("weights").get_to(weights);
  if (l.components.empty() || l.components.size() > 3 || (l.least && weights)) {
    throw Error("the layer " + l.name + " is impossible; the file is damaged");
  }
  return l;
}

/// Throws Error for a piece that does not lie in the film, or has no samples.
void check_piece(const FilmPiece& p, const Film& film) {
  const std::int64_t x = std::int64_t(p.x) - film.x, y = std::int64_t(p.y) - film.y;
  const bool inside = p.x >= 0 && p.y >= 0 && p.width > 0 && p.height > 0 && x >= 0 && y >= 0 &&
                      p.width <= film.crop_width - x && p.height <= film.crop_height - y;
  const bool adaptive = p.begin == 0 && p.end == 0;
  if (inside && (adaptive || p.begin < p.end)) return;
  throw Error("has pieces that are empty or lie outside it; the file is damaged");
}

/// As `to_json` made it; throws what nlohmann throws.
SumsHeader from_json(const Json& j) {
  if (j.at("version").get<int>() != kVersion) {
    throw Error(
        fmt::format("stores its sums in version {}; this program reads version {}; render the "
                    "picture again, or go on with the pvol that wrote it",
                    j.at("version").get<int>(), kVersion));
  }
  SumsHeader h;
  j.at("key").get_to(h.record.key);
  for (const Json& p : j.at("pieces")) h.record.pieces.push_back(to_piece(p));
  j.at("first_sample").get_to(h.window.first_sample);
  j.at("counts").get_to(h.choice.counts);
  if (j.at("layers").size() > kMostLayers) throw Error("too many layers; the file is damaged");
  for (const Json& l : j.at("layers")) {
    bool weights = false;
    h.window.layers.push_back(to_layer(l, weights));
    if (weights) h.window.layers.back().weights.resize(1);  // stands for those of the pixels
  }
  h.choice.needs = j.contains("needs");
  if (h.choice.needs) {
    h.window.needs.emplace();
    j.at("needs").get_to(h.window.needs->samples);
  }
  return h;
}

}  // namespace

Imf::Header make_sums_header(const Film& film, const FilmRecord& record) {
  Imf::Header header = make_header(film, std::nullopt);
  header.setName(kSumsPart);
  header.setType(Imf::SCANLINEIMAGE);
  header.compression() = Imf::ZIP_COMPRESSION;
  for (const Plane& p : planes_of(film.layers, choice_of(film, record))) {
    header.channels().insert(p.name, Imf::Channel(Imf::UINT));
  }
  header.insert(kRecord, Imf::StringAttribute(to_json(film, record).dump()));
  return header;
}

void write_sums(Imf::OutputPart& out, const Film& film, const FilmRecord& record) {
  const std::vector<Plane> planes = planes_of(film.layers, choice_of(film, record));
  const auto width = std::size_t(film.crop_width);
  const int at_once = rows_at_once(film.crop_height, width * planes.size() * sizeof(std::uint32_t));
  const std::size_t plane_size = width * std::size_t(at_once);
  std::vector<std::uint32_t> rows_of_all(plane_size * planes.size());
  PixelRecord pixel = empty_record(film.layers);
  for (int begin = 0; begin < film.crop_height; begin += at_once) {
    const int rows = std::min(at_once, film.crop_height - begin);
    const std::size_t first = film.index(0, begin), count = width * std::size_t(rows);
    for (std::size_t i = 0; i < count; ++i) {
      load(film, first + i, pixel);
      for (std::size_t k = 0; k < planes.size(); ++k) {
        rows_of_all[k * plane_size + i] = planes[k].get(pixel);
      }
    }
    Imf::FrameBuffer buffer;
    for (std::size_t k = 0; k < planes.size(); ++k) {
      std::uint32_t* const plane = rows_of_all.data() + k * plane_size;
      buffer.insert(planes[k].name, Imf::Slice::Make(Imf::UINT, plane, {film.x, film.y + begin},
                                                     film.crop_width, rows));
    }
    out.setFrameBuffer(buffer);
    out.writePixels(rows);
  }
}

SumsHeader read_sums_header(const Imf::Header& header) {
  const auto* text = header.findTypedAttribute<Imf::StringAttribute>(kRecord);
  if (text == nullptr || text->value().size() > kLongestRecord) {
    throw Error("has sums without their record; the file is damaged");
  }
  SumsHeader h;
  try {
    h = from_json(Json::parse(text->value()));
  } catch (const nlohmann::json::exception& e) {
    throw Error(fmt::format("the record of its sums is damaged: {}", e.what()));
  }
  const Film window = film_of(header);
  h.window.width = window.width, h.window.height = window.height;
  h.window.x = window.x, h.window.y = window.y;
  h.window.crop_width = window.crop_width, h.window.crop_height = window.crop_height;
  h.window.color_space = window.color_space;
  for (const FilmPiece& p : h.record.pieces) check_piece(p, h.window);
  for (const Plane& p : planes_of(h.window.layers, h.choice)) {
    const Imf::Channel* channel = header.channels().findChannel(p.name);
    if (channel != nullptr && channel->type == Imf::UINT) continue;
    throw Error("has no plane " + p.name + " among its sums; the file is damaged");
  }
  return h;
}

}  // namespace pvol::formats::detail
