// Cameras at the ends of lens, film and matrix.
#include <limits>

#include "testenv/extremes/rows.h"

namespace alabaster::testing {
namespace {

/// A glowing rectangle that fills the left half of what the camera sees at `distance`, in a picture of 16 x 16.
Picture half_filled(CameraParameters camera, double distance, double half_width, uint32_t samples = 16) {
  SceneBuilder b;
  const double size = 4 * half_width;
  // Turned to face the camera, which looks along -z; its right edge at x = 0.
  const Matrix4d facing(1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, -0.5 * size, 0, -distance, 1);
  b.add(b.prototype(plane_mesh(static_cast<float>(size))), b.material(glowing(1)), facing);
  camera.camera_to_world = Matrix4d();
  return Picture(picture_of(&b, camera, samples));
}

CameraParameters with_view(double degrees) {
  return look_at({0, 0, 0}, {0, 0, -1}, degrees);
}

void print_views(Rows& rows) {
  for (const double degrees : {0.001, 1e-6, 179.0, 179.99})
    for (const double distance : {1.0, 1e4}) {
      const Picture p = half_filled(with_view(degrees), distance, distance * std::tan(degrees * M_PI / 360));
      rows.compare("rectangle that fills half of the view", text("%g degrees, %g away", degrees, distance), "its share",
                   p.mean, 0.5, 1e-3, "its edge lies between pixels, and is rounded");
      rows.report().require(p.sound, "narrow and wide views are sound");
    }
}

void print_lenses(Rows& rows) {
  const auto seen = [](float f_stop, float focus) {
    CameraParameters camera = with_view(40);
    camera.f_stop = f_stop;
    camera.focus_distance = focus;
    return half_filled(camera, 10, 10 * std::tan(20 * M_PI / 180), 64);
  };
  const Picture pinhole = seen(0, 10);
  const auto same = [&](const char* extreme, const Picture& p) {
    const size_t different = different_values(p, pinhole);
    rows.require("rectangle that fills half of the view", extreme, "the pinhole's picture", "bits",
                 text("%zu values differ", different), p.sound && different == 0);
  };
  same("focus at 0", seen(1, 0));
  for (const float f_stop : {1e30f, std::numeric_limits<float>::max()}) {
    const Picture p = seen(f_stop, 10);
    rows.compare("rectangle that fills half of the view", text("f-stop %g: no aperture", double(f_stop)), "its share",
                 p.mean, 0.5, 1e-3, "its edge lies between pixels");
  }
  for (const float focus : {1e10f, 1e30f, std::numeric_limits<float>::max()})
    for (const double degrees : {40.0, 170.0}) {
      CameraParameters camera = with_view(degrees);
      camera.f_stop = 100;  // 1/200 of a unit wide: the edge blurs evenly, so the share stays
      camera.focus_distance = focus;
      const Picture p = half_filled(camera, 10, 10 * std::tan(degrees * M_PI / 360), 64);
      rows.compare("rectangle that fills half of the view",
                   text("focus at %g, view of %g degrees", double(focus), degrees), "its share", p.mean, 0.5, 2e-3,
                   "its far edge blurs out of the view");
      rows.report().require(p.sound, "lenses focused far away are sound");
    }
  // A lens as wide as the whole scene, in an endless sky.
  SceneBuilder b;
  b.add(b.prototype(plane_mesh(1)), b.material(glowing(1)), translation(0, -1e3, 0)).add(constant_dome(1, true));
  for (const float f_stop : {1e-6f, 1e-20f, 1e-38f}) {
    CameraParameters camera = with_view(40);
    camera.f_stop = f_stop;
    camera.focus_distance = 10;
    const Picture p(picture_of(&b, camera, 16));
    rows.require("a sky of radiance 1", text("f-stop %g: a lens %g wide", double(f_stop), 1 / double(f_stop)), "1",
                 "exact; rays from beyond 1e17 meet the sky alone", p.said(), p.finite && p.mean.mean == 1);
  }
}

void print_matrices(Rows& rows) {
  SceneBuilder b;
  DisneyParameters skin;
  skin.scatter_distance = Rgb(0.1f);
  b.add(b.prototype(sphere_mesh(0.5f, 16, true)), b.material(skin)).add(constant_dome(1, true));
  const CameraParameters view = look_at({0, 0, 3}, {0, 0, 0}, 30);
  const Picture expected(picture_of(&b, view, 4));
  const auto with = [&](const Matrix4d& m) {
    CameraParameters camera = view;
    camera.camera_to_world = m;
    return Picture(picture_of(&b, camera, 4));
  };
  for (const double scale : {1e-30, 1e-6, 1e6, 1e30}) {
    const size_t different = different_values(with(scaling(scale, scale, scale) * view.camera_to_world), expected);
    rows.require("scattering ball", text("the camera's matrix scaled by %g", scale), "the same picture",
                 "the axes' rounding: 1 % of the pixels", text("%zu values differ", different),
                 different < expected.color.size() / 100);
  }
  struct Named {
    const char* name;
    Matrix4d m;
  };
  Matrix4d flat = view.camera_to_world, zero = flat, sheared = flat, mirrored = flat;
  for (int i = 0; i < 3; ++i) flat[1][i] = flat[0][i], zero[0][i] = 0, mirrored[0][i] = -mirrored[0][i];
  for (int i = 0; i < 3; ++i) sheared[1][i] = flat[0][i] + 1e-12 * sheared[1][i];
  const Named matrices[] = {{"two axes are equal", flat},
                            {"two axes are 1e-12 apart", sheared},
                            {"an axis is zero", zero},
                            {"mirrored", mirrored}};
  for (const Named& n : matrices) {
    const Picture p = with(n.m);
    rows.require("scattering ball", std::string("the camera's matrix: ") + n.name,
                 "finite (passes refuse matrices that are not invertible)", "exact", p.said(), p.finite);
  }
}

void print_films(Rows& rows) {
  SceneBuilder b;
  DisneyParameters skin;
  skin.scatter_distance = Rgb(0.1f);
  b.add(b.prototype(sphere_mesh(0.5f, 16, true)), b.material(skin)).add(constant_dome(1, true));
  RenderRequest request = picture_of(&b, look_at({0, 0, 3}, {0, 0, 0}, 30), 2, 40);
  const Picture whole(request);
  size_t different = 0;
  for (const auto& [x, y] : {std::pair{0, 0}, {39, 39}, {20, 20}, {31, 32}}) {
    request.data_window = {x, y, x + 1, y + 1};
    const Picture pixel(request);
    for (size_t c = 0; c < 4; ++c) different += pixel.color[c] != whole.color[4 * size_t(40 * y + x) + c];
  }
  rows.require("scattering ball", "crops of one pixel", "the whole picture's pixels", "bits",
               text("%zu values differ", different), different == 0);
  const auto shape = [&](int width, int height) {
    request.width = width, request.height = height;
    request.data_window = {0, 0, width, height};
    request.camera.horizontal_aperture = 0.5f * float(width) / float(std::max(width, height));
    request.camera.vertical_aperture = 0.5f * float(height) / float(std::max(width, height));
    const Picture p(request);
    rows.require("scattering ball", text("a film of %d x %d", width, height), "sound, every pixel drawn", "exact",
                 p.said(), p.sound && p.color.size() == 4 * size_t(width) * size_t(height) && p.mean.mean > 0);
  };
  shape(1, 1);
  shape(32768, 1);
  shape(1, 32768);
}

}  // namespace

void print_cameras(Report& report) {
  Rows rows(report, "Cameras",
            "Finite: every pixel is, none is negative, no sample had to be dropped. Sound: nor was any ray.");
  print_views(rows);
  print_lenses(rows);
  print_matrices(rows);
  print_films(rows);
}

}  // namespace alabaster::testing
