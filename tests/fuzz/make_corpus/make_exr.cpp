// EXR files with every compression, type of channel and layout.
#include <ImfChannelList.h>
#include <ImfDeepFrameBuffer.h>
#include <ImfDeepScanLineOutputFile.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfTiledOutputFile.h>

#include <array>
#include <vector>

#include "make_corpus/make_corpus.h"
#include "pvol/formats/image.h"

namespace pvol::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 6, kHeight = 5;

/// Values that all types of channels can hold, in memory as floats.
struct Pixels {
  std::vector<float> values = std::vector<float>(3 * kWidth * kHeight);
  std::vector<half> halves = std::vector<half>(values.size());
  std::vector<unsigned> integers = std::vector<unsigned>(values.size());

  Pixels() {
    for (std::size_t i = 0; i < values.size(); ++i) {
      values[i] = float(i % 7);
      halves[i] = values[i];
      integers[i] = unsigned(i % 7);
    }
  }

  [[nodiscard]] const void* at(Imf::PixelType type, std::size_t i) const {
    if (type == Imf::HALF) return &halves[i];
    if (type == Imf::UINT) return &integers[i];
    return &values[i];
  }
};

Imf::Header header_of(Imf::PixelType type, Imf::Compression compression) {
  Imf::Header header({{-2, 3}, {kWidth + 2, kHeight + 2}}, {{0, 3}, {kWidth - 1, kHeight + 2}});
  header.compression() = compression;
  for (const char* name : {"R", "G", "B"}) header.channels().insert(name, Imf::Channel(type));
  return header;
}

Imf::FrameBuffer buffer_of(const Pixels& pixels, Imf::PixelType type, const Imf::Header& header) {
  Imf::FrameBuffer buffer;
  const std::size_t bytes = type == Imf::HALF ? 2 : 4;
  const char* names[] = {"R", "G", "B"};
  for (std::size_t c = 0; c < 3; ++c) {
    buffer.insert(names[c], Imf::Slice::Make(type, pixels.at(type, c), header.dataWindow(),
                                             3 * bytes, 3 * bytes * kWidth));
  }
  return buffer;
}

void write_scanlines(const fs::path& file, Imf::PixelType type, Imf::Compression compression) {
  const Pixels pixels;
  const Imf::Header header = header_of(type, compression);
  Imf::OutputFile out(file.c_str(), header);
  out.setFrameBuffer(buffer_of(pixels, type, header));
  out.writePixels(kHeight);
}

void write_tiles(const fs::path& file, Imf::LevelMode mode) {
  const Pixels pixels;
  Imf::Header header = header_of(Imf::HALF, Imf::ZIP_COMPRESSION);
  header.setTileDescription(Imf::TileDescription(4, 4, mode));
  Imf::TiledOutputFile out(file.c_str(), header);
  out.setFrameBuffer(buffer_of(pixels, Imf::HALF, header));
  for (int y = 0; y < out.numYLevels(); ++y) {
    for (int x = 0; x < out.numXLevels(); ++x) {
      if (!out.isValidLevel(x, y)) continue;
      out.writeTiles(0, out.numXTiles(x) - 1, 0, out.numYTiles(y) - 1, x, y);
    }
  }
}

void write_parts(const fs::path& file) {
  const Pixels pixels;
  std::array<Imf::Header, 2> headers = {header_of(Imf::FLOAT, Imf::ZIPS_COMPRESSION),
                                        header_of(Imf::FLOAT, Imf::NO_COMPRESSION)};
  for (std::size_t i = 0; i < headers.size(); ++i) {
    headers[i].setName("part" + std::to_string(i));
    headers[i].setType(Imf::SCANLINEIMAGE);
  }
  Imf::MultiPartOutputFile out(file.c_str(), headers.data(), int(headers.size()));
  for (std::size_t i = 0; i < headers.size(); ++i) {
    Imf::OutputPart part(out, int(i));
    part.setFrameBuffer(buffer_of(pixels, Imf::FLOAT, headers[i]));
    part.writePixels(kHeight);
  }
}

