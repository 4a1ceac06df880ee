#include "core/digest/cryptomatte_hash.h"

#include <bit>
#include <cstddef>

namespace alabaster {

// Appleby's MurmurHash3_x86_32 with seed 0: blocks of four bytes, then the rest, little endian.
uint32_t cryptomatte_hash(std::string_view name) {
  const auto byte = [&](size_t i) { return static_cast<uint32_t>(static_cast<unsigned char>(name[i])); };
  const auto scrambled = [](uint32_t k) { return std::rotl(k * 0xcc9e2d51u, 15) * 0x1b873593u; };
  uint32_t h = 0;
  size_t at = 0;
  for (; at + 4 <= name.size(); at += 4) {
    h ^= scrambled(byte(at) | byte(at + 1) << 8 | byte(at + 2) << 16 | byte(at + 3) << 24);
    h = std::rotl(h, 13) * 5 + 0xe6546b64u;
  }
  uint32_t rest = 0;
  for (size_t i = name.size(); i > at; --i) rest = rest << 8 | byte(i - 1);
  h ^= scrambled(rest);
  h ^= static_cast<uint32_t>(name.size());
  h = (h ^ h >> 16) * 0x85ebca6bu;
  h = (h ^ h >> 13) * 0xc2b2ae35u;
  h ^= h >> 16;

  // As the specification mends exponents that filters and programs do not keep.
  const uint32_t exponent = h >> 23 & 0xff;
  return exponent == 0 || exponent == 0xff ? h ^ 1u << 23 : h;
}

}  // namespace alabaster
