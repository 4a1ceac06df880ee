// Each row of each look, generated from the tables: an input is set, and the parameter of AlabasterDisney is what a
// second computation of the formula gives.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/material/disney_material.h"
#include "core/subsurface/medium.h"
#include "delegate/looks/look_tables.h"
#include "delegate/looks/looks.h"
#include "delegate/support/parameters.h"

namespace alabaster::hd::looks {
namespace {

using Inputs = std::map<std::string, Vec3f>;
using Expected = std::function<Vec3f(const Inputs&)>;

float mixed(double bare, double coated, const Vec3f& coat) {
  return float(bare + (coated - bare) * std::min(double(coat.x), 1.0));
}
/// Emission below a coat.
Vec3f shining(const Inputs& in, const char* strength, const char* coat) {
  Vec3f light = in.at(strength) * in.at("emission_color");
  for (int i = 0; i < 3; ++i) light[i] *= mixed(1, double(in.at("coat_color")[i]), in.at(coat));
  return light;
}

// Rows that are no product of their inputs.
using Named = std::map<std::string, Expected>;
const std::map<std::string, Named>& formulas() {
  static const auto standard = std::map<std::string, Expected>{
      {"dispersion", [](const Inputs& in) { return Vec3f(20 / in.at("transmission_dispersion").x); }},
      {"sheenRoughness", [](const Inputs& in) { return in.at("sheen_roughness"); }},
      {"sheenTint", [](const Inputs&) { return Vec3f(0); }},
      {"diffuseRoughness", [](const Inputs&) { return Vec3f(0.43f); }},
      {"anisotropic", [](const Inputs& in) { return in.at("specular_anisotropy") / 0.9f; }},
      {"iridescence", [](const Inputs& in) { return Vec3f(in.at("thin_film_thickness").x > 0 ? 1.0f : 0.0f); }},
      {"emission", [](const Inputs& in) { return shining(in, "emission", "coat"); }},
      {"opacity", [](const Inputs& in) {
         const Vec3f o = in.at("opacity");
         return Vec3f((o.x + o.y + o.z) / 3);
       }}};
  static const auto open = std::map<std::string, Expected>{
      {"roughness",
       [](const Inputs& in) {  // the geometric mean of both alphas of OpenPBR is the square of ours
         const double bare = in.at("specular_roughness").x, a = in.at("specular_roughness_anisotropy").x,
                      under = std::pow(bare, 4) + 2 * std::pow(double(in.at("coat_roughness").x), 4),
                      r = mixed(bare, std::min(1.0, std::pow(under, 0.25)), in.at("coat_weight"));
         const double along = r * r * std::sqrt(2 / (1 + (1 - a) * (1 - a))), across = (1 - a) * along;
         return Vec3f(float(std::sqrt(std::sqrt(along * across))));
       }},
      {"ior",
       [](const Inputs& in) {
         const double i = in.at("specular_ior").x, n = std::max(1.0f, in.at("coat_ior").x);
         return in.at("transmission_weight").x > 0 ? Vec3f(float(i))
                                                   : Vec3f(mixed(i, std::max(i / n, n / i), in.at("coat_weight")));
       }},
      {"emission", [](const Inputs& in) { return shining(in, "emission_luminance", "coat_weight"); }},
      {"dispersion",
       [](const Inputs& in) {
         return in.at("transmission_dispersion_scale") * (20 / in.at("transmission_dispersion_abbe_number").x);
       }},
      {"anisotropic", [](const Inputs& in) { return in.at("specular_roughness_anisotropy") / 0.9f; }},
      {"diffuseRoughness", [](const Inputs&) { return Vec3f(0.43f); }},
      {"iridescenceThickness", [](const Inputs& in) { return in.at("thin_film_thickness") * 1000.0f; }},
      {"sheenTint", [](const Inputs&) { return Vec3f(0); }},
      {"sheenRoughness", [](const Inputs& in) { return in.at("fuzz_roughness"); }}};
  static const std::map<std::string, std::map<std::string, Expected>> all{
      {"UsdPreviewSurface",
       {{"diffuseRoughness", [](const Inputs&) { return Vec3f(0.43f); }},
        {"metallic",
         [](const Inputs& in) { return in.at("useSpecularWorkflow").x > 0 ? Vec3f(0) : in.at("metallic"); }},
        {"ior", [](const Inputs& in) { return in.at("useSpecularWorkflow").x > 0 ? Vec3f(1.5f) : in.at("ior"); }},
        {"specularColor",
         [](const Inputs& in) {
           return in.at("useSpecularWorkflow").x > 0 ? in.at("specularColor") / 0.04f : Vec3f(1);
         }},
        {"opacity", [](const Inputs& in) { return in.at("opacity"); }}}},
      {"ND_standard_surface_surfaceshader", standard},
      {"ND_standard_surface_surfaceshader_100", standard},
      {"arnold:standard_surface", standard},
      {"ND_open_pbr_surface_surfaceshader", open},
      {"arnold:openpbr_surface", open},
      {"ND_disney_principled",
       {{"ior",
         [](const Inputs& in) {
           if (in.at("specTrans").x > 0) return in.at("ior");
           const double f = std::sqrt(0.08 * double(in.at("specular").x));
           return Vec3f(float((1 + f) / (1 - f)));
         }}}},
      {"ND_gltf_pbr_surfaceshader",
       {{"baseColor",
         [](const Inputs& in) {  // with a volume
           return in.at("base_color") * (in.at("transmission").x >= 1 ? in.at("base_color") : Vec3f(1));
         }},
        {"roughness",
         [](const Inputs& in) {
           const double b = std::pow(double(in.at("roughness").x), 2);
           return Vec3f(float(std::pow(b * (b + (1 - b) * std::pow(double(in.at("anisotropy_strength").x), 2)), .25)));
         }},
        {"anisotropic",
         [](const Inputs& in) {
           const double b = std::pow(double(in.at("roughness").x), 2);
           return Vec3f(float((1 - b / (b + (1 - b) * std::pow(double(in.at("anisotropy_strength").x), 2))) / .9));
         }},
        {"ior", [](const Inputs& in) { return in.at("ior").x < 1 ? Vec3f(1.5f) : in.at("ior"); }},
        {"specularColor",
         [](const Inputs& in) { return in.at("specular_color") * (in.at("ior").x == 0 ? 25.0f : 1.0f); }},
        {"thin",
         [](const Inputs& in) {
           const bool passes = in.at("transmission").x > 0 || in.at("diffuse_transmission").x > 0;
           return Vec3f(passes && in.at("thickness").x == 0 ? 1.0f : 0.0f);
         }},
        {"specTrans",
         [](const Inputs& in) {
           return in.at("transmission") * (in.at("thickness").x > 0 ? 1 : 1 - in.at("scatter_strength").x);
         }},
        {"subsurfaceWeight",
         [](const Inputs& in) { return Vec3f(in.at("thickness").x > 0 || in.at("transmission").x > 0 ? 1.0f : 0.0f); }},
        {"subsurfaceColor",
         [](const Inputs& in) {
           const bool attenuates = in.at("attenuation_distance").x > 0 && in.at("attenuation_color") != Vec3f(1);
           if (in.at("thickness").x > 0)
             return attenuates ? in.at("multiscatter_color") * in.at("scatter_strength").x : Vec3f(-1);
           return in.at("transmission").x > 0 ? Vec3f(-1) : in.at("multiscatter_color");
         }},
        {"meanFreePath",
         [](const Inputs& in) {
           Vec3f path(0);
           for (int i = 0; i < 3 && in.at("thickness").x > 0 && in.at("attenuation_color") != Vec3f(1); ++i)
             path[i] =
                 float(double(in.at("attenuation_distance").x) / -std::log(double(in.at("attenuation_color")[i])));
           return path;
         }},
        {"diffTrans",
         [](const Inputs& in) {
           return in.at("scatter_strength").x > 0 ? Vec3f(0) : in.at("diffuse_transmission") * 2.0f;
         }},
        {"attenuationDistance",
         [](const Inputs& in) { return in.at("scatter_strength").x > 0 ? Vec3f(0) : in.at("attenuation_distance"); }},
        {"sheen", [](const Inputs& in) { return Vec3f(in.at("sheen_color").x > 0 ? 1.0f : 0.0f); }},
        {"sheenRoughness", [](const Inputs& in) { return Vec3f(std::max(in.at("sheen_roughness").x, 0.07f)); }},
        {"sheenTint", [](const Inputs&) { return Vec3f(0); }},
        {"anisotropicRotation", [](const Inputs& in) { return in.at("anisotropy_rotation") / 6.2831853f; }},
        {"opacity", [](const Inputs& in) { return in.at("alpha_mode").x == 0 ? Vec3f(1) : in.at("alpha"); }},
        {"opacityThreshold",
         [](const Inputs& in) { return Vec3f(in.at("alpha_mode").x == 1 ? in.at("alpha_cutoff").x : 0.0f); }}}}};
  return all;
}

bool is_parameter(const LookRow& row) {
  return find_material_parameter(row.target) != nullptr;
}

// Rows of the interior depend on each other: look_joins_test.cpp has them.
bool is_joined(const Look& look, const LookRow& row) {
  const std::string target = row.target;
  const bool joins = std::any_of(look.rows.begin(), look.rows.end(), [](const LookRow& one) {
    return std::string_view(one.target) == "transmissionColor";
  });
  if (is_parameter(row) && find_material_parameter(row.target)->words[0]) return true;  // preview_surface_test.cpp
  if (!is_parameter(row) || target == "scatterAnisotropy" || target == "diffTransColor") return true;
  return (target == "baseColor" || target == "specTrans" || target == "thin") && joins;
}

struct Read {
  Read(const char* type, const Inputs& inputs) {
    MaterialNetwork network;
    MaterialNode& node = network.nodes["/m/s"];
    node.nodeTypeId = type;
    for (const auto& [name, value] : inputs)
      node.parameters[name] = value.x == value.y && value.y == value.z ? Value(value.x) : Value(value);
    network.terminals["surface"] = {"/m/s", "out"};
    network = ReadLook(network, [&](const char*, const std::string& text) { warnings.push_back(text); });
    surface = network.nodes.at("/m/s");
  }
  Vec3f value(const char* target) const {
    const auto found = surface.parameters.find(target);
    const Value value = found != surface.parameters.end()
                            ? found->second
                            : support::get_parameter(*find_material_parameter(target), DisneyParameters());
    std::array<double, 4> n{};
    const size_t count = value.components(&n);
    return count == 1 ? Vec3f(float(n[0])) : Vec3f(float(n[0]), float(n[1]), float(n[2]));
  }
  MaterialNode surface;
  std::vector<std::string> warnings;
};

TEST(LookRows, ArriveByTheirFormulas) {
  size_t tried = 0;
  for (const Look& look : look_tables())
    for (const char* type : look.types)
      for (const LookRow& row : look.rows) {
        if (row.formula == normals_of || is_joined(look, row)) continue;
        SCOPED_TRACE(std::string(type) + " " + row.target);
        // All inputs of the row at values of their own, one after the other; what switches the row is on.
        Inputs inputs;
        for (const LookInput& input : row.inputs) inputs[input.name] = input.initial;
        if (row.when) inputs.try_emplace(row.when, Vec3f(0.4f)).first->second = Vec3f(0.4f);
        const auto& own = formulas().find(look.types.front());
        for (size_t changed = 0; changed <= row.inputs.size(); ++changed) {
          if (changed > 0) {
            const bool is_color = row.inputs[changed - 1].initial != Vec3f(0) && changed % 2 == 0;
            const float v = 0.3f + 0.05f * float(changed);
            inputs[row.inputs[changed - 1].name] = is_color ? Vec3f(v, v / 2, v / 4) : Vec3f(v);
          }
          Vec3f expected(1);
          const auto named = own != formulas().end() ? own->second.find(row.target) : Named::const_iterator();
          if (own != formulas().end() && named != own->second.end())
            expected = named->second(inputs);
          else
            for (const LookInput& input : row.inputs) expected *= inputs.at(input.name);
          // As a number has it.
          if (!find_material_parameter(row.target)->is_color()) expected = Vec3f(expected.x);
          const Vec3f found = Read(type, inputs).value(row.target);
          for (int i = 0; i < 3; ++i)
            if (std::isfinite(expected[i])) {
              EXPECT_NEAR(found[i], expected[i], 1e-5 * (1 + double(std::abs(expected[i])))) << changed << " changed";
            }
          ++tried;
        }
      }
  EXPECT_GT(tried, 300u);
}

TEST(LookRows, OneInputHasOneDefault) {
  for (const Look& look : look_tables()) {
    Inputs known;
    for (const LookRow& row : look.rows)
      for (const LookInput& input : row.inputs)
        EXPECT_EQ(known.emplace(input.name, input.initial).first->second, input.initial) << input.name;
    for (const ToldInput& told : look.told)
      EXPECT_EQ(known.emplace(told.input.name, told.input.initial).first->second, told.input.initial)
          << told.input.name;
  }
}

TEST(LookRows, AreSilentAtTheDefaultsAndTellWhatCannotBeDrawn) {
  for (const Look& look : look_tables())
    for (const char* type : look.types) {
      EXPECT_TRUE(Read(type, {}).warnings.empty()) << type;
      for (const ToldInput& told : look.told) {
        Inputs inputs{{told.input.name, Vec3f(0.37f)}};
        if (told.when) inputs[told.when] = Vec3f(1);
        const Read read(type, inputs);
        ASSERT_EQ(read.warnings.size(), 1u) << type << " " << told.input.name;
        EXPECT_NE(read.warnings[0].find(told.input.name), std::string::npos) << read.warnings[0];
      }
    }
  EXPECT_EQ(Read("ND_standard_surface_surfaceshader", {{"roughness", Vec3f(0.5f)}}).warnings.size(), 1u) << "no input";
  EXPECT_TRUE(Read("arnold:standard_surface", {{"dielectric_priority", Vec3f(2)}}).warnings.empty());
}

// Joined rows ------------------------------------------------------------------------------------------

struct Names {
  const char *type, *weight, *color, *radius, *scale, *g, *thin, *base, *clear, *tint, *depth, *scatter, *cloud_g;
};
const Names kNames[] = {
    {"ND_standard_surface_surfaceshader", "subsurface", "subsurface_color", "subsurface_radius", "subsurface_scale",
     "subsurface_anisotropy", "thin_walled", "base_color", "transmission", "transmission_color", "transmission_depth",
     "transmission_scatter", "transmission_scatter_anisotropy"},
    {"ND_open_pbr_surface_surfaceshader", "subsurface_weight", "subsurface_color", "subsurface_radius_scale",
     "subsurface_radius", "subsurface_scatter_anisotropy", "geometry_thin_walled", "base_color", "transmission_weight",
     "transmission_color", "transmission_depth", "transmission_scatter", "transmission_scatter_anisotropy"}};

void expect_near(const Vec3f& found, const Vec3f& expected, double within = 1e-5) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(found[i], expected[i], within * (1 + double(expected[i])));
}

TEST(LookJoins, SubsurfaceHasItsAnisotropy) {
  const Vec3f a(0.8f, 0.6f, 0.3f), r(1, 0.4f, 0.2f);
  for (const Names& n : kNames) {
    SCOPED_TRACE(n.type);
    const Read read(n.type,
                    {{n.weight, Vec3f(1)}, {n.color, a}, {n.radius, r}, {n.scale, Vec3f(0.5f)}, {n.g, Vec3f(0.4f)}});
    EXPECT_TRUE(read.warnings.empty());
    expect_near(read.value("scatterAnisotropy"), Vec3f(0.4f));
  }
}

TEST(LookJoins, TheBaseOfAMixtureKeepsItsColour) {
  for (const Names& n : kNames) {
    const Read read(
        n.type, {{n.weight, Vec3f(0.25f)}, {n.color, Vec3f(1, 0, 0)}, {n.base, Vec3f(0, 0, 1)}, {n.radius, Vec3f(1)}});
    EXPECT_TRUE(read.warnings.empty());
    expect_near(read.value("baseColor"), Vec3f(0, 0, 1));
  }
}

// Lambert's reflection and transmission of both parts, added by their weights.
TEST(LookJoins, AThinSheetReflectsAndPassesBothPartsByTheirWeights) {
  const Vec3f a(0.8f, 0.6f, 0.3f), base(0.2f, 0.5f, 0.9f);
  for (const Names& n : kNames)
    for (const float w : {0.3f, 1.0f})
      for (const float g : {-0.5f, 0.0f, 0.6f}) {
        const Read read(n.type,
                        {{n.weight, Vec3f(w)}, {n.color, a}, {n.base, base}, {n.g, Vec3f(g)}, {n.thin, Vec3f(1)}});
        EXPECT_TRUE(read.warnings.empty());
        EXPECT_TRUE(read.value("thin").x == 1);
        EXPECT_EQ(read.value("meanFreePath"), Vec3f(0));
        const float half = read.value("diffTrans").x / 2;
        expect_near(read.value("baseColor") * (1 - half), base * (1 - w) + a * (w * (1 - g) / 2));
        expect_near(read.value("diffTransColor") * half, a * (w * (1 + g) / 2));
      }
}

// MaterialX's graphs: a tint of the light at each crossing, where AlabasterDisney's solids take the square root.
TEST(LookJoins, AClearBodyHasItsColourAtItsDepthOrAtEachCrossing) {
  const Vec3f c(0.9f, 0.5f, 0.2f);
  for (const Names& n : kNames) {
    const Read tint(n.type, {{n.clear, Vec3f(1)}, {n.tint, c}});
    expect_near(tint.value("baseColor"), c * c);
    expect_near(Read(n.type, {{n.clear, Vec3f(1)}, {n.tint, c}, {n.thin, Vec3f(1)}}).value("baseColor"), c);
    const Read body(n.type, {{n.clear, Vec3f(1)}, {n.tint, c}, {n.depth, Vec3f(2)}});
    expect_near(body.value("attenuationColor"), c);
    EXPECT_EQ(body.value("attenuationDistance").x, 2);
    expect_near(body.value("baseColor"), Vec3f(1));
    const Read covered(n.type, {{n.clear, Vec3f(1)}, {n.weight, Vec3f(1)}});
    EXPECT_EQ(covered.value("meanFreePath"), Vec3f(0)) << "nothing is below a clear surface";
  }
  const Read disney("ND_disney_principled", {{"specTrans", Vec3f(1)}, {"baseColor", c}});
  expect_near(disney.value("baseColor"), c * c);
}

TEST(LookJoins, APartlyClearSurfaceOfTwoColoursIsTold) {
  for (const Names& n : kNames) {
    Inputs inputs{{n.clear, Vec3f(0.5f)}, {n.base, Vec3f(1, 0, 0)}, {n.tint, Vec3f(0, 1, 0)}, {n.thin, Vec3f(1)}};
    const Read two(n.type, inputs);
    expect_near(two.value("baseColor"), Vec3f(0.5f, 0.5f, 0));
    ASSERT_EQ(two.warnings.size(), 1u);
    EXPECT_NE(two.warnings[0].find("partly clear"), std::string::npos) << two.warnings[0];
    inputs[n.tint] = inputs[n.base];
    EXPECT_TRUE(Read(n.type, inputs).warnings.empty());
  }
}

// The medium that the walk makes of both is the one that was asked for.
TEST(LookJoins, ACloudyBodyHasTheExtinctionAndTheScatteringAskedFor) {
  const Vec3f c(0.9f, 0.5f, 0.2f);
  for (const Names& n : kNames)
    for (const Vec3f& scatter : {Vec3f(0.1f, 0.2f, 0.3f), Vec3f(1, 0.8f, 0.9f)})
      for (const float g : {0.0f, 0.5f}) {
        SCOPED_TRACE(std::string(n.type) + " " + std::to_string(scatter.x) + " " + std::to_string(g));
        const Read read(
            n.type,
            {{n.clear, Vec3f(1)}, {n.tint, c}, {n.depth, Vec3f(2)}, {n.scatter, scatter}, {n.cloud_g, Vec3f(g)}});
        const Vec3f a = read.value("subsurfaceColor"), path = read.value("meanFreePath");
        expect_near(read.value("baseColor"), Vec3f(1));
        double least = 0;
        for (int i = 0; i < 3; ++i) least = std::min(least, (-std::log(double(c[i])) - double(scatter[i])) / 2);
        for (int i = 0; i < 3; ++i) {
          const double total = -std::log(double(c[i])) / 2 - least;
          const double alpha = 1 - one_minus_alpha(double(a[i]), AlbedoInversion::exact, double(g));
          EXPECT_NEAR(1 / double(path[i]), total, 1e-4 * total);
          EXPECT_NEAR(alpha / double(path[i]), double(scatter[i]) / 2, 2e-4);
        }
      }
}

// KHR_materials_scatter on a sheet: transmission x mix(clear sheet, scatter, strength) over the base.
TEST(LookJoins, AScatteringGltfSheetIsAMixture) {
  const Vec3f a(0.8f, 0.6f, 0.3f), base(0.2f, 0.5f, 0.9f);
  for (const float t : {0.5f, 1.0f})
    for (const float s : {0.4f, 1.0f}) {
      const float g = 0.3f;
      const Read read("ND_gltf_pbr_surfaceshader", {{"transmission", Vec3f(t)},
                                                    {"scatter_strength", Vec3f(s)},
                                                    {"multiscatter_color", a},
                                                    {"scatter_anisotropy", Vec3f(g)},
                                                    {"base_color", base},
                                                    {"metallic", Vec3f(0)}});
      EXPECT_TRUE(read.warnings.empty());
      EXPECT_EQ(read.value("thin").x, 1);
      const float clear = read.value("specTrans").x, half = read.value("diffTrans").x / 2;
      EXPECT_NEAR(clear, t * (1 - s), 1e-6);
      expect_near(read.value("baseColor") * ((1 - half) * (1 - clear)), base * (1 - t) + a * (t * s * (1 - g) / 2));
      expect_near(read.value("diffTransColor") * (half * (1 - clear)), a * (t * s * (1 + g) / 2));
    }
}

}  // namespace
}  // namespace alabaster::hd::looks
