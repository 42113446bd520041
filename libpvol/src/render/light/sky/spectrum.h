// Spectra of the sky: a few bands, on which loops of a fixed length work.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

#include "pvol/math/color_space.h"
#include "pvol/math/vec.h"

namespace pvol::detail {

/// Wavelengths in nm, evenly from first to last; between them spectra of air are taken as linear.
inline constexpr int kBands = 16;
inline constexpr double kFirstBand = 380, kLastBand = 720;
[[nodiscard]] constexpr double band_nm(int band) {
  return kFirstBand + (kLastBand - kFirstBand) * band / (kBands - 1);
}

/// One number for each band.
struct Spectrum {
  std::array<float, kBands> v{};

  Spectrum() = default;
  explicit Spectrum(float all) { v.fill(all); }
  /// f(nm) at each band.
  template <class F>
  requires requires(F f) { f(500.0); }
  explicit Spectrum(const F& f) {
    for (int i = 0; i < kBands; ++i) v[std::size_t(i)] = float(f(band_nm(i)));
  }

  [[nodiscard]] float operator[](int band) const { return v[std::size_t(band)]; }
  [[nodiscard]] float& operator[](int band) { return v[std::size_t(band)]; }

  Spectrum& operator+=(const Spectrum& b) {
    return each(b, [](float x, float y) { return x + y; });
  }
  Spectrum& operator-=(const Spectrum& b) {
    return each(b, [](float x, float y) { return x - y; });
  }
  Spectrum& operator*=(const Spectrum& b) {
    return each(b, [](float x, float y) { return x * y; });
  }
  Spectrum& operator/=(const Spectrum& b) {
    return each(b, [](float x, float y) { return x / y; });
  }
  Spectrum& operator*=(float s) {
    for (float& x : v) x *= s;
    return *this;
  }
  /// Adds s b.
  Spectrum& add(const Spectrum& b, float s) {
    return each(b, [s](float x, float y) { return x + s * y; });
  }
  friend Spectrum operator+(Spectrum a, const Spectrum& b) { return a += b; }
  friend Spectrum operator-(Spectrum a, const Spectrum& b) { return a -= b; }
  friend Spectrum operator*(Spectrum a, const Spectrum& b) { return a *= b; }
  friend Spectrum operator/(Spectrum a, const Spectrum& b) { return a /= b; }
  friend Spectrum operator*(Spectrum a, float s) { return a *= s; }
  friend bool operator==(const Spectrum&, const Spectrum&) = default;

 private:
  template <class F>
  Spectrum& each(const Spectrum& b, const F& f) {
    for (std::size_t i = 0; i < kBands; ++i) v[i] = f(v[i], b.v[i]);
    return *this;
  }
};

/// exp(x) for x <= 0, relative error below 8e-6, and that of -87 below it: loops over it become
/// vectors, which those over std::exp do not, and it is the same everywhere.
[[nodiscard]] inline float exp_below(float x) {
  const float y = (x > -87.0f ? x : -87.0f) * 1.44269504f;
  const auto whole = std::int32_t(y - 0.5f);  // towards 0: the nearest, as y <= 0
  const float u = (y - float(whole)) * 0.69314718f;
  const float p =
      1 +
      u * (1 + u * (0.5f + u * (1.0f / 6 + u * (1.0f / 24 + u * (1.0f / 120 + u * (1.0f / 720))))));
  const float power = std::bit_cast<float>((whole + 127) << 23);
  return p * power;
}

/// exp(-depth), depths >= 0.
[[nodiscard]] inline Spectrum transmittance(const Spectrum& depth) {
  Spectrum t;
  for (std::size_t i = 0; i < kBands; ++i) t.v[i] = exp_below(-depth.v[i]);
  return t;
}

/// What a spectrum looks like that is a factor on the sun's above the air, whose luminance is 1:
/// linear, negative outside the gamut.
[[nodiscard]] Vec3d seen_as(const Spectrum& factor, ColorSpace space);

/// Albedo of grounds of this colour: that of the channel in its part of the spectrum, and mixed
/// linearly around 490 and 590 nm.
[[nodiscard]] Spectrum albedo_spectrum(Rgb albedo);

}  // namespace pvol::detail
