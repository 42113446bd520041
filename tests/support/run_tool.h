// Running the command-line tools as a shell would.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace pvol::testing {

/// Arguments of a command line.
using Words = std::vector<std::string>;

/// The first arguments, then the others.
[[nodiscard]] inline Words operator+(Words a, const Words& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

struct RunResult {
  int exit = -1;  ///< code, or -1 after a signal
  int signal =
      0;  ///< that ended the tool; SIGKILL where it ran for five minutes, which fails the test
  std::string out, err;
};

/// Runs a program and waits for it. `while_running`, if given, is called every 20 ms with the
/// process and what it has written to stderr.
[[nodiscard]] RunResult run_tool(
    const std::string& program, const std::vector<std::string>& arguments,
    const std::function<void(int pid, const std::string& err)>& while_running = {});

/// The same with stderr on a terminal, which ends lines by "\r\n".
[[nodiscard]] RunResult run_on_terminal(
    const std::string& program, const std::vector<std::string>& arguments,
    const std::function<void(int pid, const std::string& err)>& while_running = {});

/// A new folder, removed with everything in it at the end.
class ScratchFolder {
 public:
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  [[nodiscard]] std::string operator/(const std::string& name) const {
    return (path_ / name).string();
  }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] bool empty() const { return std::filesystem::is_empty(path_); }

 private:
  std::filesystem::path path_;
};

[[nodiscard]] std::string read_text(const std::filesystem::path& file);

}  // namespace pvol::testing
