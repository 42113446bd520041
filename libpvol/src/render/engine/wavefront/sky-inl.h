// Sampling a picture of a sky in lanes, as SkyPicture::sample() does it for one direction.

#if defined(PVOL_LANE_SKY_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_SKY_INL_H
#undef PVOL_LANE_SKY_INL_H
#else
#define PVOL_LANE_SKY_INL_H
#endif

#include "pvol/render/sky_picture.h"
#include "volume/simd/simd_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// A random number below n, from one of 32 bits.
HWY_INLINE I below(std::uint32_t n, U bits) {
  const auto even = hn::MulEven(bits, splat_bits(n)),
             odd = hn::MulEven(hn::Reverse2(kU, bits), splat_bits(n));
  const U high_of_even = hn::BitCast(kU, hn::ShiftRight<32>(even));
  return as_int(hn::OddEven(hn::BitCast(kU, odd), high_of_even));
}

/// The angle of (x, y), y not negative, from +x over 2 pi: turns_of().
HWY_INLINE F turns_of(F y, F x) {
  const F across = hn::Abs(x), most = hn::Max(across, y);
  const F q = select(hn::Gt(most, splat(0)), hn::Min(across, y) / most, splat(0)), s = q * q;
  F t = hn::MulAdd(s, splat(-0.00072571343f), splat(0.0037847871f));
  for (const float c : {-0.009363046f, 0.0157067872f, -0.0222869285f, 0.0317784067f, -0.0530492275f,
                        0.1591549243f}) {
    t = hn::MulAdd(t, s, splat(c));
  }
  t = t * q;
  t = select(hn::Gt(y, across), splat(0.25f) - t, t);
  return select(hn::Lt(x, splat(0)), splat(0.5f) - t, t);
}

struct PictureSample {
  V direction;
  V radiance;
  F pdf;
};

/// Pixels of a picture, by their columns and rows.
struct PictureLanes {
  const SkyPicture::Tables& t;

  struct Pixel {
    I x, y;
  };
  HWY_INLINE Pixel place_of(I pixel) const {
    const I width = splat_int(t.width), one = splat_int(1), zero = splat_int(0);
    // The quotient of floats may be one off.
    I y = to_int(to_float(pixel) * splat(1 / float(t.width)));
    I x = pixel - y * width;
    const M less = mask(hn::Lt(x, zero)), more = mask(hn::Lt(width - one, x));
    y = y - where(less, one) + where(more, one);
    x = x + where(less, width) - where(more, width);
    return {x, y};
  }
  HWY_INLINE V at(I pixel) const {
    const float* const all = &t.pixels->x;
    const I first = pixel + pixel + pixel;
    return {gather(all, first), gather(all + 1, first), gather(all + 2, first)};
  }
  /// Bilinear within the half of the sky that the place is in, `across` and `down` from the left
  /// and upper edges of the pixel's column and of the picture.
  HWY_INLINE V mixed(Pixel p, F across, F down) const {
    const I width = splat_int(t.width), half = splat_int(t.height / 2), one = splat_int(1);
    const I zero = splat_int(0);
    const I first = where(hn::Not(mask(hn::Lt(p.y, half))), half), last = first + half - one;
    const M left = hn::Lt(across, splat(0.5f));
    const I x = p.x - where(left, one), next = x + one;
    const F right = across - splat(0.5f) + select(left, splat(1), splat(0));
    const F y = hn::Max(to_float(first), hn::Min(down - splat(0.5f), to_float(last)));
    const I above = to_int(y), below = hn::Min(above + one, last);
    const F under = y - to_float(above);
    const I x0 = x + where(mask(hn::Lt(x, zero)), width);
    const I x1 = next - where(mask(hn::Lt(width - one, next)), width);
    const auto in_row = [&](I row) {
      return lerp(at(row * width + x0), at(row * width + x1), right);
    };
    return lerp(in_row(above), in_row(below), under);
  }
  static HWY_INLINE V lerp(V a, V b, F u) {
    return {hn::MulAdd(b.x - a.x, u, a.x), hn::MulAdd(b.y - a.y, u, a.y),
            hn::MulAdd(b.z - a.z, u, a.z)};
  }
};

HWY_INLINE PictureSample sample_picture(const SkyPicture::Tables& t, Random& rng) {
  const PictureLanes lanes{t};
  const I bin = below(std::uint32_t(t.bins.size()), rng.next());
  const U chance = rng.next();
  const F down = rng.uniform(), across = rng.uniform();
  const std::uint32_t* const bins = &t.bins.front().own;
  const M other = mask(hn::Lt(gather(bins, bin + bin), chance));
  const I pixel = select(other, as_int(gather(bins + 1, bin + bin)), bin);
  const PictureLanes::Pixel p = lanes.place_of(pixel);
  // Uniform in the pixel's solid angle: cos(theta) and azimuth are uniform.
  const float* const rows = &t.rows->from;
  const F v = hn::MulAdd(gather(rows + 1, p.y + p.y), down, gather(rows, p.y + p.y));
  const M upper = mask(hn::Lt(p.y, splat_int(t.upper_rows)));
  const F cosine = select(upper, splat(1) - v, v - splat(1));
  const F sine = hn::Sqrt(v * (splat(2) - v));
  const F turns = hn::MulAdd(to_float(p.x) + across, splat(1 / float(t.width)), splat(t.rotation));
  F c, s;
  point_at_turns(turns - select(hn::Lt(turns, splat(1)), splat(0), splat(1)), c, s);
  const V d{sine * c, cosine, sine * s};
  const V direction{dot(splat(t.x), d), dot(splat(t.y), d), dot(splat(t.z), d)};
  const F unit = splat(t.pdf_per_luminance);
  if (t.weights == nullptr) {
    const V radiance = lanes.at(pixel);
    const F luminance =
        hn::MulAdd(splat(0.2126f), radiance.x,
                   hn::MulAdd(splat(0.7152f), radiance.y, splat(0.0722f) * radiance.z));
    return {direction, radiance, luminance * unit};
  }
  const F place = splat(2 * float(t.height)) * turns_of(sine, cosine);
  return {direction, lanes.mixed(p, across, place), gather(t.weights, pixel) * unit};
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
