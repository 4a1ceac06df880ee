// Every parameter of the schemas at the ends of its range, inside, outside, and at numbers that are none. Values are
// read as a host's are.
#include <array>
#include <limits>

#include "core/material/disney_transmissive_bsdf.h"
#include "core/material/energy_model.h"
#include "delegate/prims/parameters.h"
#include "testenv/extremes/rows.h"
#include "testenv/support/chi_square.h"

namespace alabaster::testing {
namespace {

using hd::prims::set_parameter;

struct NamedValue {
  const char* name;
  double value;
};

// Values of a number between two bounds. The range of unbounded parameters is that of floats.
std::vector<NamedValue> extreme_values(double minimum, double maximum) {
  constexpr double kLargest = std::numeric_limits<float>::max(), kInfinite = std::numeric_limits<double>::infinity();
  const auto low = static_cast<float>(std::max(minimum, -kLargest)),
             high = static_cast<float>(std::min(maximum, kLargest));
  return {{"min", double(low)},
          {"max", double(high)},
          {"just inside", double(std::nextafter(low, high))},
          {"just inside the max", double(std::nextafter(high, low))},
          {"just outside", double(low) - 1e-6 * std::max(1.0, std::abs(double(low)))},
          {"just outside the max", double(high) * (1 + 1e-6)},
          {"denormal", 1e-40},
          {"tiny", 1e-6},
          {"one and a little", 1 + 1e-6},
          {"NaN", std::numeric_limits<double>::quiet_NaN()},
          {"infinity", kInfinite},
          {"-infinity", -kInfinite}};
}

template <class T, class... Words>
void set(const Parameter<T, Words...>& row, double value, T* object) {
  set_parameter(row, row.is_color() ? hd::Value(Vec3d(value, value, value)) : hd::Value(value), object);
}

template <class T, class... Words>
bool is_number(const Parameter<T, Words...>& row) {
  return row.is_color() || std::holds_alternative<float T::*>(row.member) ||
         std::holds_alternative<uint32_t T::*>(row.member);
}

// ---- materials

struct Base {
  const char* name;
  DisneyParameters parameters;
};

std::vector<Base> bases() {
  std::vector<Base> all(10);
  all[0].name = "plastic";
  all[1].name = "rough white", all[1].parameters.base_color = Rgb(1.0f), all[1].parameters.roughness = 1;
  all[2].name = "smooth metal", all[2].parameters.metallic = 1, all[2].parameters.roughness = 0;
  all[3].name = "brushed metal", all[3].parameters.metallic = 1, all[3].parameters.anisotropic = 1;
  all[4].name = "skin", all[4].parameters.scatter_distance = {1, 0.35f, 0.2f};
  all[5].name = "velvet", all[5].parameters.sheen = 1, all[5].parameters.sheen_roughness = 0.4f;
  all[6].name = "lacquer", all[6].parameters.clearcoat = 1, all[6].parameters.sheen = 1;
  all[7].name = "coated", all[7].parameters.coat = 1, all[7].parameters.coat_roughness = 0.3f;
  all[8].name = "soap film", all[8].parameters.iridescence = 1;
  all[9].name = "leaf", all[9].parameters.thin = true, all[9].parameters.diff_trans = 1,
  all[9].parameters.spec_trans = 0.5f;
  return all;
}

/// The findings about one parameter.
struct MaterialFindings {
  int cases = 0, bad_numbers = 0, disagreements = 0;
  Estimate brightest{0, 1};
  std::string brightest_at;

