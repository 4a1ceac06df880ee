// Materials that are damaged, and translations that a number must confirm. Networks as text: gltf_translation_test.cpp.
#include <gtest/gtest.h>

#include <cmath>

#include "testenv/support/gltf_testing.h"

namespace alabaster::hd::gltf::testing {
namespace {

/// Loads a document with one material and one texture.
Loaded load_material(const std::string& material) {
  const TemporaryFolder folder;
  return folder.load_text(R"({"asset": {"version": "2.0"}, "images": [{"uri": "a.png"}], "textures": [{"source": 0}],
                              "extensionsUsed": ["KHR_materials_anisotropy", "KHR_materials_clearcoat", "KHR_materials_ior",
                                "KHR_materials_transmission", "KHR_materials_volume"],
                              "materials": [)" +
                          material + "]}");
}

const MaterialNode& surface_of(const Loaded& loaded) {
  const MaterialNetwork& network = loaded.scene->GetMaterials().begin()->second;
  return network.nodes.at(network.terminals.at("surface").upstreamNode);
}

double number(const MaterialNode& node, const char* name) {
  const auto found = node.parameters.find(name);
  return found == node.parameters.end() ? NAN : found->second.number_or(NAN);
}

std::string extension(const std::string& name, const std::string& content) {
  return R"({"extensions": {")" + name + R"(": )" + content + "}}";
}

TEST(GltfMaterial, EveryDamageIsReportedWithItsPlace) {
  struct Case {
    std::string material;
    const char* place;
    bool fatal = true;
  };
  const Case kCases[] = {
      {R"({"normalTexture": {"index": 1}})", "materials[0].normalTexture.index"},
      {R"({"normalTexture": {"index": 0, "scale": "deep"}})", "materials[0].normalTexture.scale"},
      {R"({"emissiveTexture": {}})", "materials[0].emissiveTexture.index"},
      {R"({"alphaMode": "GLASS"})", "materials[0].alphaMode"},
      {extension("KHR_materials_transmission", R"({"transmissionTexture": {"index": 7}})"),
       "KHR_materials_transmission.transmissionTexture.index"},
      {extension("KHR_materials_transmission", R"({"transmissionFactor": [1]})"), "transmissionFactor"},
      {extension("KHR_materials_anisotropy", R"({"anisotropyRotation": true})"), "anisotropyRotation"},
      {extension("KHR_materials_iridescence", R"({"iridescenceIor": "thin"})"), "iridescenceIor"},
      {extension("KHR_materials_dispersion", R"({"dispersion": {}})"), "KHR_materials_dispersion.dispersion"},
      {extension("KHR_materials_pbrSpecularGlossiness", R"({"diffuseFactor": [1, 1, 1]})"), "diffuseFactor"},
      {extension("KHR_materials_volume", R"({"attenuationColor": [1, 1]})"), "attenuationColor"},
      {extension("ALAB_materials_disney", R"({"roughnesTexture": {"index": 0}})"), "roughnesTexture"},
      {extension("ALAB_materials_disney", R"({"roughnessTexture": {"index": 2}})"), "roughnessTexture.index"},
      {extension("ALAB_materials_disney", R"({"roughness": [0.5]})"), "must be a number"},
      // the nearest legal value is used
      {R"({"alphaMode": "MASK", "alphaCutoff": -1})", "materials[0].alphaCutoff", false},
      {R"({"pbrMetallicRoughness": {"metallicFactor": -0.5}})", "metallicFactor", false},
      {extension("KHR_materials_transmission", R"({"transmissionFactor": -1})"), "transmissionFactor", false},
      {extension("KHR_materials_clearcoat", R"({"clearcoatFactor": 3})"), "clearcoatFactor", false},
      {extension("KHR_materials_dispersion", R"({"dispersion": -1})"), "dispersion", false},
      {extension("KHR_materials_ior", R"({"ior": 0.5})"), "KHR_materials_ior.ior is below 1", false},
  };
  for (const Case& damaged : kCases) {
    const Loaded loaded = load_material(damaged.material);
    EXPECT_EQ(loaded.summary.ok, !damaged.fatal) << damaged.material << "\n" << loaded.said();
    EXPECT_TRUE(loaded.says(damaged.fatal ? Severity::error : Severity::warning, damaged.place))
        << damaged.material << loaded.said();
  }
}

// A parameter of the surface has a smaller range than the extension, which is reported as well.
TEST(GltfMaterial, ValuesBeyondTheSurfacesRangeAreTheNearestLegalOnes) {
  struct Case {
    const char *layer, *content, *parameter;
    double taken;
  };
  const Case kCases[] = {
      {"KHR_materials_ior", R"({"ior": 2000})", "ior", 1000},
      {"KHR_materials_iridescence", R"({"iridescenceFactor": 1, "iridescenceIor": 9})", "iridescenceIor", 4},
      {"KHR_materials_clearcoat", R"({"clearcoatFactor": 7})", "coat", 1},
  };
  for (const Case& one : kCases) {
    const Loaded loaded = load_material(extension(one.layer, one.content));
    EXPECT_TRUE(loaded.says(Severity::warning, "is out of range; the nearest legal value is used"))
        << one.content << loaded.said();
    EXPECT_EQ(number(surface_of(loaded), one.parameter), one.taken) << one.content;
  }
}

// A mask of cutoff 0 leaves nothing out, and one above 1 everything.
TEST(GltfMaterial, CutoffsBeyondTheRangeOfAlpha) {
  const auto opacity = [](const char* cutoff) {
    const std::string half = R"({"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.5]}, "alphaMode": "MASK", )";
    return number(surface_of(load_material(half + R"("alphaCutoff": )" + cutoff + "}")), "opacity");
  };
  EXPECT_TRUE(std::isnan(opacity("0")));
  EXPECT_EQ(opacity("1"), 0.5);
  EXPECT_EQ(opacity("1.01"), 0);
}

