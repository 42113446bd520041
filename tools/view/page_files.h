// The files of the viewer's page, which are part of the tool.
#pragma once

#include <span>
#include <string_view>

namespace pvol::viewer {

struct PageFile {
  const char* name;
  const char* type;  ///< of its content, as HTTP calls it
  std::string_view text;
};

/// Those of tools/view/page. Made by page_files.cmake.
[[nodiscard]] std::span<const PageFile> page_files();

}  // namespace pvol::viewer
