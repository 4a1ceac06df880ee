// Random edits of inputs, for builds without libFuzzer. They do not learn which inputs reach new code.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace alabaster::fuzz {

using Input = std::vector<uint8_t>;

/// Empties the list or object of JSON that `choice` picks: with spaces, so that the sizes in a GLB stay right. False if
/// the input has none.
bool empty_a_list(uint64_t choice, std::span<uint8_t> input);

/// One of `inputs`, which are not empty, with a few edits: bits turned, extreme bytes, parts removed, repeated, moved,
/// or taken from another input, lists emptied. Depends on its arguments alone.
Input edited(const std::vector<Input>& inputs, uint64_t seed, uint64_t number);

}  // namespace alabaster::fuzz
