// The C API (pvol/pvol.h, which is the manual) for C++17: owners instead of handles, exceptions
// where volumes are made, and nothing between a ray and its call. It is a header alone, over the C
// functions of the library, whatever compiled that.
//
//   pvol::api::Volume cloud;
//   cloud.set(PVOL_DENSITY, pvol::api::array(data, {nx, ny, nz})).set_extinction(4).commit();
//
//   // For each ray, on any thread:
//   pvol::api::Random random(seed, pixel, sample);
//   if (const auto t = cloud.flight({{ox, oy, oz}, {dx, dy, dz}, t_max}, random)) { ... at *t ... }
//   const float passed = cloud.transmittance(shadow_ray, PVOL_RATIO, random);
#ifndef PVOL_PVOL_HPP
#define PVOL_PVOL_HPP

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <limits>
#include <new>
#include <optional>
#include <utility>

#include "pvol/pvol.h"

namespace pvol {
namespace api {

/// What failed, by pvol_message; of that the first 1023 bytes.
class Error : public std::exception {
 public:
  Error(pvol_status status, const char* message) noexcept : status_(status) {
    std::snprintf(message_, sizeof message_, "%s", message);
  }
  const char* what() const noexcept override { return message_; }
  pvol_status status() const noexcept { return status_; }

 private:
  pvol_status status_;
  char message_[1024];
};

using Vec = std::array<double, 3>;
using Rgb = std::array<float, 3>;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A ray as pvol_ray. Without a t_max it is infinite.
inline pvol_ray ray(const Vec& o, const Vec& d, double t_max = kInfinity) {
  return {{o[0], o[1], o[2]}, {d[0], d[1], d[2]}, t_max};
}

/// N objects of somebody's.
template <class T>
struct Span {
  T* data = nullptr;
  std::size_t size = 0;
};

inline pvol_type type_of(const float*) { return PVOL_FLOAT; }
inline pvol_type type_of(const double*) { return PVOL_DOUBLE; }

/// Samples values[i][j][k], k fastest.
template <class T>
pvol_array array(const T* values, const std::array<std::int32_t, 3>& size,
                 const std::array<std::int32_t, 3>& origin = {{0, 0, 0}}) {
  pvol_array a{};
  a.values = values;
  a.type = type_of(values);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    a.size[axis] = size[axis];
    a.origin[axis] = origin[axis];
  }
  return a;
}

/// Vectors x y z, each after the other `stride` bytes on; 0: packed.
template <class T>
pvol_vectors vectors(const T* values, std::int64_t stride = 0) {
  pvol_vectors v{};
  v.values = values;
  v.type = type_of(values);
  v.stride = stride;
  v.component_stride = stride == 0 ? 0 : std::int64_t(sizeof(T));
  return v;
}

/// Random numbers: a stream of pvol's own, or those of a function of yours.
class Random : public pvol_random {
 public:
  Random(std::uint64_t seed, std::uint64_t stream, std::uint64_t sample) : pvol_random{} {
    pvol_seed(this, seed, stream, sample);
  }
  /// `f()` returns the next number of [0, 1) and must outlive this; it must not throw.
  template <class F>
  static Random of(F& f) {
    Random r(0, 0, 0);
    r.next = [](void* user) { return static_cast<double>((*static_cast<F*>(user))()); };
    r.user = &f;
    return r;
  }
  /// The next numbers are these, then those of the stream; they must outlive their use. Without
  /// effect on numbers of a function.
  Random& begin_with(Span<const float> first) {
    numbers = first.data;
    count = static_cast<std::uint32_t>(first.size);
    taken = 0;
    return *this;
  }
  double uniform() { return pvol_uniform(this); }
};

/// A flight where channels differ in their extinction.
struct RgbFlight {
  std::optional<double> t;  ///< of the collision, if there is one
  Rgb weight;               ///< by which to multiply the throughput, also where there is none
};

/// A ray's way through a volume, as pvol_walk. Copies go their own ways.
class Walk {
 public:
  Walk() = default;  ///< without segments
  Walk(const pvol_volume* volume, const pvol_ray& ray) { pvol_enter(volume, &ray, &walk_); }

