// The outputs of a texture node, as connections name them.
#pragma once

#include <array>
#include <string_view>

#include "core/material/texture_lookup.h"

namespace alabaster::hd::prims {

/// Indexed by Channel.
inline constexpr std::array<std::string_view, 6> kTextureOutputs{"rgb", "r", "g", "b", "a", "direction"};
static_assert(kTextureOutputs.size() == size_t(Channel::direction) + 1);

}  // namespace alabaster::hd::prims
