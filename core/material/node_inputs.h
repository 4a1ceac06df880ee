// The inputs of the nodes beside the surface that are values: how an image is placed and read, how a mesh is displaced.
#pragma once

#include <span>

#include "core/material/displacement.h"
#include "core/parameter/parameter.h"

namespace alabaster {

struct TextureInputs {
  Wrap wrap_s = Wrap::repeat, wrap_t = Wrap::repeat;
  TextureFilter filter = TextureFilter::linear;
  Vec2f st_offset{0, 0};
  float st_rotation = 0;
  Vec2f st_scale{1, 1};
  Vec4f scale{1, 1, 1, 1}, bias{0, 0, 0, 0};
};
struct DisplacementInputs {
  DisplacementSpace space = DisplacementSpace::normal;
  float scale = 1, midlevel = 0;
};

using TextureInput = Parameter<TextureInputs, Wrap, TextureFilter, Vec2f, Vec4f>;
std::span<const TextureInput> texture_inputs();
using DisplacementInput = Parameter<DisplacementInputs, DisplacementSpace>;
std::span<const DisplacementInput> displacement_inputs();

}  // namespace alabaster