  std::optional<pvol_segment> next() {
    pvol_segment s;
    if (pvol_next(&walk_, &s) == 0) return std::nullopt;
    return s;
  }
  float density(double t) const { return pvol_walk_density(&walk_, t); }
  float extinction(double t) const { return pvol_walk_extinction(&walk_, t); }
  bool exceeds(double t, float mu) const { return pvol_walk_exceeds(&walk_, t, mu) != 0; }
  Vec place(double t) const {
    Vec at;
    pvol_walk_place(&walk_, t, at.data());
    return at;
  }

  std::optional<double> flight(pvol_random& random) {
    double t;
    if (pvol_walk_flight(&walk_, &random, &t) != 1) return std::nullopt;
    return t;
  }
  float transmittance(pvol_estimator estimator, pvol_random& random) {
    return pvol_walk_transmittance(&walk_, estimator, &random);
  }
  double optical_depth() { return pvol_walk_optical_depth(&walk_); }
  RgbFlight flight_rgb(const Rgb& throughput, pvol_random& random) {
    RgbFlight f;
    double t;
    if (pvol_walk_flight_rgb(&walk_, throughput.data(), &random, &t, f.weight.data()) == 1) f.t = t;
    return f;
  }
  Rgb transmittance_rgb(pvol_random& random) {
    Rgb passed;
    pvol_walk_transmittance_rgb(&walk_, &random, passed.data());
    return passed;
  }
  /// False for a bad direction.
  bool resume(double t, const Vec& direction, double t_max = kInfinity) {
    return pvol_resume(&walk_, t, direction.data(), t_max) == 1;
  }

  pvol_walk* get() { return &walk_; }

 private:
  pvol_walk walk_{};
};

/// An owner of a pvol_volume; copies own the same one. What makes volumes throws Error.
class Volume {
 public:
  Volume() : volume_(pvol_new_volume()) {
    if (volume_ == nullptr) throw std::bad_alloc();
  }
  /// Takes over a reference.
  explicit Volume(pvol_volume* owned) : volume_(owned) {}
  Volume(const Volume& other) : volume_(other.volume_) { pvol_retain(volume_); }
  Volume(Volume&& other) noexcept : volume_(std::exchange(other.volume_, nullptr)) {}
  Volume& operator=(Volume other) noexcept {
    std::swap(volume_, other.volume_);
    return *this;
  }
  ~Volume() { pvol_release(volume_); }
  pvol_volume* get() const { return volume_; }

  Volume& set(int field, const pvol_array& a) { return require(pvol_set_array(get(), field, &a)); }
  Volume& set(int field, const pvol_bricks& b) {
    return require(pvol_set_bricks(get(), field, &b));
  }
  Volume& set(int field, const pvol_leaves& l) {
    return require(pvol_set_leaves(get(), field, &l));
  }
  Volume& share(int field, const pvol_array& a) {
    return require(pvol_share_array(get(), field, &a));
  }
  Volume& share(int field, const pvol_leaves& l) {
    return require(pvol_share_leaves(get(), field, &l));
  }
  Volume& set_changed(int field, const std::array<std::int32_t, 3>& lo,
                      const std::array<std::int32_t, 3>& hi) {
    return require(pvol_set_changed(get(), field, lo.data(), hi.data()));
  }
  Volume& clear(int field) { return require(pvol_clear_field(get(), field)); }
  Volume& set_transform(int field, const std::array<double, 12>& m) {
    return require(pvol_set_transform(get(), field, m.data()));
  }
  Volume& set_extinction(double mu) { return require(pvol_set_extinction(get(), mu)); }
  Volume& set_extinction_color(const Rgb& share) {
    return require(pvol_set_extinction_color(get(), share.data()));
  }
  Volume& set_interpolation(pvol_interpolation interpolation) {
    return require(pvol_set_interpolation(get(), interpolation));
  }
  Volume& set_shell(bool wanted) { return require(pvol_set_shell(get(), wanted ? 1 : 0)); }
  Volume& commit(const pvol_commit_options& options = {}) {
    return require(pvol_commit(get(), &options));
  }
  /// From any thread: commit, if one is under way, soon throws Error with PVOL_CANCELLED.
  void cancel() const { pvol_cancel(get()); }

