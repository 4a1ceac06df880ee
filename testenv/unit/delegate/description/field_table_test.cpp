// One table, made from the rows of all fields: each arrives through every interface, and what a row refuses is told in
// one sentence by all of them.
#include "delegate/c_api/alabaster.h"
#include "testenv/unit/delegate/description/scene_fixture.h"
#include "testenv/unit/delegate/host/row_values.h"

namespace alabaster::hd::description {
namespace {

using host::FieldRow;
using nlohmann::json;

/// A kind of prims, and where a description and --set name its fields.
struct Part {
  const char *kind, *list, *path, *place, *prefix;  // of its fields by name
};
constexpr Part kParts[] = {{"material", "materials", "/materials/made", "materials/made.", "surface."},
                           {"light", "lights", "/lights/made", "lights/made.", ""},
                           {"camera", "camera", "/camera", "camera.", ""},
                           {"renderSettings", "settings", "/render", "", ""},
                           {"mesh", "meshes", "/gltf/patch/nodes", "meshes/patch.", ""}};

/// Those of a description's keys that are fields of the prims.
std::vector<FieldRow> rows_of(const Part& part) {
  std::vector<FieldRow> all = host::ParameterRows(std::string(part.kind) == "material" ? "disney_material"
                                                  : std::string(part.kind) == "light"  ? "lights"
                                                  : std::string(part.kind) == "mesh"   ? "mesh"
                                                  : std::string(part.kind) == "camera" ? "camera"
                                                                                       : "render_settings");
  std::erase_if(all, [](const FieldRow& row) { return row.name == "frame"; });  // a field of the prim, too
  const std::vector<FieldRow> keys = DescriptionKeys(part.list);
  for (const FieldRow& field : host::FieldRows(part.kind))
    for (const FieldRow& key : keys)
      if (key.name == field.name && key.text == field.text && key.name != "crop") all.push_back(field);
  return all;
}

class FieldTable : public SceneFiles {
 protected:
  FieldTable() { EXPECT_EQ(api().scene_create(nullptr, nullptr, &c_scene_), ALABASTER_OK); }
  ~FieldTable() override { api().scene_destroy(c_scene_); }
  static const AlabasterApi& api() { return *alabaster_api(ALABASTER_API_VERSION); }

  static std::string type_of(const Part& part, const FieldRow& row) {
    if (std::string(part.kind) != "light") return part.kind;
    return row.lights.empty() ? "rectLight" : row.lights[0];
  }
  /// A description that gives these fields.
  static json document(const Part& part, const FieldRow& row, const json& fields) {
    json all{{"models", {{{"file", "patch.gltf"}}}}}, entry = fields;
    const std::string kind = part.kind;
    if (kind == "material") entry = {{"name", "made"}, {"set", fields}};
    if (kind == "light") entry["name"] = "made", entry["type"] = type_of(part, row);
    if (kind == "mesh") entry["match"] = "patch";
    if (kind == "camera") entry["transform"] = json::object(), entry.emplace("shutterClose", 1);
    all[part.list] = kind == "camera" || kind == "renderSettings" ? entry : json::array({entry});
    return all;
  }
  /// The field of the loaded scene.
  Value loaded(const Part& part, const FieldRow& row) {
    for (const auto& [path, prim] : scene.GetPrims())
      if (host::KindOf(prim) == part.kind && path.str().starts_with(part.path))
        for (const auto& [name, value] : host::GetFields(path, prim))
          if (name == part.prefix + row.name || name == "primvars:" + row.name) return value;
    return {};
  }
  void forget() {
    while (!scene.GetPrims().empty()) scene.Remove(Path(scene.GetPrims().begin()->first));
  }
  void expect_arrived(const Part& part, const FieldRow& row, const Value& given) {
    EXPECT_EQ(errors(), "");
    const Value value = loaded(part, row);
    constexpr double kNone = -1e30;
    if (const double number = given.number_or(kNone); number != kNone)
      EXPECT_FLOAT_EQ(float(value.number_or(kNone)), float(number * (row.in_millimetres ? 0.001 : 1)));
    else if (row.name.ends_with("file"))
      EXPECT_TRUE(value.text_or("").ends_with("/a.hdr"));
    else
      EXPECT_EQ(value.text_or(value.to_string()), given.text_or(given.to_string()));
    forget();
  }

