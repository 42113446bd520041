// What a command line says of cutting work up.
#pragma once

#include <optional>

#include "pvol/math/names.h"

namespace pvol::cli {

/// Who starts the parts.
enum class SplitForm { text, json, slurm };
[[nodiscard]] constexpr auto names(SplitForm) {
  return std::to_array<Named<SplitForm>>(
      {{SplitForm::text, "text"}, {SplitForm::json, "json"}, {SplitForm::slurm, "slurm"}});
}

struct SplitGiven {
  std::optional<int> parts{};
  std::optional<SplitForm> form{};
  std::optional<int> at_once{};  ///< most tasks that run at a time
};

}  // namespace pvol::cli