/// Pixels of several samples each.
void write_deep(const fs::path& file) {
  Imf::Header header(2, 2);
  header.compression() = Imf::ZIPS_COMPRESSION;
  header.setType(Imf::DEEPSCANLINE);
  const char* names[] = {"R", "G", "B", "A", "Z"};
  for (const char* name : names) header.channels().insert(name, Imf::Channel(Imf::FLOAT));
  std::array<unsigned, 4> counts = {1, 2, 0, 3};
  std::array<float, 3> samples = {0.5f, 0.25f, 1};
  std::array<float*, 4> pointers = {samples.data(), samples.data(), samples.data(), samples.data()};
  Imf::DeepFrameBuffer buffer;
  buffer.insertSampleCountSlice(Imf::Slice(Imf::UINT, reinterpret_cast<char*>(counts.data()),
                                           sizeof(unsigned), 2 * sizeof(unsigned)));
  for (const char* name : names) {
    buffer.insert(name, Imf::DeepSlice(Imf::FLOAT, reinterpret_cast<char*>(pointers.data()),
                                       sizeof(float*), 2 * sizeof(float*), sizeof(float)));
  }
  Imf::DeepScanLineOutputFile out(file.c_str(), header);
  out.setFrameBuffer(buffer);
  out.writePixels(2);
}

/// As pvol-render writes it, with counts and layers.
void write_film(const fs::path& file, bool multipart) {
  Film film{
      .width = 8, .height = 8, .x = 2, .y = 3, .crop_width = 4, .crop_height = 3, .pixels = {}};
  film.layers = {{"sky", {}}, {"sun.1", {}}, {"depth", {}, "Z"}};
  for (int i = 0; i < 12; ++i) {
    PixelSums p;
    p.samples = 4;
    p.sum = Vec3d(double(i));
    p.sum_squares = Vec3d(double(i * i));
    p.alpha = 2;
    film.counts.emplace_back().fill(std::uint64_t(i));
    film.pixels.push_back(p);
    for (Layer& layer : film.layers) layer.sums.emplace_back(0.5 * i);
  }
  formats::write_exr(
      file, film, {{"pvol:seed", "1"}},
      {.aovs = AovSet::all(), .multipart = multipart, .pixels = formats::PixelType::half});
}

/// As pvol-render --deep writes it.
void write_deep_film(const fs::path& file, formats::ExrCompression compression) {
  Film film{
      .width = 8, .height = 8, .x = 2, .y = 3, .crop_width = 4, .crop_height = 3, .pixels = {}};
  film.deep = {1, 3, 4, std::vector<std::vector<DeepBin>>(12)};
  for (std::size_t i = 0; i < 12; ++i) {
    film.pixels.push_back({.sum = Vec3d(1), .sum_squares = Vec3d(1), .alpha = 3, .samples = 8});
    for (std::size_t k = 0; k < i % 5; ++k) film.deep.add(i, 1.1 + 0.5 * double(k), Vec3d(0.25));
  }
  formats::write_deep_exr(file, film, {{"pvol:seed", "1"}}, {.compression = compression});
}

}  // namespace

void make_exr_corpus(const fs::path& folder) {
  constexpr std::pair<const char*, Imf::Compression> kCompressions[] = {
      {"none", Imf::NO_COMPRESSION},   {"rle", Imf::RLE_COMPRESSION},
      {"zips", Imf::ZIPS_COMPRESSION}, {"zip", Imf::ZIP_COMPRESSION},
      {"piz", Imf::PIZ_COMPRESSION},   {"pxr24", Imf::PXR24_COMPRESSION},
      {"b44", Imf::B44_COMPRESSION},   {"b44a", Imf::B44A_COMPRESSION},
      {"dwaa", Imf::DWAA_COMPRESSION}, {"dwab", Imf::DWAB_COMPRESSION}};
  for (const auto& [name, compression] : kCompressions) {
    write_scanlines(folder / (std::string("half_") + name + ".exr"), Imf::HALF, compression);
  }
  write_scanlines(folder / "float_zip.exr", Imf::FLOAT, Imf::ZIP_COMPRESSION);
  write_scanlines(folder / "uint_none.exr", Imf::UINT, Imf::NO_COMPRESSION);
  write_tiles(folder / "tiles.exr", Imf::ONE_LEVEL);
  write_tiles(folder / "mipmap.exr", Imf::MIPMAP_LEVELS);
  write_tiles(folder / "ripmap.exr", Imf::RIPMAP_LEVELS);
  write_parts(folder / "parts.exr");
  write_deep(folder / "deep.exr");
  write_deep_film(folder / "deep_film_zips.exr", formats::ExrCompression::zips);
  write_deep_film(folder / "deep_film_none.exr", formats::ExrCompression::none);
  // film.exr is of a version before there were AOVs.
  write_film(folder / "film_layers.exr", false);
  write_film(folder / "film_parts.exr", true);
}

}  // namespace pvol::fuzz