  /// What C++ and C say of an edit of the prim; "": it is done.
  std::vector<std::string> edit_faults(const Part& part, const FieldRow& row, const std::string& field,
                                       const Value& value) {
    host::RetainedSceneDelegate own;
    host::Fields plain;
    if (std::string(part.kind) == "material") plain = {{"surface.type", Token("AlabasterDisney")}};
    EXPECT_EQ(host::SetPrim(&own, "/it", Token(type_of(part, row)), plain).fault, "");
    const std::string text = value.text_or("");
    const void* data = text.empty() ? value.data() : text.c_str();
    const AlabasterParameter surface{"surface.type",
                                     {ALABASTER_TOKEN, ALABASTER_SCALAR, "AlabasterDisney", 1, nullptr, nullptr}};
    const AlabasterParameter given{
        field.c_str(),
        {text.empty() ? value.type() : ALABASTER_STRING, value.is_array() ? ALABASTER_ARRAY : ALABASTER_SCALAR, data,
         value.count(), nullptr, nullptr}};
    EXPECT_EQ(api().scene_set(c_scene_, "/it", type_of(part, row).c_str(), &surface, plain.size()), ALABASTER_OK);
    const bool is_done = api().scene_edit(c_scene_, "/it", &given, 1) == ALABASTER_OK;
    return {host::EditPrim(&own, "/it", {{field, value}}).fault, is_done ? "" : api().last_error()};
  }

  AlabasterScene* c_scene_ = nullptr;
};

TEST_F(FieldTable, EachFieldArrivesThroughEachInterface) {
  write_image("a.hdr");
  for (const Part& part : kParts)
    for (const FieldRow& row : rows_of(part)) {
      SCOPED_TRACE(std::string(part.kind) + " " + row.name);
      const Value value = host::good_value(row);
      const json given = support::json_of(value);
      EXPECT_EQ(host::CheckField(part.kind, row.name, value), "");
      describe(document(part, row, {{row.name, given}}).dump());
      expect_arrived(part, row, value);
      const std::string file = folder_ / "a.hdr";
      const std::string text = row.name.ends_with("file") ? file : given.is_string() ? value.text_or("") : given.dump();
      describe(document(part, row, json::object()).dump(), with_overrides({part.place + row.name + "=" + text}));
      expect_arrived(part, row, value);
      for (const std::string& fault : edit_faults(part, row, part.prefix + row.name, value)) EXPECT_EQ(fault, "");
    }
}

TEST_F(FieldTable, WhatARowRefusesIsToldInOneSentence) {
  for (const Part& part : kParts)
    for (const FieldRow& row : rows_of(part))
      for (const auto& [wrong, is_out_of_range] : host::wrong_values(row)) {
        SCOPED_TRACE(std::string(part.kind) + " " + row.name + " " + wrong.dump());
        const Value value = support::value_of(wrong);
        std::string says = host::CheckField(part.kind, row.name, value);
        EXPECT_TRUE(says.starts_with("'" + row.name + "' must be ")) << says;
        EXPECT_FALSE(describe(document(part, row, {{row.name, wrong}}).dump()).ok);
        EXPECT_NE(errors().find("scene.json:1 /"), std::string::npos) << errors();
        EXPECT_NE(errors().find("/" + row.name + ": " + says), std::string::npos) << errors() << says;
        const std::string option = part.place + row.name + "=" + wrong.dump();
        EXPECT_EQ(describe(document(part, row, json::object()).dump(), with_overrides({option})).cause,
                  LoadCause::option);
        EXPECT_NE(errors().find(option + ": " + says), std::string::npos) << errors();
        says.insert(1, part.prefix);
        if (is_out_of_range && std::string(part.kind) != "renderSettings" && row.type.type != ALABASTER_INT) continue;
        for (const std::string& fault : edit_faults(part, row, part.prefix + row.name, value))
          EXPECT_NE(fault.find(says), std::string::npos) << fault;
      }
}

TEST_F(FieldTable, AMisspeltNameGetsTheNearest) {
  for (const Part& part : kParts)
    for (const FieldRow& row : rows_of(part)) {
      SCOPED_TRACE(std::string(part.kind) + " " + row.name);
      const std::string name = row.name + "x", near = "id you mean '" + row.name + "'?";
      EXPECT_FALSE(describe(document(part, row, {{name, 1}}).dump()).ok);
      EXPECT_NE(errors().find("/" + name + ": Unknown key '" + name + "'. D" + near), std::string::npos) << errors();
      EXPECT_FALSE(describe(document(part, row, json::object()).dump(), with_overrides({part.place + name + "=1"})).ok);
      EXPECT_NE(errors().find("=1: Unknown key '" + name + "'. D" + near), std::string::npos) << errors();
      for (const std::string& fault : edit_faults(part, row, part.prefix + name, 1.0f))
        EXPECT_NE(fault.find("d" + near), std::string::npos) << fault;
    }
}

}  // namespace
}  // namespace alabaster::hd::description
