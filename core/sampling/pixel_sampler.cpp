#include "core/sampling/pixel_sampler.h"

namespace alabaster {
namespace {

// Direction numbers of the first four Sobol dimensions, from the primitive polynomials and initial values of Joe and
// Kuo 2008 (new-joe-kuo-6): d=2: s=1 a=0 m={1}; d=3: s=2 a=1 m={1,3}; d=4: s=3 a=1 m={1,3,1}. Dimension 1 is van der
// Corput.
//
// Scrambling works on reversed bits, before and after. So the tables take an index with its bits reversed, and give the
// point with its bits reversed.
struct SobolTables {
  // One table per dimension and byte of the reversed index: four lookups replace 32 conditional XORs.
  uint32_t bytes[4][4][256] = {};

  constexpr SobolTables() {
    constexpr int degree[4] = {0, 1, 2, 3};
    constexpr uint32_t coefficients[4] = {0, 0, 1, 1};
    constexpr uint32_t initial[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 3, 0}, {1, 3, 1}};
    for (int d = 0; d < 4; ++d) {
      uint32_t v[32] = {};
      for (int i = 0; i < 32; ++i) {
        const int s = degree[d];
        if (d == 0) {
          v[i] = 1u << (31 - i);
        } else if (i < s) {
          v[i] = initial[d][i] << (31 - i);
        } else {
          v[i] = v[i - s] ^ (v[i - s] >> s);
          for (int k = 1; k < s; ++k)
            if ((coefficients[d] >> (s - 1 - k)) & 1u) v[i] ^= v[i - k];
        }
      }
      for (int b = 0; b < 4; ++b)
        for (uint32_t value = 0; value < 256; ++value) {
          uint32_t x = 0;
          for (int bit = 0; bit < 8; ++bit)
            if ((value >> bit) & 1u) x ^= v[31 - (8 * b + bit)];
          bytes[d][b][value] = reverse_bits(x);
        }
    }
  }
};
constexpr SobolTables kSobol;

uint32_t reversed_sobol(uint32_t reversed_index, size_t dimension) {
  const auto& t = kSobol.bytes[dimension];
  return t[0][reversed_index & 255u] ^ t[1][(reversed_index >> 8) & 255u] ^ t[2][(reversed_index >> 16) & 255u] ^
         t[3][reversed_index >> 24];
}

// Laine-Karras style hash on reversed bits: an Owen scramble (Burley 2020, section 3; constants of Vegdahl's
// improvement).
uint32_t scramble_reversed(uint32_t x, uint32_t seed) {
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16) | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return x;
}

}  // namespace

std::array<float, 4> PixelSampler::draw(Dimension purpose, uint32_t depth) const {
  const uint32_t block = hash_combine(seed_, (static_cast<uint32_t>(purpose) << 24) + depth);
  const uint32_t index = scramble_reversed(reversed_index_, block);
  std::array<float, 4> u{};
  for (size_t d = 0; d < 4; ++d) {
    const uint32_t seed = hash_combine(block, static_cast<uint32_t>(d) + 1);
    u[d] = to_unit_float(reverse_bits(scramble_reversed(reversed_sobol(index, d), seed)));
  }
  return u;
}

}  // namespace alabaster
