// The endings of files' names, by which their kinds are known.
#pragma once

#include <filesystem>
#include <string>

namespace alabaster::hd::support {

/// ".exr" of "a/B.EXR"; only ASCII is made lower case.
inline std::string lower_extension(const std::string& file) {
  std::string extension = std::filesystem::path(file).extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return extension;
}

}  // namespace alabaster::hd::support
