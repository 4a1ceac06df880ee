// Materials without a scene.
#pragma once

#include <cmath>

#include "core/material/bsdf_value.h"
#include "core/material/disney_material.h"

namespace alabaster::testing {

/// f without the cosine, which is reciprocal.
inline Rgb f_of(const BsdfValue& value, const Vec3f& wi) {
  return value.f_cos * (1 / std::abs(wi.z));
}

/// Multiplies the parameter by a channel of the image.
inline void connect(const char* parameter, std::shared_ptr<const Texture> image, DisneyMaterial* material,
                    Channel channel = Channel::rgb) {
  MaterialTexture texture;
  texture.lookup.image = std::move(image);
  texture.uses.push_back({find_material_parameter(parameter), channel});
  material->textures.push_back(std::move(texture));
}

/// The parameters where "st" has this value.
inline DisneyParameters evaluate_at(const DisneyMaterial& material, const Vec2f& st) {
  Mesh mesh;
  mesh.uv_sets.resize(1);
  mesh.uv_sets[0].name = "st";
  const TriangleHit hit;
  return material.evaluate({mesh, hit, st});
}

}  // namespace alabaster::testing
