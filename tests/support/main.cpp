// main() of all test executables: runs the tests, and those of chance that failed once more with
// new seeds.
//
// A family of comparisons fails by chance once in a thousand changes of its random numbers. So a
// test in which nothing but families failed runs again in three processes with new seeds, and
// passes where two of them pass. An error of the size that the family can see fails all three.
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "support/effort.h"
#include "support/statistics.h"

extern char** environ;

namespace pvol::proof {
namespace {

constexpr int kRuns = 3, kMustPass = 2;

/// Collects the tests that failed, apart by whether nothing but families failed in them.
class Failures : public testing::EmptyTestEventListener {
 public:
  std::vector<std::string> by_chance;
  int others = 0;

 private:
  void OnTestStart(const testing::TestInfo& /*test*/) override { beyond_families_ = false; }
  void OnTestPartResult(const testing::TestPartResult& result) override {
    if (!result.failed()) return;
    if (std::string_view(result.message()).find(kFamilyFailure) == std::string_view::npos) {
      beyond_families_ = true;
    }
  }
  void OnTestEnd(const testing::TestInfo& test) override {
    if (!test.result()->Failed()) return;
    if (beyond_families_) {
      ++others;
    } else {
      by_chance.push_back(std::string(test.test_suite_name()) + '.' + test.name());
    }
  }

  bool beyond_families_ = false;
};

/// Whether the test passes in a process of its own with the seeds shifted by `shift`.
bool passes_again(const std::string& program, const std::string& test, int shift) {
  setenv(kSeedVariable, std::to_string(shift).c_str(), 1);
  std::string filter = "--gtest_filter=" + test, brief = "--gtest_brief=1", name = program;
  std::array<char*, 4> arguments{name.data(), filter.data(), brief.data(), nullptr};
  pid_t child = 0;
  int status = 1;
  if (posix_spawn(&child, program.c_str(), nullptr, nullptr, arguments.data(), environ) != 0) {
    return false;
  }
  return waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

/// Runs a test again with new seeds and says what came of it.
bool is_false_alarm(const std::string& program, const std::string& test) {
  int passed = 0;
  for (int run = 1; run <= kRuns; ++run) passed += passes_again(program, test, run) ? 1 : 0;
  unsetenv(kSeedVariable);
  const bool pardoned = passed >= kMustPass;
  std::printf("[ NEW SEEDS] %s: passed with %d of %d new seeds: %s\n", test.c_str(), passed, kRuns,
              pardoned ? "a false alarm" : "it fails");
  return pardoned;
}

int run(const std::string& program) {
  auto* const failures = new Failures;  // GoogleTest deletes it
  testing::UnitTest::GetInstance()->listeners().Append(failures);
  const int code = RUN_ALL_TESTS();
  if (code == 0 || std::getenv(kSeedVariable) != nullptr) return code;
  for (const char* of_this_run :
       {"GTEST_TOTAL_SHARDS", "GTEST_SHARD_INDEX", "GTEST_SHARD_STATUS_FILE", "GTEST_OUTPUT"}) {
    unsetenv(of_this_run);
  }
  int failed = failures->others;
  for (const std::string& test : failures->by_chance)
    failed += is_false_alarm(program, test) ? 0 : 1;
  return failed == 0 && !failures->by_chance.empty() ? 0 : 1;
}

}  // namespace
}  // namespace pvol::proof

int main(int count, char** arguments) {
  unsetenv("OCIO");  // views are those of pvol itself, here and in tools that tests run
  testing::InitGoogleTest(&count, arguments);
  return pvol::proof::run(arguments[0]);
}
