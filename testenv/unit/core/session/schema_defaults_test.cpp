// schemas/ and the structs of core agree on names, defaults and ranges.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "core/camera/camera.h"
#include "core/light/light.h"
#include "core/material/disney_material.h"
#include "core/session/render_settings.h"
#include "testenv/support/build_paths.h"

namespace alabaster {
namespace {

using nlohmann::json;

json properties_of(const std::string& schema) {
  std::ifstream file(testing::source_file("schemas/") + schema + ".json");
  return json::parse(file).at("properties");
}

// A parameter's minimum or maximum: that of a list's items, and of the first alternative of a textured one.
std::optional<double> bound(const json& parameter, const char* which) {
  if (parameter.contains(which)) return parameter[which].get<double>();
  if (parameter.contains("items")) return bound(parameter["items"], which);
  if (parameter.contains("anyOf")) return bound(parameter["anyOf"][0], which);
  return std::nullopt;
}

json to_json(const Rgb& c) {
  return {c.r, c.g, c.b};
}
template <class T>
json to_json(const T& value) {
  return value;
}

// The schema's numbers as floats, which they become.
json as_floats(json value) {
  if (value.is_array())
    for (json& item : value) item = as_floats(item);
  return value.is_number_float() ? json(value.get<float>()) : value;
}

// Every row of a table is in the schema, with the struct's default, the row's range and a sentence.
template <class Row, class T>
void expect_schema(const json& properties, const Row& row, const T& defaults) {
  SCOPED_TRACE(row.name);
  ASSERT_TRUE(properties.contains(row.name));
  const json& property = properties[row.name];
  EXPECT_FALSE(property.value("description", "").empty());
  EXPECT_TRUE(property.contains("unit"));
  std::visit(
      [&](auto member) {
        using Member = std::decay_t<decltype(defaults.*member)>;
        if constexpr (std::is_enum_v<Member>) {
          std::vector<std::string> words;
          for (const char* word : row.words)
            if (word) words.emplace_back(word);
          EXPECT_EQ(property["enum"], json(words));
          EXPECT_EQ(property["default"], words.at(static_cast<size_t>(defaults.*member)));
        } else {
          EXPECT_EQ(as_floats(property["default"]), to_json(defaults.*member));
          if constexpr (std::is_same_v<Member, bool>) return;
          if (property.contains("exclusiveMinimum"))
            EXPECT_GT(row.minimum, property["exclusiveMinimum"].get<double>());
          else
            EXPECT_EQ(bound(property, "minimum").value_or(-kUnbounded), row.minimum);
          EXPECT_EQ(bound(property, "maximum").value_or(kUnbounded), row.maximum);
        }
      },
      row.member);
}

TEST(SchemaDefaults, DisneyMaterialIsItsTable) {
  const json properties = properties_of("disney_material");
  EXPECT_EQ(properties.size(), material_parameters().size());
  for (const MaterialParameter& row : material_parameters()) {
    expect_schema(properties, row, DisneyParameters());
    EXPECT_EQ(row.is_textured(), properties[row.name].contains("anyOf")) << row.name << " may be a texture";
  }
}

TEST(SchemaDefaults, RenderSettingsAreTheirTable) {
  const json properties = properties_of("render_settings");
  for (const SettingParameter& row : setting_parameters()) expect_schema(properties, row, RenderSettings());
  EXPECT_EQ(properties.size(), setting_parameters().size());
}

TEST(SchemaDefaults, LightsAreTheirTable) {
  const json properties = properties_of("lights");
  for (const auto& row : light_parameters()) expect_schema(properties, row, LightDescription());
  EXPECT_EQ(properties["texture:file"]["default"], "");
  EXPECT_EQ(properties["shaping:ies:file"]["default"], "");
  EXPECT_EQ(properties.size(), light_parameters().size() + 2);
}

TEST(SchemaDefaults, CameraIsItsTable) {
  const json properties = properties_of("camera");
  const CameraParameters defaults;
  for (const auto& row : camera_parameters()) expect_schema(properties, row, defaults);
  EXPECT_EQ(properties["projection"]["default"], defaults.orthographic ? "orthographic" : "perspective");
  EXPECT_EQ(properties["clippingRange"]["default"], (json{defaults.clip_near, defaults.clip_far}));
  EXPECT_EQ(properties["clipPlanes"]["default"].size(), defaults.clip_planes.size());
  EXPECT_EQ(properties.size(), camera_parameters().size() + 3);
}

}  // namespace
}  // namespace alabaster
