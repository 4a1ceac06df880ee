#include "delegate/host/schemas.h"

#include <cmath>
#include <sstream>

#include "delegate/host/open_fields.h"
#include "delegate/host/parameter_pages.h"
#include "delegate/host/product_writer.h"
#include "delegate/support/json_values.h"

namespace alabaster::hd::host {
namespace {

using nlohmann::ordered_json;

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

constexpr double kSmallest = 1e-20;  // a minimum below it stands for "above 0"

// Whole numbers without a point.
ordered_json number_of(double value) {
  if (value == std::floor(value) && std::abs(value) < 0x1p53) return int64_t(value);
  return support::shortest_decimal(static_cast<float>(value));
}

void add_range(double low, double high, ordered_json* entry) {
  if (low > 0 && low < kSmallest)
    (*entry)["exclusiveMinimum"] = 0;
  else if (low != -kUnbounded)
    (*entry)["minimum"] = number_of(low);
  if (high != kUnbounded) (*entry)["maximum"] = number_of(high);
}

/// Type and range of a value, and its default.
struct Form {
  ordered_json type, fallback;
};
template <class Row, class T>
Form form_of(const Row& row, const T& defaults) {
  Form form;
  std::visit(
      [&](auto member) {
        using Member = std::decay_t<decltype(defaults.*member)>;
        const Member& value = defaults.*member;
        if constexpr (std::is_same_v<Member, bool>) {
          form.type["type"] = "boolean";
          form.fallback = value;
        } else if constexpr (std::is_enum_v<Member>) {
          form.type["type"] = "string";
          for (const char* word : row.words)
            if (word) form.type["enum"].push_back(word);
          form.fallback = row.words[static_cast<size_t>(value)];
        } else if constexpr (std::is_same_v<Member, Rgb>) {
          ordered_json item = {{"type", "number"}};
          add_range(row.minimum, row.maximum, &item);
          form.type = {{"type", "array"}, {"items", item}, {"minItems", 3}, {"maxItems", 3}};
          form.fallback = {number_of(double(value.r)), number_of(double(value.g)), number_of(double(value.b))};
        } else if constexpr (requires { Member::dimensions(); }) {
          const unsigned count = Member::dimensions();
          form.type = {{"type", "array"}, {"items", {{"type", "number"}}}, {"minItems", count}, {"maxItems", count}};
          for (unsigned i = 0; i < count; ++i) form.fallback.push_back(number_of(double(value[int(i)])));
        } else {
          form.type["type"] = std::is_same_v<Member, float> ? "number" : "integer";
          add_range(row.minimum, row.maximum, &form.type);
          form.fallback = number_of(double(value));
        }
      },
      row.member);
  return form;
}

template <class Row, class T>
ordered_json entry_of(const Row& row, const T& defaults) {
  const Form form = form_of(row, defaults);
  ordered_json entry = form.type;
  if constexpr (std::is_same_v<Row, MaterialParameter>) {
    const char* texture = row.texels == Texels::colors ? "colorTexture" : "numberTexture";
    if (row.is_color() && row.texels == Texels::numbers) texture = "distanceTexture";
    if (row.is_textured())
      entry = {{"anyOf", {form.type, {{"$ref", std::string("textures.json#/definitions/") + texture}}}}};
  }
  entry["default"] = form.fallback;
  entry["unit"] = row.unit;
  if constexpr (std::is_same_v<T, alabaster::LightParameters>)
    for (size_t type = 0; type < std::size(kLightTypes); ++type)
      if (row.of >> type & 1) entry["appliesTo"].push_back(kLightTypes[type]);
  if constexpr (std::is_same_v<T, CameraParameters>)
    if (row.of == kMillimetres) entry["unitInDescription"] = "mm";
  entry["description"] = row.text;
  return entry;
}

/// A line of an object: "name": value, on one line.
std::string line_of(const std::string& indent, const std::string& name, const ordered_json& value, bool last) {
  return indent + ordered_json(name).dump() + ": " + value.dump() + (last ? "\n" : ",\n");
}

/// The table and the name in `"NAME": {"$ref": "TABLE.json#/properties/NAME"}`; empty: it is another line.
struct Reference {
  std::string table, indent;
};
Reference reference_in(const std::string& line) {
  const std::string target = ".json#/properties/", mark = "{\"$ref\": \"";
  const size_t begin = line.find(mark), end = line.find(target);
  const size_t name = line.find('"');
  if (begin == std::string::npos || end == std::string::npos || end < begin) return {};
  const std::string table = line.substr(begin + mark.size(), end - begin - mark.size());
  const bool is_same = line.find(target + line.substr(name + 1, line.find('"', name + 1) - name - 1) + "\"") == end;
  return is_same ? Reference{table, line.substr(0, name)} : Reference{};
}

std::string schema_text(const Schema& schema) {
  const std::string name = schema.name;
  std::string text = "{\n";
  text += line_of("  ", "$schema", "http://json-schema.org/draft-07/schema#", false);
  text += line_of("  ", "$id", name + ".json", false) + line_of("  ", "title", schema.title, false);
  text += line_of("  ", "description", schema.text, false) + line_of("  ", "type", "object", false);
  text += line_of("  ", "additionalProperties", false, false) + "  \"properties\": {\n";
  const ordered_json properties = TableProperties(name);
  for (auto property = properties.begin(); property != properties.end(); ++property) {
    text += "    \"" + property.key() + "\": {\n";
    for (auto part = property->begin(); part != property->end(); ++part)
      text += line_of("      ", part.key(), *part, std::next(part) == property->end());
    text += std::next(property) == properties.end() ? "    }\n" : "    },\n";
  }
  return text + "  }\n}\n";
}

}  // namespace

ordered_json TableProperties(const std::string& name) {
  ordered_json properties = ordered_json::object();
  visit_table(name, [&](const auto& rows, const auto& defaults, auto others) {
    for (const auto& row : rows) properties[row.name] = entry_of(row, defaults);
    for (const OtherParameter& row : others)
      if (row.schema) properties[row.name] = ordered_json::parse(row.schema);
  });
  return properties;
}

std::map<std::string, std::string> TableSchemas() {
  std::map<std::string, std::string> texts;
  for (const Schema& schema : kSchemas) texts[schema.name] = schema_text(schema);
  return texts;
}

std::map<std::string, std::string> TableFiles() {
  std::map<std::string, std::string> files;
  for (const auto& [name, text] : TableSchemas()) files["schemas/" + name + ".json"] = text;
  AddParameterPages(&files);
  return files;
}

// The list of AOVs begins after a line "enum": [, with the first of them.
std::string WithTables(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  std::string out;
  const std::vector<std::string>& aovs = ProductAovs();
  for (size_t i = 0; i < lines.size();) {
    if (i > 0 && lines[i - 1].ends_with("\"enum\": [") && lines[i].ends_with("\"" + aovs[0] + "\",")) {
      const std::string indent = lines[i].substr(0, lines[i].find('"'));
      while (i < lines.size() && lines[i].starts_with(indent + '"')) ++i;
      for (const std::string& aov : aovs) out += indent + "\"" + aov + (&aov == &aovs.back() ? "\"\n" : "\",\n");
      continue;
    }
    const Reference reference = reference_in(lines[i]);
    const ordered_json properties = TableProperties(reference.table);
    if (properties.empty()) {
      out += lines[i++] + "\n";
      continue;
    }
    while (i < lines.size() && reference_in(lines[i]).table == reference.table) ++i;
    for (auto property = properties.begin(); property != properties.end(); ++property) {
      const std::string target = reference.table + ".json#/properties/" + property.key();
      const bool is_last = std::next(property) == properties.end() && !lines[i - 1].ends_with(',');
      out += reference.indent + "\"" + property.key() + "\": {\"$ref\": \"" + target + "\"}" + (is_last ? "\n" : ",\n");
    }
  }
  return out;
}

}  // namespace alabaster::hd::host
