// Lights: a closed set. UsdLux terms; radiance = color * intensity * 2^exposure (normalize divides by area).
//
// To add a light: 1. its pair of files with the five functions below; 2. its name in the variant `Light`; 3. its line
// in LightDescription's type; 4. its entry in schemas/lights.json; 5. its chi-square line in testenv/statistical;
// 6. a scene that needs it.
//
// Everything is in render space. pdfs are per solid angle at the reference point.
#pragma once

#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "core/color/rgb.h"
#include "core/math/ray.h"
#include "core/math/transform.h"
#include "core/sampling/distribution.h"
#include "core/texture/texture.h"

namespace alabaster {

struct LightSample {
  Vec3f wi{0, 0, 1};   // unit, from the reference point to the light
  float distance = 0;  // to the sampled point; infinity for distant and dome
  Rgb radiance{0.0f};  // arriving along wi; for a delta light: irradiance on a plane facing it (pdf = 1)
  float pdf = 0;       // per solid angle; 1 for delta lights
  bool delta = false;
};

struct LightHit {
  float t = 0;         // along the ray; infinity for distant and dome
  Rgb radiance{0.0f};  // emitted towards the ray's origin
  float pdf = 0;       // that sample() would have had for this direction from the ray's origin
};

enum class LightType { rect, sphere, distant, dome };

/// A light as the scene gives it (before placement in render space).
struct LightDescription {
  LightType type = LightType::rect;
  Matrix4d light_to_world;  // lights emit down their local -z (rect, distant); scale applies to sizes
  Rgb color{1.0f};
  float intensity = 1;
  float exposure = 0;           // stops
  bool normalize = false;       // power independent of area (rect, sphere) or of angle (distant)
  float width = 1, height = 1;  // rect
  float radius = 0.5f;  // sphere; 0 with treat_as_point: a point light of `intensity` candela-like radiant intensity
  bool treat_as_point = false;
  float angle = 0.53f;  // distant: angular diameter in degrees; 0: delta, color*intensity is then irradiance
  float cone_inner = 180, cone_outer = 180;  // spot shaping of a sphere light about -z, half angles in degrees;
                                             // smooth between them as KHR_lights_punctual defines
  std::shared_ptr<const Texture> texture;    // dome: lat-long, USD's orientation (see dome_light.h)
  bool visible_to_camera = false;
};

class RectLight {
 public:
  RectLight(const LightDescription& description, const Vec3d& render_origin);
  std::optional<LightSample> sample(const Vec3f& p, const Vec2f& u) const;  // p: reference point
  std::optional<LightHit> intersect(const Ray& ray) const;
  float power(float scene_radius) const;

 private:
  Vec3f center_, x_, y_, n_;  // half edge vectors (along width, height) and unit normal of the emitting side
  float area_ = 0;
  Rgb radiance_{0.0f};
};

class SphereLight {
 public:
  SphereLight(const LightDescription& description, const Vec3d& render_origin);
  std::optional<LightSample> sample(const Vec3f& p, const Vec2f& u) const;
  std::optional<LightHit> intersect(const Ray& ray) const;
  float power(float scene_radius) const;
  bool is_delta() const { return radius_ == 0; }

 private:
  float shaping(const Vec3f& from_light) const;
  Vec3f center_, axis_;
  float radius_ = 0, cos_inner_ = -1, cos_outer_ = -1;
  Rgb radiance_{0.0f};  // or radiant intensity for a point
};

class DistantLight {
 public:
  DistantLight(const LightDescription& description, const Vec3d& render_origin);
  std::optional<LightSample> sample(const Vec3f& p, const Vec2f& u) const;
  std::optional<LightHit> intersect(const Ray& ray) const;
  float power(float scene_radius) const;
  bool is_delta() const { return one_minus_cos_ == 0; }

 private:
  Vec3f direction_;  // unit, towards the light
  float one_minus_cos_ = 0;
  Rgb radiance_{0.0f};
};

class DomeLight {
 public:
  DomeLight(const LightDescription& description, const Vec3d& render_origin);
  std::optional<LightSample> sample(const Vec3f& p, const Vec2f& u) const;
  std::optional<LightHit> intersect(const Ray& ray) const;  // always hits, at infinity
  float power(float scene_radius) const;

 private:
  Affine world_to_light_, light_to_world_;
  Rgb scale_{0.0f};
  std::shared_ptr<const Texture> texture_;
  std::shared_ptr<const Distribution2D> distribution_;
  float mean_luminance_ = 1;
};

/// Emissive triangles of one instance.
class MeshLight {
 public:
  struct Triangle {
    Vec3f p0, p1, p2;  // render space
    Rgb radiance;      // both sides
  };
  MeshLight(uint32_t instance, std::vector<Triangle> triangles, std::vector<uint32_t> triangle_ids);
  std::optional<LightSample> sample(const Vec3f& p, const Vec2f& u) const;
  /// pdf of sampling the point where a ray from `p` with unit `wi` met triangle `triangle_id` at distance t.
  float pdf(uint32_t triangle_id, const Vec3f& wi, float t) const;
  float power(float scene_radius) const;
  uint32_t instance() const { return instance_; }

 private:
  uint32_t instance_;
  std::vector<Triangle> triangles_;
  std::vector<uint32_t> index_of_triangle_;  // mesh triangle -> entry, or ~0u
  Distribution1D distribution_;              // by area times luminance
};

using Light = std::variant<RectLight, SphereLight, DistantLight, DomeLight, MeshLight>;

}  // namespace alabaster
