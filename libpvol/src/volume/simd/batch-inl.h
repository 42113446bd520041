// Batches of rays: which stage runs when, and what becomes of a ray. The scalar flights
// (volume/flights.h) are their reference.

#if defined(PVOL_LANE_BATCH_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_BATCH_INL_H
#undef PVOL_LANE_BATCH_INL_H
#else
#define PVOL_LANE_BATCH_INL_H
#endif

#include <utility>

#include "pvol/track/transmittance.h"
#include "volume/batch_rays.h"
#include "volume/simd/batch_kernels.h"
#include "volume/simd/decide-inl.h"
#include "volume/simd/enter-inl.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// Nobody counts the work of batches.
struct NoCounts {
  static constexpr bool on() { return false; }
  static void add_segments(const std::uint32_t*, std::uint32_t) {}
};

/// Frees the slots of the chosen lanes of a register of events, after visit(event, slot).
template <class Visit>
HWY_INLINE void end_rays(BatchMemory& m, std::size_t at, M chosen, const Visit& visit) {
  for (std::uint32_t lanes = bits_of(chosen); lanes != 0; lanes &= lanes - 1) {
    const std::size_t event = at + std::size_t(std::countr_zero(lanes));
    const std::uint32_t slot = m.flying.bits(kId)[m.events.source[event]];
    visit(event, m.slots[slot]);
    m.free_slot(slot);
  }
}

/// Rays whose tentative collisions were null fly on.
HWY_INLINE void put_back(BatchMemory& m, const RaysInFlight& in_flight, std::size_t at, M null,
                         Random& rng) {
  Records& to = m.queue;
  pack(null, rng.exponential(), to[kDepth] + to.n);
  pack(null, load(&m.events.left[at]), to[kLeft] + to.n);
  in_flight.put(null, rng, to);
  to.n += count(null);
}

/// Collisions are found, and handed to collide(event, slot); null ones fly on.
template <class Collide>
HWY_INLINE void end_at_collisions(const SimdField& f, BatchMemory& m, const Collide& collide) {
  const Events& e = m.events;
  decide(f, m);
  for (std::size_t at = 0; at < e.n; at += kLanes) {
    const M on = first(e.n - at), is_real = mask_of(e.real[at / kLanes]);
    end_rays(m, at, is_real, collide);
    Random rng{load(&e.rng0[at]), load(&e.rng1[at])};
    put_back(m, RaysInFlight(m, at, on), at, hn::AndNot(is_real, on), rng);
  }
}

/// Distances of collisions.
struct BatchFlights {
  const BatchTask& task;

  void start(std::size_t ray, bool bad) const {
    task.t[ray] =
        bad ? std::numeric_limits<double>::quiet_NaN() : std::numeric_limits<double>::infinity();
  }
  void leave(std::size_t, float) const {}
  HWY_INLINE void decide_events(BatchMemory& m) const {
    end_at_collisions(task.field, m, [&](std::size_t event, const BatchMemory::Slot& s) {
      const double flown = double(s.length) - double(m.events.left[event]);
      task.t[s.ray] = std::min(s.t0 + flown, s.t1);
    });
  }
};

/// 1 for rays that left without a collision, else 0.
struct BatchAnalog {
  const BatchTask& task;

  void start(std::size_t ray, bool bad) const {
    task.through[ray] = bad ? std::numeric_limits<float>::quiet_NaN() : 1.0f;
  }
  void leave(std::size_t, float) const {}
  HWY_INLINE void decide_events(BatchMemory& m) const {
    end_at_collisions(task.field, m,
                      [&](std::size_t, const BatchMemory::Slot& s) { task.through[s.ray] = 0; });
  }
};

/// Products of the probabilities of passing tentative collisions, with the roulette of
/// track/transmittance.h.
struct BatchRatio {
  const BatchTask& task;

  void start(std::size_t ray, bool bad) const { BatchAnalog{task}.start(ray, bad); }
  void leave(std::size_t ray, float weight) const { task.through[ray] = weight; }
  HWY_INLINE void decide_events(BatchMemory& m) const {
    fetch_samples(task.field, m);
    if (task.field.look_up == LookUp::nearest) {
      weigh<LookUp::nearest>(m);
    } else {
      weigh<LookUp::trilinear>(m);
    }
  }

