#include "core/material/node_inputs.h"

namespace alabaster {

// The second line of a row is its unit and its description. clang-format would give each element a line.
// clang-format off
std::span<const TextureInput> texture_inputs() {
  using T = TextureInputs;
  static constexpr TextureInput kTable[] = {
      {"wrapS", &T::wrap_s, -kUnbounded, kUnbounded, {"repeat", "mirror", "clamp", "black"},
       "none", "Continuation of the image outside the unit square along u."},
      {"wrapT", &T::wrap_t, -kUnbounded, kUnbounded, {"repeat", "mirror", "clamp", "black"},
       "none", "Continuation of the image outside the unit square along v."},
      {"filter", &T::filter, -kUnbounded, kUnbounded, {"linear", "nearest"},
       "none", "How texels are read between their centres."},
      {"stOffset", &T::st_offset, -kUnbounded, kUnbounded, {},
       "none", "Moves the texture coordinates, which count from the image's upper left corner with v down here, as in "
       "KHR_texture_transform: after scale and rotation."},
      {"stRotation", &T::st_rotation, -kUnbounded, kUnbounded, {},
       "radians", "Turns the texture coordinates as in KHR_texture_transform."},
      {"stScale", &T::st_scale, -kUnbounded, kUnbounded, {},
       "none", "Scales the texture coordinates as in KHR_texture_transform."},
      {"scale", &T::scale, -kUnbounded, kUnbounded, {},
       "none", "Multiplies the texel."},
      {"bias", &T::bias, -kUnbounded, kUnbounded, {},
       "none", "Is added to the scaled texel."},
  };
  return kTable;
}

std::span<const DisplacementInput> displacement_inputs() {
  using D = DisplacementInputs;
  static constexpr DisplacementInput kTable[] = {
      {"scale", &D::scale, -kUnbounded, kUnbounded, {},
       "unit of the mesh", "Length that 1 stands for."},
      {"midlevel", &D::midlevel, -kUnbounded, kUnbounded, {},
       "none", "Value that leaves a point where it is."},
      {"space", &D::space, -kUnbounded, kUnbounded, {"normal", "tangent", "object"},
       "none", "Along the normal by one channel; or by a vector in tangent space (r along growing u, g along growing v, "
       "b along the normal) or in object space."},
  };
  return kTable;
}
// clang-format on

}  // namespace alabaster
