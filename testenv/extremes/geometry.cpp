// Shapes and places at the ends of what floats and rays can tell apart.
#include <algorithm>
#include <tuple>

#include "core/geometry/surface_hit.h"
#include "core/material/displacement.h"
#include "testenv/extremes/rows.h"
#include "testenv/support/cages.h"
#include "testenv/support/mesh_bodies.h"
#include "testenv/support/reports.h"

namespace alabaster::testing {
namespace {

Mesh mesh_of(std::vector<Vec3f> points, std::vector<Corners> triangles) {
  Mesh mesh;
  mesh.points = std::move(points);
  mesh.triangles = std::move(triangles);
  for (const Vec3f& p : mesh.points) mesh.bounds.extend(p);
  return mesh;
}

/// The share of a picture, from above and `size` wide, that glows with radiance 1.
Picture glow_from_above(Mesh mesh, float size, uint32_t samples = 4) {
  SceneBuilder b;
  b.add(b.prototype(std::move(mesh)), b.material(glowing(1)));
  return Picture(picture_of(&b, from_above(size), samples));
}

// ---- scale and place

DisneyParameters shiny() {
  DisneyParameters p;
  p.roughness = 0.3f;
  p.clearcoat = 1;
  return p;
}

// Opaque, clear and scattering surfaces, and every type of light, all lengths times `s`, at `place`.
RenderRequest everything(double s, const Vec3d& place = Vec3d(0, 0, 0), uint32_t seed = 0) {
  const auto f = static_cast<float>(s);
  SceneBuilder b;
  const auto at = [&](double x, double y, double z) { return Matrix4d().setTranslation(place + Vec3d(x, y, z) * s); };
  const auto ball = b.prototype(sphere_mesh(0.5f * f, 16, true));
  DisneyParameters glass;
  glass.spec_trans = 1;
  glass.roughness = 0.1f;
  glass.attenuation_color = {0.5f, 0.9f, 0.8f};
  glass.attenuation_distance = f;
  DisneyParameters skin = medium_only(0.8f, 0.1f * f);
  b.add(b.prototype(plane_mesh(8 * f)), b.material(shiny()), at(0, -0.5, 0));
  b.add(ball, b.material(glass), at(-1.1, 0, 0)).add(ball, b.material(skin), at(0, 0, 0));
  b.add(ball, b.material(glowing(2)), at(1.1, 0, 0));
  Matrix4d down(1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1);
  int i = 0;
  for (const LightType type : {LightType::rect, LightType::sphere, LightType::disk, LightType::cylinder}) {
    LightParameters light;
    light.type = type;
    light.intensity = 4;
    light.width = light.height = light.length = 0.4f * f;
    light.radius = 0.2f * f;
    light.light_to_world = down * at(i++ - 1.5, 2, 0.5);
    b.add(light);
  }
  LightParameters sun;
  sun.type = LightType::distant;
  sun.light_to_world = down;
  b.add(sun).add(constant_dome(0.2f, true));
  const auto eye = [&](const Vec3d& p) { return place + p * s; };
  RenderRequest request = picture_of(&b, look_at(eye({0, 1, 5}), eye({0, 0, 0}), 40), 4, 24);
  request.settings.seed = seed;
  return request;
}

// A matt ball and a scattering one, which touch the floor, all lengths times `s`.
RenderRequest lit_ball(double s, bool has_floor, LightType type) {
  const auto f = static_cast<float>(s);
  SceneBuilder b;
  const auto at = [&](double x, double y, double z) { return translation(x * s, y * s, z * s); };
  const auto ball = b.prototype(sphere_mesh(0.5f * f, 16, true));
  b.add(ball, b.material(medium_only(0.5f, 0)), at(-0.6, 0, 0));
  b.add(ball, b.material(medium_only(0.8f, 0.1f * f)), at(0.6, 0, 0));
  if (has_floor) b.add(b.prototype(plane_mesh(8 * f)), b.material(shiny()), at(0, -0.5, 0));
  LightParameters light;
  light.type = type;
  light.intensity = 4;
  light.width = light.height = 0.4f * f;
  light.radius = 0.2f * f;
  light.light_to_world = Matrix4d(1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1) * at(0.5, 2, 0.5);
  b.add(light);
  return picture_of(&b, look_at(Vec3d(0, 1, 5) * s, Vec3d(0, 0, 0), 40), 16, 24);
}

void print_scales(Rows& rows) {
  const Picture expected(everything(1));
  size_t different = 0;
  for (int k = -20; k <= 28; k += 4) different += different_values(Picture(everything(std::ldexp(1.0, k))), expected);
  rows.require("all kinds of surfaces and lights", "all lengths times 2^-20 to 2^28", "the same picture", "bits",
               text("%zu values differ", different), different == 0 && expected.sound);
  for (const double s : {1e-12, 1e-10, 1e-8, 1e10, 1e11})
    for (const auto& [name, floor, light] : {std::tuple{"rectangle", true, LightType::rect},
                                             {"ball of light", true, LightType::sphere},
                                             {"sky", false, LightType::dome}}) {
      const Picture here(lit_ball(1, floor, light)), scaled(lit_ball(s, floor, light));
      rows.require(std::string("balls on a floor under a ") + name, text("all lengths times %g", s),
                   "the mean at scale 1", "5e-3 of it: without grids of distances walks have other noise",
                   text("%.6g, at scale 1 %.6g", scaled.mean.mean, here.mean.mean),
                   scaled.sound && std::abs(scaled.mean.mean / here.mean.mean - 1) < 5e-3);
    }
  for (const double place : {1e3, 1e6, 1e7}) {
    const Picture moved(everything(1, Vec3d(place, -place, place)));
    const size_t moved_values = different_values(moved, expected);
    rows.require("all kinds of surfaces and lights, instanced", text("at (1, -1, 1) times %g", place),
                 "the same picture", "bits", text("%zu values differ", moved_values), moved_values == 0);
  }
}

// A mesh of which one point is far away must not take the others' precision.
void print_stray_points(Rows& rows) {
  const auto picture = [](float far) {
    SceneBuilder b;
    Mesh stray = sphere_mesh(0.5f, 16, true);
    stray.points.back() = {0, -0.5f - far, 0};
    stray.bounds.extend(stray.points.back());
    b.add(b.prototype(std::move(stray)), b.material(medium_only(0.5f, 0)), translation(3, 0, 0));
    b.add(b.prototype(sphere_mesh(0.5f, 16, true)), b.material(glowing(1)));
    return Picture(picture_of(&b, look_at({0, 0, 5}, {0, 0, 0}, 15), 64));
  };
  const Picture expected = picture(0);
  for (const float far : {1e6f, 1e10f, 1e16f}) {
    const Picture p = picture(far);
    rows.require("a ball beside another that has a stray point", text("%g radii away", double(2 * far)),
                 "it is seen where it was: the share of the picture that it fills", "2e-3: rounding moves the samples",
                 text("%.5f, without %.5f", p.mean.mean, expected.mean.mean),
                 p.sound && std::abs(p.mean.mean - expected.mean.mean) < 2e-3);
  }
}

// ---- triangles

void print_slivers(Rows& rows) {
  // A unit square, cut into slivers that all meet in one corner: 1e8 times longer than wide.
  for (const float width : {1e-4f, 1e-6f, 1e-8f}) {
    std::vector<Vec3f> points = {{-0.5f, 0, -0.5f}, {-0.5f, 0, 0.5f}};
    std::vector<Corners> triangles;
    for (uint32_t i = 0; i < 8; ++i) {
      points.emplace_back(-0.5f + width * float(i + 1), 0.0f, 0.5f);
      triangles.push_back({0, i + 1, i + 2});
    }
    points.emplace_back(0.5f, 0.0f, 0.5f);
    points.emplace_back(0.5f, 0.0f, -0.5f);
    triangles.push_back({0, 9, 10});
    triangles.push_back({0, 10, 11});
    const Picture p = glow_from_above(mesh_of(points, triangles), 1);
    rows.require("square cut into slivers", text("%g times as long as wide", double(1 / width)), "no hole: 1", "exact",
                 p.said(), p.sound && p.mean.mean == 1 && p.mean.sigma == 0);
  }
}

void print_degenerate_faces(Rows& rows) {
  const auto lit = [](Mesh mesh) {
    SceneBuilder b;
    DisneyParameters glow = shiny();
    glow.emission = Rgb(1.0f);
    b.add(b.prototype(std::move(mesh)), b.material(glow)).add(constant_dome(1, true));
    return Picture(picture_of(&b, look_at({0, 1, 2}, {0, 0, 0}, 40), 4));
  };
  const Mesh plane = plane_mesh(1);
  const Picture expected = lit(plane);
  Mesh empty_faces = plane;
  for (const Corners& t : {Corners{0, 0, 0}, {1, 1, 2}, {0, 2, 0}}) empty_faces.triangles.push_back(t);
  empty_faces.triangle_face.resize(empty_faces.triangles.size());
  const size_t different = different_values(lit(empty_faces), expected);
  rows.require("a glowing square", "faces without area beside it", "the same picture", "bits",
               text("%zu values differ", different), different == 0);
  Mesh twice = merged(plane, plane);
  twice.triangle_face.resize(twice.triangles.size());
  SceneBuilder b;
  b.add(b.prototype(twice), b.material(medium_only(0.5f, 0))).add(constant_dome(1, false));
  SceneBuilder single;
  single.add(single.prototype(plane), single.material(medium_only(0.5f, 0))).add(constant_dome(1, false));
  const Picture p(picture_of(&b, look_at({0, 1, 2}, {0, 0, 0}, 40), 16));
  const size_t different_twice =
      different_values(p, Picture(picture_of(&single, look_at({0, 1, 2}, {0, 0, 0}, 40), 16)));
  rows.require("a matt square", "every face twice, in the same place", "the same picture: no face shades its double",
               "bits", text("%zu values differ", different_twice), p.sound && different_twice == 0);
  const Picture needle = glow_from_above(mesh_of({{-0.5f, 0, 0}, {0.5f, 0, 0}, {0.5f, 0, 1e-30f}}, {{0, 1, 2}}), 1);
  rows.require("one triangle", "1e30 times as long as wide", "sound and not seen", "exact", needle.said(),
               needle.sound && needle.mean.mean == 0);
  const Picture one =
      glow_from_above(mesh_of({{-0.5f, 0, -0.5f}, {-0.5f, 0, 0.5f}, {0.5f, 0, 0.5f}}, {{0, 1, 2}}), 1, 256);
  rows.compare("one triangle", "half of the picture", "its share", one.mean, 0.5);
}

void print_crossing_faces(Rows& rows) {
  // Two unit squares that cross along x = 0 at 45 degrees: from above each hides the lower half of the other.
  Mesh cross = mesh_of({{-0.5f, -0.5f, -0.5f}, {-0.5f, -0.5f, 0.5f}, {0.5f, 0.5f, 0.5f}, {0.5f, 0.5f, -0.5f}},
                       {{0, 1, 2}, {0, 2, 3}});
  Mesh other = cross;
  for (Vec3f& p : other.points) p.y = -p.y;
  SceneBuilder b;
  b.add(b.prototype(cross), b.material(glowing(1))).add(b.prototype(other), b.material(glowing(3)));
  const Picture p(picture_of(&b, from_above(1), 64));
  rows.compare("squares of radiance 1 and 3 through each other", "seen from above", "each half a picture: mean", p.mean,
               2);
  size_t right = 0;
  for (size_t y = 0; y < 16; ++y)
    for (size_t x = 0; x < 16; ++x) {
      // The order of the sides depends on the sign of the film's x.
      const float v = p.color[4 * (16 * y + x) + 1], edge = p.color[1];
      right += v == (x < 8 ? edge : 4 - edge);
    }
  rows.require("squares of radiance 1 and 3 through each other", "every pixel", "that of the upper one", "exact",
               text("%zu of 256", right), right == 256);
}

// White surfaces in a furnace show the furnace: light that meets its own surface again is missing at grazing views.
void print_grazing_needles(Rows& rows) {
  for (const double height : {1e-2, 1e-4, 1e-6}) {
    SceneBuilder b;
    DisneyParameters p = medium_only(1, 0);
    b.add(b.prototype(plane_mesh(2)), b.material(p)).add(constant_dome(1, false));
    CameraParameters camera = look_at({5, 5 * height, 0}, {0, 0, 0}, 0.001);
    camera.vertical_aperture *= static_cast<float>(height);
    const Picture picture(picture_of(&b, camera, 16));
    const double expected = (1 - 0.5 * std::pow(1 - height / std::hypot(1, height), 5)) * 41 / 42;
    rows.compare("white square in a furnace", text("seen at an angle of %g", height), "(1 - .5 F_V) 41/42",
                 picture.mean, expected, 1e-5 * expected + 2.5e-4, "normals are bent up to a cosine of 1e-4");
    rows.report().require(picture.sound, "grazing views are sound");
  }
}

// ---- cages

RefinementOptions at_level(int level) {
  RefinementOptions options;
  options.level = level;
  return options;
}

Cage pole_cage(int valence, SubdivisionScheme scheme) {
  // A double cone of quads is not possible: triangles about two poles.
  Cage cage;
  cage.scheme = scheme;
  cage.points = {{0, 1, 0}, {0, -1, 0}};
  for (int i = 0; i < valence; ++i) {
    const double angle = 2 * M_PI * i / valence;
    cage.points.emplace_back(float(std::cos(angle)), 0.0f, float(std::sin(angle)));
    const int a = 2 + i, c = 2 + (i + 1) % valence;
    cage.face_vertex_counts.insert(cage.face_vertex_counts.end(), {3, 3});
    cage.face_vertex_indices.insert(cage.face_vertex_indices.end(), {0, c, a, 1, a, c});
  }
  return cage;
}

/// A closed white body in a furnace: every path ends in the furnace, whatever the shape.
void furnace_row(Rows& rows, const char* scene, const std::string& extreme, Mesh mesh) {
  const std::string triangles = text("%zu triangles", mesh.triangles.size());
  size_t odd = 0;
  for (const Corners& t : mesh.normal_triangles.empty() ? mesh.triangles : mesh.normal_triangles)
    for (const uint32_t i : t) odd += !(std::abs(length(mesh.normals[i]) - 1) < 1e-5f);
  SceneBuilder b;
  DisneyParameters p = medium_only(1, 0);
  b.add(b.prototype(std::move(mesh)), b.material(p)).add(constant_dome(1, true));
  RenderRequest request = picture_of(&b, look_at({1, 2, 3}, {0, 0, 0}, 40), 16);
  request.settings.max_depth = 64;
  const Picture picture(request);
  rows.require(scene, extreme + ", " + triangles, "sound, normals unit, no brighter than the furnace",
               "4 standard errors", text("%zu odd normals, ", odd) + picture.said(),
               odd == 0 && picture.sound && picture.mean.mean <= 1 + 4 * picture.mean.sigma && picture.mean.mean > 0.3);
}

void print_cages(Rows& rows) {
  for (const SubdivisionScheme scheme : {SubdivisionScheme::catmull_clark, SubdivisionScheme::loop}) {
    const char* name = scheme == SubdivisionScheme::loop ? "double cone, loop" : "double cone, catmullClark";
    furnace_row(rows, name, "valence 100, level 4", build_mesh(pole_cage(100, scheme), at_level(4), {}));
    furnace_row(rows, name, "valence 3, level 8", build_mesh(pole_cage(3, scheme), at_level(8), {}));
  }
  // Three cubes' faces meet in one edge, and two more touch in one point.
  Cage cage = test::cube_cage(SubdivisionScheme::catmull_clark);
  const auto add_cube = [&](const Vec3f& at) {
    const Cage other = test::cube_cage();
    const auto first = static_cast<int>(cage.points.size());
    for (const Vec3f& p : other.points) cage.points.push_back(p + at);
    for (const int i : other.face_vertex_indices) cage.face_vertex_indices.push_back(first + i);
    cage.face_vertex_counts.insert(cage.face_vertex_counts.end(), other.face_vertex_counts.begin(),
                                   other.face_vertex_counts.end());
  };
  const auto weld = [&] {
    const std::vector<int> first = weld_by_position(cage.points);
    for (int& i : cage.face_vertex_indices) i = first[size_t(i)];
  };
  add_cube({2, 2, 0});     // shares an edge: four faces at it
  add_cube({-2, -2, -2});  // shares a point
  weld();
  cage.face_vertex_counts.push_back(4);  // a fin at an edge of the first
  cage.face_vertex_indices.insert(cage.face_vertex_indices.end(), {0, 1, 3, 2});
  Reports reports;
  if (sanitize_cage(cage, "/cage", reports.sink))
    furnace_row(rows, "cubes that share an edge, a point and a face", "non-manifold, level 3",
                build_mesh(cage, at_level(3), reports.sink));
  Mesh inside_out = build_mesh(test::cube_cage(SubdivisionScheme::catmull_clark), at_level(4), {});
  for (size_t i = 0; i < inside_out.points.size(); ++i) inside_out.points[i] -= inside_out.normals[i] * 3.0f;
  inside_out.bounds = {};
  for (const Vec3f& p : inside_out.points) inside_out.bounds.extend(p);
  furnace_row(rows, "ball displaced by three radii", "turned inside out", std::move(inside_out));
}

// ---- placements

void print_placements(Rows& rows) {
  const auto picture = [](const Matrix4d& m, bool flip, size_t* warnings) {
    SceneBuilder b;
    Mesh ball = sphere_mesh(0.5f, 12, true);
    if (flip) {
      for (Vec3f& p : ball.points) p.x = -p.x;
      for (Vec3f& n : ball.normals) n.x = -n.x;
      for (Corners& t : ball.triangles) std::swap(t[1], t[2]);
    }
    DisneyParameters skin = medium_only(0.8f, 0.1f);
    skin.anisotropic = 0;
    b.add(b.prototype(std::move(ball)), b.material(skin), m)
        .add(b.prototype(plane_mesh(4)), b.material(shiny()), translation(0, -0.5, 0));
    LightParameters key;
    key.type = LightType::sphere;
    key.intensity = 20;
    key.light_to_world = translation(2, 3, 1);
    b.add(key);
    RenderRequest request = picture_of(&b, look_at({0, 1, 4}, {0, 0, 0}, 30), 16);
    *warnings = request.scene->instances.size();
    return Picture(request);
  };
  size_t instances = 0;
  const Picture mirrored = picture(scaling(-1, 1, 1), false, &instances), sound = picture(Matrix4d(), true, &instances);
  const Estimate d = difference(mirrored, sound);
  rows.compare("scattering ball on a floor", "mirrored by its matrix", "the mean of the mirrored mesh",
               {d.mean + sound.mean.mean, d.sigma}, sound.mean.mean);
  for (const auto& [name, m] : {std::pair<const char*, Matrix4d>{"scale (1, 0, 1)", scaling(1, 0, 1)},
                                {"scale 0", scaling(0, 0, 0)},
                                {"scale (1, 1e-30, 1)", scaling(1, 1e-30, 1)}}) {
    const Picture p = picture(m, false, &instances);
    rows.require("scattering ball on a floor", std::string("singular: ") + name, "left out, the floor is drawn",
                 "exact", text("%zu instances, ", instances) + p.said(), p.sound && instances == 1 && p.mean.mean > 0);
  }
  for (const double flat : {1e-3, 1e-6}) {
    const Picture p = picture(scaling(1, flat, 1), false, &instances);
    rows.require("scattering ball on a floor", text("flattened to %g", flat), "sound", "exact", p.said(), p.sound);
  }
}

void print_many_triangles(Rows& rows) {
  // Few in the short run; 3e7 in the long one.
  const bool is_long = rows.report().sigma() < 1e-3;
  const int side = is_long ? 3873 : 400;
  Mesh mesh;
  mesh.points.reserve(size_t(side + 1) * size_t(side + 1));
  for (int z = 0; z <= side; ++z)
    for (int x = 0; x <= side; ++x)
      mesh.points.emplace_back(float(x) / float(side) - 0.5f, 0.0f, float(z) / float(side) - 0.5f);
  for (int z = 0; z < side; ++z)
    for (int x = 0; x < side; ++x) {
      const auto a = uint32_t(z * (side + 1) + x), n = uint32_t(side + 1);
      mesh.triangles.push_back({a, a + n, a + n + 1});
      mesh.triangles.push_back({a, a + n + 1, a + 1});
    }
  mesh.bounds = Bounds{{-0.5f, 0, -0.5f}, {0.5f, 0, 0.5f}};
  const std::string count = text("%zu triangles", mesh.triangles.size());
  const Picture p = glow_from_above(std::move(mesh), 1);
  rows.require("square", count, "no hole: 1", "exact", p.said(), p.sound && p.mean.mean == 1);
}

}  // namespace

void print_geometry(Report& report) {
  Rows rows(report, "Geometry",
            "Sound: every pixel is finite and not negative, no sample and no ray had to be dropped.");
  print_scales(rows);
  print_stray_points(rows);
  print_slivers(rows);
  print_degenerate_faces(rows);
  print_crossing_faces(rows);
  print_grazing_needles(rows);
  print_cages(rows);
  print_placements(rows);
  print_many_triangles(rows);
}

}  // namespace alabaster::testing
