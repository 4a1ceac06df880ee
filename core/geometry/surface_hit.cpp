#include "core/geometry/surface_hit.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "core/math/frame.h"

namespace alabaster {
namespace {

const Corners& normal_corners(const Mesh& mesh, uint32_t triangle) {
  return mesh.normal_triangles.empty() ? mesh.triangles[triangle] : mesh.normal_triangles[triangle];
}
// 2^-exponent of x: multiplying by it brings x near 1 without rounding (x normal and finite, else 1).
float exact_reciprocal_scale(float x) {
  const uint32_t exponent = (std::bit_cast<uint32_t>(x) >> 23) & 0xff;
  if (exponent == 0 || exponent >= 254) return 1;
  return std::bit_cast<float>((254 - exponent) << 23);
}

// Unit vector along v for any finite v whose length is not subnormal; `otherwise` if there is none.
Vec3f unit_or(const Vec3f& v, const Vec3f& otherwise) {
  const Vec3f w = v * exact_reciprocal_scale(max_abs_component(v));
  const float l2 = dot(w, w);
  if (!(l2 > 0) || !std::isfinite(l2)) return otherwise;
  return w * (1 / std::sqrt(l2));
}

Vec3f absolute(const Vec3f& v) {
  return {std::abs(v.x), std::abs(v.y), std::abs(v.z)};
}

// |v| times the matrix of absolute values: the growth of error bounds under the linear part.
Vec3f grow(const Vec3f& bound, const Affine& m) {
  return absolute(m.x) * bound.x + absolute(m.y) * bound.y + absolute(m.z) * bound.z;
}

// All bounds below count in units of this: four roundings of 2^-24 each, which covers a dot product of three terms and
// a translation (Higham, "Accuracy and Stability of Numerical Algorithms", 2nd ed., eq. 3.5).
constexpr float kRoundings = 2 * std::numeric_limits<float>::epsilon();

// The plane test of a ray against a triangle in its own space: the vertices relative to the origin, the normal from
// their differences, and the dot product err by some roundings of the largest coordinate, once for each of the three
// axes that the normal mixes. m bounds the coordinates of the triangle, and so those of the hit.
float plane_error(float m, const Vec3f& normal) {
  const Vec3f n = absolute(normal);
  return 2 * m * (n.x + n.y + n.z);
}

// The distance along ng that rounding can displace a point between here and the plane test in object space:
//   render  p = fl(p_object M + t):           s_j = sum_i |M_ij| m + |t_j|                     (and fl(p + n offset))
//   object  p' = fl(p W - t W), W = M^-1:     q   = (s + |t|) |W|
//   W itself is rounded, by |W||M||W|:        r   = q |M| |W|       (Higham, section 14.1)
// An object-space displacement e moves the point by e M in render space, so along ng by at most
// sum_i e_i |row_i(M) . ng|. Nothing here has a unit but the lengths themselves.
float render_offset(float m, const Vec3f& ng, const Affine& to_render, const Affine& to_object) {
  const Vec3f t = absolute(to_render.t);
  const Vec3f s = grow(Vec3f(m, m, m), to_render) + t;
  const Vec3f q = grow(s + t, to_object);
  const Vec3f r = grow(grow(q, to_render), to_object);
  const Vec3f along = absolute(to_render.transpose_vector(ng));
  return kRoundings * (dot(s, absolute(ng)) + plane_error(m, along) + dot(q + r, along));
}

// Vectors at a triangle's corners: where the mesh has them, or posed ones. A mesh that stands still is not copied.
struct CornerVectors {
  const Vec3f &a, &b, &c;
};

CornerVectors in_mesh(const std::vector<Vec3f>& vectors, const Corners& c) {
  return {vectors[c[0]], vectors[c[1]], vectors[c[2]]};
}

// The normals at the corners, in a mesh that deforms.
[[gnu::noinline]] std::array<Vec3f, 3> posed_normals(const Mesh& mesh, const TriangleHit& hit) {
  const Corners& c = normal_corners(mesh, hit.triangle);
  return {mesh.normal_at(c[0], hit.time), mesh.normal_at(c[1], hit.time), mesh.normal_at(c[2], hit.time)};
}

// The interpolated normal in object space. Three corners that all point inward are taken as authored for the other
// side; a single one that leans over the horizon is left to the caller, who bends the result.
inline Vec3f interpolated_normal(const CornerVectors& at, const TriangleHit& hit, const Vec3f& ng_object) {
  const Vec3f n = at.a * (1 - hit.u - hit.v) + at.b * hit.u + at.c * hit.v;
  const bool reversed = dot(at.a, ng_object) < 0 && dot(at.b, ng_object) < 0 && dot(at.c, ng_object) < 0;
  return reversed ? -n : n;
}
Vec3f interpolated_normal(const Mesh& mesh, const TriangleHit& hit, const Vec3f& ng_object) {
  if (mesh.deforms()) [[unlikely]] {
    const auto posed = posed_normals(mesh, hit);
    return interpolated_normal({posed[0], posed[1], posed[2]}, hit, ng_object);
  }
  return interpolated_normal(in_mesh(mesh.normals, normal_corners(mesh, hit.triangle)), hit, ng_object);
}

Vec3f shading_normal(const Mesh& mesh, const TriangleHit& hit, const SurfacePoint& s, const Affine& render_to_object) {
  if (mesh.normals.empty()) return s.ng;
  const Vec3f ns = unit_or(render_to_object.transpose_vector(interpolated_normal(mesh, hit, s.ng_object)), s.ng);
  const float cosine = dot(ns, s.ng);
  // Bending by reflection in the tangent plane is continuous where the normal crosses the horizon.
  return cosine < 0 ? unit_or(ns - s.ng * (2 * cosine), s.ng) : ns;
}

struct TextureFrame {
  Vec2f uv{0, 0};
  Vec3f dpdu{0, 0, 0};  // any length, object space; zero: none
};

// A triangle in the first set of texture coordinates.
struct UvTriangle {
  const Vec2f &t0, &t1, &t2;
  Vec2f d1 = t1 - t0, d2 = t2 - t0;
  float determinant = d1.x * d2.y - d2.x * d1.y;

