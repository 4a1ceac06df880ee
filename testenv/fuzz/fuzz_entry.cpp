// The entry points of libFuzzer; ALABASTER_FUZZ_TARGET is the function that it calls.
#include "testenv/fuzz/fuzz_target.h"
#include "testenv/fuzz/input_editor.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  alabaster::fuzz::ALABASTER_FUZZ_TARGET({data, size});
  return 0;
}

extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t most);

// libFuzzer's own edits, and one that JSON rarely survives otherwise.
extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t most, unsigned seed) {
  if (seed % 8 == 0 && alabaster::fuzz::empty_a_list(seed / 8, {data, size})) return size;
  return LLVMFuzzerMutate(data, size, most);
}
