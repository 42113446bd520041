// Calls of the C interface, chosen by the bytes: what a host sets, commits and asks in any order
// and with any numbers. Pointers and sizes are honest, since C cannot check them; all else may be
// wrong. What rays return must be possible.
#include <array>
#include <cmath>
#include <cstring>
#include <deque>
#include <limits>
#include <vector>

#include "fuzz.h"
#include "pvol/pvol.h"

namespace {

using namespace pvol::fuzz;

constexpr int kMostCalls = 64;
constexpr int kEdge = 24;  // samples of the largest array along an axis

/// The input, byte by byte; zeros behind its end.
class Script {
 public:
  explicit Script(Input bytes) : bytes_(bytes) {}

  [[nodiscard]] bool ended() const { return at_ >= bytes_.size(); }
  std::uint8_t byte() { return ended() ? 0 : bytes_[at_++]; }
  int below(int end) { return byte() % end; }

  /// A number that hosts have, or one that nobody expects.
  double number() {
    static constexpr double kSome[] = {0,    1,     -1,    0.5,    3,      7.25, 24,  1e-3,
                                       -0.0, 1e-30, 1e300, 1e-300, 5e-324, 1e38, -12, 100};
    const int which = below(24);
    if (which < 16) return kSome[which];
    if (which == 16) return std::numeric_limits<double>::infinity();
    if (which == 17) return std::numeric_limits<double>::quiet_NaN();
    return (byte() * 256 + byte()) / 1024.0 - 32;
  }
  /// A lattice coordinate: small, or at the end of its type.
  std::int32_t coordinate() {
    const int which = below(16);
    if (which == 0) return std::numeric_limits<std::int32_t>::max() - below(16);
    if (which == 1) return std::numeric_limits<std::int32_t>::min() + below(16);
    return byte() - 64;
  }
  template <std::size_t kSize>
  void fill(double (&to)[kSize]) {
    for (double& v : to) v = number();
  }

 private:
  Input bytes_;
  std::size_t at_ = 0;
};

/// Samples for arrays and leaves of any type, which outlive the volumes.
struct Samples {
  std::array<double, std::size_t(kEdge) * kEdge * kEdge> memory{};

  void make(Script& script, pvol_type type) {
    const float value = float(script.number());
    const int period = 1 + script.below(16);
    for (std::size_t i = 0; i < memory.size(); ++i) {
      const double v = i % std::size_t(period) == 0 ? double(value) : 0.25;
      if (type == PVOL_DOUBLE) {
        memory[i] = v;
      } else {
        const auto f = float(v);
        std::memcpy(reinterpret_cast<char*>(memory.data()) + 4 * i, &f, 4);
      }
    }
  }
};

struct Host {
  Script script;
  // All stay as they are: those of other fields until a commit, shared ones as long as the volume.
  std::deque<Samples> samples{};
  std::deque<std::vector<pvol_leaf>> all_leaves{};
  std::deque<std::vector<pvol_tile>> all_tiles{};
  pvol_volume* volume = pvol_new_volume();
  pvol_random random{};

  explicit Host(Input bytes) : script(bytes) { pvol_seed(&random, 1, 2, 3); }
  ~Host() { pvol_release(volume); }
  Host(const Host&) = delete;
  Host& operator=(const Host&) = delete;

  pvol_array array() {
    Samples& own = samples.emplace_back();
    pvol_array a{};
    a.type = pvol_type(script.below(3));
    const bool invalid = script.below(16) == 0;
    own.make(script, a.type);
    a.values = script.below(16) == 0 ? nullptr : own.memory.data();
    for (int c = 0; c < 3; ++c) {
      a.size[c] = script.below(kEdge + 1) - (script.below(16) == 0 ? 2 : 0);
      a.origin[c] = script.coordinate();
    }
    if (script.below(2) == 1) {  // i fastest, where it fits into the memory
      const std::int64_t bytes = a.type == PVOL_DOUBLE ? 8 : a.type == PVOL_FLOAT ? 4 : 2;
      a.stride[0] = bytes, a.stride[1] = bytes * kEdge, a.stride[2] = bytes * kEdge * kEdge;
    }
    if (invalid) a.type = pvol_type(3);
    return a;
  }

