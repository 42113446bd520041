// A picture to look at while it is rendered: its PNG, and a page beside it that a browser reloads.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

namespace pvol::report {

/// The page of a.png is a.html. It reloads itself and the picture each second, by no script and
/// from any place: a page that was opened as a file does, too. Both files are written atomically.
class LivePage {
 public:
  explicit LivePage(std::filesystem::path png);
  /// Writes a page that reloads no more, where `end` was not called.
  ~LivePage();
  LivePage(const LivePage&) = delete;
  LivePage& operator=(const LivePage&) = delete;

  /// Calls `write_png` and writes the page, at most once a second. `state` is told below the
  /// picture. Throws Error where writing fails.
  void show(const std::string& state, const std::function<void()>& write_png);
  /// The last page, for a PNG that is written already. Throws Error where writing fails.
  void end(const std::string& state);

  [[nodiscard]] const std::filesystem::path& page() const { return page_; }

 private:
  void write(const std::string& state, bool reloads);

  std::filesystem::path png_, page_;
  std::chrono::steady_clock::time_point shown_{};
  std::uint64_t number_ = 0;  ///< of the picture: browsers load another one for another address
  bool ended_ = false;
};

}  // namespace pvol::report
