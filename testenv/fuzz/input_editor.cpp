#include "testenv/fuzz/input_editor.h"

#include <algorithm>
#include <array>

#include "core/sampling/pixel_sampler.h"

namespace alabaster::fuzz {
namespace {

constexpr size_t kLongest = 20000, kLongestPart = 64;

size_t below(Rng& rng, size_t count) {
  return count == 0 ? 0 : static_cast<size_t>(rng.next() % count);
}

struct Part {
  size_t begin = 0, end = 0;
};

Part part_of(Rng& rng, const Input& input) {
  const size_t begin = below(rng, input.size());
  return {begin, std::min(input.size(), begin + 1 + below(rng, kLongestPart))};
}

void edit(Rng& rng, const std::vector<Input>& inputs, Input* input) {
  constexpr std::array<uint8_t, 12> kExtremes{0, 1, 0x7f, 0x80, 0xff, '0', '9', '-', '"', '{', '[', ','};
  const auto at = [&](size_t offset) { return input->begin() + static_cast<std::ptrdiff_t>(offset); };
  const Part part = part_of(rng, *input);
  const size_t place = below(rng, input->size() + 1);
  switch (below(rng, input->empty() ? 1 : 7)) {
    case 0: {  // a part of any input
      const Input& other = inputs[below(rng, inputs.size())];
      const Part taken = part_of(rng, other);
      input->insert(at(place), other.begin() + static_cast<std::ptrdiff_t>(taken.begin),
                    other.begin() + static_cast<std::ptrdiff_t>(taken.end));
      break;
    }
    case 1:
      (*input)[part.begin] ^= static_cast<uint8_t>(1u << below(rng, 8));
      break;
    case 2:
      (*input)[part.begin] = kExtremes[below(rng, kExtremes.size())];
      break;
    case 3:
      input->erase(at(part.begin), at(part.end));
      break;
    case 4: {
      const Input again(at(part.begin), at(part.end));
      input->insert(at(place), again.begin(), again.end());
      break;
    }
    case 5:
      empty_a_list(rng.next(), *input);
      break;
    default:
      std::fill(at(part.begin), at(part.end), kExtremes[below(rng, kExtremes.size())]);
  }
}

/// Behind the string that begins at `at`.
size_t string_end(std::span<const uint8_t> text, size_t at) {
  for (++at; at < text.size() && text[at] != '"'; ++at)
    if (text[at] == '\\') ++at;
  return at + 1;
}

}  // namespace

bool empty_a_list(uint64_t choice, std::span<uint8_t> input) {
  std::vector<std::pair<size_t, size_t>> lists;  // their brackets
  std::vector<size_t> open;
  for (size_t i = 0; i < input.size(); ++i) {
    if (input[i] == '"') {
      i = string_end(input, i) - 1;
    } else if (input[i] == '[' || input[i] == '{') {
      open.push_back(i);
    } else if ((input[i] == ']' || input[i] == '}') && !open.empty()) {
      lists.emplace_back(open.back(), i);
      open.pop_back();
    }
  }
  if (lists.empty()) return false;
  const auto [first, last] = lists[choice % lists.size()];
  std::fill(input.begin() + static_cast<std::ptrdiff_t>(first) + 1, input.begin() + static_cast<std::ptrdiff_t>(last),
            uint8_t(' '));
  return true;
}

Input edited(const std::vector<Input>& inputs, uint64_t seed, uint64_t number) {
  Rng rng(seed, number);
  Input input = inputs[below(rng, inputs.size())];
  for (size_t left = 1 + below(rng, 6); left > 0; --left) edit(rng, inputs, &input);
  if (input.size() > kLongest) input.resize(kLongest);
  return input;
}

}  // namespace alabaster::fuzz
