#include "core/digest/digest.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace alabaster {

struct Digest::State {
  XXH3_state_t hash;
};

Digest::Digest() : state_(std::make_unique<State>()) {
  XXH3_128bits_reset(&state_->hash);
}

Digest::~Digest() = default;

void Digest::add_bytes(std::span<const std::byte> bytes) {
  if (!bytes.empty()) XXH3_128bits_update(&state_->hash, bytes.data(), bytes.size());
}

std::string Digest::text() const {
  constexpr char kDigits[] = "0123456789abcdef";
  const XXH128_hash_t hash = XXH3_128bits_digest(&state_->hash);
  std::string text;
  for (const uint64_t half : {hash.high64, hash.low64})
    for (int shift = 60; shift >= 0; shift -= 4) text += kDigits[half >> shift & 15];
  return text;
}

uint64_t checksum(std::span<const std::byte> bytes, uint64_t number) {
  return XXH3_64bits_withSeed(bytes.data(), bytes.size(), number);
}

}  // namespace alabaster
