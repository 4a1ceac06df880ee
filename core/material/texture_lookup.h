// A value that a material reads at a hit: an image through texture coordinates, or a primvar.
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
  std::shared_ptr<const Texture> image;  // null: the numbers of a primvar
  UvSetName primvar = "st";              // texture coordinates of the image, or those numbers
  Vec4f fallback{0};                     // of a primvar that is not there: the value
  UvTransform transform;
  Rgb scale{1.0f}, bias{0.0f};  // value = texel * scale + bias; of a direction, the angle's, by its first components
  float alpha_scale = 1, alpha_bias = 0;
  /// Light is linear in the colour, so its mean over a footprint may stand for it.
  bool is_linear = false;
  bool operator==(const TextureLookup&) const = default;

  Rgb color(const HitPrimvars& at) const {
    if (image) [[likely]]
      return texel(at) * scale + bias;
    const Vec4f value = of_primvar(at);
    return {value.x, value.y, value.z};
  }
  /// One number of an image, where it has been placed.
  float value(const Vec2f& st, Channel channel) const {
    if (channel == Channel::a) return image->alpha(st) * alpha_scale + alpha_bias;
    return (image->rgb(st) * scale + bias)[component_of(channel)];
  }
  /// In turns, 0 to 1.
  float direction(const HitPrimvars& at) const {
    const Rgb c = image ? texel(at) : color(at);
    float turns = std::atan2(2 * c.g - 1, 2 * c.r - 1) * (0.5f / float(M_PI));
    if (image) turns = turns * scale.r + bias.r;
    return turns - std::floor(turns);
  }
  float alpha(const HitPrimvars& at) const {
    return image ? image->alpha(transform(at.uv(primvar))) * alpha_scale + alpha_bias : of_primvar(at).w;
  }

 private:
  /// One number stands for all four; the fourth of two or three is 1.
  Vec4f of_primvar(const HitPrimvars& at) const {
    Vec4f n;
    const int count = at.read(primvar, &n);
    if (count == 0) return fallback;
    if (count == 1) n = Vec4f(n.x);
    if (count == 2 || count == 3) n.w = 1;
    return n * Vec4f(scale.r, scale.g, scale.b, alpha_scale) + Vec4f(bias.r, bias.g, bias.b, alpha_bias);
  }
  Rgb texel(const HitPrimvars& at) const {
    const Vec2f uv = transform(at.uv(primvar));
    if (!(at.footprint() > 0) || !is_linear) [[likely]]
      return image->rgb(uv);
    const Vec2f size(static_cast<float>(image->width()), static_cast<float>(image->height()));
    return image->filtered(uv, transform.texels_across(at.footprint(), at.uv_metric(primvar), size));
  }
};

/// A texture that says how the normal lies on the surface.
struct NormalMap : TextureLookup {
  bool is_bump = false;          // heights, in object space units, instead of normals in tangent space
  Channel channel = Channel::r;  // of a height
};

}  // namespace alabaster