  static UvTriangle of(const Mesh& mesh, uint32_t triangle) {
    const UvSet& set = mesh.uv_sets.front();
    const Corners& c = corners_of(set, mesh, triangle);
    return {set.values[c[0]], set.values[c[1]], set.values[c[2]]};
  }
};

TextureFrame texture_frame(const Mesh& mesh, const TriangleHit& hit, const Vec3f& e1, const Vec3f& e2) {
  if (mesh.uv_sets.empty()) return {};
  const UvTriangle t = UvTriangle::of(mesh, hit.triangle);
  TextureFrame frame;
  frame.uv = t.t0 * (1 - hit.u - hit.v) + t.t1 * hit.u + t.t2 * hit.v;
  if (t.determinant != 0) frame.dpdu = (e1 * t.d2.y - e2 * t.d1.y) * std::copysign(1.0f, t.determinant);
  return frame;
}

// The triangle in its own space.
struct Facet {
  std::array<Vec3f, 3> corners;
  const Vec3f &p0 = corners[0], &p1 = corners[1], &p2 = corners[2];
  Vec3f e1 = p1 - p0, e2 = p2 - p0;
  float scale = exact_reciprocal_scale(std::max(max_abs_component(e1), max_abs_component(e2)));

  Facet(const Mesh& mesh, const TriangleHit& hit) : corners(mesh.corners_at(hit.triangle, hit.time)) {}
  Facet(const Facet&) = delete;
  Facet& operator=(const Facet&) = delete;
  float largest_coordinate() const {
    return std::max(max_abs_component(p0), std::max(max_abs_component(p1), max_abs_component(p2)));
  }
};

inline void set_point(const Mesh& mesh, const TriangleHit& hit, const Facet& f, const Affine& object_to_render,
                      const Affine& render_to_object, SurfacePoint* s) {
  s->p_object = f.p0 * (1 - hit.u - hit.v) + f.p1 * hit.u + f.p2 * hit.v;
  s->ng_object = unit_or(cross(f.e1 * f.scale, f.e2 * f.scale), Vec3f(0, 0, 1));
  s->p = object_to_render.point(s->p_object);
  s->ng = unit_or(render_to_object.transpose_vector(s->ng_object), s->ng_object);
  s->ns = shading_normal(mesh, hit, *s, render_to_object);
  // The vertices bound the error, not the hit: a ray in the middle of a large triangle still meets its far corners.
  const float m = f.largest_coordinate();
  s->offset = render_offset(m, s->ng, object_to_render, render_to_object);
  s->offset_object = kRoundings * (plane_error(m, s->ng_object) + m);
  // Between poses the corners and the placement are rounded once more each.
  if (hit.time > 0) [[unlikely]]
    s->offset *= 2, s->offset_object *= 2;
}

inline Vec3f shift_in_object(const CornerVectors& points, const CornerVectors& normals, const TriangleHit& hit,
                             const SurfacePoint& side) {
  const float weights[3] = {1 - hit.u - hit.v, hit.u, hit.v};
  const bool reversed = dot(normals.a + normals.b + normals.c, side.ng_object) < 0;
  const Vec3f* const p[3] = {&points.a, &points.b, &points.c};
  const Vec3f* const vertex_normals[3] = {&normals.a, &normals.b, &normals.c};
  Vec3f shift(0, 0, 0);
  for (size_t i = 0; i < 3; ++i) {
    const Vec3f n = reversed ? -*vertex_normals[i] : *vertex_normals[i];
    // Below the tangent plane of the vertex: up to it. A normal that leans over the facet's horizon is no guide.
    const float depth = dot(*p[i] - side.p_object, n);
    if (depth > 0 && dot(n, side.ng_object) > 0) shift += n * (weights[i] * depth / dot(n, n));
  }
  return shift;
}

}  // namespace

void prefetch_corners(const Mesh& mesh, uint32_t triangle, Attributes attributes) {
  for (const uint32_t c : mesh.triangles[triangle]) __builtin_prefetch(&mesh.points[c]);
  if (!mesh.normals.empty())
    for (const uint32_t c : normal_corners(mesh, triangle)) __builtin_prefetch(&mesh.normals[c]);
  if (attributes == Attributes::normals_and_uvs && !mesh.uv_sets.empty()) {
    const UvSet& set = mesh.uv_sets.front();
    for (const uint32_t c : corners_of(set, mesh, triangle)) __builtin_prefetch(&set.values[c]);
  }
}

SurfacePoint surface_point(const Mesh& mesh, const TriangleHit& hit, const Affine& object_to_render,
                           const Affine& render_to_object) {
  SurfacePoint s;
  set_point(mesh, hit, Facet(mesh, hit), object_to_render, render_to_object, &s);
  return s;
}

SurfaceHit surface_hit(const Mesh& mesh, const TriangleHit& hit, const Affine& object_to_render,
                       const Affine& render_to_object) {
  SurfaceHit s;
  const Facet f(mesh, hit);
  set_point(mesh, hit, f, object_to_render, render_to_object, &s);
  const TextureFrame frame = texture_frame(mesh, hit, f.e1 * f.scale, f.e2 * f.scale);
  s.uv = frame.uv;
  s.dpdu = unit_or(object_to_render.vector(frame.dpdu), frame_from_normal(s.ns).s);
  return s;
}

bool has_direction_of_u(const Mesh& mesh, uint32_t triangle) {
  return !mesh.uv_sets.empty() && UvTriangle::of(mesh, triangle).determinant != 0;
}

Vec3f stand_in_tangent(const SurfacePoint& at, const Affine& object_to_render) {
  constexpr float kAcross = 1e-8f;  // squared sine
  const Vec3f n = unit_or(object_to_render.transpose_vector(at.ns), at.ng_object), about(n.z, 0, -n.x);
  const Vec3f tangent = dot(about, about) > kAcross ? about : Vec3f(1, 0, 0);
  return unit_or(object_to_render.vector(tangent), frame_from_normal(at.ns).s);
}

bool has_mirrored_uvs(const Mesh& mesh, uint32_t triangle) {
  return !mesh.uv_sets.empty() && UvTriangle::of(mesh, triangle).determinant < 0;
}

Vec2f HitPrimvars::uv(const UvSetName& set) const {
  if (Vec4f own; has_own(set, &own)) return {own.x, own.y};
  if (mesh_.uv_sets.empty()) return {0, 0};
  if (mesh_.uv_sets.front().name == set) return uv_;
  const UvSet* const found = mesh_.uv_set(set);
  return found ? interpolated<Vec2f>(*found, mesh_, hit_) : Vec2f(0, 0);
}

// J = D E^-1 with the edges E and their uv D, so J J^T = D (E^T E)^-1 D^T.
Vec3f HitPrimvars::uv_metric(const UvSetName& set) const {
  const UvSet* const found = mesh_.uv_set(set);
  if (Vec4f own; !found || has_own(set, &own)) return Vec3f(0, 0, 0);
  const Corners &c = mesh_.triangles[hit_.triangle], &t = corners_of(*found, mesh_, hit_.triangle);
  const Vec3f e1 = footprint_.object_to_render->vector(mesh_.points[c[1]] - mesh_.points[c[0]]);
  const Vec3f e2 = footprint_.object_to_render->vector(mesh_.points[c[2]] - mesh_.points[c[0]]);
  const Vec2f d1 = found->values[t[1]] - found->values[t[0]], d2 = found->values[t[2]] - found->values[t[0]];
  const float g11 = dot(e1, e1), g12 = dot(e1, e2), g22 = dot(e2, e2);
  const float determinant = g11 * g22 - g12 * g12;
  if (!(determinant > 0)) return Vec3f(0, 0, 0);
  const auto product = [&](float a1, float a2, float b1, float b2) {
    return (a1 * b1 * g22 - (a1 * b2 + a2 * b1) * g12 + a2 * b2 * g11) / determinant;
  };
  return {product(d1.x, d2.x, d1.x, d2.x), product(d1.x, d2.x, d1.y, d2.y), product(d1.y, d2.y, d1.y, d2.y)};
}

int HitPrimvars::read(const UvSetName& name, Vec4f* numbers) const {
  *numbers = Vec4f(0);
  if (const int count = has_own(name, numbers)) return count;
  const NamedAttribute* const found = mesh_.primvar(name);
  if (!found) return 0;
  const auto read_one = [&]<class T>(const MeshAttribute<T>& attribute) {
    constexpr size_t kNumberBytes = sizeof(float), kCount = sizeof(T) / kNumberBytes;
    const T value = interpolated(attribute, mesh_, hit_);
    std::copy_n(reinterpret_cast<const float*>(&value), kCount, &numbers->x);
    return static_cast<int>(kCount);
  };
  return std::visit(read_one, found->values);
}

Vec3f curvature_shift(const Mesh& mesh, const TriangleHit& hit, const SurfacePoint& side,
                      const Affine& object_to_render) {
  if (mesh.normals.empty()) return Vec3f(0, 0, 0);
  if (mesh.deforms()) [[unlikely]] {
    const auto p = mesh.corners_at(hit.triangle, hit.time), n = posed_normals(mesh, hit);
    return object_to_render.vector(shift_in_object({p[0], p[1], p[2]}, {n[0], n[1], n[2]}, hit, side));
  }
  return object_to_render.vector(shift_in_object(in_mesh(mesh.points, mesh.triangles[hit.triangle]),
                                                 in_mesh(mesh.normals, normal_corners(mesh, hit.triangle)), hit, side));
}

}  // namespace alabaster
