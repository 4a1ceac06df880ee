// The surface against the BRDF that glTF defines: directional albedo over the angle of view. Prints the table from
// which delegate/manual/gltf.md has its numbers.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "core/material/disney_bsdf.h"
#include "core/material/disney_material.h"
#include "testenv/support/gltf_testing.h"
#include "testenv/support/material_testing.h"

namespace alabaster::hd::gltf::testing {
namespace {

using Brdf = std::function<double(const Vec3f& wo, const Vec3f& wi)>;

void set_member(const MaterialParameter& row, const Value& value, DisneyParameters* p) {
  if (const auto* color = std::get_if<Rgb DisneyParameters::*>(&row.member)) {
    const Vec3f c = value.get_or(Vec3f(0));
    p->** color = Rgb(c.x, c.y, c.z);
  } else if (const auto* number = std::get_if<float DisneyParameters::*>(&row.member)) {
    p->** number = float(value.number_or(0));
  } else if (const auto* flag = std::get_if<bool DisneyParameters::*>(&row.member)) {
    p->** flag = value.get_or(false);
  }
}

/// The constants that a material becomes.
DisneyParameters translated(const std::string& material) {
  const TemporaryFolder folder;
  const Loaded loaded = folder.load_text(R"({"asset": {"version": "2.0"}, "materials": [)" + material + "]}");
  EXPECT_TRUE(loaded.summary.ok) << loaded.said();
  const MaterialNetwork& network = loaded.scene->GetMaterials().begin()->second;
  const MaterialNode& node = network.nodes.at(network.terminals.at("surface").upstreamNode);
  DisneyParameters p;
  for (const auto& [name, value] : node.parameters) {
    if (name.str().ends_with(":colorSpace")) continue;
    const MaterialParameter* row = find_material_parameter(name.str());
    EXPECT_NE(row, nullptr) << name.str();
    if (row) set_member(*row, value, &p);
  }
  return p;
}

/// By midpoints, uniform in the square of the cosine and in azimuth.
double directional_albedo(const Brdf& f, double cos_o) {
  constexpr int kRows = 256, kColumns = 512;
  const Vec3f wo(float(std::sqrt(1 - cos_o * cos_o)), 0, float(cos_o));
  double sum = 0;
  for (int i = 0; i < kRows; ++i)
    for (int j = 0; j < kColumns; ++j) {
      const double cos2 = (i + 0.5) / kRows, phi = (j + 0.5) / kColumns * 2 * std::numbers::pi;
      const double sine = std::sqrt(1 - cos2);
      sum += f(wo, Vec3f(float(sine * std::cos(phi)), float(sine * std::sin(phi)), float(std::sqrt(cos2))));
    }
  return sum * std::numbers::pi / (kRows * kColumns);
}

Brdf ours(const DisneyParameters& p) {
  return [p](const Vec3f& wo, const Vec3f& wi) {
    return double(alabaster::testing::f_of(DisneyBsdf(p, wo).evaluate(wi), wi).r);
  };
}

/// The specular term of glTF 2.0, appendix B.3: D V, with alpha = roughness^2 and height-correlated masking.
double khronos_microfacet(double alpha, const Vec3f& wo, const Vec3f& wi) {
  const Vec3f h = (wo + wi).normalized();
  const double a2 = alpha * alpha, n = double(h.z), o = double(wo.z), i = double(wi.z);
  const double d = a2 / (std::numbers::pi * std::pow(n * n * (a2 - 1) + 1, 2));
  return d * 0.5 / (i * std::sqrt(o * o * (1 - a2) + a2) + o * std::sqrt(i * i * (1 - a2) + a2));
}

double fresnel(double f0, double cosine) {
  return f0 + (1 - f0) * std::pow(1 - cosine, 5);
}
double half_cosine(const Vec3f& wo, const Vec3f& wi) {
  return double(wo.dot((wo + wi).normalized()));
}

/// glTF 2.0, appendix B.2: fresnel_mix of a Lambertian base and the specular term.
Brdf khronos_dielectric(double color, double roughness) {
  return [=](const Vec3f& wo, const Vec3f& wi) {
    const double f = fresnel(0.04, half_cosine(wo, wi));
    return (1 - f) * color / std::numbers::pi + f * khronos_microfacet(roughness * roughness, wo, wi);
  };
}
Brdf khronos_metal(double color, double roughness) {
  return [=](const Vec3f& wo, const Vec3f& wi) {
    return fresnel(color, half_cosine(wo, wi)) * khronos_microfacet(roughness * roughness, wo, wi);
  };
}

/// KHR_materials_clearcoat, fresnel_coat over a rough dielectric: ior 1.5, alpha = roughness^2.
Brdf khronos_coat(double color, double roughness, double coat_roughness) {
  return [=](const Vec3f& wo, const Vec3f& wi) {
    const double layer = khronos_microfacet(coat_roughness * coat_roughness, wo, wi);
    const double base = khronos_dielectric(color, roughness)(wo, wi);
    return (1 - fresnel(0.04, double(wo.z))) * base + fresnel(0.04, half_cosine(wo, wi)) * layer;
  };
}

/// KHR_materials_sheen over a Lambertian base that is not dimmed: Charlie (Estevez and Kulla 2017), visibility of
/// Neubelt and Pettineo 2013.
Brdf khronos_sheen(double color, double roughness) {
  return [=](const Vec3f& wo, const Vec3f& wi) {
    const double n = double((wo + wi).normalized().z), inverse = 1 / (roughness * roughness);
    const double d = (2 + inverse) * std::pow(std::sqrt(std::max(0.0, 1 - n * n)), inverse) / (2 * std::numbers::pi);
    return color * d / (4 * (double(wo.z) + double(wi.z) - double(wo.z) * double(wi.z)));
  };
}

struct Row {
  const char* name;
  std::string material;
  Brdf khronos;
  double bound;  // of the difference, at every angle
};

TEST(GltfMaterialModel, DirectionalAlbedoAgainstKhronos) {
  const Row kRows[] = {
      {"dielectric, roughness 0.3",
       R"({"pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.8, 0.8, 1], "metallicFactor": 0, "roughnessFactor": 0.3}})",
       khronos_dielectric(0.8, 0.3), 0.03},
      {"dielectric, roughness 0.6",
       R"({"pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.8, 0.8, 1], "metallicFactor": 0, "roughnessFactor": 0.6}})",
       khronos_dielectric(0.8, 0.6), 0.1},
      {"dielectric, roughness 1",
       R"({"pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.8, 0.8, 1], "metallicFactor": 0}})",
       khronos_dielectric(0.8, 1), 0.26},
      {"metal, roughness 0.3",
       R"({"pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.8, 0.8, 1], "roughnessFactor": 0.3}})",
       khronos_metal(0.8, 0.3), 0.003},
      {"metal, roughness 0.6",
       R"({"pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.8, 0.8, 1], "roughnessFactor": 0.6}})",
       khronos_metal(0.8, 0.6), 0.04},
      {"metal, roughness 1", R"({"pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.8, 0.8, 1]}})",
       khronos_metal(0.8, 1), 0.13},
      {"coat of roughness 0.3",
       R"({"pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.8, 0.8, 1], "metallicFactor": 0, "roughnessFactor": 0.6},
           "extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 1, "clearcoatRoughnessFactor": 0.3}}})",
       khronos_coat(0.8, 0.6, 0.3), 0.07},
      {"sheen 1 of roughness 0.5, base black",
       R"({"pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0},
           "extensions": {"KHR_materials_sheen": {"sheenColorFactor": [1, 1, 1], "sheenRoughnessFactor": 0.5},
                          "KHR_materials_specular": {"specularFactor": 0}}})",
       khronos_sheen(1, 0.5), 0.001},
  };
  std::printf("%-28s  angle: albedo by glTF, ours\n", "");
  for (const Row& row : kRows) {
    const Brdf mine = ours(translated(row.material));
    std::printf("%-28s", row.name);
    for (const int degrees : {0, 30, 60, 80}) {
      const double cosine = std::cos(degrees * std::numbers::pi / 180);
      const double theirs = directional_albedo(row.khronos, cosine), found = directional_albedo(mine, cosine);
      std::printf("  %d: %.3f %.3f", degrees, theirs, found);
      EXPECT_NEAR(found, theirs, row.bound) << row.name << " at " << degrees << " degrees";
    }
    std::printf("\n");
  }
}

}  // namespace
}  // namespace alabaster::hd::gltf::testing
