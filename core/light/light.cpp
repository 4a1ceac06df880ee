#include "core/light/light.h"

#include <utility>

namespace alabaster {

Light make_light(const LightParameters& d, const Vec3d& render_origin, const LightImages& images) {
  const bool turns_alone = d.type == LightType::dome && !d.texture;  // a constant dome, which that does not change
  if (!d.poses.empty() && !turns_alone) return MovingLight(d, render_origin, images);
  return std::visit([](auto&& light) -> Light { return std::forward<decltype(light)>(light); },
                    place_light(d, render_origin, images));
}

std::shared_ptr<const LightImage> image_of(const Light& light) {
  return std::visit([](const auto& l) -> std::shared_ptr<const LightImage> { return l.image(); }, light);
}

}  // namespace alabaster
