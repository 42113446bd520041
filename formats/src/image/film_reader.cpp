// Films with their exact sums, in from EXR files.
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>

#include "image/exr_check.h"
#include "image/exr_sums.h"
#include "pvol/error.h"
#include "pvol/formats/film_file.h"

namespace pvol::formats {
namespace {

/// Number of the part with sums, or -1.
int find_sums(const Imf::MultiPartInputFile& in) {
  for (int p = 0; p < in.parts(); ++p) {
    if (in.header(p).hasName() && in.header(p).name() == detail::kSumsPart) return p;
  }
  return -1;
}

ExrCompression compression_of(Imf::Compression c) {
  switch (c) {
    case Imf::NO_COMPRESSION:
      return ExrCompression::none;
    case Imf::ZIPS_COMPRESSION:
      return ExrCompression::zips;
    case Imf::PIZ_COMPRESSION:
      return ExrCompression::piz;
    case Imf::DWAA_COMPRESSION:
      return ExrCompression::dwaa;
    default:
      return ExrCompression::zip;
  }
}

/// The result of `work`, with the file's name before the message of what it throws.
template <class Work>
auto naming_picture(const std::filesystem::path& file, const Work& work) {
  try {
    return work();
  } catch (const Error& e) {
    throw Error(file.string() + ": " + e.what());
  } catch (const std::exception& e) {
    throw Error(file.string() + ": cannot be read as an EXR picture: " + e.what());
  }
}

/// A film of some rows of a window, all 0.
Film empty_rows(const Film& window, int begin, int count, bool counts) {
  Film f = window;
  f.y += begin, f.crop_height = count;
  f.pixels.resize(std::size_t(f.crop_width) * std::size_t(count));
  for (std::size_t k = 0; k < f.layers.size(); ++k) {
    f.layers[k].sums.resize(f.pixels.size());
    if (!f.layers[k].weights.empty()) f.layers[k].weights.resize(f.pixels.size());
  }
  keep_exact_sums(f);
  if (counts) f.counts.resize(f.pixels.size());
  if (f.needs) f.needs->share.resize(f.pixels.size());
  return f;
}

}  // namespace

struct FilmReader::State {
  std::filesystem::path file;
  Imf::MultiPartInputFile in;
  detail::SumsHeader header;
  std::map<std::string, std::string> attributes;
  std::vector<detail::Plane> planes;
  int part = -1;

  explicit State(const std::filesystem::path& name) : file(name), in(name.c_str()) {
    part = find_sums(in);
    if (part < 0) {
      throw Error(
          "has no exact sums; expected a part of a picture (--samples, --crop), or one written by "
          "--checkpoint or with --sums on");
    }
    header = detail::read_sums_header(in.header(part));
    attributes = detail::string_attributes(in.header(0));
    for (int p = 0; p < in.parts(); ++p) detail::check_complete(in.partComplete(p));
    planes = detail::planes_of(header.window.layers, header.choice);
  }

  [[nodiscard]] Film rows(int begin, int count) {
    Film film = empty_rows(header.window, begin, count, header.choice.counts);
    std::vector<std::vector<std::uint32_t>> block(planes.size());
    Imf::FrameBuffer buffer;
    for (std::size_t k = 0; k < planes.size(); ++k) {
      block[k].resize(film.pixels.size());
      buffer.insert(planes[k].name, Imf::Slice::Make(Imf::UINT, block[k].data(), {film.x, film.y},
                                                     film.crop_width, count));
    }
    Imf::InputPart input(in, part);
    input.setFrameBuffer(buffer);
    input.readPixels(film.y, film.y + count - 1);
    detail::PixelRecord pixel = detail::empty_record(film.layers);
    for (std::size_t i = 0; i < film.pixels.size(); ++i) {
      for (std::size_t k = 0; k < planes.size(); ++k) planes[k].put(pixel, block[k][i]);
      detail::store(pixel, i, film);
    }
    return film;
  }
};

FilmReader::FilmReader(const std::filesystem::path& file) {
  // Checks what OpenEXR takes memory for, and names the file itself.
  (void)detail::check_exr_file(file);
  state_ = naming_picture(file, [&] { return std::make_unique<State>(file); });
}
FilmReader::~FilmReader() = default;
FilmReader::FilmReader(FilmReader&&) noexcept = default;

const Film& FilmReader::window() const { return state_->header.window; }
const FilmRecord& FilmReader::record() const { return state_->header.record; }
const std::map<std::string, std::string>& FilmReader::attributes() const {
  return state_->attributes;
}

Film FilmReader::rows(int begin, int count) {
  return naming_picture(state_->file, [&] { return state_->rows(begin, count); });
}

PictureHeader read_picture_header(const std::filesystem::path& file) {
  (void)detail::check_exr_file(file);
  return naming_picture(file, [&] {
    Imf::MultiPartInputFile in(file.c_str());
    for (int p = 0; p < in.parts(); ++p) detail::check_complete(in.partComplete(p));
    const Imf::Header& first = in.header(0);
    PictureHeader h{detail::film_of(first), detail::string_attributes(first), find_sums(in) >= 0};
    h.multipart = first.hasName() && first.name() == detail::kColourPart;
    const Imf::Channel* red = first.channels().findChannel("R");
    if (red != nullptr && red->type == Imf::HALF) h.pixels = PixelType::half;
    h.compression = compression_of(first.compression());
    return h;
  });
}

FilmFile read_film_file(const std::filesystem::path& file) {
  FilmReader reader(file);
  return {reader.rows(0, reader.window().crop_height), reader.record(), reader.attributes()};
}

}  // namespace pvol::formats
