// What waits between the stages of kernels: records of rays, one array a field, so that a stage
// reads and writes many records at once.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>
#include <utility>

namespace pvol::detail {

/// Lanes of the widest kernel. Stages read and write whole registers, beyond the last record and
/// before the first one.
inline constexpr std::size_t kMostLanes = 16;

/// Fields of a record, 4 bytes each: those of any ray. Who traces more than rays adds its own, from
/// kRayFields on.
enum Field : std::size_t {
  kX,
  kY,
  kZ,  ///< place, in cells from the dense bounds' low corner
  kDX,
  kDY,
  kDZ,     ///< direction of flight, unit, in the world
  kDepth,  ///< optical depth left up to the next tentative collision
  kLeft,   ///< distance left, of rays that are limited
  kRng0,
  kRng1,  ///< state of the random numbers
  kId,    ///< whose ray it is
  kW0,    ///< weight; by channel, its first
  kRayFields,
};

/// Most fields that records may have.
inline constexpr std::size_t kMostFields = 32;

/// Records in arrays, which grow as they must. Not every queue has a use for all fields, and memory
/// that nobody touches is none.
class Records {
 public:
  std::size_t n = 0;

  explicit Records(std::size_t fields, std::size_t capacity = 1024) : fields_(fields) {
    allocate(capacity);
  }

  [[nodiscard]] float* operator[](std::size_t f) { return at_[f]; }
  [[nodiscard]] const float* operator[](std::size_t f) const { return at_[f]; }
  [[nodiscard]] std::uint32_t* bits(std::size_t f) {
    return reinterpret_cast<std::uint32_t*>(at_[f]);
  }
  [[nodiscard]] const std::uint32_t* bits(std::size_t f) const {
    return reinterpret_cast<const std::uint32_t*>(at_[f]);
  }

  /// Makes room for so many more.
  void reserve(std::size_t more) {
    if (n + more > capacity_) grow(n + more);
  }

  /// Moves the last records, at most `most`, to `to`, which is empty and has room for them; those
  /// of their fields that `fields` has a bit for.
  void take_last(std::size_t most, std::uint32_t fields, Records& to) {
    const std::size_t count = n < most ? n : most;
    n -= count;
    for (std::size_t f = 0; f < fields_; ++f) {
      if (fields >> f & 1) std::memcpy(to.at_[f], at_[f] + n, count * sizeof(float));
    }
    to.n = count;
  }

 private:
  struct Free {
    void operator()(float* p) const { ::operator delete (p, std::align_val_t{64}); }
  };
  std::unique_ptr<float, Free> memory_;
  std::array<float*, kMostFields> at_{};
  std::size_t fields_, capacity_ = 0;

  void allocate(std::size_t capacity) {
    const std::size_t stride =
        (capacity + kMostLanes - 1) / kMostLanes * kMostLanes + 2 * kMostLanes;
    memory_.reset(static_cast<float*>(
        ::operator new (fields_* stride * sizeof(float), std::align_val_t{64})));
    std::memset(memory_.get(), 0, fields_ * stride * sizeof(float));
    for (std::size_t f = 0; f < fields_; ++f) at_[f] = memory_.get() + f * stride + kMostLanes;
    capacity_ = capacity;
  }

  void grow(std::size_t needed) {
    const std::unique_ptr<float, Free> old = std::move(memory_);
    const std::array<float*, kMostFields> from = at_;
    allocate(needed > 2 * capacity_ ? needed : 2 * capacity_);
    for (std::size_t f = 0; f < fields_; ++f) std::memcpy(at_[f], from[f], n * sizeof(float));
  }
};

}  // namespace pvol::detail
