// A value that a material reads at a hit: an image through texture coordinates, or a colour of the mesh's own.
#pragma once

#include <cmath>
#include <memory>
#include <string>

#include "core/geometry/surface_hit.h"
#include "core/texture/texture.h"
#include "core/texture/uv_transform.h"

namespace alabaster {

/// One of the values at a texel. Grey images have three equal colours; images without alpha have 1 there. `direction`
/// is the angle of the vector (2 r - 1, 2 g - 1), counter-clockwise from (1, 0).
enum class Channel { rgb, r, g, b, a, direction };

/// The component of a colour; red stands for all.
inline int component_of(Channel channel) {
  return channel == Channel::g ? 1 : channel == Channel::b ? 2 : 0;
}

struct TextureLookup {
  std::shared_ptr<const Texture> image;  // null: the mesh's displayed colour and opacity
  UvSetName uv_set = "st";
  UvTransform transform;
  Rgb scale{1.0f}, bias{0.0f};  // value = texel * scale + bias; of a direction, the angle's, by its first components
  float alpha_scale = 1, alpha_bias = 0;
  /// Light is linear in the colour, so its mean over a footprint may stand for it.
  bool is_linear = false;
  bool operator==(const TextureLookup&) const = default;

  Rgb color(const HitPrimvars& at) const { return (image ? texel(at) : at.color()) * scale + bias; }
  /// One number of an image, where it has been placed.
  float value(const Vec2f& st, Channel channel) const {
    if (channel == Channel::a) return image->alpha(st) * alpha_scale + alpha_bias;
    return (image->rgb(st) * scale + bias)[component_of(channel)];
  }
  /// In turns, 0 to 1.
  float direction(const HitPrimvars& at) const {
    const Rgb c = image ? texel(at) : at.color();
    const float turns = std::atan2(2 * c.g - 1, 2 * c.r - 1) * (0.5f / float(M_PI)) * scale.r + bias.r;
    return turns - std::floor(turns);
  }
  float alpha(const HitPrimvars& at) const {
    return (image ? image->alpha(transform(at.uv(uv_set))) : at.opacity()) * alpha_scale + alpha_bias;
  }

 private:
  Rgb texel(const HitPrimvars& at) const {
    const Vec2f uv = transform(at.uv(uv_set));
    if (!(at.footprint() > 0) || !is_linear) [[likely]]
      return image->rgb(uv);
    const Vec2f size(static_cast<float>(image->width()), static_cast<float>(image->height()));
    return image->filtered(uv, transform.texels_across(at.footprint(), at.uv_metric(uv_set), size));
  }
};

/// A texture that says how the normal lies on the surface.
struct NormalMap : TextureLookup {
  bool is_bump = false;          // heights, in object space units, instead of normals in tangent space
  Channel channel = Channel::r;  // of a height
};

}  // namespace alabaster
