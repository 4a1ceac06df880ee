#include "core/subsurface/distance_grid.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <cmath>
#include <limits>

namespace alabaster {
namespace {

constexpr uint32_t kFar = 1u << 24;  // squared half voxels, beyond any distance in a grid

struct Voxels {
  uint32_t size[3];
  std::vector<uint32_t> squared;  // distance from the centre to the nearest occupied voxel, in half voxels

  size_t index(uint32_t x, uint32_t y, uint32_t z) const { return (size_t(z) * size[1] + y) * size[0] + x; }
};

struct Piece {
  Vec3f corner[3];  // in voxels from the grid's lower corner
};

/// Marks the voxels that a triangle may touch: it is halved until what is left lies in one voxel or is a quarter of one
/// in size, and then its box is marked.
class Rasterizer {
 public:
  explicit Rasterizer(Voxels* voxels) : voxels_(voxels) {}

  void mark(const Piece& piece) {
    Bounds box;
    for (const Vec3f& c : piece.corner) box.extend(c);
    uint32_t first[3], last[3];
    bool single = true;
    for (int i = 0; i < 3; ++i) {
      first[i] = cell(box.lower[i] - kRounding, i);
      last[i] = cell(box.upper[i] + kRounding, i);
      single = single && first[i] == last[i];
    }
    if (!single && max_component(box.extent()) > 0.25f) return halve(piece);
    for (uint32_t z = first[2]; z <= last[2]; ++z)
      for (uint32_t y = first[1]; y <= last[1]; ++y)
        for (uint32_t x = first[0]; x <= last[0]; ++x)
          std::atomic_ref(voxels_->squared[voxels_->index(x, y, z)]).store(0, std::memory_order_relaxed);
  }

 private:
  /// In voxels: more than the rounding of corners, halvings and look-ups in a grid of 255.
  static constexpr float kRounding = 1e-3f;

  uint32_t cell(float position, int axis) const {
    const float last = static_cast<float>(voxels_->size[axis] - 1);
    return static_cast<uint32_t>(std::min(std::max(position, 0.0f), last));
  }

  void halve(const Piece& piece) {
    int longest = 0;
    float length2 = -1;
    for (int i = 0; i < 3; ++i) {
      const Vec3f edge = piece.corner[(i + 1) % 3] - piece.corner[i];
      if (dot(edge, edge) > length2) {
        length2 = dot(edge, edge);
        longest = i;
      }
    }
    const int next = (longest + 1) % 3;
    Piece first = piece, second = piece;
    first.corner[next] = second.corner[longest] = (piece.corner[longest] + piece.corner[next]) * 0.5f;
    mark(first);
    mark(second);
  }

  Voxels* voxels_;
};

/// One line of the transform, in half voxels: out[i] = min_j line[j] + max(0, 2 |i - j| - 1)^2, so that distances are
/// those from a voxel's centre to the nearest point of another voxel. It is the usual transform of parabolas that stand
/// on the borders between voxels, or none where j = i.
class LineTransform {
 public:
  void run(std::vector<uint32_t>* line) {
    const size_t n = line->size();
    border_.resize(n + 1);
    apex_.resize(n + 1);
    from_.resize(n + 1);
    for (size_t i = 0; i <= n; ++i) border_[i] = std::min((*line)[i > 0 ? i - 1 : 0], (*line)[i < n ? i : n - 1]);
    const size_t parabolas = lower_envelope();
    if (parabolas == 0) return;
    size_t k = 0;
    for (size_t i = 0; i < n; ++i) {
      const int64_t centre = 2 * static_cast<int64_t>(i);
      while (k + 1 < parabolas && from_[k + 1] < static_cast<double>(centre)) ++k;
      const int64_t offset = centre - position(apex_[k]);
      (*line)[i] = std::min((*line)[i], border_[apex_[k]] + static_cast<uint32_t>(offset * offset));
    }
  }

 private:
  static int64_t position(size_t border) { return 2 * static_cast<int64_t>(border) - 1; }
  double height(size_t border) const {
    return static_cast<double>(border_[border]) + static_cast<double>(position(border) * position(border));
  }

  size_t lower_envelope() {
    size_t count = 0;
    for (size_t i = 0; i < border_.size(); ++i) {
      if (border_[i] >= kFar) continue;
      double crossing = -std::numeric_limits<double>::infinity();
      while (count > 0) {
        const size_t last = apex_[count - 1];
        crossing = (height(i) - height(last)) / (2 * static_cast<double>(position(i) - position(last)));
        if (crossing > from_[count - 1]) break;
        --count;
      }
      if (count == 0) crossing = -std::numeric_limits<double>::infinity();
      apex_[count] = i;
      from_[count] = crossing;
      ++count;
    }
    return count;
  }