// The alphas of the surface's lobe are those of the extension: mix(alpha, 1, strength^2) and alpha.
TEST(GltfMaterial, AnisotropyKeepsBothAlphas) {
  for (const auto& [roughness, strength] : {std::pair(0.6, 0.5), {0.2, 1.0}, {0.2, 0.1}}) {
    const MaterialNode surface = surface_of(load_material(
        R"({"pbrMetallicRoughness": {"roughnessFactor": )" + std::to_string(roughness) +
        R"(}, "extensions": {"KHR_materials_anisotropy": {"anisotropyStrength": )" + std::to_string(strength) + "}}}"));
    const double alpha = std::pow(number(surface, "roughness"), 2), b = roughness * roughness;
    const double aspect = std::sqrt(1 - 0.9 * number(surface, "anisotropic"));
    EXPECT_NEAR(alpha / aspect, b + (1 - b) * strength * strength, 1e-5);
    EXPECT_NEAR(alpha * aspect, b, 1e-5);
  }
  const MaterialNode sharpest = surface_of(load_material(
      R"({"pbrMetallicRoughness": {"roughnessFactor": 0},
          "extensions": {"KHR_materials_anisotropy": {"anisotropyStrength": 1}}})"));
  EXPECT_LE(number(sharpest, "anisotropic"), 1.11) << "in the range of the parameter";
}

// A texture of strengths: its ends are the extension's, and what lies between is near.
TEST(GltfMaterial, ATextureOfAnisotropyKeepsBothAlphasAtItsEnds) {
  for (const auto& [roughness, strength] : {std::pair(0.3, 0.6), {0.3, 1.0}, {0.6, 0.5}}) {
    const Loaded loaded = load_material(R"({"pbrMetallicRoughness": {"roughnessFactor": )" + std::to_string(roughness) +
                                        R"(}, "extensions": {"KHR_materials_anisotropy": {"anisotropyStrength": )" +
                                        std::to_string(strength) + R"(, "anisotropyTexture": {"index": 0}}}})");
    const MaterialNetwork& network = loaded.scene->GetMaterials().begin()->second;
    const MaterialNode surface = surface_of(loaded);
    ASSERT_EQ(surface.inputConnections.at("roughness").size(), 1u);
    const MaterialConnection& connection = surface.inputConnections.at("roughness")[0];
    const MaterialNode& node = network.nodes.at(connection.upstreamNode);
    EXPECT_EQ(connection.upstreamOutput, Token("b"));
    const double scale = double(node.parameters.at("scale").get_or(Vec4f(0)).z);
    const double bias = double(node.parameters.at("bias").get_or(Vec4f(0)).z);
    double least[2] = {1, 1}, most[2] = {1, 1};
    for (int i = 0; i <= 100; ++i) {
      const double x = i / 100.0, b = roughness * roughness, t = b + (1 - b) * strength * strength * x * x;
      const double alpha = std::pow(number(surface, "roughness") * (x * scale + bias), 2);
      const double aspect = std::sqrt(1 - 0.9 * number(surface, "anisotropic") * x);
      const double ratios[2] = {alpha / aspect / t, alpha * aspect / b};
      for (int k = 0; k < 2; ++k) {
        EXPECT_TRUE(std::abs(ratios[k] - 1) < 1e-5 || (i > 0 && i < 100)) << ratios[k] << " at " << x;
        least[k] = std::min(least[k], ratios[k]), most[k] = std::max(most[k], ratios[k]);
      }
    }
    std::printf("roughness %.1f, strength %.1f: alpha_t %.2f to %.2f of the extension's, alpha_b %.2f to %.2f\n",
                roughness, strength, least[0], most[0], least[1], most[1]);
    EXPECT_GT(std::min(least[0], least[1]), 0.65);
    EXPECT_LT(std::max(most[0], most[1]), 1.6);
  }
}

// Radians, counter-clockwise, of any size, as turns.
TEST(GltfMaterial, AnisotropyHasARotation) {
  for (const auto& [radians, turns] : {std::pair(M_PI / 2, 0.25), {-M_PI / 2, 0.75}, {5 * M_PI, 0.5}}) {
    const MaterialNode surface = surface_of(load_material(
        R"({"extensions": {"KHR_materials_anisotropy": {"anisotropyStrength": 0.5, "anisotropyRotation": )" +
        std::to_string(radians) + "}}}"));
    EXPECT_NEAR(number(surface, "anisotropicRotation"), turns, 1e-6);
  }
}

}  // namespace
}  // namespace alabaster::hd::gltf::testing
