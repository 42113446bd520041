#include "cli/build_facts.h"

#include <string_view>

#include "pvol/version.h"
#include "pvol/volume/best_kernel.h"

namespace pvol::cli {

std::string version_text() {
  constexpr std::string_view kCommit =
      PVOL_COMMIT;  // of the build; "" where there is no repository
  std::string text = PVOL_VERSION " (";
  if (!kCommit.empty()) text += std::string(kCommit) + ", ";
  return text + name(best_kernel()) + ")";
}

}  // namespace pvol::cli
