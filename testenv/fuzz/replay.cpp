// Runs kept inputs, which are in CORPUS/<target>/, through their targets, and prints how many there were of each. It
// needs no libFuzzer, so that every build finds again a fault that was found once.
//   fuzz_replay CORPUS                          the inputs as they are
//   fuzz_replay CORPUS --edit SECONDS [SEED]    and edits of them, the same ones for a seed, for so long for each
//   target
// An input that ends the program stays in the file fuzz_input_TARGET of the working folder.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "testenv/fuzz/fuzz_target.h"
#include "testenv/fuzz/input_editor.h"

namespace {

namespace fs = std::filesystem;

std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, none)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

using alabaster::fuzz::Input;

std::vector<Input> read_all(const std::vector<fs::path>& files) {
  std::vector<Input> inputs;
  for (const fs::path& file : files) {
    std::ifstream stream(file, std::ios::binary);
    inputs.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
  }
  return inputs;
}

void run_edits(const alabaster::fuzz::Target& target, const std::vector<Input>& inputs, double seconds, uint64_t seed) {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  const std::string last = std::string("fuzz_input_") + target.name;
  uint64_t count = 0;
  for (; std::chrono::duration<double>(Clock::now() - begin).count() < seconds; ++count) {
    const Input input = alabaster::fuzz::edited(inputs, seed, count);
    std::ofstream(last, std::ios::binary)
        .write(reinterpret_cast<const char*>(input.data()), static_cast<std::streamsize>(input.size()));
    target.run(input);
  }
  fs::remove(last);
  std::printf("  %llu edits\n", static_cast<unsigned long long>(count));
}

}  // namespace

int main(int argc, char** argv) {
  const bool edits = argc >= 4 && argc <= 5 && std::string(argv[2]) == "--edit";
  if (argc != 2 && !edits) {
    std::fputs("usage: fuzz_replay CORPUS [--edit SECONDS [SEED]]\n", stderr);
    return 2;
  }
  if (edits && !(std::atof(argv[3]) > 0)) {
    std::fputs("fuzz_replay: --edit takes a number of seconds\n", stderr);
    return 2;
  }
  for (const alabaster::fuzz::Target& target : alabaster::fuzz::kTargets) {
    const std::vector<fs::path> files = files_in(fs::path(argv[1]) / target.name);
    const std::vector<Input> inputs = read_all(files);
    std::printf("%s: %zu inputs\n", target.name, inputs.size());
    if (inputs.empty()) return 1;
    for (size_t i = 0; i < inputs.size(); ++i) {
      std::printf("  %s\n", files[i].filename().c_str());
      std::fflush(stdout);
      target.run(inputs[i]);
    }
    if (edits) run_edits(target, inputs, std::atof(argv[3]), argc == 5 ? std::strtoull(argv[4], nullptr, 10) : 1);
    std::fflush(stdout);
  }
  return 0;
}
