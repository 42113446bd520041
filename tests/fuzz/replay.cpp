// Runs a fuzz target without libFuzzer: on every file of a corpus, and on mutations of them, the
// same in every run.
//
//   fuzz_pvol tests/fuzz/corpus/pvol --mutations 2000     # as many over the whole corpus
//   fuzz_pvol crash-1234 --verbose                        # names each input before it is read
//
// Fails where anything but a refusal leaves the target, and where an input takes 5 s or asks for
// 512 MiB at once.
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>

#include "fuzz.h"
#include "largest_block.h"
#include "mutate.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);
/// Only some targets have one.
extern "C" [[gnu::weak]] std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                                             std::size_t most, unsigned seed);

namespace {

using namespace pvol::fuzz;
namespace fs = std::filesystem;

constexpr double kMostSeconds = 5;
constexpr std::size_t kLargestBlock = std::size_t(512) << 20;  // bytes

struct File {
  std::string name;
  Buffer bytes;
};

struct Settings {
  std::vector<fs::path> paths;
  std::size_t mutations = 0;
  bool verbose = false;
};

Settings parse(int count, char** arguments) {
  Settings s;
  for (int i = 1; i < count; ++i) {
    const std::string a = arguments[i];
    if (a == "--verbose") {
      s.verbose = true;
    } else if (a == "--mutations" && i + 1 < count) {
      s.mutations = std::stoul(arguments[++i]);
    } else {
      s.paths.emplace_back(a);
    }
  }
  return s;
}

std::vector<File> load(const std::vector<fs::path>& paths) {
  std::vector<fs::path> names;
  for (const fs::path& path : paths) {
    if (!fs::is_directory(path)) {
      names.push_back(path);
      continue;
    }
    for (const auto& entry : fs::directory_iterator(path)) names.push_back(entry.path());
  }
  std::sort(names.begin(), names.end());
  std::vector<File> files;
  for (const fs::path& name : names) {
    std::ifstream in(name, std::ios::binary);
    if (!in) throw std::runtime_error("cannot read " + name.string());
    files.push_back({name.filename().string(), {std::istreambuf_iterator<char>(in), {}}});
  }
  return files;
}

/// Counts inputs, and those at which the target fails.
class Replay {
 public:
  explicit Replay(bool verbose) : verbose_(verbose) {}

  /// The target gets a block of its own size, so that sanitizers see reads past its end.
  void run(const Buffer& bytes, const std::string& name) {
    if (verbose_) std::cout << name << ": " << bytes.size() << " bytes" << std::endl;
    ++inputs_;
    static_cast<void>(take_largest_block());
    const auto start = std::chrono::steady_clock::now();
    try {
      const Buffer own(bytes.begin(), bytes.end());
      static_cast<void>(LLVMFuzzerTestOneInput(own.data(), own.size()));
    } catch (const std::exception& e) {
      fail(name, e.what());
    } catch (...) {
      fail(name, "something that is no exception was thrown");
    }
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
    if (time.count() > kMostSeconds) fail(name, std::to_string(time.count()) + " s");
    const std::size_t block = take_largest_block();
    if (block > kLargestBlock) fail(name, std::to_string(block) + " bytes of memory at once");
  }

  [[nodiscard]] std::size_t failures() const { return failures_; }
  [[nodiscard]] std::size_t inputs() const { return inputs_; }

 private:
  void fail(const std::string& name, const std::string& what) {
    ++failures_;
    std::cout << name << ": " << what << std::endl;
  }

  bool verbose_;
  std::size_t inputs_ = 0, failures_ = 0;
};

Buffer mutated(const Buffer& bytes, const Buffer& other, pvol::Rng& rng) {
  if (LLVMFuzzerCustomMutator == nullptr || below(2, rng)) return mutate(bytes, other, rng);
  Buffer room(2 * bytes.size() + 4096);
  std::copy(bytes.begin(), bytes.end(), room.begin());
  room.resize(
      LLVMFuzzerCustomMutator(room.data(), bytes.size(), room.size(), unsigned(rng.block().lo)));
  return room;
}

void run_all(const std::vector<File>& files, std::size_t mutations, Replay& replay) {
  for (const File& file : files) replay.run(file.bytes, file.name);
  for (std::size_t m = 0; m < mutations; ++m) {
    pvol::Rng rng(1, 0, m);
    const File& file = files[m % files.size()];
    const Buffer& other = files[below(files.size(), rng)].bytes;
    replay.run(mutated(file.bytes, other, rng), file.name + ", mutation " + std::to_string(m));
  }
}

}  // namespace

/// What custom mutators call.
std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most) {
  static std::uint64_t calls = 0;
  pvol::Rng rng(2, 0, ++calls);
  Buffer bytes = mutate({data, data + size}, {}, rng);
  bytes.resize(std::min(bytes.size(), most));
  std::copy(bytes.begin(), bytes.end(), data);
  return bytes.size();
}

int main(int count, char** arguments) try {
  const Settings settings = parse(count, arguments);
  const std::vector<File> files = load(settings.paths);
  if (files.empty()) throw std::runtime_error("there are no files to replay");
  Replay replay(settings.verbose);
  run_all(files, settings.mutations, replay);
  std::cout << replay.failures() << " of " << replay.inputs() << " inputs failed" << std::endl;
  return replay.failures() == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
} catch (const std::exception& e) {
  std::cerr << e.what() << '\n';
  return 2;
}
