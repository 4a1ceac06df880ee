// A light that moves within the shutter: at each time it is the still light of the pose then.
// Units, frames, pdfs and the treatment of bad values, common to all lights: light_parameters.h, light.h.
#pragma once

#include <memory>
#include <variant>

#include "core/light/cylinder_light.h"
#include "core/light/distant_light.h"
#include "core/light/dome_light.h"
#include "core/light/rect_disk_light.h"
#include "core/light/sphere_light.h"

namespace alabaster {

using StillLight = std::variant<RectDiskLight, CylinderLight, SphereLight, DistantLight, DomeLight>;

/// The light of these parameters where it stands first.
StillLight place_light(const LightParameters& parameters, const Vec3d& render_origin, const LightImages& images = {});

/// What it gives at a time is that of the light placed there, with its pdf. The choice of light knows no time: it takes
/// the light to be anywhere in a box that holds it over the whole shutter. It is placed anew for each sample and each
/// ray that asks, so that lights which stand still pay nothing for it.
class MovingLight {
 public:
  /// `parameters` has poses.
  MovingLight(const LightParameters& parameters, const Vec3d& render_origin, const LightImages& images = {});
  /// `time`: of the shutter, 0 to 1.
  std::optional<LightSample> sample(const Vec3f& p, const Vec2f& u, const Vec3f& n = Vec3f(0, 0, 0),
                                    float time = 0) const;
  /// At the ray's time.
  std::optional<LightHit> intersect(const Ray& ray, const Vec3f& n = Vec3f(0, 0, 0)) const;
  double importance(const Vec3f& p) const;
  const LightExtent& extent() const { return over_shutter_->extent; }
  bool is_below(const Vec3f&, const Vec3f&) const { return false; }
  const std::shared_ptr<const LightImage>& image() const { return over_shutter_->image; }

 private:
  struct OverShutter {
    LightParameters parameters;   // without poses
    std::vector<Matrix4d> poses;  // even ones
    Vec3d render_origin;
    std::shared_ptr<const LightImage> image;
    LightExtent extent;
  };
  StillLight at(float time) const;

  std::shared_ptr<const OverShutter> over_shutter_;
};

}  // namespace alabaster
