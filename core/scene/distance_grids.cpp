#include "core/scene/distance_grids.h"

#include <set>

#include "core/subsurface/random_walk_loop.h"

namespace alabaster {
namespace {

struct MeanFreePaths {
  float longest = 0;        // world; 0: nothing scatters
  float of_long_walks = 0;  // the longest in a material where walks are long; 0: none is
};

/// A texture may be white anywhere.
void extend(const DisneyMaterial& material, MeanFreePaths* paths) {
  if (!material.scatters()) return;
  const DisneyParameters& p = material.constants;
  const Rgb albedo = material.base_color_map ? Rgb(1.0f) : p.base_color;
  const Medium medium = make_medium(albedo, p.scatter_distance, AlbedoInversion::exact, p.scatter_anisotropy);
  float mfp = 0;
  for (int c = 0; c < 3; ++c)
    if (medium.active[c] && medium.sigma_t[c] > 0) mfp = std::max(mfp, 1 / medium.sigma_t[c]);
  paths->longest = std::max(paths->longest, mfp);
  if (useful_shortcuts(medium, {}).sphere_steps) paths->of_long_walks = std::max(paths->of_long_walks, mfp);
}

/// World distance from the middle of an instance's bounds to their nearest side, at least.
float half_thickness(const Instance& instance) {
  const Vec3f extent = instance.prototype->mesh.bounds.extent();
  return 0.5f * std::min(extent.x, std::min(extent.y, extent.z)) * instance.walk.distance_scale;
}

// Measured (testenv/statistical/results/walk_efficiency.md): in a body less than so many mean free paths across from
// the middle, walks leave before spheres find room, and before guiding has saved what it costs.
constexpr float kRoom = 30;

bool has_room_for_spheres(const Instance& instance, float mfp) {
  // A grid of 128 voxels bounds no distance below two; deeper than kDeep few walks go.
  constexpr float kVoxelsAcross = 128, kDeep = 32;
  const float voxel =
      max_component(instance.prototype->mesh.bounds.extent()) * instance.walk.distance_scale / kVoxelsAcross;
  return half_thickness(instance) > kRoom * mfp && 2 * voxel < kDeep * mfp;
}

}  // namespace

float least_stretch(const Affine& map) {
  // Eigenvalues of the Gram matrix by Jacobi's rotations, in double.
  const Vec3d rows[3] = {{map.x.x, map.x.y, map.x.z}, {map.y.x, map.y.y, map.y.z}, {map.z.x, map.z.y, map.z.z}};
  double a[3][3];
  double largest = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      a[i][j] = dot(rows[i], rows[j]);
      largest = std::max(largest, std::abs(a[i][j]));
    }
  constexpr int kSweeps = 12;
  for (int sweep = 0; sweep < kSweeps; ++sweep)
    for (int p = 0; p < 2; ++p)
      for (int q = p + 1; q < 3; ++q) {
        if (a[p][q] == 0) continue;
        const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
        const double t = std::copysign(1.0, theta) / (std::abs(theta) + std::hypot(theta, 1.0));
        const double c = 1 / std::hypot(t, 1.0), s = t * c;
        for (int k = 0; k < 3; ++k) {
          const double kp = a[k][p], kq = a[k][q];
          a[k][p] = c * kp - s * kq;
          a[k][q] = s * kp + c * kq;
        }
        for (int k = 0; k < 3; ++k) {
          const double pk = a[p][k], qk = a[q][k];
          a[p][k] = c * pk - s * qk;
          a[q][k] = s * pk + c * qk;
        }
      }
  const double smallest = std::min(a[0][0], std::min(a[1][1], a[2][2])) - 1e-15 * largest;
  return smallest > 0 ? static_cast<float>(std::sqrt(smallest) * (1 - 0x1p-22)) : 0;
}

void add_distance_grids(SceneSnapshot* snapshot) {
  std::set<const DistanceGrid*> counted;
  for (Instance& instance : snapshot->instances) {
    MeanFreePaths paths;
    for (const DisneyMaterial* material : instance.materials) extend(*material, &paths);
    if (!(paths.longest > 0) || instance.walk.set) continue;
    instance.walk.distance_scale = least_stretch(instance.object_to_world);
    instance.walk.room_to_guide = half_thickness(instance) > kRoom * paths.longest;
    if (!(paths.of_long_walks > 0) || !has_room_for_spheres(instance, paths.of_long_walks)) continue;
    const DistanceGrid* grid = instance.prototype->distances();
    instance.walk.distances = grid;
    if (grid && counted.insert(grid).second) snapshot->memory_bytes += grid->memory_bytes();
  }
}

}  // namespace alabaster
