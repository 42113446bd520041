#include "support/run_tool.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <thread>

namespace pvol::testing {
namespace {

/// In the child: becomes the program, with its streams in files or on a terminal.
[[noreturn]] void become(const std::string& program, const std::vector<std::string>& arguments,
                         const std::string& out, const std::string& err) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // a test that is stopped leaves no tool behind
  // Tests in the background of a script ignore SIGINT; what they run does not.
  for (const int s : {SIGHUP, SIGINT, SIGTERM, SIGUSR1}) std::signal(s, SIG_DFL);
  const int null = open("/dev/null", O_RDONLY);
  const int to_out = open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  const int to_err = open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_NOCTTY, 0600);
  dup2(null, STDIN_FILENO);
  dup2(to_out, STDOUT_FILENO);
  dup2(to_err, STDERR_FILENO);
  std::vector<char*> argv{const_cast<char*>(program.c_str())};
  for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);
  execv(program.c_str(), argv.data());
  _exit(127);
}

RunResult result_of(int status) {
  RunResult r;
  if (WIFEXITED(status)) r.exit = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) r.signal = WTERMSIG(status);
  return r;
}

/// What still runs after so long hangs, or waits for what never comes.
constexpr auto kLimit = std::chrono::minutes(5);

using Clock = std::chrono::steady_clock;

/// Kills a tool that began at `start` and runs too long: whatever is then expected of it, the test
/// fails.
void end_if_late(int pid, const std::string& program, Clock::time_point& start) {
  if (Clock::now() - start < kLimit) return;
  kill(pid, SIGKILL);
  start = Clock::now();
  ADD_FAILURE() << program << " was still running after "
                << std::chrono::duration_cast<std::chrono::seconds>(kLimit).count() << " s";
}

}  // namespace

std::string read_text(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

RunResult run_tool(const std::string& program, const std::vector<std::string>& arguments,
                   const std::function<void(int, const std::string&)>& while_running) {
  const ScratchFolder streams;
  const std::string out = streams / "out", err = streams / "err";
  const int pid = fork();
  if (pid < 0) throw std::runtime_error("fork failed");
  if (pid == 0) become(program, arguments, out, err);

  int status = 0;
  auto start = Clock::now();
  while (waitpid(pid, &status, WNOHANG) == 0) {
    end_if_late(pid, program, start);
    if (while_running) while_running(pid, read_text(err));
    std::this_thread::sleep_for(std::chrono::milliseconds(while_running ? 20 : 2));
  }
  RunResult r = result_of(status);
  r.out = read_text(out);
  r.err = read_text(err);
  return r;
}

RunResult run_on_terminal(const std::string& program, const std::vector<std::string>& arguments,
                          const std::function<void(int, const std::string&)>& while_running) {
  const ScratchFolder streams;
  const int screen = posix_openpt(O_RDWR | O_NOCTTY);
  if (screen < 0 || grantpt(screen) != 0 || unlockpt(screen) != 0) {
    throw std::runtime_error("no terminal");
  }
  const std::string terminal = ptsname(screen);
  const int held = open(terminal.c_str(), O_RDWR | O_NOCTTY);  // until the child has it, too
  const int pid = fork();
  if (pid < 0) throw std::runtime_error("fork failed");
  if (pid == 0) become(program, arguments, streams / "out", terminal);
  std::string err;
  int status = 0;
  // What was written stays to be read; the terminal's end would come as an error.
  fcntl(screen, F_SETFL, O_NONBLOCK);
  auto start = Clock::now();
  for (bool ended = false;;) {
    char text[4096];
    const ssize_t size = read(screen, text, sizeof text);
    if (size > 0) err.append(text, std::size_t(size));
    if (size > 0) continue;
    if (ended) break;
    ended = waitpid(pid, &status, WNOHANG) != 0;
    if (!ended) end_if_late(pid, program, start);
    if (!ended && while_running) while_running(pid, err);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  close(held);
  close(screen);
  RunResult r = result_of(status);
  r.out = read_text(streams / "out");
  r.err = err;
  return r;
}

ScratchFolder::ScratchFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "pvol test XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no folder for temporary files");
  path_ = name;
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace pvol::testing
