// A scene is the same scene through every way in: named fields of C++ and of C, archives, glTF, descriptions and --set.
#include "delegate/archive/archive.h"
#include "delegate/description/render_description.h"
#include "delegate/support/json_values.h"
#include "testenv/support/gltf_testing.h"
#include "testenv/unit/delegate/doors/doors.h"
#include "testenv/unit/delegate/doors/random_scene.h"
#include "testenv/unit/delegate/gltf/gltf_builder.h"

namespace alabaster::hd::doors {
namespace {

using nlohmann::json;

class SameScene : public ::testing::TestWithParam<unsigned> {
 protected:
  std::string file(const std::string& name) const { return folder_.path() + "/" + name; }

  /// A scene with a prim of every kind, and most of its fields.
  host::Prims random_prims() {
    CppDoor door;
    for (const Path& path : kPaths) {
      Fields fields = RandomScene::base_of(path);
      for (auto& field : random_.fields_of(path))
        if (field.first != "categories:near") fields.push_back(std::move(field));
      EXPECT_EQ(door.set(path, random_.kind_of(path), fields), "") << path.str();
    }
    return door.prims();
  }

  /// What the program draws of a file.
  void load(const std::string& name, CppDoor* door, const description::LoadOptions& options = {}) {
    const auto sink = [&](const Diagnostic& d) { EXPECT_NE(d.severity, Severity::error) << d.where << ": " << d.text; };
    ASSERT_TRUE(LoadScene(name, &door->stage.scene, sink, options).ok);
  }
  static void expect_same(Door* door, Door* reference, const std::string& what) {
    EXPECT_EQ(door->dump(), reference->dump()) << what;
    EXPECT_EQ(door->picture(), reference->picture()) << what;
  }
  /// The prims, through all doors that take any.
  void expect_same_through_all(const host::Prims& prims) {
    CppDoor whole, fields, archived, loaded;
    CDoor c, c_loaded;
    for (const auto& [path, prim] : prims) whole.stage.scene.Set(path, prim);
    ASSERT_NO_FATAL_FAILURE(fields.set_all(prims));
    ASSERT_NO_FATAL_FAILURE(c.set_all(prims));
    EXPECT_TRUE(fields.prims() == prims);
    ASSERT_EQ(archive::WriteArchive(file("all.alab"), prims), "");
    ASSERT_TRUE(archive::ReadArchive(file("all.alab"), &archived.stage.scene, {}).ok);
    EXPECT_TRUE(archived.prims() == prims);
    ASSERT_NO_FATAL_FAILURE(load(file("all.alab"), &loaded));
    ASSERT_EQ(CDoor::api().scene_load(c_loaded.scene, file("all.alab").c_str(), nullptr, nullptr), ALABASTER_OK);
    expect_same(&fields, &whole, "fields of C++");
    expect_same(&c, &whole, "fields of C");
    expect_same(&archived, &whole, "an archive");
    expect_same(&loaded, &whole, "a scene file");
    expect_same(&c_loaded, &whole, "a scene file, of C");
  }

