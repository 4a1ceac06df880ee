// Every parameter of the schemas at the ends of its range, inside, outside, and at numbers that are none. Values are
// read as a host's are.
#include <array>
#include <limits>

#include "core/material/disney_transmissive_bsdf.h"
#include "core/material/energy_model.h"
#include "delegate/support/parameters.h"
#include "testenv/extremes/rows.h"
#include "testenv/support/chi_square.h"

namespace alabaster::testing {
namespace {

using hd::support::set_parameter;

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
  std::vector<Base> all(13);
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
  all[10].name = "half skin", all[10].parameters.scatter_distance = {1, 0.35f, 0};
  all[10].parameters.subsurface_weight = 0.5f, all[10].parameters.subsurface_color = {1, 0.5f, 0.9f};
  all[11].name = "stained glass", all[11].parameters.spec_trans = 0.6f, all[11].parameters.coat = 0.8f;
  all[11].parameters.coat_color = {0.9f, 0.5f, 0.1f}, all[11].parameters.coat_darkening = 1;
  all[12].name = "window", all[12].parameters.opacity_mode = OpacityMode::transparent;
  all[12].parameters.thin = true, all[12].parameters.spec_trans = 0.7f;
  return all;
}

Vec3f along(float cosine) {
  // Off the axes, so that the directions of anisotropy differ.
  const float sine = std::sqrt(1 - sqr(cosine));
  return {0.8f * sine, 0.6f * sine, cosine};
}

/// A material seen along one direction.
struct View {
  DisneyParameters parameters;
  Vec3f wo;
  std::string at;
  double brightness = 0;  // of the furnace, as far as it is known
};

/// Calls `use` with the BSDF. The indices of both sides are equal in the furnace: light that crosses into another
/// medium has its radiance scaled.
template <class Use>
void with_bsdf(const View& view, const Use& use) {
  const DisneyParameters& p = view.parameters;
  if (p.transmits())
    use(DisneyTransmissiveBsdf(p, view.wo, {p.thin ? p.ior : 1, false}, EnergyModel::bounded));
  else
    use(DisneyBsdf(p, view.wo, EnergyModel::bounded));
}

/// The findings about one parameter.
struct MaterialFindings {
  static constexpr size_t kViews = 12;  // looked at twice

  int views = 0, bad_numbers = 0, disagreements = 0;
  std::vector<View> brightest;  // falling

