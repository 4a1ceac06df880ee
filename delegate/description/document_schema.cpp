// The schemas, written from the tables of parameters and of the keys of descriptions.
#include <cmath>
#include <map>

#include "delegate/description/document_keys.h"
#include "delegate/description/lengths.h"
#include "delegate/description/render_description.h"
#include "delegate/support/json_values.h"
#include "delegate/support/presets_text.h"

namespace alabaster::hd::description {
namespace {

using nlohmann::ordered_json;
using Form = Key::Form;

// Tables of parameters ----------------------------------------------------------------------------------
struct Schema {
  const char *name, *title, *text;
};
constexpr Schema kSchemas[] = {
    {"disney_material", "Disney BSDF parameters",
     "Parameters of the surface node AlabasterDisney (Burley 2012, Burley 2015). Values outside a range are clamped by "
     "the renderer and refused in a render description."},
    {"texture_node", "Inputs of AlabasterTexture",
     "An image, the node AlabasterTexture: texel * scale + bias. Outputs are rgb, r, g, b, a, and direction: the turns "
     "of "
     "the vector that red and green hold, for anisotropicRotation."},
    {"displacement_node", "Inputs of AlabasterDisplacement",
     "The node AlabasterDisplacement moves the points of refined meshes by (displacement - midlevel) * scale in the "
     "mesh's object space."},
    {"mesh", "Mesh options",
     "Options of mesh prims: fields of a mesh, and constant primvars of these names of a scene delegate."},
    {"lights", "Light parameters",
     "Parameters of light prims in UsdLux terms: radiance = color * intensity * 2^exposure. appliesTo names the light "
     "types that have a parameter; without it, all have it."},
    {"camera", "Camera parameters",
     "Parameters of the camera prim. The contract takes lens and film sizes in scene units, of which only the ratios "
     "matter to a pinhole. A render description takes them in unitInDescription (millimetres in a scene of metres)."},
    {"render_settings", "Render settings", "Names and meanings of the render delegate's settings."}};

// Whole numbers without a point.
ordered_json number_of(double value) {
  if (value == std::floor(value) && std::abs(value) < 0x1p53) return int64_t(value);
  return support::shortest_decimal(static_cast<float>(value));
}
ordered_json plain_numbers(const ordered_json& value) {
  if (value.is_number()) return number_of(value.get<double>());
  ordered_json all = value;
  if (value.is_array())
    for (ordered_json& one : all) one = plain_numbers(one);
  return all;
}

ordered_json list_of(const ordered_json& item, size_t count) {
  return {{"type", "array"}, {"items", item}, {"minItems", count}, {"maxItems", count}};
}

/// The type of a value, and its range.
ordered_json type_entry(const host::FieldRow& row) {
  const TypeInfo& info = GetTypeInfo(row.type.type);
  if (!row.words.empty()) return {{"type", "string"}, {"enum", row.words}};
  if (row.type.type == ALABASTER_BOOL) return {{"type", "boolean"}};
  if (info.bytes == 0) return {{"type", "string"}};
  const bool is_whole = info.scalar == Scalar::int32 || info.scalar == Scalar::int64 || info.scalar == Scalar::uint32;
  ordered_json entry = {{"type", is_whole ? "integer" : "number"}};
  if (row.is_above_zero())
    entry["exclusiveMinimum"] = 0;
  else if (row.low != -kInfinite)
    entry["minimum"] = number_of(row.low);
  if (row.high != kInfinite) entry["maximum"] = number_of(row.high);
  if (info.components > 1) entry = list_of(entry, info.components);
  if (row.type.is_array) entry = {{"type", "array"}, {"items", entry}};
  return entry;
}

/// The entry of a row in a schema.
ordered_json row_schema(const host::FieldRow& row) {
  ordered_json entry = type_entry(row);
  const bool is_length = row.unit == "scene unit";
  if (!row.texture.empty() || is_length) entry = {{"anyOf", {entry}}};
  if (!row.texture.empty()) entry["anyOf"].push_back({{"$ref", "textures.json#/definitions/" + row.texture}});
  if (is_length) entry["anyOf"].push_back({{"$ref", "render_description.json#/definitions/length"}});
  if (!row.fallback.empty()) entry["default"] = plain_numbers(support::json_of(row.fallback));
  if (!row.unit.empty()) entry["unit"] = row.unit;
  if (!row.lights.empty()) entry["appliesTo"] = row.lights;
  if (row.in_millimetres) entry["unitInDescription"] = "mm";
  entry["description"] = row.text;
  return entry;
}

/// A line of an object: "name": value, on one line.
std::string line_of(const std::string& indent, const std::string& name, const ordered_json& value, bool last) {
  return indent + ordered_json(name).dump() + ": " + value.dump() + (last ? "\n" : ",\n");
}

std::string table_schema(const Schema& schema) {
  const std::string name = schema.name;
  std::string text = "{\n";
  text += line_of("  ", "$schema", "http://json-schema.org/draft-07/schema#", false);
  text += line_of("  ", "$id", name + ".json", false) + line_of("  ", "title", schema.title, false);
  text += line_of("  ", "description", schema.text, false) + line_of("  ", "type", "object", false);
  text += line_of("  ", "additionalProperties", false, false) + "  \"properties\": {\n";
  ordered_json properties;
  for (const host::FieldRow& row : host::ParameterRows(name)) properties[row.name] = row_schema(row);
  for (auto property = properties.begin(); property != properties.end(); ++property) {
    text += "    \"" + property.key() + "\": {\n";
    for (auto part = property->begin(); part != property->end(); ++part)
      text += line_of("      ", part.key(), *part, std::next(part) == property->end());
    text += std::next(property) == properties.end() ? "    }\n" : "    },\n";
  }
  return text + "  }\n}\n";
}

// Descriptions -------------------------------------------------------------------------------------------
ordered_json schema_of(const Key& key);

ordered_json object_schema(const Key& key) {
  ordered_json schema = {{"type", "object"}, {"additionalProperties", false}};
  if (key.needs.size() == 1) schema["required"] = key.needs[0];
  for (const auto& set : key.needs)
    if (key.needs.size() > 1) schema["anyOf"].push_back({{"required", set}});
  for (const Key& child : key.keys) {
    ordered_json entry = schema_of(child);
    if (!child.reference.empty()) entry = {{"$ref", child.reference}};
    if (child.has_own_text) entry = {{"allOf", {entry}}, {"description", child.row.text}};
    schema["properties"][child.row.name] = std::move(entry);
  }
  return schema;
}

/// Of one value, or one of a list.
ordered_json value_schema(const Key& key) {
  ordered_json schema = row_schema(key.row);
  if (key.row.type.type == ALABASTER_STRING && key.kind.empty() && key.row.fallback.text_or("none") != "")
    schema["minLength"] = 1;
  if (!key.beginning.empty()) {
    schema["anyOf"] = {{{"enum", schema["enum"]}}, {{"pattern", "^" + key.beginning + "."}}};
    schema.erase("enum");
  }
  return schema;
}

ordered_json list_schema(const Key& key) {
  ordered_json item = key.form == Form::objects ? object_schema(key) : value_schema(key), schema = {{"type", "array"}};
  ordered_json words = ordered_json::object();
  for (const char* word : {"default", "unit", "description"})
    if (item.contains(word)) words[word] = item[word], item.erase(word);
  schema["items"] = std::move(item);
  if (key.least > 0) schema["minItems"] = key.least;
  if (key.most != ~size_t(0)) schema["maxItems"] = key.most;
  if (key.row.unit == "scene unit")  // of all of them
    schema = {{"anyOf", {schema, {{"$ref", "render_description.json#/definitions/length"}}}}};
  schema.update(words);
  schema["description"] = key.row.text;
  return schema;
}

ordered_json schema_of(const Key& key) {
  if (key.form == Form::value) return value_schema(key);
  if (key.form == Form::values || key.form == Form::objects) return list_schema(key);
  ordered_json schema = object_schema(key);
  if (key.form == Form::values_or_object) schema = {{"anyOf", {list_schema(key), schema}}};
  schema["description"] = key.row.text;
  return schema;
}

/// As dump(2), but what fits into a line stands on one.
std::string readable(const ordered_json& value, const std::string& indent = "\n") {
  constexpr size_t kMostInLine = 140;
  std::string line = value.dump(-1, ' ');
  if (!value.is_structured() || indent.size() + line.size() < kMostInLine) return line;
  std::string text;
  for (const auto& [key, item] : value.items())
    text += (text.empty() ? "" : ",") + indent + "  " + (value.is_array() ? "" : ordered_json(key).dump() + ": ") +
            readable(item, indent + "  ");
  return (value.is_array() ? "[" : "{") + text + indent + (value.is_array() ? "]" : "}");
}

std::string schema_text(const std::string& name, const std::string& title, const std::string& text,
                        const ordered_json& content) {
  ordered_json schema = {{"$schema", "http://json-schema.org/draft-07/schema#"},
                         {"$id", name + ".json"},
                         {"title", title},
                         {"description", text}};
  schema.update(content);
  return readable(schema) + "\n";
}

const Key& key_at(const Key& key, std::initializer_list<const char*> names) {
  const Key* found = &key;
  for (const char* name : names) found = find_key(found->keys, name);
  return *found;
}

std::string description_schema() {
  const Key& root = description_key();
  ordered_json content = object_schema(root);
  const Key& models = key_at(root, {"models"});
  content["definitions"]["length"] = length_schema();
  for (const Key* shared : {&models, &key_at(models, {"motion"}), &key_at(models, {"transform"})})
    content["definitions"][shared->row.name] = schema_of(*shared);
  return schema_text("render_description", "Render description", root.row.text, content);
}

std::string textures_schema() {
  ordered_json content;
  for (const char* name : {"colorTexture", "distanceTexture", "numberTexture"})
    content["definitions"][name] = schema_of(texture_key(name));
  return schema_text("textures", "Textures of materials",
                     "A texture in the place of a parameter of disney_material.json.", content);
}

}  // namespace

std::vector<host::FieldRow> DescriptionKeys(const std::string& part) {
  const Key* key = find_key(description_key().keys, part);
  if (key && part == "materials") key = find_key(key->keys, "set");
  std::vector<host::FieldRow> rows;
  if (key)
    for (const Key& one : key->keys) rows.push_back(one.row);
  return rows;
}

// They are never destroyed, because threads may load while the process ends.
const char* SchemaText(const std::string& name) {
  static const auto* made = new std::map<std::string, std::string>([] {
    std::map<std::string, std::string> texts;
    for (const Schema& schema : kSchemas) texts[schema.name] = table_schema(schema);
    texts["render_description"] = description_schema();
    texts["textures"] = textures_schema();
    texts["quality_presets"] = support::presets_text();
    return texts;
  }());
  const auto found = made->find(name);
  return found == made->end() ? nullptr : found->second.c_str();
}

}  // namespace alabaster::hd::description
