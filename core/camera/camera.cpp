#include "core/camera/camera.h"

#include <algorithm>
#include <limits>

#include "core/sampling/warp.h"

namespace alabaster {
namespace {

Vec3f axis(const Matrix4d& m, int row) {
  const Vec3d a(m[row][0], m[row][1], m[row][2]);
  return Vec3f(normalize(a));
}

// The squares of directions and of points on the lens stay below the largest float.
constexpr float kLargest = 1e18f;

float representable(float x) {
  return std::clamp(x, -kLargest, kLargest);
}

// Linear between samples. 0 says that there is no lens, and leads nowhere: before and after it the earlier sample
// holds.
float value_at(const TimeSamples<float>& samples, double time) {
  const auto after = std::upper_bound(samples.times.begin(), samples.times.end(), time);
  const auto next = static_cast<size_t>(after - samples.times.begin());
  if (next == 0) return samples.values.front();
  const float a = samples.values[next - 1];
  if (after == samples.times.end()) return a;
  const float b = samples.values[next];
  if (a == 0 || b == 0) return a;
  const auto share = static_cast<float>((time - *(after - 1)) / (*after - *(after - 1)));
  return a * (1 - share) + b * share;
}

float value_at(const TimeSamples<float>& samples, float without, double time) {
  return samples.values.empty() ? without : value_at(samples, time);
}

Lens lens_at(const CameraParameters& camera, double time) {
  return {value_at(camera.focal_lengths, camera.focal_length, time), value_at(camera.f_stops, camera.f_stop, time),
          value_at(camera.focus_distances, camera.focus_distance, time)};
}

double opening_of(const CameraParameters& camera) {
  return static_cast<double>(camera.shutter_open);
}
double close_of(const CameraParameters& camera) {
  return static_cast<double>(camera.shutter_close);
}

// Calls visit(value) for values that all others over the shutter lie between.
template <class Visit>
void for_each_turn(const CameraParameters& camera, const TimeSamples<float>& samples, const Visit& visit) {
  for (const double time : {opening_of(camera), close_of(camera)}) visit(value_at(samples, time));
  for (size_t i = 0; i < samples.values.size(); ++i)
    if (samples.times[i] > opening_of(camera) && samples.times[i] < close_of(camera)) visit(samples.values[i]);
}

// Over the shutter: the least value above 0, or the largest float if there is none, and the greatest one.
std::pair<float, float> limits_of(const CameraParameters& camera, const TimeSamples<float>& samples, float without) {
  std::pair<float, float> limits{std::numeric_limits<float>::max(), 0.0f};
  const auto add = [&](float value) {
    if (value > 0) limits.first = std::min(limits.first, value);
    limits.second = std::max(limits.second, value);
  };
  if (samples.values.empty())
    add(without);
  else
    for_each_turn(camera, samples, add);
  return limits;
}

}  // namespace

void open_lens(CameraParameters* camera) {
  const Lens lens = lens_at(*camera, opening_of(*camera));
  camera->focal_length = lens.focal_length, camera->f_stop = lens.f_stop, camera->focus_distance = lens.focus_distance;
  for (TimeSamples<float>* samples : {&camera->focal_lengths, &camera->f_stops, &camera->focus_distances}) {
    if (samples->values.empty()) continue;
    bool moves = false;
    const float first = value_at(*samples, opening_of(*camera));
    for_each_turn(*camera, *samples, [&](float value) { moves = moves || value != first; });
    if (!moves) *samples = {};
  }
}

std::span<const Parameter<CameraParameters>> camera_parameters() {
  using P = CameraParameters;
  constexpr double kSmallest = 1e-30;  // of what a projection divides by
  // The second line of a row is its unit and its description. clang-format would give each element a line.
  // clang-format off
  static constexpr Parameter<P> kTable[] = {
      {"focalLength", &P::focal_length, kSmallest, kUnbounded, {},
       "scene unit", "Focal length of the lens.", kMillimetres},
      {"horizontalAperture", &P::horizontal_aperture, kSmallest, kUnbounded, {},
       "scene unit", "Width of the film.", kMillimetres},
      {"verticalAperture", &P::vertical_aperture, kSmallest, kUnbounded, {},
       "scene unit", "Height of the film.", kMillimetres},
      {"horizontalApertureOffset", &P::horizontal_aperture_offset, -kUnbounded, kUnbounded, {},
       "scene unit", "Shift of the film to the right.", kMillimetres},
      {"verticalApertureOffset", &P::vertical_aperture_offset, -kUnbounded, kUnbounded, {},
       "scene unit", "Shift of the film upwards.", kMillimetres},
      {"fStop", &P::f_stop, 0, kUnbounded, {},
       "f-number", "Lens aperture as focal length over diameter; 0 is a pinhole with everything in focus."},
      {"focusDistance", &P::focus_distance, 0, kUnbounded, {},
       "scene unit", "Distance to the plane in focus."},
      {"apertureBlades", &P::aperture_blades, 0, 64, {},
       "none", "Blades of the aperture, which is a regular polygon as large as the round one; below 3 it is round."},
      {"apertureRotation", &P::aperture_rotation, -kUnbounded, kUnbounded, {},
       "degrees", "Rotation of the aperture's polygon; at 0 a corner points to the right."},
      {"exposure", &P::exposure, -64, 64, {},
       "stops", "Multiplies all radiance in the picture by 2 to this power."},
      {"shutterOpen", &P::shutter_open, -kUnbounded, kUnbounded, {},
       "frames", "Time at which the shutter opens, relative to the frame that is drawn."},
      {"shutterClose", &P::shutter_close, -kUnbounded, kUnbounded, {},
       "frames", "Time at which the shutter closes, relative to the frame that is drawn. Motion in between is "
       "blurred."},
  };
  // clang-format on
  return kTable;
}

Camera::Camera(const CameraParameters& p, int width, int height, const Vec3d& render_origin)
    : x_(axis(p.camera_to_world, 0)),
      y_(axis(p.camera_to_world, 1)),
      z_(axis(p.camera_to_world, 2)),
      clip_near_(p.clip_near),
      clip_far_(p.clip_far),
      orthographic_(p.orthographic),
      blades_(p.aperture_blades >= 3 ? p.aperture_blades : 0),
      rotation_(p.aperture_rotation * (kPi / 180)),
      is_clipped_(p.clip_far > 0 || !p.clip_planes.empty()) {
  if (!p.clip_planes.empty()) clip_planes_ = std::make_shared<const std::vector<Vec4f>>(p.clip_planes);
  const Matrix4d& m = p.camera_to_world;
  origin_ = Vec3f(Vec3d(m[3][0], m[3][1], m[3][2]) - render_origin);
  set_lens({p.focal_length, p.f_stop, p.focus_distance}, p, width, height);
}

void Camera::set_lens(const Lens& lens, const CameraParameters& p, int width, int height) {
  // Aperture -> tangent plane at distance one; an orthographic aperture is the view's size itself.
  const float unit = orthographic_ ? 1.0f : 1.0f / lens.focal_length;
  const float w = representable(p.horizontal_aperture * unit), h = representable(p.vertical_aperture * unit);
  film_scale_ = {w / static_cast<float>(width), -h / static_cast<float>(height)};
  film_offset_ = {representable(p.horizontal_aperture_offset * unit) - 0.5f * w,
                  representable(p.vertical_aperture_offset * unit) + 0.5f * h};
  const bool has_lens = lens.f_stop > 0 && lens.focus_distance > 0 && !orthographic_;
  lens_radius_ = has_lens ? representable(lens.focal_length / (2 * lens.f_stop)) : 0;
  focus_distance_ = std::clamp(lens.focus_distance, lens_radius_ / kLargest, kLargest);
}

// The radius of the circle that holds the aperture. A regular polygon is as large as the disk: another number of blades
// changes the shape of what is out of focus, not how much it is.
float Camera::aperture_radius() const {
  if (blades_ == 0) return lens_radius_;
  const auto n = static_cast<float>(blades_);
  return lens_radius_ * std::sqrt(kTwoPi / (n * std::sin(kTwoPi / n)));
}

Vec2f Camera::sample_aperture(const Vec2f& lens) const {
  if (blades_ == 0) return sample_concentric_disk(lens) * lens_radius_;
  const auto n = static_cast<float>(blades_);
  const float corner_angle = kTwoPi / n, radius = aperture_radius();
  const float side = std::min(std::floor(lens.x * n), n - 1);
  const Vec2f b = sample_uniform_triangle({lens.x * n - side, lens.y});
  const auto corner = [&](float i) {
    const float angle = rotation_ + i * corner_angle;
    return Vec2f(std::cos(angle), std::sin(angle)) * radius;
  };
  return corner(side) * b.y + corner(side + 1) * (1 - b.x - b.y);
}

Ray Camera::generate_ray(const Vec2f& film, const Vec2f& lens) const {
  const float px = film.x * film_scale_.x + film_offset_.x, py = film.y * film_scale_.y + film_offset_.y;
  Ray ray;
  if (orthographic_) {
    ray.org = origin_ + x_ * px + y_ * py - z_ * clip_near_;
    ray.dir = -z_;
    if (is_clipped_) [[unlikely]]
      clip(&ray);
    return ray;
  }
  Vec3f local(px, py, -1);  // on the plane at distance one
  Vec3f origin = origin_;
  if (lens_radius_ > 0) {
    // Kolb, Mitchell, Hanrahan 1995, thin lens: all rays of a film point meet in the plane of focus.
    const Vec2f d = sample_aperture(lens);
    const Vec3f focus = local * focus_distance_;
    local = {(focus.x - d.x) / focus_distance_, (focus.y - d.y) / focus_distance_, -1};
    origin = origin_ + x_ * d.x + y_ * d.y;
  }
  const Vec3f towards = x_ * local.x + y_ * local.y - z_;
  ray.org = origin + towards * clip_near_;
  ray.dir = normalize(towards);
  if (is_clipped_) [[unlikely]]
    clip(&ray);
  return ray;
}

Bounds Camera::ray_origins(const Vec2f& film_begin, const Vec2f& film_end) const {
  Bounds bounds;
  if (clip_planes_) {
    bounds.extend(Vec3f(std::numeric_limits<float>::infinity()));
    bounds.extend(Vec3f(-std::numeric_limits<float>::infinity()));
    return bounds;
  }
  // Origins are affine in the film position, and in the point on the aperture.
  const float aperture = aperture_radius();
  for (const float film_x : {film_begin.x, film_end.x})
    for (const float film_y : {film_begin.y, film_end.y}) {
      const float px = film_x * film_scale_.x + film_offset_.x, py = film_y * film_scale_.y + film_offset_.y;
      if (orthographic_) {
        bounds.extend(origin_ + x_ * px + y_ * py - z_ * clip_near_);
        continue;
      }
      for (const float x : {-aperture, aperture})
        for (const float y : {-aperture, aperture}) {
          const float tilt_x = aperture > 0 ? x / focus_distance_ : 0, tilt_y = aperture > 0 ? y / focus_distance_ : 0;
          bounds.extend(origin_ + x_ * x + y_ * y + (x_ * (px - tilt_x) + y_ * (py - tilt_y) - z_) * clip_near_);
        }
    }
  return bounds;
}

// The ray begins at the near plane.
void Camera::clip(Ray* ray) const {
  const Vec3f from = ray->org - origin_;
  const Vec3f org(dot(from, x_), dot(from, y_), dot(from, z_));
  const Vec3f dir(dot(ray->dir, x_), dot(ray->dir, y_), dot(ray->dir, z_));
  float begin = 0, end = ray->tmax;
  const auto cut = [&](const Vec4f& plane) {
    const Vec3f n(plane.x, plane.y, plane.z);
    const float height = dot(n, org) + plane.w, rise = dot(n, dir);
    if (rise > 0)
      begin = std::max(begin, -height / rise);
    else if (rise < 0)
      end = std::min(end, -height / rise);
    else if (height < 0)
      end = 0;
  };
  if (clip_far_ > 0) cut({0, 0, 1, clip_far_});
  if (clip_planes_)
    for (const Vec4f& plane : *clip_planes_) cut(plane);
  ray->tmax = begin < end ? end - begin : 0;
  if (begin < end) ray->org = ray->org + ray->dir * begin;
}

PixelCone Camera::pixel_cone(const Vec3f& d) const {
  const float side = std::min(std::abs(film_scale_.x), std::abs(film_scale_.y));
  if (orthographic_) return {side, 0};
  // Off the axis the film plane is seen at a slant and from farther away: radially it shrinks by cos^2.
  const float cosine = dot(d, z_);
  return {0, side * cosine * cosine};
}

std::optional<Vec2f> Camera::project(const Vec3f& p_render) const {
  const Vec3f eye = to_eye(p_render);
  if (!(eye.z < 0)) return std::nullopt;
  const float depth = orthographic_ ? 1 : -eye.z;
  return Vec2f((eye.x / depth - film_offset_.x) / film_scale_.x, (eye.y / depth - film_offset_.y) / film_scale_.y);
}

float Camera::axial_depth(const Vec3f& p_render) const {
  return dot(origin_ - p_render, z_);
}

float Camera::distance(const Vec3f& p_render) const {
  return orthographic_ ? axial_depth(p_render) : length(p_render - origin_);
}

MovingCamera::MovingCamera(const CameraParameters& parameters, int width, int height, const Vec3d& render_origin)
    : opens_(parameters.opens), closes_(parameters.closes) {
  CameraParameters posed = parameters;
  for (const Matrix4d& pose : parameters.poses) {
    posed.camera_to_world = pose;
    poses_.emplace_back(posed, width, height, render_origin);
  }
  if (poses_.empty()) poses_.emplace_back(parameters, width, height, render_origin);
  const CameraParameters& p = parameters;
  if (p.focal_lengths.values.empty() && p.f_stops.values.empty() && p.focus_distances.values.empty()) return;
  posed.poses.clear(), posed.clip_planes.clear();
  lens_ = std::make_shared<const MovingLens>(MovingLens{std::move(posed), width, height});
}

// With the shortest and the longest focal length and the nearest and the farthest focus, each with the widest aperture:
// origins are affine in 1 / focal length, in 1 / focus distance and in the point on the aperture.
std::vector<Camera> MovingCamera::at_limits_of_lens(const Camera& pose) const {
  if (!lens_) return {pose};
  const CameraParameters& p = lens_->parameters;
  const auto [shortest, longest] = limits_of(p, p.focal_lengths, p.focal_length);
  const float widest = limits_of(p, p.f_stops, p.f_stop).first;
  const auto [nearest, farthest] = limits_of(p, p.focus_distances, p.focus_distance);
  std::vector<Camera> all;
  for (const float focal_length : {shortest, longest})
    for (const float focus_distance : {nearest, farthest})
      all.emplace_back(pose).set_lens({focal_length, widest * (focal_length / longest), focus_distance}, p,
                                      lens_->width, lens_->height);
  return all;
}

// Between poses the frame is not quite orthogonal: an origin is no farther from the camera's than the sum of its
// coordinates.
Bounds MovingCamera::ray_origins(const Vec2f& film_begin, const Vec2f& film_end) const {
  if (!moves() || poses_.front().clip_planes_) return poses_.front().ray_origins(film_begin, film_end);
  Bounds bounds;
  for (const Camera& pose : poses_) {
    Bounds there;
    for (const Camera& limit : at_limits_of_lens(pose)) there.extend(limit.ray_origins(film_begin, film_end));
    if (poses_.size() == 1) return there;
    float reach = 0;
    for (const Vec3f& corner : there.corners()) {
      const Vec3f eye = pose.to_eye(corner);
      reach = std::max(reach, std::abs(eye.x) + std::abs(eye.y) + std::abs(eye.z));
    }
    bounds.extend(pose.origin_ - Vec3f(reach));
    bounds.extend(pose.origin_ + Vec3f(reach));
  }
  return bounds;
}

Camera MovingCamera::at(float share) const {
  Camera camera = pose_at(share);
  if (!lens_) return camera;
  const CameraParameters& p = lens_->parameters;
  const double time = opening_of(p) + (close_of(p) - opening_of(p)) * static_cast<double>(share);
  camera.set_lens(lens_at(p, time), p, lens_->width, lens_->height);
  return camera;
}

Camera MovingCamera::pose_at(float share) const {
  if (poses_.size() == 1) return poses_.front();
  const PoseTime at(share, poses_.size());
  const Camera &a = poses_[at.first], &b = poses_[at.first + 1];
  Camera posed = a;
  posed.origin_ = at.between(a.origin_, b.origin_);
  posed.x_ = normalize(at.between(a.x_, b.x_));
  posed.y_ = normalize(at.between(a.y_, b.y_));
  posed.z_ = normalize(at.between(a.z_, b.z_));
  return posed;
}

float Camera::clip_depth(float axial) const {
  // Hydra's depth: window-space depth of a GL projection, 0 at the near plane, 1 at the far plane.
  const float n = clip_near_, f = clip_far_;
  if (orthographic_) return f > n ? (axial - n) / (f - n) : 0;
  if (!(n > 0)) return axial / (1 + axial);
  return f > n ? f * (axial - n) / (axial * (f - n)) : 1 - n / axial;
}

}  // namespace alabaster
