// Skies, suns and points.
#include "pvol/render/lights.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

namespace pvol {
namespace {

using std::numbers::pi;

/// Radius in radians below which a sun is a point: half the spacing of float directions.
constexpr double kLeastRadius = 0x1p-24;

/// Index i with cdf[i] <= u < cdf[i + 1]; cdf ascends from 0 to 1.
int find_bin(std::span<const double> cdf, double u) {
  const auto above = std::upper_bound(cdf.begin(), cdf.end() - 1, u);
  return std::max(0, int(above - cdf.begin()) - 1);
}

/// Turns weights into a cumulative distribution in place: n + 1 values; returns the sum.
double accumulate(std::span<double> cdf) {
  double sum = 0;
  for (double& v : cdf) {
    const double weight = v;
    v = sum;
    sum += weight;
  }
  for (double& v : cdf) v = sum > 0 ? v / sum : 0;
  cdf.back() = 1;
  return sum;
}

/// A vector turned by the shortest way that takes +y to `up`, unit; about x where that is -y.
Vec3d from_y(Vec3d up, Vec3d v) {
  if (up.y < -1 + 1e-12) return {v.x, -v.y, -v.z};
  const Vec3d axis(up.z, 0, -up.x);  // times the sine
  return v * up.y + cross(axis, v) + axis * (dot(axis, v) / (1 + up.y));
}

}  // namespace

SkyLight::SkyLight(const Environment& environment) : environment_(environment) {
  if (const auto* gradient = std::get_if<GradientSky>(&environment_)) {
    up_ = Vec3f(normalize(gradient->up));
  }
  const auto* picture = std::get_if<ImageSky>(&environment_);
  if (picture == nullptr) return;
  const int width = picture->width, height = picture->height;
  rotation_ = picture->rotation / 360;
  turned_ = normalize(picture->up) != Vec3d(0, 1, 0);
  if (turned_) {
    const auto axis = [&](Vec3d v) { return Vec3f(from_y(normalize(picture->up), v)); };
    x_ = axis({1, 0, 0}), y_ = axis({0, 1, 0}), z_ = axis({0, 0, 1});
  }
  for (int y = 0; y <= height; ++y) row_y_.push_back(std::cos(pi * y / height));
  std::vector<double> rows(std::size_t(height) + 1);
  pixel_cdf_.resize(std::size_t(height) * std::size_t(width + 1));
  for (int y = 0; y < height; ++y) {
    const std::span row(&pixel_cdf_[std::size_t(y) * std::size_t(width + 1)],
                        std::size_t(width) + 1);
    for (int x = 0; x < width; ++x) {
      const Rgb c = picture->pixels[std::size_t(y) * std::size_t(width) + std::size_t(x)];
      row[std::size_t(x)] = double(luminance(c * picture->scale));
    }
    const double solid_angle = row_y_[std::size_t(y)] - row_y_[std::size_t(y) + 1];
    rows[std::size_t(y)] = accumulate(row) * solid_angle;
  }
  const double sum = accumulate(rows);
  mean_luminance_ = float(sum / (2 * width));
  if (sum > 0) row_cdf_ = std::move(rows);  // a black picture is not sampled
}

SkyLight::Pixel SkyLight::pixel_at(Vec3f d) const {
  const auto& picture = std::get<ImageSky>(environment_);
  if (turned_) d = {dot(d, x_), dot(d, y_), dot(d, z_)};
  double turns = std::atan2(double(d.z), double(d.x)) / (2 * pi) - rotation_;
  turns -= std::floor(turns);
  // Near the poles y is 1 to the last digit for a fraction of a degree; x and z still tell.
  const double theta = std::atan2(std::hypot(double(d.x), double(d.z)), double(d.y)) / pi;
  return {std::min(int(turns * picture.width), picture.width - 1),
          std::min(int(theta * picture.height), picture.height - 1)};
}

Rgb SkyLight::radiance(Vec3f d) const {
  struct Visitor {
    const SkyLight& sky;
    Vec3f d;
    Rgb operator()(const ConstantSky& s) const { return s.radiance; }
    Rgb operator()(const GradientSky& s) const {
      const float height = dot(d, sky.up_);
      const Rgb end = height > 0 ? s.zenith : s.ground;
      return s.horizon + (end - s.horizon) * std::min(std::abs(height), 1.0f);
    }
    Rgb operator()(const ImageSky& s) const {
      const Pixel p = sky.pixel_at(d);
      return s.pixels[std::size_t(p.y) * std::size_t(s.width) + std::size_t(p.x)] * s.scale;
    }
  };
  return std::visit(Visitor{*this, d}, environment_);
}

float SkyLight::pixel_pdf(Pixel p) const {
  const auto& picture = std::get<ImageSky>(environment_);
  const std::size_t y = std::size_t(p.y), x = std::size_t(p.x), width = std::size_t(picture.width);
  const double* row = &pixel_cdf_[y * (width + 1)];
  const double share = (row_cdf_[y + 1] - row_cdf_[y]) * (row[x + 1] - row[x]);
  const double solid_angle = 2 * pi / picture.width * (row_y_[y] - row_y_[y + 1]);
  return float(share / solid_angle);
}

LightSample SkyLight::sample(Rng& rng) const {
  const auto& picture = std::get<ImageSky>(environment_);
  const Philox::Block bits = rng.block();
  const int y = find_bin(row_cdf_, to_uniform_double(bits.lo));
  const std::size_t width = std::size_t(picture.width);
  const std::span row(&pixel_cdf_[std::size_t(y) * (width + 1)], width + 1);
  const int x = find_bin(row, to_uniform_double(bits.hi));
  // Uniform in the pixel's solid angle: cos(theta) and azimuth are uniform.
  const double top = row_y_[std::size_t(y)], bottom = row_y_[std::size_t(y) + 1];
  const auto [along, around] = rng.uniform2();
  const double cosine = top + (bottom - top) * double(along);
  const double azimuth = 2 * pi * ((x + double(around)) / picture.width + rotation_);
  const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
  Vec3f d(Vec3d(sine * std::cos(azimuth), cosine, sine * std::sin(azimuth)));
  if (turned_) d = x_ * d.x + y_ * d.y + z_ * d.z;
  return {d, picture.pixels[std::size_t(y) * width + std::size_t(x)] * picture.scale,
          pixel_pdf({x, y})};
}

/// How many patches a sky is divided into, across and down.
SkyLight::Pixel SkyLight::patches() const {
  constexpr int kAcross = 512, kDown = 256;
  const auto* picture = std::get_if<ImageSky>(&environment_);
  if (!picture) return {kAcross, kDown};
  const auto multiple = [](int pixels, int least) { return pixels * ((least - 1) / pixels + 1); };
  return {multiple(picture->width, kAcross), multiple(picture->height, kDown)};
}

/// Of a place in a picture, over its size; of other skies in a picture that stands upright.
Vec3f SkyLight::direction_at(double across, double down) const {
  const double azimuth = 2 * pi * (across + rotation_), theta = pi * down, sine = std::sin(theta);
  const Vec3f d(Vec3d(sine * std::cos(azimuth), std::cos(theta), sine * std::sin(azimuth)));
  return turned_ ? x_ * d.x + y_ * d.y + z_ * d.z : d;
}

/// Of all azimuths between two heights of it.
double SkyLight::solid_angle(double top, double bottom) {
  return 2 * pi * (std::cos(pi * top) - std::cos(pi * bottom));
}

float SkyLight::pdf(Vec3f d) const { return sampled() ? pixel_pdf(pixel_at(d)) : 0.0f; }

SunLight::SunLight(const Sun& sun)
    : direction(Vec3f(normalize(sun.direction))), irradiance(sun.irradiance) {
  const double radius = sun.angle / 2 * pi / 180;
  if (radius < kLeastRadius) return;
  // 1 - cos = 2 sin^2 of the half: exact for the smallest discs. The irradiance of a disc of
  // uniform radiance L on the plane that faces it is L pi sin^2(radius).
  const double half = std::sin(radius / 2), sine = std::sin(radius);
  one_minus_cos_radius = float(2 * half * half);
  disc_pdf = float(1 / (4 * pi * half * half));
  disc_radiance = irradiance * float(1 / (pi * sine * sine));
}

LightSample SunLight::sample_disc(Rng& rng) const {
  const auto [u, azimuth] = rng.uniform2();
  return {turn(direction, one_minus_cos_radius * u, azimuth), disc_radiance, disc_pdf};
}

namespace {

/// Share of the irradiance of a plane that faces the middle of a disc of even radiance, for one
/// whose normal is `angle` away from there. Above the horizon as a whole it counts by the cosine;
/// of a disc that sets, arcs at equal angles from the normal are summed.
double share_on_plane(double angle, double radius) {
  if (angle + radius <= pi / 2) return std::cos(angle);
  if (angle - radius >= pi / 2) return 0;
  constexpr int kArcs = 512;
  const double from = std::max(angle - radius, 0.0), step = (pi / 2 - from) / kArcs;
  double sum = 0;
  for (int i = 0; i < kArcs; ++i) {
    const double a = from + (i + 0.5) * step;
    const double cosine =
        (std::cos(radius) - std::cos(a) * std::cos(angle)) / (std::sin(a) * std::sin(angle));
    sum += std::cos(a) * std::sin(a) * 2 * std::acos(std::clamp(cosine, -1.0, 1.0)) * step;
  }
  return sum / (pi * std::sin(radius) * std::sin(radius));
}

}  // namespace

Rgb SunLight::on_plane(Vec3d /*place*/, Vec3d normal) const {
  const double cosine = std::clamp(dot(Vec3d(direction), normal), -1.0, 1.0);
  if (disc_pdf == 0) return irradiance * float(std::max(0.0, cosine));
  const double radius = 2 * std::asin(std::sqrt(0.5 * double(one_minus_cos_radius)));
  return irradiance * float(share_on_plane(std::acos(cosine), radius));
}

Rgb PointSource::on_plane(Vec3d place, Vec3d normal) const {
  const LightSample l = arriving_at(place);
  return l.radiance * float(std::max(0.0, dot(Vec3d(l.direction), normal)));
}

LightSample PointSource::arriving_at(Vec3d place) const {
  const Vec3d way = position - place;
  const double distance = length(way);
  const Rgb irradiance(Vec3d(intensity) / (distance * distance));
  // At the light, or nearer than sqrt(I / 3e38), a float does not hold what arrives.
  if (!(distance > 0) || !is_finite(irradiance)) return {Vec3f(0, 0, 1), Rgb(0.0f)};
  return {Vec3f(way / distance), irradiance, 0, distance};
}

Rgb PointSource::irradiance_on(const Box& box) const {
  const Vec3d way = position - box.centre(), rim = box.extent() * 0.5;
  return Rgb(Vec3d(intensity) / std::max(dot(way, way), dot(rim, rim)));
}

namespace {

/// One for each kind of light.
LightSource make_ready(const Sun& sun) { return SunLight(sun); }
LightSource make_ready(const PointLight& light) {
  return PointSource{light.position, light.intensity};
}

}  // namespace

std::vector<LightSource> make_light_sources(std::span<const Light> lights) {
  std::vector<LightSource> sources;
  for (const Light& light : lights) {
    sources.push_back(std::visit([](const auto& l) { return make_ready(l); }, light));
  }
  return sources;
}

}  // namespace pvol
