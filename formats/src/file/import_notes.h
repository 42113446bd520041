// What an importer of scenes says of them.
#pragma once

#include <set>
#include <string>
#include <vector>

namespace pvol::formats::detail {

/// What the importer leaves out or changes, each once, in the order in which it was met.
class ImportNotes {
 public:
  /// `where` has the place as text(), "scene.usda:12".
  template <class Where>
  void add(const Where& where, const std::string& text) {
    if (said_.insert(text).second) all_.push_back(where.text() + ": " + text);
  }
  [[nodiscard]] const std::vector<std::string>& all() const { return all_; }

 private:
  std::set<std::string> said_;
  std::vector<std::string> all_;
};

}  // namespace pvol::formats::detail
