// delegate_conformance [--library PATH] [--repeat SCALE] [GoogleTest's options]
//
// Loads a render delegate's library and runs the suite on it. The suite is a module of its own: it calls functions of
// the installed headers (Token, Path, Value), which the library under test, or one that it is linked to, must provide.
#include <dlfcn.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "testenv/conformance/host.h"

namespace {

void* load(const char* path, int mode) {
  void* handle = dlopen(path, mode);
  if (!handle) std::fprintf(stderr, "delegate_conformance: %s\n", dlerror());
  return handle;
}

// Takes `name VALUE` out of the arguments; `fallback` if it is not there.
const char* take(int* argc, char** argv, const char* name, const char* fallback) {
  for (int i = 1; i + 1 < *argc; ++i) {
    if (std::strcmp(argv[i], name) != 0) continue;
    const char* value = argv[i + 1];
    for (int k = i; k + 2 <= *argc; ++k) argv[k] = argv[k + 2];
    *argc -= 2;
    return value;
  }
  return fallback;
}

}  // namespace

int main(int argc, char** argv) {
  const char* path = take(&argc, argv, "--library", CONFORMANCE_LIBRARY);
  const char* repeat = std::getenv("CONFORMANCE_REPEAT");
  conformance::Library library;
  library.repeat = std::atof(take(&argc, argv, "--repeat", repeat ? repeat : "1"));

  void* delegate = load(path, RTLD_NOW | RTLD_GLOBAL);
  void* suite = delegate ? load(CONFORMANCE_SUITE, RTLD_NOW) : nullptr;
  if (!suite) return 2;
  library.create = reinterpret_cast<decltype(library.create)>(dlsym(delegate, "CreateAlabasterRenderDelegate"));
  library.destroy = reinterpret_cast<decltype(library.destroy)>(dlsym(delegate, "DestroyAlabasterRenderDelegate"));
  using Run = int (*)(int, char**, const conformance::Library*);
  const auto run = reinterpret_cast<Run>(dlsym(suite, "RunConformanceSuite"));
  if (!library.create || !library.destroy || !run) {
    std::fprintf(stderr, "delegate_conformance: %s has no delegate\n", path);
    return 2;
  }
  return run(argc, argv, &library);
}
