#include "core/denoise/oidn_search.h"

#include <dlfcn.h>
#include <glob.h>

#include <cstdlib>
#include <filesystem>

namespace alabaster {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLibrary = "libOpenImageDenoise.so.2";
constexpr const char* kInWheel = "oidn/lib";  // of the package pyoidn

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

void add_from_folder(const fs::path& folder, std::vector<std::string>* files) {
  for (const fs::path& place : {folder, folder / "lib", folder / kInWheel, folder / "pyoidn" / kInWheel}) {
    std::error_code error;
    if (fs::is_regular_file(place / kLibrary, error)) files->push_back((place / kLibrary).string());
  }
}

/// The folder of the program or library that holds this code; empty if it cannot be told.
fs::path own_folder() {
  Dl_info info{};
  if (!dladdr(reinterpret_cast<const void*>(&find_oidn), &info) || !info.dli_fname) return {};
  std::error_code error;
  const fs::path file = fs::canonical(info.dli_fname, error);
  return error ? fs::path() : file.parent_path();
}

void add_from_python(const std::string& root, std::vector<std::string>* files) {
  if (root.empty()) return;
  glob_t found{};
  const std::string pattern = root + "/lib/python3*/*-packages";  // site-packages, Debian's dist-packages
  if (glob(pattern.c_str(), 0, nullptr, &found) == 0)
    for (size_t i = 0; i < found.gl_pathc; ++i) add_from_folder(found.gl_pathv[i], files);
  globfree(&found);
}

}  // namespace

std::vector<std::string> find_oidn(const std::string& named) {
  std::vector<std::string> files;
  std::error_code error;
  if (!named.empty()) {
    if (fs::is_directory(named, error))
      add_from_folder(named, &files);
    else if (fs::is_regular_file(named, error))  // the loader would wait for a FIFO
      files.push_back(fs::absolute(named, error).string());
    return files;
  }
  if (const fs::path own = own_folder(); !own.empty()) {
    add_from_folder(own / "oidn", &files);
    add_from_folder(own.parent_path() / "oidn", &files);
    add_from_folder(own / "alabaster/oidn", &files);  // cmake --install puts it there
    // In a wheel: pyoidn lies beside the Python module that holds this library.
    for (fs::path place = own; place.has_relative_path(); place = place.parent_path())
      if (place.filename() == "site-packages" || place.filename() == "dist-packages") add_from_folder(place, &files);
  }
  files.emplace_back(kLibrary);
  add_from_python(variable("VIRTUAL_ENV"), &files);
  if (const std::string home = variable("HOME"); !home.empty()) add_from_python(home + "/.local", &files);
  add_from_python("/usr/local", &files);
  add_from_python("/usr", &files);
  return files;
}

}  // namespace alabaster
