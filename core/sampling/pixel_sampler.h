// Random numbers of one camera sample: a function of (pixel, sample index, dimension block, frame, seed) alone, so that
// the picture does not depend on threads, tiles or pauses.
//
// Each purpose at each bounce has a block of four dimensions: the first four of Sobol, Owen-scrambled, with the sample
// index shuffled per block (Burley 2020, "Practical Hash-based Owen Scrambling", JCGT 9(4)). Every aligned run of 2^m
// indices stratifies each dimension into 2^m intervals, and dimensions (0, 1) into every elementary box of area 2^-m: a
// (0,m,2)-net. Give those two to the choice that matters most. A purpose that needs an unbounded number of dimensions
// (the random walk) takes a stream (Rng) seeded by its block.
#pragma once

#include <array>
#include <cstdint>

#include "core/math/vector.h"

namespace alabaster {

/// 32-bit finalizer with low bias (Wellons' triple32).
inline uint32_t hash32(uint32_t x) {
  x ^= x >> 17;
  x *= 0xed5ad4bbu;
  x ^= x >> 11;
  x *= 0xac4c1b51u;
  x ^= x >> 15;
  x *= 0x31848babu;
  x ^= x >> 14;
  return x;
}
inline uint32_t hash_combine(uint32_t seed, uint32_t value) {
  return hash32(seed ^ (value + 0x9e3779b9u + (seed << 6) + (seed >> 2)));
}
/// [0, 1), 24 bits: never 1 after rounding.
inline float to_unit_float(uint32_t bits) {
  return static_cast<float>(bits >> 8) * 0x1p-24f;
}

constexpr uint32_t reverse_bits(uint32_t x) {
  x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
  x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
  x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
  return __builtin_bswap32(x);
}

/// PCG32 (O'Neill 2014): an independent stream per seed pair.
class Rng {
 public:
  Rng(uint64_t seed, uint64_t stream) : state_(0), increment_((stream << 1) | 1) {
    next();
    state_ += seed;
    next();
  }
  uint32_t next() {
    const uint64_t old = state_;
    state_ = old * 6364136223846793005ull + increment_;
    const auto shifted = static_cast<uint32_t>(((old >> 18) ^ old) >> 27);
    const auto rotation = static_cast<uint32_t>(old >> 59);
    return (shifted >> rotation) | (shifted << ((32 - rotation) & 31));
  }
  float uniform() { return to_unit_float(next()); }

 private:
  uint64_t state_, increment_;
};

/// The purposes that draw numbers; a path vertex at depth d uses blocks (purpose, d).
enum class Dimension : uint32_t {
  film_lens,
  bsdf,
  subsurface,
  light,
  exit_bsdf,
  exit_light,
  opacity = 7,  // a purpose has left, and the others keep their numbers
  time,
  ambient_occlusion
};

class PixelSampler {
 public:
  /// `seed` must already mix the frame and the user's seed: see pixel_seed().
  PixelSampler(uint32_t pixel_seed, uint32_t sample_index)
      : seed_(pixel_seed), index_(sample_index), reversed_index_(reverse_bits(sample_index)) {}

  /// Four numbers in [0,1): well distributed over the samples of a pixel, jointly in all four.
  std::array<float, 4> draw(Dimension purpose, uint32_t depth) const;

  /// 32 random bits of this block, to be hashed with what they decide.
  uint32_t number(Dimension purpose, uint32_t depth) const {
    return hash_combine(hash_combine(seed_, (static_cast<uint32_t>(purpose) << 24) + depth), index_);
  }

  /// The sampler of branch `branch` of `count` that the sample's path splits into: the branches of all samples of a
  /// pixel are as well distributed as samples are.
  PixelSampler of_branch(uint32_t branch, uint32_t count) const { return {seed_, index_ * count + branch}; }

  /// An unbounded independent stream for this block.
  Rng stream(Dimension purpose, uint32_t depth) const {
    const uint32_t block = hash_combine(seed_, (static_cast<uint32_t>(purpose) << 24) + depth);
    return {(static_cast<uint64_t>(block) << 32) | index_, hash_combine(block, index_)};
  }

 private:
  uint32_t seed_, index_, reversed_index_;
};

inline uint32_t pixel_seed(int x, int y, uint32_t frame, uint32_t seed) {
  return hash_combine(hash_combine(hash_combine(hash32(seed), frame), static_cast<uint32_t>(x)),
                      static_cast<uint32_t>(y));
}

}  // namespace alabaster
