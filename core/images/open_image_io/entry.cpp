#include <dlfcn.h>
#include <unistd.h>

#include <atomic>

#include "core/images/library_entry.h"
#include "core/images/open_image_io/functions.h"

// OpenImageIO stays to the end of the process: its threads may still run when the last user leaves, and what it brings
// (OpenBLAS, GDAL) does not survive an unload. Ours goes.
static void keep_open_image_io() {
  Dl_info info{};
  const auto version = reinterpret_cast<const void*>(&OIIO::openimageio_version);
  if (!dladdr(version, &info)) return;
  if (void* held = dlopen(info.dli_fname, RTLD_NOW | RTLD_NOLOAD | RTLD_NODELETE)) dlclose(held);
}

std::string alabaster::openexr_fault() {
  static std::atomic<pid_t> user{0};  // whose threads they are
  pid_t first = 0;
  const pid_t self = getpid();
  if (user.compare_exchange_strong(first, self) || first == self) return {};
  return "this process was forked from one that had read or written an EXR, and lacks OpenEXR's threads; begin it with "
         "exec (Python: multiprocessing's spawn), or use another format";
}

extern "C" __attribute__((visibility("default"))) const alabaster::ImageFunctions* alabaster_image_functions(
    uint32_t interface) {
  static const alabaster::ImageFunctions functions = {&alabaster::open_image, &alabaster::encode_image,
                                                      &alabaster::inflates_to};
  if (interface != alabaster::kImageInterface) return nullptr;
  keep_open_image_io();
  return &functions;
}
