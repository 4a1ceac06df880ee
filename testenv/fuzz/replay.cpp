// Runs kept inputs, which are in CORPUS/<target>/, through their targets, and prints how many there were of each. It
// needs no libFuzzer, so that every build finds again a fault that was found once.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "testenv/fuzz/fuzz_target.h"

namespace {

namespace fs = std::filesystem;

std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, none)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

void replay(const alabaster::fuzz::Target& target, const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  const std::vector<uint8_t> bytes{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  std::printf("  %s\n", file.filename().c_str());
  std::fflush(stdout);
  target.run(bytes);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: fuzz_replay CORPUS\n", stderr);
    return 2;
  }
  for (const alabaster::fuzz::Target& target : alabaster::fuzz::kTargets) {
    const std::vector<fs::path> files = files_in(fs::path(argv[1]) / target.name);
    std::printf("%s: %zu inputs\n", target.name, files.size());
    for (const fs::path& file : files) replay(target, file);
    if (files.empty()) return 1;
  }
  return 0;
}
