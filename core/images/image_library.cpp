#include <dlfcn.h>
#include <link.h>
#include <locale.h>
#include <sys/mman.h>

#include <algorithm>
#include <atomic>
#include <cstdarg>
#include <cstring>
#include <filesystem>
#include <latch>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

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

bool is_address_space_short() {
  constexpr size_t kLibraries = size_t(1) << 30;  // more than 200 of them
  void* const place = mmap(nullptr, kLibraries, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (place == MAP_FAILED) return true;
  munmap(place, kLibraries);
  return false;
}

/// True if OpenImageIO's libraries do not fit into the address space that the process may have. The loader's text says
/// the same of a file system that forbids programs.
bool is_memory_short(const std::string& reason) {
  if (reason.find("Cannot allocate memory") != std::string::npos) return true;
  if (reason.find("failed to map segment") == std::string::npos) return false;
  return is_address_space_short();
}

/// OpenImageIO brings OpenVDB, and that log4cplus, whose initializer starts four threads. If it cannot, it ends the
/// process or waits without end, so the threads are tried before. OpenBLAS, which comes with them, starts one per core.
bool are_threads_short() {
  constexpr unsigned kLogging = 4, kMostOthers = 64;
  const unsigned count = kLogging + std::min(std::thread::hardware_concurrency(), kMostOthers);
  std::latch over(1);
  std::vector<std::jthread> threads;
  bool is_short = false;
  try {
    while (threads.size() < count) threads.emplace_back([&over] { over.wait(); });
  } catch (const std::system_error&) {
    is_short = true;
  }
  over.count_down();
  return is_short;
}

bool is_log4cplus_loaded() {
  const auto look = [](dl_phdr_info* info, size_t, void*) {
    return int(std::strstr(info->dlpi_name, "liblog4cplus") != nullptr);
  };
  return dl_iterate_phdr(look, nullptr) != 0;
}

/// At exit log4cplus waits for its threads to end, also in a forked child, which has none of them. Nothing that was
/// loaded with it uses them.
void end_log4cplus_threads(void* library) {
  const auto end = reinterpret_cast<void (*)()>(dlsym(library, "_ZN9log4cplus18shutdownThreadPoolEv"));
  if (end) end();
}

bool are_of_one_library(const void* a, const void* b) {
  Dl_info of_a{}, of_b{};
  return dladdr(a, &of_a) && dladdr(b, &of_b) && of_a.dli_fbase == of_b.dli_fbase;
}

/// libtiff's own handlers print. OpenImageIO 2.4 replaces them, 2.5 leaves them for what it does not take itself. A
/// host's handlers stay.
void silence_libtiff(void* library) {
  using Handler = void (*)(const char* module, const char* format, va_list arguments);
  for (const char* const name : {"TIFFSetErrorHandler", "TIFFSetWarningHandler"}) {
    const auto set = reinterpret_cast<Handler (*)(Handler)>(dlsym(library, name));
    if (!set) continue;
    const Handler before = set(nullptr);
    if (before && !are_of_one_library(reinterpret_cast<void*>(before), reinterpret_cast<void*>(set))) set(before);
  }
}

class ImageLibrary {
 public:
  // OpenImageIO itself stays (open_image_io/entry.cpp).
  ~ImageLibrary() {
    if (handle_) dlclose(handle_);
  }

  const ImageFunctions* load(std::string* fault) {
    if (const ImageFunctions* const loaded = functions_)
      return loaded;  // without the lock, which a fork may leave taken
    const std::lock_guard lock(mutex_);
    if (functions_) return functions_;
    const std::string file = candidates().front();
    const bool is_logging_ours = !is_log4cplus_loaded();
    if (is_logging_ours && are_threads_short()) {
      if (is_address_space_short())
        throw MemoryRefused(
            "memory is short for OpenImageIO's threads; raise the limit of the process (ulimit -v), or free memory");
      *fault =
          "images cannot be read or written: the system gives this process no more threads; raise its limit "
          "(ulimit -u, or that of the container)";
      return nullptr;
    }
    // RTLD_LOCAL: a host may bring another OpenImageIO.
    void* handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!handle) return refuse(loader_error(), fault);
    if (is_logging_ours) end_log4cplus_threads(handle);
    silence_libtiff(handle);
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
  std::atomic<const ImageFunctions*> functions_{nullptr};
};

}  // namespace

const ImageFunctions* image_functions(std::string* fault) {
  static ImageLibrary library;
  return library.load(fault);
}

}  // namespace alabaster
