#include "support/slab_oracle.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace pvol::test {
namespace {

/// Weight of the nodes that are asked for besides the quadrature's: they see the light at the
/// others and add nothing to it.
constexpr double kTinyWeight = 1e-14;

/// A square matrix, by rows.
struct Matrix {
  std::size_t n;
  std::vector<double> a;

  explicit Matrix(std::size_t size) : n(size), a(size * size) {}
  [[nodiscard]] double operator()(std::size_t i, std::size_t j) const { return a[i * n + j]; }
  double& operator()(std::size_t i, std::size_t j) { return a[i * n + j]; }
};

Matrix identity(std::size_t n) {
  Matrix m(n);
  for (std::size_t i = 0; i < n; ++i) m(i, i) = 1;
  return m;
}

/// s a + b.
Matrix add(double s, const Matrix& a, const Matrix& b) {
  Matrix c = b;
  for (std::size_t i = 0; i < c.a.size(); ++i) c.a[i] += s * a.a[i];
  return c;
}

/// Adds `factor` times row `from` of a matrix to row `to` of another, or of the same.
void add_row(double factor, const Matrix& a, std::size_t from, Matrix& b, std::size_t to) {
  const double* const source = &a.a[from * a.n];
  double* const sum = &b.a[to * a.n];
  for (std::size_t j = 0; j < a.n; ++j) sum[j] += factor * source[j];
}

Matrix operator*(const Matrix& a, const Matrix& b) {
  Matrix c(a.n);
  for (std::size_t i = 0; i < a.n; ++i) {
    for (std::size_t k = 0; k < a.n; ++k) add_row(a(i, k), b, k, c, i);
  }
  return c;
}

/// a^-1 b, for matrices near the identity, which need no pivoting.
Matrix solve(Matrix a, Matrix b) {
  for (std::size_t k = 0; k < a.n; ++k) {
    for (std::size_t i = k + 1; i < a.n; ++i) {
      const double factor = a(i, k) / a(k, k);
      add_row(-factor, a, k, a, i);
      add_row(-factor, b, k, b, i);
    }
  }
  for (std::size_t k = a.n; k-- > 0;) {
    for (std::size_t j = 0; j < a.n; ++j) b(k, j) /= a(k, k);
    for (std::size_t i = 0; i < k; ++i) add_row(-a(i, k), b, k, b, i);
  }
  return b;
}

/// P_0(x) ... P_{count-1}(x).
std::vector<double> legendre(std::size_t count, double x) {
  std::vector<double> p(count, 1);
  if (count > 1) p[1] = x;
  for (std::size_t l = 2; l < count; ++l) {
    const double k = double(l);
    p[l] = ((2 * k - 1) * x * p[l - 1] - (k - 1) * p[l - 2]) / k;
  }
  return p;
}

struct Layer {
  Matrix reflection, transmission;
};

/// d(down, up)/d(tau) = generator (down, up), for radiances at the nodes that go down and up.
Matrix generator(const SlabOptics& o, const std::vector<double>& mu,
                 const std::vector<double>& weight, std::size_t terms) {
  const std::size_t n = mu.size();
  std::vector<std::vector<double>> p;
  for (const double x : mu) p.push_back(legendre(terms, x));
  Matrix m(2 * n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      // The phase function's azimuthal mean for cosines of one sign and of opposite signs.
      double same = 0, opposite = 0;
      for (std::size_t l = 0; l < terms; ++l) {
        const double term = double(2 * l + 1) * std::pow(o.g, double(l)) * p[i][l] * p[j][l];
        same += term;
        opposite += l % 2 == 0 ? term : -term;
      }
      const double scale = 0.5 * o.albedo * weight[j] / mu[i];
      m(i, j) = scale * same - (i == j ? 1 / mu[i] : 0);
      m(i, n + j) = scale * opposite;
      m(n + i, j) = -m(i, n + j);
      m(n + i, n + j) = -m(i, j);
    }
  }
  return m;
}

/// Largest sum of magnitudes in a row.
double norm(const Matrix& m) {
  double largest = 0;
  for (std::size_t i = 0; i < m.n; ++i) {
    double sum = 0;
    for (std::size_t j = 0; j < m.n; ++j) sum += std::abs(m(i, j));
    largest = std::max(largest, sum);
  }
  return largest;
}

/// Layers thinner than this many inverse norms of the generator have a short Taylor series.
constexpr double kThin = 0.25;

/// The layer of this thickness: exp(generator tau) takes what goes down and up at the top to what
/// does at the bottom; solved for what leaves.
Layer thin_layer(const Matrix& generator, double tau) {
  constexpr int kTerms = 12;  // kThin^13 / 13! is below 1e-17
  const std::size_t n = generator.n / 2;
  Matrix e = identity(2 * n);
  for (int k = kTerms; k > 0; --k) e = add(tau / k, generator * e, identity(2 * n));
  const auto block = [&](std::size_t row, std::size_t column) {
    Matrix b(n);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) b(i, j) = e(row * n + i, column * n + j);
    }
    return b;
  };
  const Matrix reflection = add(-1, solve(block(1, 1), block(1, 0)), Matrix(n));
  return {reflection, add(1, block(0, 1) * reflection, block(0, 0))};
}

