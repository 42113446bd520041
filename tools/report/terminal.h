// Reports as text for terminals.
#pragma once

#include <string>

#include "report/document.h"

namespace pvol::report {

/// Paragraphs in lines of at most 110 columns; tables with as wide columns as they need, rows that
/// stand out behind a "*"; a blank line around tables and where a part begins. Without figures.
[[nodiscard]] std::string to_terminal(const Document& document);

}  // namespace pvol::report
