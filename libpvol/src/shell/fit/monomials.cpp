#include "shell/fit/monomials.h"

#include <algorithm>
#include <cstring>

namespace pvol::detail {
namespace {

// Eight floats at once: the vector extension of GCC and Clang, of a fixed width so that sums do not
// depend on the processor. Arrays that are read so hold a multiple of eight.
using Wide = float __attribute__((vector_size(4 * kWide)));

double total(const Wide& v) {
  double sum = 0;
  for (std::size_t lane = 0; lane < kWide; ++lane) sum += double(v[lane]);
  return sum;
}

}  // namespace

Monomials monomials(const Quadric& q) {
  Monomials m;
  std::ranges::transform(terms(q), m.begin(), [](double c) { return float(c); });
  return m;
}

void evaluate(const Monomials& q, const Points& points, float* values) {
  const float *x = points.x.data(), *y = points.y.data(), *z = points.z.data();
  for (std::size_t i = 0; i < points.size(); ++i) {
    values[i] = x[i] * (q[0] * x[i] + q[5] * y[i] + q[4] * z[i] + q[6]) +
                y[i] * (q[1] * y[i] + q[3] * z[i] + q[7]) + z[i] * (q[2] * z[i] + q[8]) + q[9];
  }
}

float greatest(const Monomials& q, const Points& points) {
  std::vector<float> values(points.size());
  evaluate(q, points, values.data());
  while (values.size() % kWide != 0) values.push_back(values[0]);
  return largest(values);
}

std::size_t count_positive(const Monomials& q, const Points& points) {
  std::vector<float> values(points.size());
  evaluate(q, points, values.data());
  std::size_t count = 0;
  for (const float v : values) count += v > 0;
  return count;
}

QuadricTerms moments(const Points& points, const std::vector<float>& weight) {
  Wide sum[10] = {};
  for (std::size_t i = 0; i < points.size(); i += kWide) {
    Wide x, y, z, w;
    std::memcpy(&x, &points.x[i], sizeof x);
    std::memcpy(&y, &points.y[i], sizeof y);
    std::memcpy(&z, &points.z[i], sizeof z);
    std::memcpy(&w, &weight[i], sizeof w);
    const Wide wx = w * x, wy = w * y, wz = w * z;
    sum[0] += wx * x;
    sum[1] += wy * y;
    sum[2] += wz * z;
    sum[3] += wy * z;
    sum[4] += wz * x;
    sum[5] += wx * y;
    sum[6] += wx;
    sum[7] += wy;
    sum[8] += wz;
    sum[9] += w;
  }
  QuadricTerms result;
  for (std::size_t k = 0; k < 10; ++k) result[k] = total(sum[k]);
  return result;
}

float largest(const std::vector<float>& values) {
  Wide most;
  std::memcpy(&most, values.data(), sizeof most);
  for (std::size_t i = kWide; i < values.size(); i += kWide) {
    Wide v;
    std::memcpy(&v, &values[i], sizeof v);
    most = v > most ? v : most;
  }
  float result = most[0];
  for (std::size_t lane = 1; lane < kWide; ++lane) result = std::max(result, most[lane]);
  return result;
}

}  // namespace pvol::detail
