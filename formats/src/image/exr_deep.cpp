// Deep pictures out to OpenEXR: several samples in each pixel, by depth.
#include <ImfChannelList.h>
#include <ImfDeepFrameBuffer.h>
#include <ImfDeepImageStateAttribute.h>
#include <ImfDeepScanLineOutputFile.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>

#include <algorithm>
#include <array>

#include "image/exr_out.h"
#include "image/exr_zip.h"
#include "pvol/error.h"
#include "pvol/formats/image.h"

namespace pvol::formats {
namespace {

/// A channel of a deep file, and its value of a sample.
struct DeepChannel {
  const char* name;
  bool colour;  ///< which may be half; the products of many alphas and depths need more
  double (*value)(const DeepSample&);
};
constexpr std::array kChannels = std::to_array<DeepChannel>({
    {"R", true, [](const DeepSample& s) { return s.colour.x; }},
    {"G", true, [](const DeepSample& s) { return s.colour.y; }},
    {"B", true, [](const DeepSample& s) { return s.colour.z; }},
    {"A", false, [](const DeepSample& s) { return s.alpha; }},
    {"Z", false, [](const DeepSample& s) { return s.z; }},
    {"ZBack", false, [](const DeepSample& s) { return s.z_back; }},
});

Imf::PixelType type_of(const DeepChannel& c, const DeepExrOptions& o) {
  return c.colour && o.pixels == PixelType::half ? Imf::HALF : Imf::FLOAT;
}

/// Rows of a picture as OpenEXR takes them: for each pixel its number of samples and, by channel,
/// where they are.
class Rows {
 public:
  Rows(const Film& film, const DeepExrOptions& o) : film_(film) {
    for (std::size_t c = 0; c < kChannels.size(); ++c) types_[c] = type_of(kChannels[c], o);
  }

  /// Takes the rows from `begin` on; how many values half did not hold.
  std::uint64_t take(int begin, int rows, double error, DeepExrWritten& done) {
    begin_ = begin;
    counts_.clear();
    for (std::size_t c = 0; c < kChannels.size(); ++c) bytes_[c].clear(), places_[c].clear();
    std::uint64_t clamped = 0;
    for (int y = begin; y < begin + rows; ++y) {
      for (int x = 0; x < film_.crop_width; ++x) {
        const std::size_t pixel = film_.index(x, y);
        const std::vector<DeepSample> samples =
            deep_samples(film_.deep, pixel, film_.pixels[pixel].samples, error);
        counts_.push_back(std::uint32_t(samples.size()));
        done.samples += samples.size();
        for (std::size_t c = 0; c < kChannels.size(); ++c) clamped += put(samples, c);
      }
    }
    find_places();
    return clamped;
  }

  /// Valid until the next take.
  [[nodiscard]] Imf::DeepFrameBuffer buffer() {
    Imf::DeepFrameBuffer buffer;
    buffer.insertSampleCountSlice(Imf::Slice(Imf::UINT, origin(counts_.data()), sizeof counts_[0],
                                             sizeof counts_[0] * width()));
    for (std::size_t c = 0; c < kChannels.size(); ++c) {
      buffer.insert(kChannels[c].name,
                    Imf::DeepSlice(types_[c], origin(places_[c].data()), sizeof(char*),
                                   sizeof(char*) * width(), detail::bytes_of(types_[c])));
    }
    return buffer;
  }

 private:
  const Film& film_;
  int begin_ = 0;
  std::array<Imf::PixelType, kChannels.size()> types_{};
  std::vector<std::uint32_t> counts_;
  std::array<std::vector<char>, kChannels.size()> bytes_;
  std::array<std::vector<char*>, kChannels.size()> places_;

  [[nodiscard]] std::size_t width() const { return std::size_t(film_.crop_width); }

  std::uint64_t put(const std::vector<DeepSample>& samples, std::size_t c) {
    std::vector<char>& to = bytes_[c];
    const std::size_t size = detail::bytes_of(types_[c]);
    std::uint64_t clamped = 0;
    for (const DeepSample& s : samples) {
      to.resize(to.size() + size);
      clamped += detail::store(kChannels[c].value(s), types_[c], &to.back() + 1 - size) ? 1 : 0;
    }
    return clamped;
  }

  void find_places() {
    for (std::size_t c = 0; c < kChannels.size(); ++c) {
      char* next = bytes_[c].data();
      for (const std::uint32_t count : counts_) {
        places_[c].push_back(next);
        next += count * detail::bytes_of(types_[c]);
      }
    }
  }

  /// Where pixel (0, 0) of the whole image would be.
  template <class T>
  [[nodiscard]] char* origin(T* first) const {
    const std::int64_t row = std::int64_t(film_.y) + begin_;
    return reinterpret_cast<char*>(first) -
           (row * film_.crop_width + film_.x) * std::int64_t(sizeof(T));
  }
};

}  // namespace

DeepExrWritten write_deep_exr(const std::filesystem::path& file, const Film& film,
                              const std::map<std::string, std::string>& attributes,
                              const DeepExrOptions& options) {
  if (film.deep.pixels.size() != film.pixels.size()) {
    throw Error(file.string() + ": the film has no depths; render it with RenderOptions::deep");
  }
  DeepExrWritten done;
  detail::write_exr_file(file, film, [&](Imf::OStream& stream) {
    Imf::Header header = detail::make_header(film, options.camera);
    header.setType(Imf::DEEPSCANLINE);
    header.compression() =
        options.compression == ExrCompression::none ? Imf::NO_COMPRESSION : Imf::ZIPS_COMPRESSION;
    Imf::addDeepImageState(header, Imf::DIS_TIDY);
    for (const DeepChannel& c : kChannels) {
      header.channels().insert(c.name, Imf::Channel(type_of(c, options)));
    }
    detail::add_attributes(attributes, header);
    Imf::DeepScanLineOutputFile out(stream, header);
    Rows rows(film, options);
    for (int begin = 0; begin < film.crop_height; begin += detail::kZipRows) {
      const int count = std::min(detail::kZipRows, film.crop_height - begin);
      done.clamped += rows.take(begin, count, options.error, done);
      out.setFrameBuffer(rows.buffer());
      out.writePixels(count);
    }
  });
  return done;
}

}  // namespace pvol::formats
