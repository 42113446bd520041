// Reports for scripts.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace pvol::cli {

using Json = nlohmann::ordered_json;

/// Names in files need not be UTF-8; JSON must be.
[[nodiscard]] inline std::string to_text(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace pvol::cli