/// Two such layers, with light going to and fro between them.
Layer doubled(const Layer& l) {
  const Matrix between =
      solve(add(-1, l.reflection * l.reflection, identity(l.reflection.n)), l.transmission);
  return {add(1, l.transmission * (l.reflection * between), l.reflection),
          l.transmission * between};
}

}  // namespace

Quadrature gauss_legendre(int n) {
  Quadrature q;
  for (int i = 0; i < n; ++i) {
    double x = -std::cos(std::numbers::pi * (i + 0.75) / (n + 0.5)), slope = 0;
    for (int step = 0; step < 10; ++step) {
      const std::vector<double> p = legendre(std::size_t(n) + 1, x);
      slope = n * (x * p[std::size_t(n)] - p[std::size_t(n) - 1]) / (x * x - 1);
      x -= p[std::size_t(n)] / slope;
    }
    q.x.push_back(0.5 + 0.5 * x);
    q.weight.push_back(1 / ((1 - x * x) * slope * slope));
  }
  return q;
}

Slab::Slab(const SlabOptics& optics, const std::vector<double>& cosines, int streams)
    : depth_(optics.depth), streams_(std::size_t(streams)) {
  Quadrature q = gauss_legendre(streams);
  mu_ = std::move(q.x);
  weight_ = std::move(q.weight);
  mu_.insert(mu_.end(), cosines.begin(), cosines.end());
  weight_.resize(mu_.size(), kTinyWeight);

  const Matrix change = generator(optics, mu_, weight_, 2 * streams_);
  int doublings = 0;
  while (std::ldexp(optics.depth, -doublings) * norm(change) > kThin) ++doublings;
  Layer layer = thin_layer(change, std::ldexp(optics.depth, -doublings));
  for (int i = 0; i < doublings; ++i) layer = doubled(layer);
  reflection_ = std::move(layer.reflection.a);
  transmission_ = std::move(layer.transmission.a);
}

/// What leaves at a node in a hemisphere of radiance 1 is, by reciprocity, what leaves in all
/// directions of a beam that falls in there.
Fluxes Slab::at_node(std::size_t node) const {
  Fluxes f{0, 0, std::exp(-depth_ / mu_[node])};
  for (std::size_t j = 0; j < mu_.size(); ++j) {
    f.reflected += reflection_[node * mu_.size() + j];
    f.transmitted += transmission_[node * mu_.size() + j];
  }
  f.transmitted -= f.direct;
  return f;
}

Fluxes Slab::collimated(std::size_t incidence) const { return at_node(streams_ + incidence); }

Fluxes Slab::diffuse() const {
  Fluxes sum{0, 0, 0};
  for (std::size_t i = 0; i < streams_; ++i) {
    const Fluxes f = at_node(i);
    const double share = 2 * mu_[i] * weight_[i];
    sum.reflected += share * f.reflected;
    sum.transmitted += share * f.transmitted;
    sum.direct += share * f.direct;
  }
  return sum;
}

double Slab::reflected_radiance(std::size_t view, std::size_t incidence) const {
  return reflection_[(streams_ + view) * mu_.size() + streams_ + incidence] /
         (2 * std::numbers::pi * kTinyWeight);
}

double Slab::transmitted_radiance(std::size_t view, std::size_t incidence) const {
  if (view == incidence) throw std::invalid_argument("slab: name the cosine twice");
  return transmission_[(streams_ + view) * mu_.size() + streams_ + incidence] /
         (2 * std::numbers::pi * kTinyWeight);
}

HFunction::HFunction(double albedo) : albedo_(albedo), nodes_(gauss_legendre(128)) {
  // The integrand has a logarithm's branch at 0: x = s^3 moves the nodes there.
  for (std::size_t i = 0; i < nodes_.x.size(); ++i) {
    const double s = nodes_.x[i];
    nodes_.x[i] = s * s * s;
    nodes_.weight[i] *= 3 * s * s;
  }
  h_.assign(nodes_.x.size(), 1);
  constexpr int kMostSteps = 1000;
  for (int step = 0; step < kMostSteps; ++step) {
    std::vector<double> next;
    for (const double mu : nodes_.x) next.push_back((*this)(mu));
    double change = 0;
    for (std::size_t i = 0; i < h_.size(); ++i) {
      change = std::max(change, std::abs(next[i] - h_[i]));
      h_[i] = 0.5 * (h_[i] + next[i]);  // iterates lie on both sides
    }
    if (change < 1e-13) return;
  }
  throw std::runtime_error("H-function: no convergence");
}

double HFunction::operator()(double mu) const {
  double integral = 0;
  for (std::size_t i = 0; i < h_.size(); ++i) {
    integral += nodes_.weight[i] * nodes_.x[i] * h_[i] / (mu + nodes_.x[i]);
  }
  return 1 / (std::sqrt(1 - albedo_) + 0.5 * albedo_ * integral);
}

double HFunction::plane_albedo(double mu) const { return 1 - std::sqrt(1 - albedo_) * (*this)(mu); }

}  // namespace pvol::test