  const gltf::testing::TemporaryFolder folder_;
  RandomScene random_{GetParam()};
};

TEST_P(SameScene, AnyPrimIsTheSameThroughFieldsAndArchives) {
  expect_same_through_all(random_prims());
}

/// What a description says of a prim with these fields, `prefix` before their names.
json entry_of(const Fields& fields, const std::string& prefix, const std::vector<FieldRow>& rows) {
  json entry = json::object();
  for (const auto& [name, value] : fields)
    for (const FieldRow& row : rows)
      if (prefix + row.name == name) entry[row.name] = support::json_of(value);
  return entry;
}
std::vector<FieldRow> mesh_rows() {
  std::vector<FieldRow> rows = host::ParameterRows("mesh");
  for (const FieldRow& row : host::FieldRows("mesh"))
    for (const char* name : {"scheme", "refineLevel", "interpolateBoundary", "faceVaryingLinearInterpolation"})
      if (row.name == name) rows.push_back(row);
  return rows;
}

/// What a description, and --set, can say of a prim of the scene.
struct Part {
  const char *list, *path, *prefix;
  std::vector<FieldRow> rows;
};
std::vector<Part> parts() {
  return {{"materials", "/wax", "surface.", host::ParameterRows("disney_material")},
          {"meshes", "/body", "", mesh_rows()},
          {"lights", "/key", "", host::ParameterRows("lights")},
          {"camera", "/camera", "", host::ParameterRows("camera")}};
}

TEST_P(SameScene, ADescriptionAndOptionsMakeTheEditsOfAHost) {
  CppDoor plain, host;
  for (const Path& path : kPaths)
    ASSERT_EQ(plain.set(path, random_.kind_of(path), RandomScene::base_of(path)), "") << path.str();
  ASSERT_EQ(plain.edit("/body", {{"material", Path("/wax")}}), "");
  ASSERT_EQ(archive::WriteArchive(file("plain.alab"), plain.prims()), "");
  ASSERT_NO_FATAL_FAILURE(host.set_all(plain.prims()));
  json document{{"models", {{{"file", "plain.alab"}}}}};
  std::vector<std::string> arrived;  // in the renderer
  description::LoadOptions options;
  options.camera = "/camera";
  for (const Part& part : parts()) {
    const std::string list = part.list;
    const Token type = TypeOf(plain.prims().at(part.path));
    json entry = json::object();
    for (const FieldRow& row : part.rows) {
      const bool has = row.lights.empty() || std::count(row.lights.begin(), row.lights.end(), type.str()) > 0;
      Value value = has && random_.chance(0.7) ? random_.value_of(row) : Value();
      if (value.empty() || value.text_or("") == "loop") continue;  // the cube has quadrangles
      json given = support::json_of(value);
      const std::string place = list == "camera" ? "camera." : list + "/" + part.path + ".";
      options.overrides.emplace_back(place + row.name + "=" + (given.is_string() ? value.text_or("") : given.dump()));
      entry[row.name] = given;
      if (row.in_millimetres) value = float(value.number_or(0)) * 0.001f;
      ASSERT_EQ(host.edit(part.path, {{part.prefix + row.name, value}}), "") << row.name;
      const auto fields = host::FieldRows("mesh");
      const auto is_row = [&](const FieldRow& field) { return field.name == row.name; };
      if (std::none_of(fields.begin(), fields.end(), is_row) && value.to_string() != row.fallback.to_string())
        arrived.push_back("\n  " + row.name + " " + value.to_string() + "\n");
    }
    if (list == "materials") entry = {{"match", part.path}, {"set", entry}};
    if (list == "meshes" || list == "lights") entry["match"] = part.path;
    if (list == "camera") entry["use"] = part.path;
    document[list] = list == "camera" ? entry : json::array({entry});
  }
  const std::string dump = std::regex_replace(host.dump(), std::regex("\""), "");         // of words
  const bool is_transparent = dump.find("opacityMode transparent") != std::string::npos;  // its specTrans follows
  for (const std::string& line : arrived) {
    const bool follows = is_transparent && line.starts_with("\n  specTrans ");
    EXPECT_TRUE(follows || dump.find(line) != std::string::npos) << line << dump;
  }
  CppDoor described, set;
  ASSERT_NO_FATAL_FAILURE(load(folder_.write("scene.json", document.dump()), &described));
  ASSERT_NO_FATAL_FAILURE(load(file("plain.alab"), &set, options));
  expect_same(&described, &host, "a description: " + document.dump());
  expect_same(&set, &host, "--set");
}

/// A scene of each kind that glTF has. `random` null: its materials and lights are all defaults.
std::string gltf_scene(RandomScene* random) {
  const auto number = [&](float otherwise, float low, float high) {
    return random ? random->number(low, high) : otherwise;
  };
  const auto color = [&](float otherwise) {
    return json{number(otherwise, 0, 1), number(otherwise, 0, 1), number(otherwise, 0, 1)};
  };
  gltf::testing::GltfBuilder b;
  b.triangle();
  b.primitive()["material"] = 0;
  b.json["extensionsUsed"] = {"KHR_lights_punctual", "KHR_materials_ior", "KHR_materials_clearcoat"};
  json base = color(1), coat{{"clearcoatFactor", number(0, 0, 1)}, {"clearcoatRoughnessFactor", number(0, 0, 1)}};
  base.push_back(1);
  json& wax = b.json["materials"][0] = {{"name", "wax"}, {"emissiveFactor", color(0)}};
  wax["pbrMetallicRoughness"] = {
      {"baseColorFactor", base}, {"metallicFactor", number(1, 0, 1)}, {"roughnessFactor", number(1, 0, 1)}};
  wax["extensions"] = {{"KHR_materials_ior", {{"ior", number(1.5f, 1.2f, 1.9f)}}}, {"KHR_materials_clearcoat", coat}};
  b.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}}}};
  b.json["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"name", "lamp"}, {"type", "point"}, {"color", color(1)}, {"intensity", number(1, 1, 50)}}};
  b.json["nodes"] = {{{"name", "body"}, {"mesh", 0}},
                     {{"name", "eye"}, {"camera", 0}, {"translation", {0.3, 0.3, 4}}},
                     {{"name", "lamp"},
                      {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}},
                      {"translation", {number(0, -1, 1), 0, 3}}}};
  b.json["scenes"][0]["nodes"] = {0, 1, 2};
  return b.bytes();
}

TEST_P(SameScene, WhatGltfSaysIsWhatEditsOfAnotherOneSay) {
  CppDoor read, edited;
  for (const char* folder : {"random", "plain"}) std::filesystem::create_directory(file(folder));
  folder_.write("random/scene.glb", gltf_scene(&random_));
  folder_.write("plain/scene.glb", gltf_scene(nullptr));
  json document{{"models", {{{"file", "scene.glb"}}}}, {"camera", {{"use", "eye"}, {"fStop", 8}}}};  // "/camera"
  ASSERT_NO_FATAL_FAILURE(load(folder_.write("random/scene.json", document.dump()), &read));
  for (const auto& [path, prim] : read.prims()) {
    const Fields fields = GetFields(path, prim);
    if (host::KindOf(prim) == "material") {
      const json all = entry_of(fields, "surface.", host::ParameterRows("disney_material"));
      document["materials"].push_back({{"match", "wax"}, {"replace", all}});
    }
    if (const auto* light = std::get_if<host::LightDescription>(&prim)) {
      json entry = entry_of(fields, "", host::ParameterRows("lights"));
      entry["match"] = "lamp", entry["transform"] = support::json_of(light->transform);
      document["lights"].push_back(std::move(entry));
    }
  }
  ASSERT_NO_FATAL_FAILURE(load(folder_.write("plain/scene.json", document.dump()), &edited));
  expect_same(&edited, &read, document.dump());
  expect_same_through_all(read.prims());
}

INSTANTIATE_TEST_SUITE_P(Seeds, SameScene, ::testing::Range(0u, 3u));

}  // namespace
}  // namespace alabaster::hd::doors
