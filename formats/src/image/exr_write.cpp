// Films out to OpenEXR.
#include <fmt/format.h>

#include <ImfChannelList.h>
#include <ImfChromaticities.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMatrixAttribute.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <ImfStdIO.h>
#include <ImfStringAttribute.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <numbers>

#include "pvol/error.h"
#include "pvol/formats/atomic_file.h"
#include "pvol/formats/image.h"
#include "pvol/render/film_channels.h"

namespace pvol::formats {
namespace {

constexpr int kBlockRows = 16;  // the rows that OpenEXR's zip compresses together
constexpr float kLargestHalf = 65504;

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
                     : group_named(groups, "rgba", true);
    const bool opaque = o.opaque && std::string_view(c.name) == "A";
    g.channels.push_back({c.name, [&film, &c, opaque](std::size_t i) {
                            return opaque ? 1.0 : c.get(film.pixels[i]);
                          }});
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

/// Rows of a matrix by which points are multiplied from the left, as EXR has it.
Imath::M44f matrix_of(Vec3d x, Vec3d y, Vec3d z, Vec3d origin) {
  Imath::M44d m;
  for (int i = 0; i < 3; ++i) m[i][0] = x[i], m[i][1] = y[i], m[i][2] = z[i];
  m[3][0] = -dot(x, origin), m[3][1] = -dot(y, origin), m[3][2] = -dot(z, origin);
  return Imath::M44f(m);
}

/// RenderMan's convention, which other programs read: the camera looks along its +z with x to the
/// right and y up, and the whole image is [-1, 1] x [-1, 1] in device coordinates.
void add_camera(const Camera& camera, const Film& film, Imf::Header& header) {
  const Vec3d z = normalize(camera.target - camera.position);
  const Vec3d x = normalize(cross(z, camera.up)), y = cross(x, z);
  const double across = std::tan(camera.fov / 360 * std::numbers::pi);
  const double aspect = double(film.width) / film.height;
  const Imath::M44f to_camera = matrix_of(x, y, z, camera.position);
  // Depth is 0 one unit before the camera and 1 at infinity: there are no clipping planes.
  const Imath::M44f project(float(1 / (across * aspect)), 0, 0, 0, 0, float(1 / across), 0, 0, 0, 0,
                            1, 1, 0, 0, -1, 0);
  Imf::addWorldToCamera(header, to_camera);
  Imf::addWorldToNDC(header, to_camera * project);
}

Imf::Header header_of(const Film& film, const Group& group, const ExrOptions& o) {
  const Imath::Box2i display({0, 0}, {film.width - 1, film.height - 1});
  const Imath::Box2i data({film.x, film.y},
                          {film.x + film.crop_width - 1, film.y + film.crop_height - 1});
  Imf::Header header(display, data);
  header.compression() = compression_of(group, o.compression);
  Imf::addChromaticities(header, Imf::Chromaticities());  // the default is Rec.709 with D65
  if (o.camera) add_camera(*o.camera, film, header);
  for (const Channel& c : group.channels) header.channels().insert(c.name, Imf::Channel(c.type));
  return header;
}

void add_attributes(const std::map<std::string, std::string>& attributes, Imf::Header& header) {
  for (const auto& [name, text] : attributes) {
    if (header.find(name) != header.end()) {
      throw Error("the attribute " + name + " has a meaning of its own in EXR files; rename it");
    }
    header.insert(name, Imf::StringAttribute(text));
  }
}

/// Puts a value into a file's block of pixels; whether half cannot hold it.
bool store(double value, Imf::PixelType type, char* to) {
  auto v = float(value);
  if (type == Imf::FLOAT) {
    std::memcpy(to, &v, sizeof v);
    return false;
  }
  const bool beyond = std::isfinite(v) && std::abs(v) > kLargestHalf;
  if (beyond) v = std::copysign(kLargestHalf, v);
  const half h(v);
  std::memcpy(to, &h, sizeof h);
  return beyond;
}

std::size_t bytes_of(Imf::PixelType type) { return type == Imf::HALF ? 2 : 4; }

/// Writes block by block, so that no second copy of the picture is needed. Returns how many values
/// were clamped.
template <class Out>
std::uint64_t write_pixels(Out& out, const Film& film, const Group& group) {
  std::size_t pixel_bytes = 0;
  for (const Channel& c : group.channels) pixel_bytes += bytes_of(c.type);
  const std::size_t row_bytes = std::size_t(film.crop_width) * pixel_bytes;
  std::vector<char> block(row_bytes * kBlockRows);
  std::uint64_t clamped = 0;
  for (int begin = 0; begin < film.crop_height; begin += kBlockRows) {
    const int rows = std::min(kBlockRows, film.crop_height - begin);
    char* next = block.data();
    for (int y = begin; y < begin + rows; ++y) {
      for (int x = 0; x < film.crop_width; ++x) {
        for (const Channel& c : group.channels) {
          clamped += store(c.value(film.index(x, y)), c.type, next) ? 1 : 0;
          next += bytes_of(c.type);
        }
      }
    }
    Imf::FrameBuffer buffer;
    const char* first = block.data();
    for (const Channel& c : group.channels) {
      buffer.insert(c.name, Imf::Slice::Make(c.type, first, {film.x, film.y + begin},
                                             film.crop_width, rows, pixel_bytes, row_bytes));
      first += bytes_of(c.type);
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
  add_attributes(attributes, header);
  Imf::OutputFile out(stream, header);
  return write_pixels(out, film, group);
}

/// A part for each group; the attributes are the first one's.
std::uint64_t write_parts(Imf::OStream& stream, const Film& film, const Attributes& attributes,
                          const ExrOptions& o) {
  const std::vector<Group> groups = groups_of(film, o);
  std::vector<Imf::Header> headers;
  for (const Group& g : groups) {
    Imf::Header& header = headers.emplace_back(header_of(film, g, o));
    header.setName(g.name);
    header.setType(Imf::SCANLINEIMAGE);
  }
  add_attributes(attributes, headers.front());
  Imf::MultiPartOutputFile out(stream, headers.data(), int(headers.size()));
  std::uint64_t clamped = 0;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    Imf::OutputPart part(out, int(i));
    clamped += write_pixels(part, film, groups[i]);
  }
  return clamped;
}

}  // namespace

void validate(const ExrOptions& options) {
  if (options.compression != ExrCompression::dwaa || options.multipart) return;
  for (const AovRow& r : kAovs) {
    if (r.colour || !options.aovs.has(r.aov)) continue;
    throw Error(fmt::format(
        "compression dwaa rounds what it takes for colour, and {} holds numbers; take multipart, "
        "where layers of numbers are packed by zip, or another compression",
        r.name));
  }
}

std::uint64_t write_exr(const std::filesystem::path& file, const Film& film,
                        const std::map<std::string, std::string>& attributes,
                        const ExrOptions& options) {
  if (film.crop_width < 1 || film.crop_height < 1) {
    throw Error(file.string() + ": the picture has no pixels; choose a size of at least 1 x 1");
  }
  std::uint64_t clamped = 0;
  write_atomically(file, [&](const std::filesystem::path& aside) {
    try {
      validate(options);
      std::ofstream stream(aside, std::ios::binary);
      {
        Imf::StdOFStream exr_stream(stream, file.c_str());
        clamped =
            (options.multipart ? write_parts : write_one)(exr_stream, film, attributes, options);
      }
      // The destructor of OutputFile writes the offsets of the blocks and hides what goes wrong.
      stream.close();
      if (!stream) throw Error("writing failed; is the disk full?");
    } catch (const std::exception& e) {
      throw Error(file.string() + ": " + e.what());
    }
  });
  return clamped;
}

}  // namespace pvol::formats
