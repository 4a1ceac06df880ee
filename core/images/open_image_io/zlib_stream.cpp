#include <zlib.h>

#include <array>

#include "core/images/open_image_io/functions.h"

namespace alabaster {

bool inflates_to(std::span<const uint8_t> stream, uint64_t size) {
  std::array<uint8_t, 16384> out;
  z_stream z{};
  z.next_in = const_cast<uint8_t*>(stream.data());
  z.avail_in = uInt(stream.size());
  if (inflateInit(&z) != Z_OK) return false;
  uint64_t got = 0;
  int status = Z_OK;
  while (status == Z_OK && got <= size) {
    z.next_out = out.data(), z.avail_out = uInt(out.size());
    status = inflate(&z, Z_NO_FLUSH);
    got += out.size() - z.avail_out;
  }
  inflateEnd(&z);
  return status == Z_STREAM_END && got == size;
}

}  // namespace alabaster
