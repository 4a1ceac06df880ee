// Pinhole and thin-lens perspective, and orthographic projection.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/math/bounds.h"
#include "core/math/motion.h"
#include "core/math/ray.h"
#include "core/parameter/parameter.h"

namespace alabaster {

/// Apertures, focal length and focus distance in world units (Hydra's convention). The camera looks down its local -z,
/// y up.
struct CameraParameters {
  Matrix4d camera_to_world;  // identity by default
  float focal_length = 50;
  float horizontal_aperture = 36;
  float vertical_aperture = 24;
  float horizontal_aperture_offset = 0;
  float vertical_aperture_offset = 0;
  float f_stop = 0;  // 0: pinhole; lens radius = focal_length / (2 f_stop)
  float focus_distance = 0;
  float clip_near = 0;             // 0: none
  float clip_far = 0;              // 0: none
  std::vector<Vec4f> clip_planes;  // camera space: points with a x + b y + c z + d < 0 are cut off
  bool orthographic = false;
  uint32_t aperture_blades = 0;  // below 3: a round aperture
  float aperture_rotation = 0;   // degrees, from the camera's x to its y; 0: a corner on the x axis
  float exposure = 0;            // stops: radiance in the picture is multiplied by 2 to this power
  float shutter_open = 0;        // frames, relative to the one that is drawn
  float shutter_close = 0;       // not before it opens; the same: nothing is blurred
  std::vector<Matrix4d> poses;   // camera_to_world over the camera's own shutter, even ones; empty: stands still
  // Of a lens that moves: at times as those of the shutter, which they need not lie in. Empty: stands still.
  TimeSamples<float> focal_lengths, f_stops, focus_distances;
  float opens = 0, closes = 0;  // the camera's shutter as a part of the scene's, which goes from 0 to 1
  /// camera_to_world at the ends of the time that AOV motion shows (Instance::ends): two. Empty: that of the shutter.
  std::vector<Matrix4d> ends;
  bool operator==(const CameraParameters&) const = default;
};
/// Sets the lens to what it is where the camera's shutter opens, and drops samples of what stands still in the shutter.
void open_lens(CameraParameters* camera);
/// schemas/camera.json, but for projection, clippingRange and clipPlanes.
std::span<const Parameter<CameraParameters>> camera_parameters();

/// Of CameraParameters, what may move within the shutter.
struct Lens {
  float focal_length, f_stop, focus_distance;
};

/// A pixel sees a part of a surface that is at least `width` + `spread` times the distance wide, in its narrowest
/// direction.
struct PixelCone {
  float width = 0;   // world units
  float spread = 0;  // radians
};

/// Film coordinates: x right, y DOWN, in pixels of the full display window of width x height.
class Camera {
 public:
  /// `render_origin`: the world position that render space has at its origin (SceneSnapshot::origin).
  Camera(const CameraParameters& parameters, int width, int height, const Vec3d& render_origin);

  /// Unit direction. `lens` is used only with a lens. In render space; time 0. The ray begins and ends where the
  /// clipping planes cut it; one of which nothing is left has length 0.
  Ray generate_ray(const Vec2f& film, const Vec2f& lens) const;

  /// Bounds, in render space, of the origins of generate_ray() over a rectangle of film positions and the lens. All of
  /// space if the clipping planes of CameraParameters::clip_planes move them.
  Bounds ray_origins(const Vec2f& film_begin, const Vec2f& film_end) const;

  /// The cone of a pixel that looks in unit direction `d`, render space, without filter and lens.
  PixelCone pixel_cone(const Vec3f& d) const;

  /// A point or a direction of render space in the camera's own frame: x right, y up, looking down -z; world units.
  Vec3f to_eye(const Vec3f& p_render) const { return direction_to_eye(p_render - origin_); }
  Vec3f direction_to_eye(const Vec3f& d) const { return {dot(d, x_), dot(d, y_), dot(d, z_)}; }
  /// Where a point of render space appears, in film coordinates, without lens. Nothing if it is not before the camera.
  std::optional<Vec2f> project(const Vec3f& p_render) const;
  /// From the camera's place, without lens; of an orthographic camera along its axis.
  float distance(const Vec3f& p_render) const;
  /// Distance of a point along the camera's -z axis, world units.
  float axial_depth(const Vec3f& p_render) const;
  /// Hydra's 0..1 depth of that distance (1 = far plane). Without a near plane, where it is undefined: d / (1 + d).
  float clip_depth(float axial_depth) const;

 private:
  friend class MovingCamera;
  void set_lens(const Lens& lens, const CameraParameters& film, int width, int height);
  Vec2f sample_aperture(const Vec2f& lens) const;
  float aperture_radius() const;
  void clip(Ray* ray) const;

  Vec3f origin_, x_, y_, z_;  // frame in render space, unit
  // From film pixels to coordinates in the plane at unit distance, or to world units if orthographic.
  Vec2f film_scale_, film_offset_;
  float lens_radius_, focus_distance_, clip_near_, clip_far_;
  bool orthographic_;
  uint32_t blades_;                                        // of a polygon, else 0
  float rotation_;                                         // of the aperture, radians
  bool is_clipped_;                                        // by more than the near plane
  std::shared_ptr<const std::vector<Vec4f>> clip_planes_;  // null: none
};

/// A camera through its shutter. Samples of its own time are spread evenly over that.
class MovingCamera {
 public:
  MovingCamera(const CameraParameters& parameters, int width, int height, const Vec3d& render_origin);

  /// Where the shutter opens.
  const Camera& first() const { return poses_.front(); }
  bool moves() const { return poses_.size() > 1 || lens_; }
  /// At a share 0..1 of the shutter.
  Camera at(float share) const;
  /// Camera::ray_origins() over the shutter.
  Bounds ray_origins(const Vec2f& film_begin, const Vec2f& film_end) const;
  /// The time of the scene's shutter then.
  float time(float share) const { return opens_ + (closes_ - opens_) * share; }

 private:
  struct MovingLens {
    CameraParameters parameters;  // without poses and clipping planes
    int width, height;
  };
  Camera pose_at(float share) const;
  std::vector<Camera> at_limits_of_lens(const Camera& pose) const;

  std::vector<Camera> poses_;
  float opens_, closes_;
  std::shared_ptr<const MovingLens> lens_;  // null: it stands still
};

}  // namespace alabaster
