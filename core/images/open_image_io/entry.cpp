#include <dlfcn.h>

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

extern "C" __attribute__((visibility("default"))) const alabaster::ImageFunctions* alabaster_image_functions(
    uint32_t interface) {
  static const alabaster::ImageFunctions functions = {&alabaster::open_image, &alabaster::encode_image};
  if (interface != alabaster::kImageInterface) return nullptr;
  keep_open_image_io();
  return &functions;
}
