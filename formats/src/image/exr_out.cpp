#include "image/exr_out.h"

#include <ImfMatrixAttribute.h>
#include <ImfStandardAttributes.h>
#include <ImfStdIO.h>
#include <ImfStringAttribute.h>

#include <algorithm>
#include <cstring>
#include <fstream>

#include "image/exr_color.h"
#include "pvol/error.h"
#include "pvol/formats/atomic_file.h"
#include "pvol/formats/image.h"

namespace pvol::formats::detail {
namespace {

constexpr float kLargestHalf = 65504;

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
  const Imath::M44f to_camera = matrix_of(x, y, z, camera.position);
  Imf::addWorldToCamera(header, to_camera);
  if (camera.kind == CameraKind::latlong) return;  // which no matrix describes
  const double aspect = double(film.width) / film.height, height = half_height(camera, aspect);
  const auto [shift_x, shift_y] = shift_of(camera, aspect);
  const auto sx = float(1 / (height * aspect)), sy = float(1 / height);
  const auto dx = float(-shift_x / (height * aspect)), dy = float(-shift_y / height);
  // Depth is 0 one unit before the camera and 1 at infinity: there are no clipping planes. That of
  // parallel rays is the distance.
  const Imath::M44f perspective(sx, 0, 0, 0, 0, sy, 0, 0, dx, dy, 1, 1, 0, 0, -1, 0);
  const Imath::M44f parallel(sx, 0, 0, 0, 0, sy, 0, 0, 0, 0, 1, 0, dx, dy, 0, 1);
  Imf::addWorldToNDC(
      header, to_camera * (camera.kind == CameraKind::orthographic ? parallel : perspective));
}

}  // namespace

Imf::Header make_header(const Film& film, const std::optional<Camera>& camera) {
  const Imath::Box2i display({0, 0}, {film.width - 1, film.height - 1});
  const Imath::Box2i data({film.x, film.y},
                          {film.x + film.crop_width - 1, film.y + film.crop_height - 1});
  Imf::Header header(display, data);
  add_primaries(film.color_space, header);
  if (camera) add_camera(middle_camera(*camera), film, header);
  return header;
}

void add_attributes(const std::map<std::string, std::string>& attributes, Imf::Header& header) {
  for (const auto& [name, text] : attributes) {
    if (header.find(name) != header.end()) {
      throw Error("the attribute " + name + " is reserved in EXR files; rename it");
    }
    header.insert(name, Imf::StringAttribute(text));
  }
}

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

void write_exr_file(const std::filesystem::path& file, const Film& film,
                    const std::function<void(Imf::OStream&)>& write) {
  if (film.crop_width < 1 || film.crop_height < 1) {
    throw Error(file.string() + ": the picture has no pixels; choose a size of at least 1 x 1");
  }
  write_atomically(file, [&](const std::filesystem::path& aside) {
    try {
      std::ofstream stream(aside, std::ios::binary);
      {
        Imf::StdOFStream exr_stream(stream, file.c_str());
        write(exr_stream);
      }
      // The destructors of OpenEXR's files write the offsets of the blocks and hide what goes
      // wrong.
      stream.close();
      if (!stream) throw Error("writing failed; check that the disk is not full");
    } catch (const std::exception& e) {
      throw Error(file.string() + ": " + e.what());
    }
  });
}

}  // namespace pvol::formats::detail
