#include <dlfcn.h>
#include <locale.h>
#include <sys/mman.h>

#include <filesystem>
#include <mutex>

#include "core/images/image_file.h"
#include "core/images/library_entry.h"

namespace alabaster {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLibrary = "libalabaster_images.so." ALABASTER_SOVERSION;

/// The names to try in order, for dlopen: files that exist, and the bare name, which the system looks up.
std::vector<std::string> candidates() {
  std::vector<std::string> files;
  Dl_info info{};
  std::error_code error;
  if (dladdr(reinterpret_cast<const void*>(&image_functions), &info) && info.dli_fname) {
    const fs::path own = fs::canonical(info.dli_fname, error).parent_path();
    for (const fs::path& place : {own / kLibrary, own.parent_path() / "lib" / kLibrary})
      if (fs::exists(place, error)) files.push_back(place.string());
  }
  files.emplace_back(kLibrary);
  return files;
}

/// While it lives, this thread's texts of the C library are English.
class EnglishTexts {
 public:
  EnglishTexts() : plain_(newlocale(LC_ALL_MASK, "C", nullptr)), before_(plain_ ? uselocale(plain_) : nullptr) {}
  ~EnglishTexts() {
    if (!plain_) return;
    uselocale(before_);
    freelocale(plain_);
  }
  EnglishTexts(const EnglishTexts&) = delete;
  EnglishTexts& operator=(const EnglishTexts&) = delete;

 private:
  const locale_t plain_, before_;
};

std::string loader_error() {
  const EnglishTexts english;
  const char* const text = dlerror();
  return text ? text : "unknown reason";
}

/// True if OpenImageIO's libraries do not fit into the address space that the process may have. The loader's text says
/// the same of a file system that forbids programs.
bool is_memory_short(const std::string& reason) {
  if (reason.find("Cannot allocate memory") != std::string::npos) return true;
  if (reason.find("failed to map segment") == std::string::npos) return false;
  constexpr size_t kLibraries = size_t(1) << 30;  // more than 200 of them
  void* const place = mmap(nullptr, kLibraries, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (place == MAP_FAILED) return true;
  munmap(place, kLibraries);
  return false;
}

class ImageLibrary {
 public:
  // OpenImageIO itself stays (open_image_io/entry.cpp).
  ~ImageLibrary() {
    if (handle_) dlclose(handle_);
  }

  const ImageFunctions* load(std::string* fault) {
    const std::lock_guard lock(mutex_);
    if (functions_) return functions_;
    const std::string file = candidates().front();
    // RTLD_LOCAL: a host may bring another OpenImageIO.
    void* handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!handle) return refuse(loader_error(), fault);
    const auto entry = reinterpret_cast<ImageLibraryEntry*>(dlsym(handle, kImageLibraryEntry));
    functions_ = entry ? entry(kImageInterface) : nullptr;
    if (!functions_) {
      dlclose(handle);
      return refuse(file + " belongs to another version", fault);
    }
    handle_ = handle;
    return functions_;
  }

 private:
  static const ImageFunctions* refuse(const std::string& reason, std::string* fault) {
    if (is_memory_short(reason))
      throw MemoryRefused("memory is short: " + reason +
                          "; raise the limit of the process (ulimit -v), or free memory");
    *fault = "images cannot be read or written: " + reason + "; install " + kLibrary +
             " of this version beside the renderer's library, and OpenImageIO";
    return nullptr;
  }

  std::mutex mutex_;
  void* handle_ = nullptr;
  const ImageFunctions* functions_ = nullptr;
};

}  // namespace

const ImageFunctions* image_functions(std::string* fault) {
  static ImageLibrary library;
  return library.load(fault);
}

}  // namespace alabaster