  void bright(const Estimate& furnace, const std::string& at) {
    const auto above = [](const Estimate& e) { return (e.mean - 1) / std::max(e.sigma, 1e-6); };
    if (cases == 0 || above(furnace) > above(brightest)) brightest = furnace, brightest_at = at;
    ++cases;
  }
};

Vec3f along(float cosine) {
  // Off the axes, so that the directions of anisotropy differ.
  const float sine = std::sqrt(1 - sqr(cosine));
  return {0.8f * sine, 0.6f * sine, cosine};
}

/// Samples the material: every number is finite, samples are what evaluate() says, and the furnace is no brighter than
/// one.
template <class Bsdf>
void examine(const Bsdf& bsdf, const Rgb& body, const std::string& at, uint64_t samples, MaterialFindings* found) {
  Rng rng(found->cases + 1, 5);
  RunningStatistics light[3];
  for (uint64_t i = 0; i < samples; ++i) {
    constexpr float kLast = 0x1.fffffep-1f;
    Vec2f u = uniform2(rng);
    float lobe = rng.uniform();
    // Corners of the domain first.
    if (i < 27)
      lobe = i % 3 == 2 ? kLast : 0.5f * float(i % 3),
      u = {i / 3 % 3 == 2 ? kLast : 0.5f * float(i / 3 % 3), i / 9 == 2 ? kLast : 0.5f * float(i / 9)};
    const auto s = bsdf.sample(lobe, u);
    Rgb share(0.0f);
    if (s) {
      const bool discrete = s->lobe == Lobe::straight || s->lobe == Lobe::subsurface;
      share = s->f * ((discrete ? 1 : std::abs(s->wi.z)) / s->pdf);
      if (s->lobe == Lobe::subsurface) share *= body;
      found->bad_numbers += !is_finite(share) || !(s->pdf > 0) || std::min({s->f.r, s->f.g, s->f.b}) < 0;
      if (!discrete) {
        const BsdfValue value = bsdf.evaluate(s->wi);
        found->disagreements += !(value.f == s->f) || value.pdf != s->pdf;
      }
    }
    for (int c = 0; c < 3; ++c) light[c].add(i < 27 ? 0 : double(share[c]));
  }
  for (const RunningStatistics& channel : light) found->bright(channel, at);
}

void examine_all_sides(const DisneyParameters& p, const std::string& at, uint64_t samples, MaterialFindings* found) {
  for (const float cosine : {0.9f, 0.1f, 1e-4f}) {
    const Vec3f wo = along(cosine);
    const Rgb body = p.base_color * (41.0f / 42);  // what comes back of the light that enters, at most
    // The indices of both sides are equal in the furnace: light that crosses into another medium has its radiance
    // scaled.
    if (p.transmits())
      examine(DisneyTransmissiveBsdf(p, wo, {p.thin ? p.ior : 1, false}, EnergyModel::bounded), body, at, samples,
              found);
    else
      examine(DisneyBsdf(p, wo, EnergyModel::bounded), body, at, samples, found);
  }
}

/// The published lobes are bounded to 1e-3; layers, films and stretched facets to 2 %, because their tables are
/// coarser.
bool has_coarse_bound(const DisneyParameters& p) {
  return p.coat > 0 || (p.sheen > 0 && p.sheen_roughness > 0) || p.iridescence > 0 || p.anisotropic > 0 ||
         p.transmits();
}

void print_material_parameters(Report& report) {
  Rows rows(
      report, "Materials: each parameter of schemas/disney_material.json",
      "Each value (min, max, just inside and outside both, 1e-40, 1e-6, 1 + 1e-6, NaN, infinities) on each of ten\n"
      "materials, seen at cosines .9, .1 and 1e-4, energy model `bounded`. Finite: f, pdf and weights of all samples,\n"
      "corners of the domain among them, pdf > 0. Agree: f and pdf of a sample are evaluate()'s, to the bit. The\n"
      "furnace: the brightest mean; its tolerance is 1e-3, or 2e-2 where coat, fibres, film, stretched facets or\n"
      "transmission, whose tables are coarser, take part.");
  const uint64_t samples = report.walks_for(0.0012);
  for (const MaterialParameter& row : material_parameters()) {
    if (!is_number(row)) continue;
    MaterialFindings fine, coarse;
    for (const Base& base : bases())
      for (const NamedValue& v : extreme_values(row.minimum, row.maximum)) {
        DisneyParameters p = base.parameters;
        set(row, v.value, &p);
        examine_all_sides(p, std::string(base.name) + ", " + v.name, samples, has_coarse_bound(p) ? &coarse : &fine);
      }
    const int cases = (fine.cases + coarse.cases) / 3;
    const int bad = fine.bad_numbers + coarse.bad_numbers, disagree = fine.disagreements + coarse.disagreements;
    rows.require(row.name, "all", "finite; samples agree", "bits",
                 text("%d cases: %d bad, %d disagree", cases, bad, disagree), bad == 0 && disagree == 0);
    rows.compare_most(row.name, fine.brightest_at, "furnace", fine.brightest, 1 + 1e-3);
    rows.compare_most(row.name, coarse.brightest_at, "furnace", coarse.brightest, 1 + 2e-2);
  }
}

DisneyParameters any_extreme_material(Rng& rng) {
  DisneyParameters p;
  for (const MaterialParameter& row : material_parameters()) {
    const auto values = extreme_values(row.minimum, row.maximum);
    if (!is_number(row) || rng.next() % 2) continue;
    set(row, values[rng.next() % values.size()].value, &p);
  }
  p.thin = rng.next() % 4 == 0;
  return p;
}

void print_combinations(Report& report) {
  Rows rows(report, "Materials: extremes together",
            "Random materials, half of whose parameters have one of the values above.");
  Rng rng(91, 1);
  MaterialFindings fine, coarse;
  const auto count = static_cast<int>(report.walks_for(0.002));
  for (int i = 0; i < count; ++i) {
    const DisneyParameters p = any_extreme_material(rng);
    examine_all_sides(p, text("material %d", i), 600, has_coarse_bound(p) ? &coarse : &fine);
  }
  const int bad = fine.bad_numbers + coarse.bad_numbers, disagree = fine.disagreements + coarse.disagreements;
  rows.require("any material", text("%d of them", count), "finite; samples agree", "bits",
               text("%d bad, %d disagree", bad, disagree), bad == 0 && disagree == 0);
  rows.compare_most("published lobes", fine.brightest_at, "furnace", fine.brightest, 1 + 1e-3);
  rows.compare_most("layers, films, stretched facets, transmission", coarse.brightest_at, "furnace", coarse.brightest,
                    1 + 2e-2);
}

// The share of samples that have a direction is the integral of the pdf, and their mean weight that of f: by
// quadrature.
void print_integrals(Report& report) {
  Rows rows(
      report, "Materials: integrals of pdf and f",
      "By quadrature about the mirror direction, at cosine .6. The pdf integrates to the share of samples that have a\n"
      "direction in the hemisphere: 1 less the walk's choice and what is lost below the horizon.");
  struct Case {
    const char* name;
    double pole;  // exponent of the bins
    DisneyParameters p;
  };
  std::vector<Case> cases = {{"roughness 0", 10, {}},
                             {"roughness 1e-6", 10, {}},
                             {"roughness 1", 1, {}},
                             {"ior 1", 2, {}},
                             {"ior 1 + 1e-6", 2, {}},
                             {"anisotropic 1", 3, {}},
                             {"anisotropic 1.11", 3, {}},
                             {"metallic 1", 2, {}},
                             {"sheen 1, fibres of 1e-6", 1, {}},
                             {"coat 1 of roughness 0", 10, {}},
                             {"clearcoatGloss 1", 6, {}},
                             {"black", 2, {}}};
  cases[0].p.roughness = 0;
  cases[1].p.roughness = 1e-6f;
  cases[2].p.roughness = 1;
  cases[3].p.ior = 1;
  cases[4].p.ior = 1 + 1e-6f;
  cases[5].p.anisotropic = 1;
  cases[6].p.anisotropic = 1.11f;
  cases[7].p.metallic = 1;
  cases[8].p.sheen = 1, cases[8].p.sheen_roughness = 1e-6f;
  cases[9].p.coat = 1;
  cases[10].p.clearcoat = 1;
  cases[11].p.base_color = Rgb(0.0f);
  const Vec3f wo = along(0.6f);
  const Frame mirror = frame_from_normal({-wo.x, -wo.y, wo.z});
  for (const Case& c : cases) {
    const DisneyBsdf bsdf(c.p, wo, EnergyModel::bounded);
    Rng rng(23, 7);
    RunningStatistics directions, light;
    for (uint64_t i = 0; i < report.walks_for(0.1); ++i) {
      const float lobe = rng.uniform();
      const auto s = bsdf.sample(lobe, uniform2(rng));
      directions.add(s ? 1 : 0);
      light.add(s ? double(s->f.g * s->wi.z / s->pdf) : 0);
    }
    const double mass =
        integrate_sphere([&](const Vec3f& wi) { return double(bsdf.evaluate(wi).pdf); }, mirror, c.pole);
    const double albedo = integrate_sphere(
        [&](const Vec3f& wi) { return wi.z > 0 ? double(bsdf.evaluate(wi).f.g * wi.z) : 0; }, mirror, c.pole);
    rows.compare("plastic", c.name, "integral of the pdf", directions, mass, 1e-3, "quadrature");
    rows.compare("plastic", c.name, "integral of f cos", light, albedo, 1e-3, "quadrature");
  }
}

// ---- lights, cameras, settings

SceneBuilder lit_sphere() {
  SceneBuilder b;
  DisneyParameters skin;
  skin.scatter_distance = Rgb(0.1f);
  b.add(b.prototype(sphere_mesh(0.5f, 12, true)), b.material(skin));
  b.add(b.prototype(plane_mesh(4)), b.material({}), translation(0, -0.5, 0));
  return b;
}

const CameraParameters kView = look_at({0, 0.5, 3}, {0, 0, 0}, 30);

void print_light_parameters(Report& report) {
  Rows rows(
      report, "Lights: each parameter of schemas/lights.json",
      "Each value on each type of light over a scattering sphere. Sound: every pixel is finite and not negative, no\n"
      "sample and no ray had to be dropped.");
  SceneBuilder b = lit_sphere();
  for (const auto& row : light_parameters()) {
    if (!is_number(row)) continue;
    int pictures = 0, unsound = 0;
    std::string worst;
    for (const LightType type : {LightType::rect, LightType::sphere, LightType::distant, LightType::dome,
                                 LightType::disk, LightType::cylinder})
      for (const NamedValue& v : extreme_values(row.minimum, row.maximum)) {
        LightDescription light;
        light.type = type;
        light.light_to_world = Matrix4d(1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0.2, 2, 0.1, 1);
        light.visible_to_camera = true;
        set(row, v.value, &light);
        b.description.lights = {light};
        const Picture picture(picture_of(&b, kView, 2, 8));
        ++pictures;
        if (picture.sound) continue;
        ++unsound;
        worst = text(" (type %d, %s: ", int(type), v.name) + picture.said() + ")";
      }
    rows.require("sphere and floor", row.name, "sound", "exact",
                 text("%d of %d pictures unsound", unsound, pictures) + worst, unsound == 0);
  }
}

void print_camera_parameters(Report& report) {
  Rows rows(report, "Cameras: each parameter of schemas/camera.json",
            "Each value, with and without a lens, perspective and orthographic. Rays that begin beyond 1e17 meet the "
            "sky alone.");
  SceneBuilder b = lit_sphere();
  b.add(constant_dome(1, true));
  for (const auto& row : camera_parameters()) {
    if (!is_number(row)) continue;
    int pictures = 0, odd = 0;
    std::string worst;
    for (const bool lens : {false, true})
      for (const bool orthographic : {false, true})
        for (const NamedValue& v : extreme_values(row.minimum, row.maximum)) {
          CameraParameters camera = kView;
          camera.orthographic = orthographic;
          if (lens) camera.f_stop = 2, camera.focus_distance = 3, camera.aperture_blades = 5;
          set(row, v.value, &camera);
          const Picture picture(picture_of(&b, camera, 2, 8));
          ++pictures;
          if (picture.finite) continue;
          ++odd;
          worst = text(" (lens %d, orthographic %d, %s: ", lens, orthographic, v.name) + picture.said() + ")";
        }
    rows.require("sphere and floor under a sky", row.name, "finite", "exact",
                 text("%d of %d pictures odd", odd, pictures) + worst, odd == 0);
  }
}

void print_render_settings(Report& report) {
  Rows rows(report, "Settings: each number of schemas/render_settings.json",
            "Each value; samples, threads and time are then cut to what a test may take.");
  SceneBuilder b = lit_sphere();
  b.add(constant_dome(1, true));
  for (const auto& row : setting_parameters()) {
    if (!is_number(row)) continue;
    int pictures = 0, unsound = 0;
    for (const NamedValue& v : extreme_values(row.minimum, row.maximum)) {
      RenderRequest request = picture_of(&b, kView, 4, 8);
      set(row, v.value, &request.settings);
      RenderSettings& s = request.settings;
      s.samples = std::min(s.samples, 8u);
      s.first_sample = std::min(s.first_sample, s.samples - 1);
      s.threads = std::min(s.threads, 64u);
      if (s.adaptive || s.target_error > 0) s.first_sample = 0;
      ++pictures;
      unsound += !Picture(request).sound;
    }
    rows.require("sphere and floor under a sky", row.name, "sound", "exact",
                 text("%d of %d pictures unsound", unsound, pictures), unsound == 0);
  }
}

}  // namespace

void print_parameters(Report& report) {
  print_material_parameters(report);
  print_combinations(report);
  print_integrals(report);
  print_light_parameters(report);
  print_camera_parameters(report);
  print_render_settings(report);
}

}  // namespace alabaster::testing