  std::vector<uint32_t> border_;
  std::vector<size_t> apex_;  // of the parabolas that are lowest somewhere
  std::vector<double> from_;  // where each begins to be
};

void transform_along(int axis, Voxels* voxels, const CancelToken& cancel) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  const size_t strides[3] = {1, voxels->size[0], size_t(voxels->size[0]) * voxels->size[1]};
  tbb::parallel_for(tbb::blocked_range<uint32_t>(0, voxels->size[v], 4),
                    [&](const tbb::blocked_range<uint32_t>& range) {
                      cancel.check();
                      LineTransform transform;
                      std::vector<uint32_t> line(voxels->size[axis]);
                      for (uint32_t j = range.begin(); j < range.end(); ++j)
                        for (uint32_t i = 0; i < voxels->size[u]; ++i) {
                          uint32_t* const start = &voxels->squared[i * strides[u] + j * strides[v]];
                          for (size_t k = 0; k < line.size(); ++k) line[k] = start[k * strides[axis]];
                          transform.run(&line);
                          for (size_t k = 0; k < line.size(); ++k) start[k * strides[axis]] = line[k];
                        }
                    });
}

/// Pieces that a triangle is cut into, roughly.
double rasterization_cost(const Piece& piece) {
  const Vec3f a = piece.corner[1] - piece.corner[0], b = piece.corner[2] - piece.corner[0];
  return 1 + 32 * static_cast<double>(length(cross(a, b))) + 8 * static_cast<double>(length(a) + length(b));
}

bool rasterize(const Mesh& mesh, const Vec3f& lower, float voxels_per_unit, Voxels* voxels, const CancelToken& cancel) {
  constexpr double kMostPieces = 1e8;  // some seconds
  const auto piece_of = [&](size_t i) {
    Piece piece;
    for (size_t c = 0; c < 3; ++c) piece.corner[c] = (mesh.points[mesh.triangles[i][c]] - lower) * voxels_per_unit;
    return piece;
  };
  double cost = 0;
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (i % 4096 == 0) cancel.check();
    cost += rasterization_cost(piece_of(i));
  }
  if (!(cost < kMostPieces)) return false;
  tbb::parallel_for(tbb::blocked_range<size_t>(0, mesh.triangles.size(), 256),
                    [&](const tbb::blocked_range<size_t>& r) {
                      cancel.check();
                      Rasterizer rasterizer(voxels);
                      for (size_t i = r.begin(); i < r.end(); ++i) rasterizer.mark(piece_of(i));
                    });
  return true;
}

}  // namespace

std::shared_ptr<const DistanceGrid> build_distance_grid(const Mesh& mesh, uint32_t resolution,
                                                        const CancelToken& cancel) {
  const Vec3f extent = mesh.bounds.extent();
  const float longest = max_component(extent);
  const float per_unit = static_cast<float>(resolution) / longest;
  if (mesh.triangles.empty() || !(longest > 0) || !std::isfinite(longest) || !std::isnormal(per_unit)) return nullptr;

  auto grid = std::make_shared<DistanceGrid>();
  grid->lower_ = mesh.bounds.lower;
  grid->voxels_per_unit_ = per_unit;
  grid->unit_per_voxel_ = 1 / per_unit;
  Voxels voxels{};
  for (int i = 0; i < 3; ++i) {
    const uint32_t n = std::min(resolution, static_cast<uint32_t>(extent[i] * per_unit) + 1);
    voxels.size[i] = grid->size_[i] = n;
    grid->size_f_[i] = static_cast<float>(n);
  }
  voxels.squared.assign(size_t(voxels.size[0]) * voxels.size[1] * voxels.size[2], kFar);
  if (!rasterize(mesh, grid->lower_, per_unit, &voxels, cancel)) return nullptr;
  for (int axis = 0; axis < 3; ++axis) transform_along(axis, &voxels, cancel);

  grid->cells_.resize(voxels.squared.size());
  tbb::parallel_for(tbb::blocked_range<size_t>(0, voxels.squared.size(), 16384),
                    [&](const tbb::blocked_range<size_t>& r) {
                      for (size_t i = r.begin(); i < r.end(); ++i)
                        grid->cells_[i] = static_cast<uint8_t>(
                            std::min(255.0f, 2 * std::sqrt(static_cast<float>(voxels.squared[i])) * (1 - 0x1p-20f)));
                    });
  return grid;
}

}  // namespace alabaster
