// Counting the instructions that this process runs, where the machine lets it.
#pragma once

#include <cstdint>
#include <optional>

namespace pvol::cli {

/// Instructions in user space by this process, its later threads included. Many virtual machines
/// and containers count none: then every reading is empty.
class InstructionCounter {
 public:
  InstructionCounter();
  ~InstructionCounter();
  InstructionCounter(const InstructionCounter&) = delete;
  InstructionCounter& operator=(const InstructionCounter&) = delete;

  /// Instructions since the counter was made.
  [[nodiscard]] std::optional<std::uint64_t> read() const;

 private:
  int file_ = -1;
};

/// CPU seconds of this process so far, all threads together, in user and system mode.
[[nodiscard]] double cpu_seconds();

}  // namespace pvol::cli