  Volume& set_error_function(pvol_error_function function, void* user) {
    return require(pvol_set_error_function(get(), function, user));
  }
  /// `f(status, message)` is called before Error is thrown. It must outlive the volume, and must
  /// not throw.
  template <class F>
  Volume& set_error_function(F& f) {
    return set_error_function(
        [](void* user, pvol_status status, const char* message) {
          (*static_cast<F*>(user))(status, message);
        },
        &f);
  }

  /// Low and high corner; nothing where there is no density.
  std::optional<std::pair<Vec, Vec>> box() const {
    std::pair<Vec, Vec> b;
    if (pvol_box(get(), b.first.data(), b.second.data()) == 0) return std::nullopt;
    return b;
  }
  /// Bounds of mu_t, the lower first; nothing for a box that is not one, and without a commit.
  std::optional<std::array<float, 2>> extinction_range(const Vec& lo, const Vec& hi) const {
    std::array<float, 2> range;
    if (pvol_extinction_range(get(), lo.data(), hi.data(), range.data()) != 1) return std::nullopt;
    return range;
  }
  float density(const Vec& place) const { return pvol_density(get(), place.data()); }
  float extinction(const Vec& place) const { return pvol_extinction(get(), place.data()); }
  float value(int field, const Vec& place) const { return pvol_value(get(), field, place.data()); }
  std::uint64_t bytes() const { return pvol_bytes(get()); }

  /// Bad rays meet nothing; the C calls tell them apart.
  Walk enter(const pvol_ray& ray) const { return Walk(get(), ray); }
  std::optional<double> flight(const pvol_ray& ray, pvol_random& random) const {
    double t;
    if (pvol_sample_flight(get(), &ray, &random, &t) != 1) return std::nullopt;
    return t;
  }
  float transmittance(const pvol_ray& ray, pvol_estimator estimator, pvol_random& random) const {
    float passed = 1;
    return pvol_sample_transmittance(get(), &ray, estimator, &random, &passed) == 1 ? passed : 1;
  }
  /// Nothing for bad rays, and for all rays of tricubic volumes.
  std::optional<double> optical_depth(const pvol_ray& ray) const {
    double depth;
    if (pvol_optical_depth(get(), &ray, &depth) != 1) return std::nullopt;
    return depth;
  }
  /// How many spans there are; of them the first fill `spans`.
  std::size_t shell_spans(const pvol_ray& ray, Span<pvol_span> spans) const {
    constexpr std::size_t kMost = 1 << 20;
    const int capacity = static_cast<int>(spans.size < kMost ? spans.size : kMost);
    const int count = pvol_shell_spans(get(), &ray, spans.data, capacity);
    return count < 0 ? 0 : static_cast<std::size_t>(count);
  }

  /// Many rays at once; each returns the number of bad ones.
  std::size_t flights(const pvol_rays& rays, const pvol_streams& streams, Span<double> t) const {
    require_size(rays, t.size);
    return pvol_flights(get(), &rays, &streams, t.data);
  }
  std::size_t transmittances(const pvol_rays& rays, pvol_estimator estimator,
                             const pvol_streams& streams, Span<float> passed) const {
    require_size(rays, passed.size);
    return pvol_transmittances(get(), &rays, estimator, &streams, passed.data);
  }
  std::size_t optical_depths(const pvol_rays& rays, Span<double> depth) const {
    require_size(rays, depth.size);
    return pvol_optical_depths(get(), &rays, depth.data);
  }

 private:
  pvol_volume* volume_;

  Volume& require(pvol_status status) {
    if (status != PVOL_OK) throw Error(status, pvol_message(volume_));
    return *this;
  }
  static void require_size(const pvol_rays& rays, std::size_t results) {
    if (results >= rays.count) return;
    char message[128];
    std::snprintf(message, sizeof message,
                  "the array of results has %zu elements; expected one for each of %zu rays",
                  results, rays.count);
    throw Error(PVOL_INVALID, message);
  }
};

}  // namespace api
}  // namespace pvol

#endif
