// Reads of a checkpoint what tests look for (delegate/rendering/checkpoint_file.h,
// core/session/render_state.cpp).
#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace alabaster::testing {

/// The groups of pixels that had ended, as bits; 0 where there is no such file yet.
inline uint32_t ended_groups(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  const std::string all = text.str();
  constexpr size_t kBlockHead = 16, kStateHead = 280, kEnded = 40;  // bytes: of a block, of a state, before `ended`
  uint64_t size = 0;
  for (size_t at = all.find('\n') + 1; at >= 1 && all.size() - at > kBlockHead; at += kBlockHead + size) {
    std::memcpy(&size, &all[at], sizeof size);
    if (size > all.size() - at - kBlockHead) return 0;
    if (size != kStateHead) continue;
    uint32_t ended = 0;
    std::memcpy(&ended, &all[at + kBlockHead + kEnded], sizeof ended);
    return ended;
  }
  return 0;
}

}  // namespace alabaster::testing
