// The entry point of libFuzzer; ALABASTER_FUZZ_TARGET is the function that it calls.
#include "testenv/fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  alabaster::fuzz::ALABASTER_FUZZ_TARGET({data, size});
  return 0;
}