  pvol_leaves tree() {
    auto& leaves = all_leaves.emplace_back();
    auto& tiles = all_tiles.emplace_back();
    Samples& own = samples.emplace_back();
    own.make(script, PVOL_FLOAT);
    const auto* values = reinterpret_cast<const float*>(own.memory.data());
    const auto origin = [&](std::int32_t(&to)[3], int edge) {
      for (std::int32_t& v : to) v = script.coordinate() / edge * edge + (script.below(32) == 0);
    };
    for (int n = script.below(6); n > 0; --n) {
      pvol_leaf leaf{script.below(32) == 0 ? nullptr : values, {}};
      origin(leaf.origin, 8);
      leaves.push_back(leaf);
    }
    for (int n = script.below(3); n > 0; --n) {
      static constexpr int kEdges[] = {8, 128, 8, 9};
      pvol_tile tile{{}, kEdges[script.below(4)], float(script.number())};
      origin(tile.origin, tile.edge);
      tiles.push_back(tile);
    }
    return {leaves.data(), leaves.size(), tiles.data(), tiles.size(), {}};
  }

  pvol_ray ray() {
    pvol_ray r{};
    script.fill(r.o), script.fill(r.d);
    r.t_max = script.number();
    return r;
  }
};

int fill_brick(void* user, const std::int32_t origin[3], float* values) {
  const int seed = *static_cast<const int*>(user);
  if (seed == 255) return 1;
  for (int i = 0; i < 512; ++i) values[i] = float((i * 7 + origin[0] + seed) % 5);
  return 0;
}

void set(Host& h) {
  Script& s = h.script;
  const int field = s.below(32) == 0 ? s.byte() - 64 : s.below(3);
  double m[12];
  std::int32_t lo[3], hi[3];
  float color[3];
  switch (s.below(10)) {
    case 0: {
      const pvol_array a = h.array();
      return void(pvol_set_array(h.volume, field, &a));
    }
    case 1: {
      const pvol_array a = h.array();
      return void(pvol_share_array(h.volume, field, &a));
    }
    case 2: {
      const pvol_leaves l = h.tree();
      return void(pvol_set_leaves(h.volume, field, &l));
    }
    case 3: {
      static int seed;
      seed = s.byte();
      pvol_bricks b{{}, {}, fill_brick, &seed, {}};
      for (int c = 0; c < 3; ++c) b.lo[c] = s.coordinate(), b.hi[c] = b.lo[c] / 2 + s.below(40);
      if (s.below(32) == 0) b.fill = nullptr;
      return void(pvol_set_bricks(h.volume, field, &b));
    }
    case 4:
      s.fill(m);
      if (s.below(2) == 0) m[0] = m[5] = m[10] = 1, m[1] = m[2] = m[4] = m[6] = m[8] = m[9] = 0;
      return void(pvol_set_transform(h.volume, field, m));
    case 5:
      for (int c = 0; c < 3; ++c) lo[c] = s.coordinate(), hi[c] = s.coordinate();
      return void(pvol_set_changed(h.volume, field, lo, hi));
    case 6:
      return void(pvol_set_extinction(h.volume, s.number()));
    case 7:
      for (float& c : color) c = float(s.number());
      return void(pvol_set_extinction_color(h.volume, color));
    case 8:
      return void(pvol_set_interpolation(h.volume, pvol_interpolation(s.below(4))));
    default:
      return void(pvol_clear_field(h.volume, field));
  }
}

void commit(Host& h) {
  pvol_commit_options o{};
  o.threads = h.script.below(4) - 1;
  if (h.script.below(8) == 0) o.progress = [](void*, double done) { return int(done > 0.5); };
  const pvol_status status = pvol_commit(h.volume, h.script.below(2) == 0 ? nullptr : &o);
  require((status == PVOL_OK) || *pvol_message(h.volume) != '\0',
          "a commit fails without a message");
}

void check_length(int found, double t, double t_max) {
  if (found == 1)
    require(t >= 0 && t <= t_max * (1 + 1e-12), "a collision at " + std::to_string(t));
}
void check_passed(float passed) {
  require(passed >= -1e-5f && passed <= 1 + 1e-5f, "a transmittance of " + std::to_string(passed));
}

void ask(Host& h) {
  double lo[3] = {}, hi[3] = {}, place[3], depth = 0, t = 0;
  float range[2] = {};
  if (pvol_box(h.volume, lo, hi) == 1) {
    for (int c = 0; c < 3; ++c) require(lo[c] <= hi[c], "a box ends before it begins");
  }
  h.script.fill(place);
  require(std::isfinite(pvol_density(h.volume, place)), "a density is not finite");
  require(!std::isnan(pvol_extinction(h.volume, place)), "an extinction is no number");
  (void)pvol_value(h.volume, h.script.byte() - 8, place);
  h.script.fill(lo), h.script.fill(hi);
  if (pvol_extinction_range(h.volume, lo, hi, range) >= 0) {
    require(range[0] >= 0 && range[0] <= range[1], "a range that is none");
  }
  const pvol_ray r = h.ray();
  check_length(pvol_sample_flight(h.volume, &r, &h.random, &t), t, r.t_max);
  float passed = 0;
  const auto estimator = pvol_estimator(h.script.below(4));
  if (pvol_sample_transmittance(h.volume, &r, estimator, &h.random, &passed) == 1)
    check_passed(passed);
  if (pvol_optical_depth(h.volume, &r, &depth) == 1) require(depth >= 0, "a negative depth");
  pvol_span spans[4];
  (void)pvol_shell_spans(h.volume, &r, spans, h.script.below(5));
}

void walk(Host& h) {
  const pvol_ray r = h.ray();
  pvol_walk w;
  if (pvol_enter(h.volume, &r, &w) != 1) return;
  pvol_segment segment{};
  double before = 0, t = 0, place[3], direction[3];
  for (int n = h.script.below(32); n > 0 && pvol_next(&w, &segment) == 1; --n) {
    require(segment.t0 >= before && segment.t1 >= segment.t0, "segments out of order");
    require(segment.lo >= 0 && segment.lo <= segment.hi && segment.hi > 0, "bounds that are none");
    before = segment.t1;
    const double middle = (segment.t0 + segment.t1) / 2;
    const float mu = pvol_walk_extinction(&w, middle);
    require(mu <= segment.hi * 1.000001f, "an extinction above its majorant");
    (void)pvol_walk_density(&w, middle);
    (void)pvol_walk_exceeds(&w, middle, segment.hi / 2);
    pvol_walk_place(&w, middle, place);
  }
  if (pvol_walk_flight(&w, &h.random, &t) == 1) {
    h.script.fill(direction);
    if (pvol_resume(&w, t, direction, h.script.number()) != 1) return;
  }
  float rgb[3] = {1, 0.5f, 0}, weight[3];
  if (h.script.below(2) == 0) (void)pvol_walk_flight_rgb(&w, rgb, &h.random, &t, weight);
  check_passed(pvol_walk_transmittance(&w, pvol_estimator(h.script.below(4)), &h.random));
}

void ask_many(Host& h) {
  constexpr std::size_t kRays = 24;
  double o[3 * kRays], d[3 * kRays], t[kRays], depth[kRays];
  float passed[kRays];
  h.script.fill(o), h.script.fill(d);
  const pvol_rays rays{kRays, {o, 0, 0, PVOL_DOUBLE, 0}, {d, 0, 0, PVOL_DOUBLE, 0}, {}};
  const pvol_streams streams{h.script.byte(), 0, 0, nullptr};
  if (pvol_flights(h.volume, &rays, &streams, t) == 0) {
    for (const double v : t) require(v >= 0, "a flight of a batch that is none");
  }
  const auto estimator = pvol_estimator(h.script.below(4));
  if (pvol_transmittances(h.volume, &rays, estimator, &streams, passed) == 0) {
    for (const float v : passed) check_passed(v);
  }
  (void)pvol_optical_depths(h.volume, &rays, depth);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Host host({data, size});
  for (int call = 0; call < kMostCalls && !host.script.ended(); ++call) {
    switch (host.script.below(8)) {
      case 0:
      case 1:
      case 2:
        set(host);
        break;
      case 3:
      case 4:
        commit(host);
        break;
      case 5:
        ask(host);
        break;
      case 6:
        walk(host);
        break;
      default:
        ask_many(host);
    }
  }
  return 0;
}
