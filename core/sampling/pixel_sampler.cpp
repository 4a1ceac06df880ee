#include "core/sampling/pixel_sampler.h"

namespace alabaster {
namespace {

constexpr uint32_t reverse_bits(uint32_t x) {
  x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
  x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
  x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
  x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
  return (x >> 16) | (x << 16);
}

// Direction numbers of the first four Sobol dimensions, from the primitive polynomials and initial values of Joe and
// Kuo 2008 (new-joe-kuo-6): d=2: s=1 a=0 m={1}; d=3: s=2 a=1 m={1,3}; d=4: s=3 a=1 m={1,3,1}. Dimension 1 is van der
// Corput.
struct SobolTables {
  // One table per dimension and byte of the index: four lookups replace 32 conditional XORs.
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
            if ((value >> bit) & 1u) x ^= v[8 * b + bit];
          bytes[d][b][value] = x;
        }
    }
  }
};
constexpr SobolTables kSobol;

uint32_t sobol(uint32_t index, int dimension) {
  const auto& t = kSobol.bytes[dimension];
  return t[0][index & 255u] ^ t[1][(index >> 8) & 255u] ^ t[2][(index >> 16) & 255u] ^ t[3][index >> 24];
}

// Laine-Karras style hash on reversed bits: an Owen scramble (Burley 2020, section 3; constants of Vegdahl's
// improvement).
uint32_t nested_uniform_scramble(uint32_t x, uint32_t seed) {
  x = reverse_bits(x);
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16) | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return reverse_bits(x);
}

}  // namespace

std::array<float, 4> PixelSampler::draw(Dimension purpose, uint32_t depth) const {
  const uint32_t block = hash_combine(seed_, (static_cast<uint32_t>(purpose) << 24) + depth);
  const uint32_t index = nested_uniform_scramble(index_, block);
  std::array<float, 4> u{};
  for (int d = 0; d < 4; ++d)
    u[static_cast<size_t>(d)] =
        to_unit_float(nested_uniform_scramble(sobol(index, d), hash_combine(block, static_cast<uint32_t>(d) + 1)));
  return u;
}

}  // namespace alabaster