  template <LookUp kLookUp>
  HWY_NOINLINE void weigh(BatchMemory& m) const {
    Events& e = m.events;
    const Records& q = m.flying;
    for (std::size_t at = 0; at < e.n; at += kLanes) {
      const M on = first(e.n - at);
      const RaysInFlight in_flight(m, at, on);
      const F null = passing<kLookUp>(task.field, e, at, on);
      F weight = gather(q[kW0], in_flight.source) * null;
      Random rng{gather(q.bits(kRng0), in_flight.source), gather(q.bits(kRng1), in_flight.source)};
      const F least = splat(kTransmittanceRoulette);
      const M low = hn::Lt(weight, least);
      const M dropped = hn::And(on, hn::AndNot(hn::Lt(rng.fine_uniform() * least, weight), low));
      weight = select(low, least, weight);
      end_rays(m, at, dropped,
               [&](std::size_t, const BatchMemory::Slot& s) { task.through[s.ray] = 0; });
      const M on_its_way = hn::AndNot(dropped, on);
      pack(on_its_way, weight, m.queue[kW0] + m.queue.n);
      put_back(m, in_flight, at, on_its_way, rng);
    }
  }
};

/// Takes rays of the batch from `next` on, as many as are read at once and have room; returns how
/// many of them are bad.
template <class Job>
HWY_INLINE std::size_t read_rays(const BatchTask& task, BatchMemory& m, const Job& job,
                                 std::size_t& next) {
  EnteringRays& e = m.entering;
  e.n = 0;
  std::size_t bad = 0;
  const std::size_t room = std::min(EnteringRays::kMost, kSlice - m.queue.n);
  const std::size_t end = next + std::min(room, task.rays.size - next);
  for (; next < end; ++next) {
    const std::optional<BatchRay> ray = read_ray(task.rays, next);
    job.start(next, !ray);
    bad += !ray;
    if (!ray) continue;
    for (int axis = 0; axis < 3; ++axis) {
      e.o[std::size_t(axis)][e.n] = ray->world.o[axis];
      e.d[std::size_t(axis)][e.n] = ray->world.d[axis];
    }
    e.t0[e.n] = 0, e.t1[e.n] = ray->t_max;
    e.ray[e.n++] = next;
  }
  return bad;
}

/// Those that meet the box of the support go to the queue; returns how many are bad, for being too
/// far away.
template <class Job>
HWY_INLINE std::size_t enter(const BatchTask& task, BatchMemory& m, const Job& job) {
  const EnteringRays& e = m.entering;
  normalize_directions(m.entering);
  find_spans(task.volume, m.entering);
  std::size_t bad = 0;
  for (std::size_t k = 0; k < e.n; ++k) {
    const Ray cells = e.in_cells(k);
    if (!is_finite(cells.o)) {
      job.start(e.ray[k], true);
      ++bad;
      continue;
    }
    if (!(e.t0[k] < e.t1[k])) continue;
    Rng rng = numbers_of(task.numbers, e.ray[k]);
    const std::size_t n =
        put_ray(task.field, m.queue, cells.at(e.t0[k]), Vec3f(e.in_world(k).d), rng);
    const std::uint32_t slot = m.take_slot();
    const auto way = float(e.t1[k] - e.t0[k]);
    m.slots[slot] = {e.ray[k], e.t0[k], e.t1[k], way};
    m.queue[kLeft][n] = way;
    m.queue[kW0][n] = 1;
    m.queue.bits(kId)[n] = slot;
  }
  return bad;
}

/// Every ray of the batch to its end; see BatchKernel.
template <class Job>
std::size_t run_batch(const BatchTask& task, BatchMemory& m) {
  const Job job{task};
  NoCounts none;
  std::size_t bad = 0, next = 0;
  m.start();
  for (;;) {
    while (m.queue.n < kSlice && next < task.rays.size) {
      bad += read_rays(task, m, job, next);
      bad += enter(task, m, job);
    }
    if (m.queue.n == 0) return bad;
    std::swap(m.queue, m.flying);
    m.queue.n = 0;
    fly<true>(task.field, m, none);
    for (std::size_t k = 0; k < m.events.gone; ++k) {
      const std::size_t at = m.events.gone_source[k];
      const std::uint32_t slot = m.flying.bits(kId)[at];
      job.leave(m.slots[slot].ray, m.flying[kW0][at]);
      m.free_slot(slot);
    }
    job.decide_events(m);
  }
}

inline BatchKernels batch_kernels() {
  return {&run_batch<BatchFlights>, &run_batch<BatchAnalog>, &run_batch<BatchRatio>};
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
