#include "support/oracle.h"

#include <algorithm>
#include <cmath>

namespace pvol::test {
namespace {

/// Whether lattice points first ... last of each axis meet those of the field, and whether they are
/// all among them.
struct Overlap {
  bool any = true, all = true;

  Overlap(const Field& field, Vec3i first, Vec3i last) {
    const Vec3i end = field.origin + field.size;
    for (int axis = 0; axis < 3; ++axis) {
      any = any && last[axis] >= field.origin[axis] && first[axis] < end[axis];
      all = all && first[axis] >= field.origin[axis] && last[axis] < end[axis];
    }
  }
};

/// The trilinear polynomial of a cell, at a point in it or near it.
double trilinear(const Field& field, Vec3i cell, Vec3d p) {
  const Overlap overlap(field, cell, cell + Vec3i(1));
  if (!overlap.any) return 0;
  const Vec3d f = p - Vec3d(cell);
  const Vec3i at = cell - field.origin;
  const auto ny = std::size_t(field.size.y), nz = std::size_t(field.size.z);
  const auto value = [&](Vec3i c) {
    if (!overlap.all) return field.at(cell + c);
    return field.samples[(std::size_t(at.x + c.x) * ny + std::size_t(at.y + c.y)) * nz +
                         std::size_t(at.z + c.z)];
  };
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3i c(corner & 1, corner >> 1 & 1, corner >> 2);
    const double weight = (c.x ? f.x : 1 - f.x) * (c.y ? f.y : 1 - f.y) * (c.z ? f.z : 1 - f.z);
    sum += weight * double(value(c));
  }
  return sum;
}

/// The cubic B-spline of unit knots about 0.
double cubic_kernel(double x) {
  x = std::abs(x);
  if (x >= 2) return 0;
  return x < 1 ? (4 - 6 * x * x + 3 * x * x * x) / 6 : (2 - x) * (2 - x) * (2 - x) / 6;
}

/// The tricubic polynomial of a cell, at a point in it.
double tricubic(const Field& field, Vec3i cell, Vec3d p) {
  if (!Overlap(field, cell - Vec3i(1), cell + Vec3i(2)).any) return 0;
  double kernel[3][4];  // by axis
  for (int i = 0; i < 4; ++i) {
    const Vec3d d = p - Vec3d(cell + Vec3i(i - 1));
    for (int axis = 0; axis < 3; ++axis) kernel[axis][i] = cubic_kernel(d[axis]);
  }
  double sum = 0;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      for (int k = 0; k < 4; ++k) {
        sum += kernel[0][i] * kernel[1][j] * kernel[2][k] *
               double(field.at(cell + Vec3i(i - 1, j - 1, k - 1)));
      }
    }
  }
  return sum;
}

Vec3i floor_of(Vec3d p) {
  return {int(std::floor(p.x)), int(std::floor(p.y)), int(std::floor(p.z))};
}

/// The cell of interpolation, or the lattice point nearest to p, the upper one if two are.
Vec3i piece_of(LookUp look_up, Vec3d p) {
  return floor_of(look_up == LookUp::nearest ? p + Vec3d(0.5) : p);
}

double density_in_piece(const Field& field, LookUp look_up, Vec3i piece, Vec3d p) {
  if (look_up == LookUp::tricubic) return tricubic(field, piece, p);
  return look_up == LookUp::trilinear ? trilinear(field, piece, p) : double(field.at(piece));
}

/// Where the ray crosses planes x_axis = offset + integer, between t0 and t1.
void add_crossings(const Ray& ray, int axis, double offset, Span span, std::vector<double>& knots) {
  if (ray.d[axis] == 0) return;
  double x0 = ray.at(span.t0)[axis] - offset, x1 = ray.at(span.t1)[axis] - offset;
  if (x0 > x1) std::swap(x0, x1);
  for (double plane = std::floor(x0); plane <= std::ceil(x1); ++plane) {
    const double t = (plane + offset - ray.o[axis]) / ray.d[axis];
    if (t > span.t0 && t < span.t1) knots.push_back(t);
  }
}

}  // namespace

