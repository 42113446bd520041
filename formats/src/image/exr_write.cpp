// Films out to OpenEXR.
#include <fmt/format.h>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>

#include <algorithm>
#include <functional>
#include <memory>

#include "image/cryptomatte.h"
#include "image/exr_out.h"
#include "image/exr_sums.h"
#include "image/exr_threads.h"
#include "pvol/error.h"
#include "pvol/formats/image.h"
#include "pvol/render/film_channels.h"

namespace pvol::formats {
namespace {

/// A channel of a file, and its value at a pixel.
struct Channel {
  std::string name;
  std::function<double(std::size_t pixel)> value;
  Imf::PixelType type = Imf::FLOAT;
};

/// Channels that belong together: colour and alpha, or what one AOV has.
struct Group {
  std::string name;     ///< of its part, where it has one to itself
  bool colour = false;  ///< light; else numbers, which must not be rounded
  std::vector<Channel> channels;
};

/// The group that was made last where it has this name, else a new one.
Group& group_named(std::vector<Group>& groups, const std::string& name, bool colour) {
  if (groups.empty() || groups.back().name != name) groups.push_back({name, colour, {}});
  return groups.back();
}

std::vector<Group> groups_of(const Film& film, const ExrOptions& o) {
  std::vector<Group> groups;
  const auto add = [&](const FilmChannel& c) {
    Group& g = c.aov ? group_named(groups, row(*c.aov).name, row(*c.aov).colour)
                     : group_named(groups, detail::kColourPart, true);
    const bool opaque = o.opaque && std::string_view(c.name) == "A";
    g.channels.push_back(
        {c.name, [&film, &c, opaque](std::size_t i) { return opaque ? 1.0 : c.get(film, i); }});
  };
  for (const FilmChannel& c : kFilmChannels) {
    if (!c.aov) add(c);
  }
  for (const FilmChannel& c : kFilmChannels) {
    if (c.aov && o.aovs.has(*c.aov)) add(c);
  }
  for (const Layer& layer : film.layers) {
    Group& g = group_named(groups, layer.name, layer.components == "RGB");
    for (std::size_t k = 0; k < layer.components.size(); ++k) {
      g.channels.push_back({layer.name + "." + layer.components[k],
                            [&film, &layer, k](auto i) { return value(layer, film, i)[int(k)]; }});
    }
  }
  if (const auto matte = std::make_shared<const detail::Cryptomatte>(film); !matte->empty()) {
    Group& g = group_named(groups, detail::kCryptomatte, false);
    const std::vector<std::string> names = detail::Cryptomatte::channels();
    for (std::size_t k = 0; k < names.size(); ++k) {
      g.channels.push_back({names[k], [matte, k](std::size_t i) { return matte->value(k, i); }});
    }
  }
  for (Group& g : groups) {
    for (Channel& c : g.channels) {
      c.type = g.colour && o.pixels == PixelType::half ? Imf::HALF : Imf::FLOAT;
    }
  }
  return groups;
}

/// All in one part, as most programs expect it.
Group in_one(const std::vector<Group>& groups) {
  Group all{"", true, {}};
  for (const Group& g : groups) {
    all.channels.insert(all.channels.end(), g.channels.begin(), g.channels.end());
  }
  return all;
}

Imf::Compression compression_of(const Group& group, ExrCompression wanted) {
  switch (wanted) {
    case ExrCompression::none:
      return Imf::NO_COMPRESSION;
    case ExrCompression::zips:
      return Imf::ZIPS_COMPRESSION;
    case ExrCompression::zip:
      return Imf::ZIP_COMPRESSION;
    case ExrCompression::piz:
      return Imf::PIZ_COMPRESSION;
    case ExrCompression::dwaa:
      break;
  }
  return group.colour ? Imf::DWAA_COMPRESSION : Imf::ZIP_COMPRESSION;
}

Imf::Header header_of(const Film& film, const Group& group, const ExrOptions& o) {
  Imf::Header header = detail::make_header(film, o.camera);
  header.compression() = compression_of(group, o.compression);
  for (const Channel& c : group.channels) header.channels().insert(c.name, Imf::Channel(c.type));
  return header;
}

/// Writes some rows at a time, so that no second copy of the picture is needed. Returns how many
/// values were clamped.
template <class Out>
std::uint64_t write_pixels(Out& out, const Film& film, const Group& group) {
  std::size_t pixel_bytes = 0;
  for (const Channel& c : group.channels) pixel_bytes += detail::bytes_of(c.type);
  const std::size_t row_bytes = std::size_t(film.crop_width) * pixel_bytes;
  const int at_once = detail::rows_at_once(film.crop_height, row_bytes);
  std::vector<char> block(row_bytes * std::size_t(at_once));
  std::uint64_t clamped = 0;
  for (int begin = 0; begin < film.crop_height; begin += at_once) {
    const int rows = std::min(at_once, film.crop_height - begin);
    char* next = block.data();
    for (int y = begin; y < begin + rows; ++y) {
      for (int x = 0; x < film.crop_width; ++x) {
        for (const Channel& c : group.channels) {
          clamped += detail::store(c.value(film.index(x, y)), c.type, next) ? 1 : 0;
          next += detail::bytes_of(c.type);
        }
      }
    }
    Imf::FrameBuffer buffer;
    const char* first = block.data();
    for (const Channel& c : group.channels) {
      buffer.insert(c.name, Imf::Slice::Make(c.type, first, {film.x, film.y + begin},
                                             film.crop_width, rows, pixel_bytes, row_bytes));
      first += detail::bytes_of(c.type);
    }
    out.setFrameBuffer(buffer);
    out.writePixels(rows);
  }
  return clamped;
}

using Attributes = std::map<std::string, std::string>;

std::uint64_t write_one(Imf::OStream& stream, const Film& film, const Attributes& attributes,
                        const ExrOptions& o) {
  const Group group = in_one(groups_of(film, o));
  Imf::Header header = header_of(film, group, o);
  detail::add_attributes(attributes, header);
  Imf::OutputFile out(stream, header);
  return write_pixels(out, film, group);
}

/// What keyers look for beside the names' channels.
void add_manifest(const Attributes& attributes, Imf::Header& header) {
  Attributes manifest = attributes;
  std::erase_if(manifest, [](const auto& a) { return !a.first.starts_with("cryptomatte/"); });
  detail::add_attributes(manifest, header);
}

/// A part for each group, or one for all, and one for exact sums where those are kept; the
/// attributes are the first one's, and those of Cryptomatte also its part's.
std::uint64_t write_parts(Imf::OStream& stream, const Film& film, const Attributes& attributes,
                          const ExrOptions& o) {
  std::vector<Group> groups = groups_of(film, o);
  if (!o.multipart) groups = {in_one(groups)};
  std::vector<Imf::Header> headers;
  for (const Group& g : groups) {
    Imf::Header& header = headers.emplace_back(header_of(film, g, o));
    header.setName(g.name.empty() ? detail::kPicturePart : g.name);
    header.setType(Imf::SCANLINEIMAGE);
  }
  detail::add_attributes(attributes, headers.front());
  for (std::size_t i = 1; i < groups.size(); ++i) {
    if (groups[i].name == detail::kCryptomatte) add_manifest(attributes, headers[i]);
  }
  if (o.sums) headers.push_back(detail::make_sums_header(*o.sums->film, o.sums->record));
  Imf::MultiPartOutputFile out(stream, headers.data(), int(headers.size()));
  std::uint64_t clamped = 0;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    Imf::OutputPart part(out, int(i));
    clamped += write_pixels(part, film, groups[i]);
  }
  if (o.sums) {
    Imf::OutputPart part(out, int(groups.size()));
    detail::write_sums(part, *o.sums->film, o.sums->record);
  }
  return clamped;
}

}  // namespace

void validate(const ExrOptions& options) {
  if (options.compression != ExrCompression::dwaa || options.multipart) return;
  for (const AovRow& r : kAovs) {
    if (r.colour || !options.aovs.has(r.aov)) continue;
    throw Error(
        fmt::format("compression dwaa rounds colours, but {} holds numbers; use multipart, where "
                    "layers of numbers are packed by zip, or another compression",
                    r.name));
  }
}

std::uint64_t write_exr(const std::filesystem::path& file, const Film& film,
                        const std::map<std::string, std::string>& attributes,
                        const ExrOptions& options) {
  std::uint64_t clamped = 0;
  detail::write_exr_file(file, film, [&](Imf::OStream& stream) {
    validate(options);
    const bool several = options.multipart || options.sums;
    Attributes all = attributes;
    if (const detail::Cryptomatte matte(film); !matte.empty()) {
      for (auto& [name, text] : matte.attributes()) all[name] = text;
    }
    clamped = (several ? write_parts : write_one)(stream, film, all, options);
  });
  return clamped;
}

}  // namespace pvol::formats
