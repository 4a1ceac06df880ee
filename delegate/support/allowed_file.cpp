#include "delegate/support/allowed_file.h"

#include <algorithm>
#include <filesystem>

namespace alabaster::hd::support {

namespace {

namespace fs = std::filesystem;

// A link whose file is missing leads to where the file would be made.
fs::path behind_links(fs::path file) {
  constexpr int kMostLinks = 40;
  for (int i = 0; i < kMostLinks; ++i) {
    std::error_code none;
    if (fs::exists(file, none) || !fs::is_symlink(fs::symlink_status(file, none))) return file;
    const fs::path next = fs::read_symlink(file, none);
    file = next.is_absolute() ? next : file.parent_path() / next;
  }
  return file;
}

// A name of which no part exists stays relative unless it is made absolute first.
fs::path followed(const std::string& name, std::error_code* error) {
  const fs::path path = behind_links(fs::absolute(name, *error));
  if (*error) return {};
  // With a last '/', the last part would be empty.
  const fs::path place = fs::weakly_canonical(path, *error);
  return place.has_filename() ? place : place.parent_path();
}

}  // namespace

std::string OutsideFault(const std::string& folder, const std::string& file) {
  std::error_code no_folder, no_file;
  const fs::path top = followed(folder.empty() ? "." : folder, &no_folder), place = followed(file, &no_file);
  if (no_folder || no_file)
    return "'" + file + "' cannot be followed: " + (no_folder ? no_folder : no_file).message() +
           "; check its folders and links";
  const bool below = std::mismatch(top.begin(), top.end(), place.begin(), place.end()).first == top.end();
  if (below) return {};
  return "'" + place.string() +
         "' lies outside the folder of the file that names it (links are followed); move it there, or allow " +
         "it with --allow-outside (hosts: option allow_outside)";
}

}  // namespace alabaster::hd::support