double density_at(const Field& field, LookUp look_up, Vec3d p) {
  return density_in_piece(field, look_up, piece_of(look_up, p), p);
}

RayOracle::RayOracle(const Field& field, LookUp look_up, const Ray& ray, double extinction,
                     double end)
    : field_(&field), look_up_(look_up), ray_(ray), scale_(extinction) {
  const int reach = look_up == LookUp::tricubic ? 2 : 1;
  const Box box{Vec3d(field.origin - Vec3i(reach)),
                Vec3d(field.origin + field.size + Vec3i(reach - 1))};
  const auto span = intersect(box, ray, 0, end);
  if (!span) return;
  const double offset = look_up == LookUp::nearest ? 0.5 : 0;
  knots_ = {span->t0, span->t1};
  for (int axis = 0; axis < 3; ++axis) add_crossings(ray, axis, offset, *span, knots_);
  std::sort(knots_.begin(), knots_.end());
  knots_.erase(std::unique(knots_.begin(), knots_.end()), knots_.end());
  depth_.push_back(0);
  for (std::size_t i = 0; i + 1 < knots_.size(); ++i) {
    depth_.push_back(depth_.back() + integral(i, knots_[i + 1]));
  }
}

/// mu_t at t by the polynomial of a piece, which its midpoint identifies beyond doubt.
double RayOracle::in_piece(std::size_t piece, double t) const {
  const Vec3d middle = ray_.at(0.5 * (knots_[piece] + knots_[piece + 1]));
  return scale_ * density_in_piece(*field_, look_up_, piece_of(look_up_, middle), ray_.at(t));
}

/// int of mu_t from the piece's start to t: by Simpson's rule, which is exact for cubics, or that
/// of Gauss with five points, which is for the polynomials of degree 9 of tricubic fields.
double RayOracle::integral(std::size_t piece, double t) const {
  const double a = knots_[piece], middle = 0.5 * (a + t), half = 0.5 * (t - a);
  if (look_up_ != LookUp::tricubic) {
    return half / 3 * (in_piece(piece, a) + 4 * in_piece(piece, middle) + in_piece(piece, t));
  }
  const double root = 2 * std::sqrt(10.0 / 7), part = 13 * std::sqrt(70.0);
  double sum = 128.0 / 225 * in_piece(piece, middle);
  for (const double sign : {-1.0, 1.0}) {
    const double x = half * std::sqrt(5 + sign * root) / 3, weight = (322 - sign * part) / 900;
    sum += weight * (in_piece(piece, middle - x) + in_piece(piece, middle + x));
  }
  return half * sum;
}

std::size_t RayOracle::piece_at(double t) const {
  const auto after = std::upper_bound(knots_.begin() + 1, knots_.end() - 1, t);
  return std::size_t(after - knots_.begin()) - 1;
}

double RayOracle::extinction(double t) const {
  if (knots_.empty() || t < knots_.front() || t > knots_.back()) return 0;
  return in_piece(piece_at(t), t);
}

double RayOracle::optical_depth(double t) const {
  if (knots_.empty() || t <= knots_.front()) return 0;
  if (t >= knots_.back()) return depth_.back();
  const std::size_t piece = piece_at(t);
  return depth_[piece] + integral(piece, t);
}

double RayOracle::inverse_optical_depth(double depth) const {
  if (knots_.empty()) return 0;
  const auto above = std::lower_bound(depth_.begin() + 1, depth_.end() - 1, depth);
  const auto piece = std::size_t(above - depth_.begin()) - 1;
  double lo = knots_[piece], hi = knots_[piece + 1];
  for (;;) {  // bisection until no midpoint is left
    const double middle = 0.5 * (lo + hi);
    if (middle <= lo || middle >= hi) return hi;
    (depth_[piece] + integral(piece, middle) < depth ? lo : hi) = middle;
  }
}

}  // namespace pvol::test
