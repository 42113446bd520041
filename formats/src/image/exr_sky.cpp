// Sky pictures in from OpenEXR.
#include <fmt/format.h>

#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>

#include <algorithm>
#include <vector>

#include "image/exr_check.h"
#include "image/exr_color.h"
#include "image/exr_threads.h"
#include "image/sky_readers.h"
#include "pvol/error.h"
#include "pvol/formats/image.h"

namespace pvol::formats {
namespace {

void check_radiance(Rgb c, std::size_t index, std::size_t width) {
  if (is_finite(c) && min_component(c) >= 0) return;
  throw Error(
      fmt::format("pixel ({}, {}) is ({:g}, {:g}, {:g}); expected finite radiance of at least 0; "
                  "of a filtered picture, cut negative numbers off: oiiotool SKY --clamp:min=0 -o "
                  "NEW",
                  index % width, index / width, c.x, c.y, c.z));
}

/// A part of a picture would be stretched over the whole sky.
void check_whole(const Imf::Header& header) {
  const Imath::Box2i &data = header.dataWindow(), &picture = header.displayWindow();
  if (data == picture) return;
  const auto text = [](const Imath::Box2i& b) {
    return fmt::format("({}, {}) to ({}, {})", b.min.x, b.min.y, b.max.x, b.max.y);
  };
  throw Error(
      fmt::format("holds the pixels {} of a picture that is {} (its data window and its "
                  "display window); expected all of it and no more: write it without "
                  "cropping, or overscan",
                  text(data), text(picture)));
}

ImageSky read_pixels(Imf::InputFile& in) {
  const Imath::Box2i& box = in.header().dataWindow();
  ImageSky sky;
  sky.width = box.max.x - box.min.x + 1;
  sky.height = box.max.y - box.min.y + 1;
  const std::size_t width = std::size_t(sky.width);
  std::vector<Rgb>& pixels = sky.pixels.edit();
  // Memory grows with what was decoded: a small damaged file cannot ask for gigabytes.
  const int at_once = detail::rows_at_once(sky.height, width * sizeof(Rgb));
  for (int begin = 0; begin < sky.height; begin += at_once) {
    const int rows = std::min(at_once, sky.height - begin);
    const std::size_t first = pixels.size();
    pixels.resize(first + width * std::size_t(rows));
    const Imath::V2i origin{box.min.x, box.min.y + begin};
    Imf::FrameBuffer buffer;
    const auto add = [&](const char* name, const float* at) {
      buffer.insert(name, Imf::Slice::Make(Imf::FLOAT, at, origin, sky.width, rows, sizeof(Rgb),
                                           sizeof(Rgb) * width));
    };
    add("R", &pixels[first].x);
    add("G", &pixels[first].y);
    add("B", &pixels[first].z);
    in.setFrameBuffer(buffer);
    in.readPixels(origin.y, origin.y + rows - 1);
    for (std::size_t i = first; i < pixels.size(); ++i) check_radiance(pixels[i], i, width);
  }
  return sky;
}

}  // namespace

detail::StoredSky detail::read_exr_sky(const std::filesystem::path& file) {
  (void)detail::check_exr_file(file);
  try {
    Imf::InputFile in(file.c_str());
    detail::check_picture(in.header());
    check_whole(in.header());
    detail::check_complete(in.isComplete());
    return {read_pixels(in), detail::primaries_of(in.header())};
  } catch (const Error& e) {
    throw Error(file.string() + ": " + e.what());
  } catch (const std::exception& e) {
    throw Error(file.string() + ": cannot be read as an EXR picture: " + e.what());
  }
}

}  // namespace pvol::formats
