// The number that stands for a name in Cryptomatte's layers (Friedman and Jones 2015, specification 1.2.0).
#pragma once

#include <cstdint>
#include <string_view>

namespace alabaster {

/// MurmurHash3_32 of the name, made into the bits of a float that is neither 0, subnormal, infinite nor NaN.
uint32_t cryptomatte_hash(std::string_view name);

}  // namespace alabaster
