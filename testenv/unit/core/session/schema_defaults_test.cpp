// schemas/ and the structs of core agree on names, defaults and ranges.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "core/camera/camera.h"
#include "core/light/light.h"
#include "core/material/disney_parameters.h"
#include "core/session/render_settings.h"

namespace alabaster {
namespace {

using nlohmann::json;

json properties_of(const std::string& schema) {
  std::ifstream file(std::string(ALABASTER_SOURCE_DIR) + "/schemas/" + schema + ".json");
  return json::parse(file).at("properties");
}

std::vector<std::string> names_of(const json& properties) {
  std::vector<std::string> names;
  for (const auto& [name, parameter] : properties.items()) names.push_back(name);
  return names;
}

// A parameter of DisneyParameters by its schema name: one float or three.
std::map<std::string, std::vector<float*>> disney_fields(DisneyParameters* p) {
  const auto rgb = [](Rgb* c) { return std::vector<float*>{&(*c)[0], &(*c)[1], &(*c)[2]}; };
  return {{"baseColor", rgb(&p->base_color)},
          {"metallic", {&p->metallic}},
          {"roughness", {&p->roughness}},
          {"anisotropic", {&p->anisotropic}},
          {"specularTint", {&p->specular_tint}},
          {"ior", {&p->ior}},
          {"specular", {&p->specular}},
          {"specularColor", rgb(&p->specular_color)},
          {"sheen", {&p->sheen}},
          {"sheenTint", {&p->sheen_tint}},
          {"clearcoat", {&p->clearcoat}},
          {"clearcoatGloss", {&p->clearcoat_gloss}},
          {"scatterDistance", rgb(&p->scatter_distance)},
          {"scatterAnisotropy", {&p->scatter_anisotropy}},
          {"emission", rgb(&p->emission)}};
}

// minimum or maximum of a parameter, looked up in the list's items and in the alternatives of a textured one.
std::optional<float> bound(const json& parameter, const char* which) {
  if (parameter.contains(which)) return parameter[which].get<float>();
  if (parameter.contains("items")) return bound(parameter["items"], which);
  if (parameter.contains("anyOf")) return bound(parameter["anyOf"][0], which);
  return std::nullopt;
}

TEST(SchemaDefaults, DisneyMaterialHasTheStructsDefaults) {
  const json properties = properties_of("disney_material");
  DisneyParameters parameters;
  const auto fields = disney_fields(&parameters);
  EXPECT_EQ(names_of(properties).size(), fields.size());
  for (const auto& [name, floats] : fields) {
    ASSERT_TRUE(properties.contains(name)) << name;
    const json& value = properties[name]["default"];
    for (size_t i = 0; i < floats.size(); ++i)
      EXPECT_EQ(*floats[i], (value.is_array() ? value[i] : value).get<float>()) << name;
    EXPECT_FALSE(properties[name].value("description", "").empty()) << name;
    EXPECT_TRUE(properties[name].contains("unit")) << name;
  }
}

TEST(SchemaDefaults, DisneyMaterialIsClampedToTheSchemasRanges) {
  const json properties = properties_of("disney_material");
  for (const auto& [name, parameter] : properties.items()) {
    for (const char* which : {"minimum", "maximum"}) {
      const std::optional<float> limit = bound(parameter, which);
      if (!limit) continue;
      const float beyond = std::string(which) == "minimum" ? *limit - 1 : *limit + 1;
      DisneyParameters given;
      const auto given_fields = disney_fields(&given);
      for (float* f : given_fields.at(name)) *f = beyond;
      DisneyParameters clamped = clamp_to_ranges(given);
      const auto clamped_fields = disney_fields(&clamped);
      for (const float* f : clamped_fields.at(name)) EXPECT_FLOAT_EQ(*f, *limit) << name << " " << which;
    }
  }
}

TEST(SchemaDefaults, RenderSettingsHaveTheStructsDefaults) {
  const json p = properties_of("render_settings");
  const RenderSettings s;
  EXPECT_EQ(p["samples"]["default"], s.samples);
  EXPECT_EQ(p["targetError"]["default"], s.target_error);
  EXPECT_EQ(p["adaptive"]["default"], s.adaptive);
  EXPECT_EQ(p["timeLimit"]["default"], s.time_limit);
  EXPECT_EQ(p["seed"]["default"], s.seed);
  EXPECT_EQ(p["frame"]["default"], s.frame);
  EXPECT_EQ(p["maxDepth"]["default"], s.max_depth);
  EXPECT_EQ(p["rouletteDepth"]["default"], s.roulette_depth);
  EXPECT_EQ(p["threads"]["default"], s.threads);
  // Enumerations are listed in the order of the enum.
  const auto choice = [&](const char* name) {
    const json& list = p[name]["enum"];
    return std::find(list.begin(), list.end(), p[name]["default"]) - list.begin();
  };
  EXPECT_EQ(choice("subsurface"), static_cast<int>(s.subsurface));
  EXPECT_EQ(p["inversion"]["default"], s.inversion == AlbedoInversion::exact ? "exact" : "?");
  EXPECT_EQ(choice("walkWeights"), static_cast<int>(s.walk_weights));
  EXPECT_EQ(p["walkGuiding"]["default"], s.walk_guiding);
  EXPECT_EQ(p["walkSphereSteps"]["default"], s.walk_sphere_steps);
  EXPECT_EQ(choice("filter"), static_cast<int>(s.filter));
  EXPECT_EQ(p.size(), 15u);
}

TEST(SchemaDefaults, LightsHaveTheStructsDefaults) {
  const json p = properties_of("lights");
  const LightDescription d;
  EXPECT_EQ(p["intensity"]["default"], d.intensity);
  EXPECT_EQ(p["exposure"]["default"], d.exposure);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(p["color"]["default"][static_cast<size_t>(i)].get<float>(), d.color[i]);
  EXPECT_EQ(p["normalize"]["default"], d.normalize);
  EXPECT_EQ(p["width"]["default"], d.width);
  EXPECT_EQ(p["height"]["default"], d.height);
  EXPECT_EQ(p["radius"]["default"], d.radius);
  EXPECT_EQ(p["treatAsPoint"]["default"], d.treat_as_point);
  EXPECT_EQ(p["angle"]["default"].get<float>(), d.angle);
  EXPECT_EQ(p["coneInner"]["default"], d.cone_inner);
  EXPECT_EQ(p["coneOuter"]["default"], d.cone_outer);
  EXPECT_EQ(p["visibleToCamera"]["default"], d.visible_to_camera);
  EXPECT_EQ(p["texture:file"]["default"], "");
  EXPECT_EQ(p.size(), 13u);
}

TEST(SchemaDefaults, CameraHasTheStructsDefaults) {
  const json p = properties_of("camera");
  const CameraParameters c;
  EXPECT_EQ(p["projection"]["default"], c.orthographic ? "orthographic" : "perspective");
  EXPECT_EQ(p["focalLength"]["default"], c.focal_length);
  EXPECT_EQ(p["horizontalAperture"]["default"], c.horizontal_aperture);
  EXPECT_EQ(p["verticalAperture"]["default"], c.vertical_aperture);
  EXPECT_EQ(p["horizontalApertureOffset"]["default"], c.horizontal_aperture_offset);
  EXPECT_EQ(p["verticalApertureOffset"]["default"], c.vertical_aperture_offset);
  EXPECT_EQ(p["fStop"]["default"], c.f_stop);
  EXPECT_EQ(p["focusDistance"]["default"], c.focus_distance);
  EXPECT_EQ(p["clippingRange"]["default"][0], c.clip_near);
  EXPECT_EQ(p["clippingRange"]["default"][1], c.clip_far);
  EXPECT_EQ(p.size(), 9u);
}

}  // namespace
}  // namespace alabaster
