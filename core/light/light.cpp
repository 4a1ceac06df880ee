#include "core/light/light.h"

namespace alabaster {

Light make_light(const LightParameters& d, const Vec3d& render_origin, const LightImages& images) {
  switch (d.type) {
    case LightType::rect:
    case LightType::disk:
      return RectDiskLight(d, render_origin, images);
    case LightType::cylinder:
      return CylinderLight(d, render_origin);
    case LightType::sphere:
      return SphereLight(d, render_origin);
    case LightType::distant:
      return DistantLight(d, render_origin);
    case LightType::dome:
      break;
  }
  return DomeLight(d, render_origin, images);
}

std::shared_ptr<const LightImage> image_of(const Light& light) {
  return std::visit([](const auto& l) -> std::shared_ptr<const LightImage> { return l.image(); }, light);
}

}  // namespace alabaster