  void keep(View view) {
    ++views;
    const auto at = std::upper_bound(brightest.begin(), brightest.end(), view,
                                     [](const View& a, const View& b) { return a.brightness > b.brightness; });
    brightest.insert(at, std::move(view));
    if (brightest.size() > kViews) brightest.pop_back();
  }
};

/// The light that one sample gives in a white furnace. Notes numbers that are bad, and values that are not
/// evaluate()'s.
template <class Bsdf>
Rgb furnace_sample(const Bsdf& bsdf, const DisneyParameters& p, float lobe, const Vec2f& u, MaterialFindings* found) {
  const auto s = bsdf.sample(lobe, u);
  if (!s) return Rgb(0.0f);
  const bool discrete = s->lobe == Lobe::straight || s->lobe == Lobe::subsurface;
  Rgb share = s->weight();
  if (s->lobe == Lobe::subsurface) share *= p.medium_albedo() * (41.0f / 42);  // what comes back of it at most
  found->bad_numbers += !is_finite(share) || !(s->pdf > 0) || std::min({s->f_cos.r, s->f_cos.g, s->f_cos.b}) < 0;
  if (!discrete) {
    const BsdfValue value = bsdf.evaluate(s->wi);
    found->disagreements += !(value.f_cos == s->f_cos) || value.pdf != s->pdf;
  }
  return share;
}

/// Every number is finite, and samples are what evaluate() says: at the corners of the domain and at evenly spread
/// places (Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences"), which tell the furnace roughly.
void examine(View view, uint64_t samples, MaterialFindings* found) {
  with_bsdf(view, [&](const auto& bsdf) {
    constexpr float kLast = 0x1.fffffep-1f;
    const auto end = [kLast](int i) { return i == 2 ? kLast : 0.5f * static_cast<float>(i); };
    for (int i = 0; i < 27; ++i) furnace_sample(bsdf, view.parameters, end(i % 3), {end(i / 3 % 3), end(i / 9)}, found);
    const auto spread = [kLast](uint64_t i, double step) {
      const double x = 0.5 + static_cast<double>(i) * step;
      return std::min(static_cast<float>(x - std::floor(x)), kLast);
    };
    double sum[3] = {0, 0, 0};
    for (uint64_t i = 0; i < samples; ++i) {
      const Vec2f u(spread(i, 0.6710436067037893), spread(i, 0.5497004779019703));
      const Rgb light = furnace_sample(bsdf, view.parameters, spread(i, 0.8191725133961645), u, found);
      for (int c = 0; c < 3; ++c) sum[c] += static_cast<double>(light[c]);
    }
    view.brightness = std::max({sum[0], sum[1], sum[2]}) / static_cast<double>(samples);
  });
  found->keep(std::move(view));
}

/// The furnace's brightest channel.
Estimate furnace(const View& view, uint64_t samples, uint64_t seed) {
  RunningStatistics light[3];
  MaterialFindings ignored;
  Rng rng(seed, 5);
  with_bsdf(view, [&](const auto& bsdf) {
    for (uint64_t i = 0; i < samples; ++i) {
      const Vec2f u = uniform2(rng);
      const Rgb share = furnace_sample(bsdf, view.parameters, rng.uniform(), u, &ignored);
      for (int c = 0; c < 3; ++c) light[c].add(static_cast<double>(share[c]));
    }
  });
  return *std::max_element(std::begin(light), std::end(light),
                           [](const auto& a, const auto& b) { return a.mean() < b.mean(); });
}

/// The row of the brightest furnace: of the views that looked brightest, the one that does so again, seen afresh.
void print_brightest(Rows& rows, const std::string& scene, MaterialFindings* found, uint64_t samples) {
  for (View& view : found->brightest) view.brightness = furnace(view, samples / 8, 1).mean;
  const View& view = *std::max_element(found->brightest.begin(), found->brightest.end(),
                                       [](const View& a, const View& b) { return a.brightness < b.brightness; });
  rows.compare_most(scene, view.at + text(", cosine %g", static_cast<double>(view.wo.z)), "furnace",
                    furnace(view, samples, 2), 1 + 1e-3);
}

void examine_all_sides(const DisneyParameters& p, const std::string& at, uint64_t samples, MaterialFindings* found) {
  for (const float cosine : {0.9f, 0.1f, 1e-4f}) examine({p, along(cosine), at}, samples, found);
}

void print_material_parameters(Report& report) {
  Rows rows(
      report, "Materials: each parameter of schemas/disney_material.json",
      "Each value (min, max, just inside and outside both, 1e-40, 1e-6, 1 + 1e-6, NaN, infinities) on each of "
      "thirteen\n"
      "materials, seen at cosines .9, .1 and 1e-4, energy model `bounded`. Finite: f, pdf and weights of all samples,\n"
      "corners of the domain among them, pdf > 0. Agree: f and pdf of a sample are evaluate()'s, to the bit. The\n"
      "furnace: the brightest of all, found with few samples and measured with many.");
  const uint64_t samples = report.walks_for(0.0012);
  for (const MaterialParameter& row : material_parameters()) {
    if (!is_number(row)) continue;
    MaterialFindings found;
    for (const Base& base : bases())
      for (const NamedValue& v : extreme_values(row.minimum, row.maximum)) {
        DisneyParameters p = base.parameters;
        set(row, v.value, &p);
        examine_all_sides(p, std::string(base.name) + ", " + v.name, samples, &found);
      }
    rows.require(row.name, "all", "finite; samples agree", "bits",
                 text("%d cases: %d bad, %d disagree", found.views / 3, found.bad_numbers, found.disagreements),
                 found.bad_numbers == 0 && found.disagreements == 0);
    print_brightest(rows, row.name, &found, report.walks_for(0.2));
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
  MaterialFindings found;
  const auto count = static_cast<int>(report.walks_for(0.002));
  for (int i = 0; i < count; ++i) examine_all_sides(any_extreme_material(rng), text("material %d", i), 600, &found);
  rows.require("any material", text("%d of them", count), "finite; samples agree", "bits",
               text("%d bad, %d disagree", found.bad_numbers, found.disagreements),
               found.bad_numbers == 0 && found.disagreements == 0);
  print_brightest(rows, "any material", &found, report.walks_for(0.4));
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
      light.add(s ? double(s->weight().g) : 0);
    }
    const double mass =
        integrate_sphere([&](const Vec3f& wi) { return double(bsdf.evaluate(wi).pdf); }, mirror, c.pole);
    const double albedo = integrate_sphere(
        [&](const Vec3f& wi) { return wi.z > 0 ? double(bsdf.evaluate(wi).f_cos.g) : 0; }, mirror, c.pole);
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
        LightParameters light;
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
