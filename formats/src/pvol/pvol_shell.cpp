// The shel chunk: a bounding shell with its certificate.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "pvol/error.h"
#include "pvol/pvol_chunks.h"

namespace pvol::formats::detail {
namespace {

using StoredQuadric = std::array<float, 10>;

StoredQuadric stored(const Quadric& q) {
  StoredQuadric c;
  std::ranges::transform(terms(q), c.begin(), [](double v) { return float(v); });
  return c;
}

Quadric loaded(const StoredQuadric& c) {
  QuadricTerms t;
  std::ranges::copy(c, t.begin());
  return quadric(t);
}

struct StoredPerturbation {
  StoredQuadric quadric = {};
  float strength = 0;
};
static_assert(sizeof(StoredPerturbation) == 44);

template <class T>
void append(std::vector<std::byte>& to, const T& value) {
  const std::size_t at = to.size();
  to.resize(at + sizeof value);
  std::memcpy(to.data() + at, &value, sizeof value);
}

}  // namespace

std::vector<std::byte> encode_shell(const Shell& shell, const Pyramid& pyramid,
                                    const std::string& place) {
  if (const auto wrong = validate(shell)) {
    throw Error(place + ": the shell to write is wrong: " + *wrong + ".");
  }
  if (shell.lo != pyramid.support_lo || shell.hi != pyramid.support_hi) {
    throw Error(
        place +
        ": the shell to write belongs to another cloud: its box differs from that of the bounds.");
  }
  ShellHeader h;
  h.kind = shell.kind == ShellKind::soft ? 1 : 0;
  h.perturbations = std::uint32_t(shell.form.perturbations.size());
  h.bound = shell.certificate.bound;
  h.boxes = shell.certificate.boxes;
  h.depth = shell.certificate.depth;
  const ShellTightness& t = shell.tightness;
  h.tightness = {float(t.volume_ratio), float(t.hit_ratio), float(t.box_volume_ratio),
                 float(t.box_hit_ratio)};
  std::vector<std::byte> bytes;
  append(bytes, h);
  append(bytes, stored(shell.form.base));
  for (const Perturbation& r : shell.form.perturbations) {
    append(bytes, StoredPerturbation{stored(r.form.base), float(r.strength)});
  }
  return bytes;
}

Shell decode_shell(ChunkReader& chunk, const Pyramid& pyramid) {
  const auto h = chunk.get<ShellHeader>();
  if (h.kind > 1) {
    throw Error(fmt::format("{}: a shell of the unknown kind {}. Use a newer pvol.", chunk.place(),
                            h.kind));
  }
  const std::uint64_t expected = sizeof(ShellHeader) + sizeof(StoredQuadric) +
                                 std::uint64_t(h.perturbations) * sizeof(StoredPerturbation);
  if (h.perturbations > std::uint32_t(kMaxPerturbations) || chunk.raw_bytes() != expected) {
    refuse(chunk.place(), fmt::format("{} perturbations do not fit into {} bytes", h.perturbations,
                                      chunk.raw_bytes()));
  }
  Shell shell;
  shell.kind = h.kind == 1 ? ShellKind::soft : ShellKind::hard;
  shell.lo = pyramid.support_lo;
  shell.hi = pyramid.support_hi;
  shell.certificate = {h.bound, h.boxes, h.depth};
  for (const float ratio : h.tightness) {
    if (!std::isfinite(ratio)) refuse(chunk.place(), "a ratio is not finite");
  }
  shell.tightness = {double(h.tightness[0]), double(h.tightness[1]), double(h.tightness[2]),
                     double(h.tightness[3])};
  shell.form.base = loaded(chunk.get<StoredQuadric>());
  std::vector<StoredPerturbation> perturbations(h.perturbations);
  chunk.read(perturbations);
  for (const StoredPerturbation& p : perturbations) {
    shell.form.perturbations.push_back({{loaded(p.quadric), {}}, double(p.strength)});
  }
  if (const auto wrong = validate(shell)) refuse(chunk.place(), *wrong);
  return shell;
}

}  // namespace pvol::formats::detail
