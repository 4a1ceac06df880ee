// Lights that are very strong, very weak, very small, very near, or none.
#include "testenv/extremes/rows.h"
#include "testenv/support/memory_texture.h"
#include "testenv/support/reports.h"

namespace alabaster::testing {
namespace {

Matrix4d facing_down(double x, double y, double z) {
  return Matrix4d(1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, x, y, z, 1);
}

/// A matt square under the lights, seen from above; `size` of the picture.
Picture lit_square(const std::vector<LightParameters>& lights, float size = 0.01f, uint32_t samples = 64,
                   float albedo = 0.5f) {
  SceneBuilder b;
  b.add(b.prototype(plane_mesh(4)), b.material(medium_only(albedo, 0)));
  for (const LightParameters& light : lights) b.add(light);
  return Picture(picture_of(&b, from_above(size), samples));
}

LightParameters ball(double radius, double height, float intensity) {
  LightParameters light;
  light.type = LightType::sphere;
  light.radius = static_cast<float>(radius);
  light.intensity = intensity;
  light.light_to_world = translation(0, height, 0);
  return light;
}

/// Radiance of a matt square of this albedo that light from within a cone about its normal meets with radiance 1.
double lit_by_cone(double albedo, double cosine) {
  // Int (1 - .5 (1 - mu)^5) 2 mu dmu over the cone.
  const double m = 1 - cosine;
  return albedo * (1 - cosine * cosine - (std::pow(m, 6) / 6 - std::pow(m, 7) / 7));
}

double lit_by_ball(double albedo, double radius, double height) {
  return lit_by_cone(albedo, std::sqrt(1 - radius * radius / (height * height)));
}

void print_strengths(Rows& rows) {
  const Picture one = lit_square({ball(0.5, 2, 1)});
  for (const int k : {-100, -50, 50, 100}) {
    const Picture scaled = lit_square({ball(0.5, 2, std::ldexp(1.0f, k))});
    size_t different = 0;
    for (size_t i = 0; i < one.color.size(); ++i)
      different += i % 4 < 3 && std::ldexp(one.color[i], k) != scaled.color[i] ? 1 : 0;
    rows.require("square under a ball of light", text("2^%d times as strong", k), "the picture times that", "bits",
                 text("%zu values differ", different), scaled.sound && different == 0);
  }
  std::vector<LightParameters> all;
  for (int k = -30; k <= 30; k += 2) all.push_back(ball(0.5, 2, float(std::pow(10.0, k))));
  const Picture both = lit_square(all, 0.01f, 1024);
  const double expected = lit_by_ball(0.5, 0.5, 2) * (1e30 / (1 - 1e-2));
  rows.compare("square under 31 balls of light in one place", "1e-30 to 1e30 strong, each a hundred times the last",
               "their sum over 1e30", {both.mean.mean / 1e30, both.mean.sigma / 1e30}, expected / 1e30,
               1e-4 * expected / 1e30, "the picture's width");
  rows.report().require(both.sound, "strong and weak lights together are sound");
  // A weak light beside a strong one whose light does not arrive.
  LightParameters away = ball(0.5, -2, 1e30f);
  const Picture weak = lit_square({ball(0.5, 2, 1e-30f), away}, 0.01f, 64);
  const double weak_expected = lit_by_ball(0.5, 0.5, 2);
  rows.compare("square under a ball of light", "1e-30 strong, another of 1e30 behind the square", "1e-30 of its light",
               {weak.mean.mean / 1e-30, weak.mean.sigma / 1e-30}, weak_expected, 1e-4 * weak_expected,
               "the picture's width");
}

void print_contacts(Rows& rows) {
  for (const double gap : {1e-2, 1e-4, 0.0}) {
    // The middle sees a ball that nearly fills its sky. At the point of contact itself there is no answer.
    const double radius = 0.5, height = radius + gap, x = 0.02;
    SceneBuilder b;
    b.add(b.prototype(plane_mesh(4)), b.material(medium_only(0.5f, 0)));
    b.add(ball(radius, height, 1));
    CameraParameters camera = from_above(1e-3f);
    camera.camera_to_world[3][0] = x;
    const Picture p(picture_of(&b, camera, 256));
    // A ball wholly above the horizon: irradiance pi sin^2 cos; its directions reach from the horizon to the zenith, so
    // the diffuse's Fresnel term is bounded, not known.
    const double d2 = x * x + height * height, irradiance = radius * radius / d2 * height / std::sqrt(d2);
    rows.compare("square under a ball of light", text("a gap of %g", gap), "between 1 and 1 - 1/21 of pi sin^2 cos",
                 p.mean, 0.5 * irradiance * (1 - 0.5 / 21), 0.5 * irradiance * 0.5 / 21, "the Fresnel term");
    rows.report().require(p.sound, "lights near a surface are sound");
  }
  LightParameters flat;
  flat.width = flat.height = 1;
  flat.light_to_world = facing_down(0, 0, 0);
  const Picture in_plane = lit_square({flat}, 0.5f);
  rows.require("square and a rectangle of light", "in one plane, facing into it", "no light", "exact", in_plane.said(),
               in_plane.sound && in_plane.mean.mean == 0);
  flat.light_to_world = Matrix4d();
  flat.light_to_world[3][2] = 0;
  const Picture through = lit_square({flat}, 0.5f, 256);
  rows.require("square and a rectangle of light", "standing in it, at right angles", "sound and lit", "exact",
               through.said(), through.sound && through.mean.mean > 0);
  const Picture half = lit_square({ball(0.5, 0, 1)}, 2);
  rows.require("square and a ball of light", "half below it", "sound and lit", "exact", half.said(),
               half.sound && half.mean.mean > 0);
}

// A point of light in the middle of a clear ball that absorbs: a plane outside gets what the interior leaves.
void print_light_in_medium(Rows& rows) {
  const auto lit = [](float distance, uint32_t seed) {
    SceneBuilder b;
    DisneyParameters clear;
    clear.ior = 1;
    clear.specular = 0;
    clear.base_color = Rgb(1.0f);
    clear.roughness = 0;
    clear.spec_trans = 1;
    clear.attenuation_color = Rgb(0.25f);
    clear.attenuation_distance = distance;
    b.add(b.prototype(plane_mesh(4)), b.material(medium_only(0.5f, 0)));
    b.add(b.prototype(sphere_mesh(0.5f, 64, true)), b.material(clear), translation(0, 1, 0));
    b.add(ball(0.05, 1, 100));
    CameraParameters camera = from_above(0.01f, 0.4);  // below the ball
    RenderRequest request = picture_of(&b, camera, 256);
    request.settings.seed = seed;
    return Picture(request);
  };
  const double open = 100 * lit_by_ball(0.5, 0.05, 1);
  for (const auto& [distance, passes] : {std::pair{0.5f, 0.25}, {5.0f, std::pow(0.25, 0.1)}}) {
    const Picture p = lit(distance, 1);
    // The light's surface is .05 from the middle: the path inside is .45 long.
    const double expected = open * std::pow(passes, 0.9);
    rows.compare("square under a ball of light in a clear ball of index 1", text("%g left", passes), "Beer's law",
                 p.mean, expected, 4e-3 * expected, "the ball's facets, and paths off its axis");
    rows.report().require(p.sound, "lights in media are sound");
  }
  const auto inside = [](SubsurfaceMode mode) {
    SceneBuilder b;
    b.add(b.prototype(sphere_mesh(1, 24, true)), b.material(medium_only(0.9f, 0.2f))).add(ball(0.2, 0, 5));
    RenderRequest request = picture_of(&b, look_at({0, 0, 5}, {0, 0, 0}, 20), 16);
    request.settings.subsurface = mode;
    return Picture(request);
  };
  const Picture p = inside(SubsurfaceMode::walk);
  rows.require("scattering ball around a ball of light", "walk",
               "sound: lights that no geometry shows do not light media", "exact", p.said(),
               p.sound && p.mean.mean == 0);
}

void print_suns(Rows& rows) {
  constexpr int kWidth = 512, kHeight = 256;
  for (const int row : {1, 64, 120}) {
    std::vector<Rgb> texels(size_t(kWidth) * kHeight, Rgb(0.0f));
    texels[size_t(row) * kWidth + 17] = Rgb(1e6f);
    LightParameters sky;
    sky.type = LightType::dome;
    sky.texture = std::make_shared<MemoryTexture>(kWidth, std::move(texels));
    const Picture p = lit_square({sky}, 0.01f, 256);
    // Irradiance of the texel that the row is from the zenith (the first row is at the top, or at the bottom: dark).
    const auto edge = [&](int i) { return std::cos(M_PI * i / kHeight); };
    const double c0 = edge(row), c1 = edge(row + 1), irradiance = (c0 * c0 - c1 * c1) * M_PI / kWidth;
    const double fresnel = 1 - 0.5 * std::pow(1 - 0.5 * (c0 + c1), 5);
    const double expected = 1e6 * 0.5 / M_PI * irradiance * fresnel;
    rows.compare("square under a sky of 512 x 256", text("one texel of 1e6, row %d", row), "its irradiance", p.mean,
                 expected, 2e-3 * expected, "the texel's width: it is filtered");
    rows.report().require(p.sound, "one-texel suns are sound");
  }
}

void print_angles(Rows& rows) {
  const auto sun = [](float angle) {
    LightParameters light;
    light.type = LightType::distant;
    light.normalize = true;
    light.intensity = 3;
    light.angle = angle;
    light.light_to_world = facing_down(0, 0, 0);
    return light;
  };
  for (const float angle : {0.0f, 1e-30f, 1e-6f, 0.53f}) {
    const Picture p = lit_square({sun(angle)});
    rows.compare("square under a sun, normalize", text("angle %g", double(angle)), "A E / pi", p.mean, 0.5 * 3 / M_PI,
                 angle > 0.1f ? 1e-4 : 1e-6, angle > 0.1f ? "cosines of its rim" : "float rounding");
    rows.report().require(p.sound, "suns of any angle are sound");
  }
  for (const float angle : {180.0f, 359.9f, 360.0f}) {
    LightParameters light = sun(angle);
    light.normalize = false;
    light.intensity = 1;
    const Picture p = lit_square({light}, 0.01f, 256);
    rows.compare("square under a sun", text("angle %g", double(angle)), "that of a constant sky", p.mean,
                 lit_by_cone(0.5, 0), 1e-5, "float rounding");
  }
}

void print_no_light(Rows& rows) {
  const auto none = [&](const char* extreme, LightParameters light) {
    light.light_to_world = facing_down(0, 2, 0);
    light.visible_to_camera = true;
    const Picture p = lit_square({light}, 1, 4);
    rows.require("square under a light", extreme, "black", "exact", p.said(), p.sound && p.mean.mean == 0);
  };
  LightParameters light;
  light.width = 0;
  none("rectangle of width 0", light);
  light = {};
  light.type = LightType::disk, light.radius = 0;
  none("disk of radius 0", light);
  light = {};
  light.type = LightType::cylinder, light.length = 0;
  none("cylinder of length 0", light);
  for (const LightType type : {LightType::rect, LightType::sphere, LightType::distant, LightType::dome}) {
    light = {};
    light.type = type, light.intensity = 0;
    none("power 0", light);
    light.intensity = 1, light.color = Rgb(0.0f);
    none("black", light);
  }
  for (const float radius : {1e-6f, 1e-15f}) {
    // As small as that, it is a point of radiant intensity pi r^2 L.
    const Picture p = lit_square({ball(double(radius), 2, 1 / (radius * radius))});
    rows.compare("square under a ball of light", text("radius %g", double(radius)), "a point's", p.mean, 0.5 / 4, 1e-5,
                 "the picture's width");
  }
}

}  // namespace

void print_lights(Report& report) {
  Rows rows(report, "Lights", "A matt square of albedo .5 is lit and seen along its normal.");
  print_strengths(rows);
  print_contacts(rows);
  print_light_in_medium(rows);
  print_suns(rows);
  print_angles(rows);
  print_no_light(rows);
}

}  // namespace alabaster::testing
