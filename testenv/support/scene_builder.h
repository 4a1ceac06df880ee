// Small scenes for tests: meshes by formula, one call to a committed snapshot, one call to a finished film.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/session/render_session.h"

namespace alabaster::testing {

/// A rectangle in the xz plane about the origin, normal +y, size by size.
Mesh plane_mesh(float size);
/// A latitude-longitude sphere, points on the sphere; smooth normals if asked.
Mesh sphere_mesh(float radius, int rings, bool smooth);

/// Collects a scene; snapshot() compiles it and fails the process' test on any error report.
class SceneBuilder {
 public:
  SceneBuilder();
  std::shared_ptr<const DisneyMaterial> material(const DisneyParameters& parameters);
  std::shared_ptr<const MeshPrototype> prototype(Mesh mesh);
  SceneBuilder& add(const std::shared_ptr<const MeshPrototype>& prototype,
                    const std::shared_ptr<const DisneyMaterial>& material,
                    const Matrix4d& object_to_world = Matrix4d());
  SceneBuilder& add(const LightParameters& light);
  SceneDescription description;
  std::shared_ptr<const SceneSnapshot> snapshot(uint64_t number = 1);

 private:
  std::shared_ptr<TraceDevice> device_;
};

LightParameters constant_dome(float radiance, bool visible_to_camera);

/// Camera at `eye` looking at `target`, y up (or z up when looking along y), square film, `fov` degrees.
CameraParameters look_at(const Vec3d& eye, const Vec3d& target, double fov_degrees);

/// A frame of 72 x 72 pixels with everything that draws random numbers: subsurface, specular, an area light and a dome.
/// It asks for all AOVs.
RenderRequest mixed_request(uint32_t samples);

/// Renders to the end and returns the film.
std::shared_ptr<const Film> render(const RenderRequest& request, RenderProgress* progress = nullptr);

/// Mean and standard error of the mean over a film's pixels (colour channel 0..2), treating pixels as independent.
struct MeanError {
  double mean = 0, standard_error = 0;
};
MeanError film_mean(const Film& film, int channel);

}  // namespace alabaster::testing
