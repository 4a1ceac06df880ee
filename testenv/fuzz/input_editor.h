// Random edits of inputs, for builds without libFuzzer. They do not learn which inputs reach new code.
#pragma once

#include <cstdint>
#include <vector>

namespace alabaster::fuzz {

using Input = std::vector<uint8_t>;

/// One of `inputs`, which are not empty, with a few edits: bits turned, extreme bytes, parts removed, repeated, moved,
/// or taken from another input. Depends on its arguments alone.
Input edited(const std::vector<Input>& inputs, uint64_t seed, uint64_t number);

}  // namespace alabaster::fuzz
