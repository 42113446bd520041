// Command lines as a shell reads them.
#pragma once

#include <string>
#include <vector>

namespace pvol::cli {

/// A word that bash takes as it is: in quotes where it needs them, on one line whatever it holds.
[[nodiscard]] std::string shell_word(const std::string& word);

/// A command of such words.
[[nodiscard]] std::string shell_line(const std::vector<std::string>& command);

}  // namespace pvol::cli
