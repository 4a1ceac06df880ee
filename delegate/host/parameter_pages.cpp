#include "delegate/host/parameter_pages.h"

#include <algorithm>
#include <cmath>

#include "delegate/host/open_fields.h"

namespace alabaster::hd::host {
namespace {

constexpr const char* kWritten = "written by `alabaster schema --write`, from the tables of fields and parameters";

constexpr std::string_view kMaterial = "material", kRenderSettings = "renderSettings";

/// A line of a page.
struct Row {
  std::string name, type, values, fallback, unit, text;
};

// Rows of fields ------------------------------------------------------------------------------------

std::string joined(const std::string& left, const char* between, const std::string& right) {
  return left.empty() || right.empty() ? left + right : left + between + right;
}
std::string range_text(const std::string& low, const std::string& high) {
  if (high.empty()) return low.empty() ? "" : "at least " + low;
  return low.empty() ? "at most " + high : low + " to " + high;
}
std::string end_text(double end) {
  return std::isinf(end) ? "" : limit_text(end);
}

std::string values_of(const FieldRow& field) {
  std::string words;
  for (const std::string& word : field.words) words = joined(words, ", ", word);
  if (!words.empty()) return words;
  if (field.is_above_zero()) return joined("above 0", ", at most ", end_text(field.high));
  return range_text(end_text(field.low), end_text(field.high));
}

std::string type_of(const FieldRow& field) {
  if (field.type.type == ALABASTER_NONE) return "any";
  if (field.type.type == ALABASTER_SAMPLES) return "samples";
  if (!field.words.empty()) return "word";
  if (field.is_color) return "color";
  if (field.type.type == ALABASTER_STRING && !field.type.is_array) return "text";
  const std::string name = field.type.type == ALABASTER_UINT ? "int" : GetTypeInfo(field.type.type).name;
  return (field.type.is_array ? "array of " : "") + name;
}

std::string fallback_of(const FieldRow& field) {
  const Value& value = field.fallback;
  if (value.type() == ALABASTER_MATRIX) return "identity";
  if (const auto* names = value.get<Array<Token>>()) {
    std::string text;
    for (const Token& name : *names) text = joined(text, ", ", name.str());
    return text;
  }
  if (value.is_array() || value.type() == ALABASTER_SAMPLES || value.empty()) return {};
  return GetTypeInfo(value.type()).bytes == 0 ? value.text_or("") : value.to_string();
}

Row row_of(const std::string& name, const FieldRow& field) {
  Row row{name, type_of(field), values_of(field), fallback_of(field), field.unit, field.text};
  if (!field.texture.empty()) row.type += " or texture";
  std::string lights;
  for (const std::string& light : field.lights) lights = joined(lights, ", ", light);
  if (!lights.empty()) row.text += " Lights: " + lights + ".";
  return row;
}

void add_fields(std::span<const Field> fields, std::vector<Row>* rows) {
  for (const Field& field : fields) rows->push_back(row_of(field.name, row_of_field(field)));
}

void add_parameters(const std::string& schema, const std::string& prefix, std::vector<Row>* rows) {
  for (const FieldRow& field : ParameterRows(schema)) rows->push_back(row_of(prefix + field.name, field));
}

// Pages ---------------------------------------------------------------------------------------------

std::string cell(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '|' ? "\\|" : c == '<' ? "&lt;" : std::string(1, c);
  return " " + out + " |";
}
std::string code(const std::string& text) {
  return text.empty() ? text : "`" + text + "`";
}

std::string page_text(const std::string& title, const std::vector<Row>& rows) {
  std::string text = "# Fields: " + title + "\n\nThis page is " + kWritten + ".\n\n";
  text += "| name | type | values | default | unit | meaning |\n| --- | --- | --- | --- | --- | --- |\n";
  for (const Row& row : rows)
    text += "|" + cell(code(row.name)) + cell(row.type) + cell(row.values) + cell(code(row.fallback)) + cell(row.unit) +
            cell(row.text) + "\n";
  return text;
}

// Python's stub -------------------------------------------------------------------------------------

/// doubleSided is double_sided.
std::string python_name(const std::string& name) {
  std::string out;
  for (const char c : name)
    out += std::isupper(static_cast<unsigned char>(c)) ? std::string("_") + char(std::tolower(c)) : std::string(1, c);
  return out;
}

std::string literal(const std::string& words) {
  std::string quoted = "\"";
  for (const char c : words) quoted += c == ',' ? "\"," : c == ' ' ? " \"" : std::string(1, c);
  return "Literal[" + quoted + "\"]";
}

std::string python_type(const Row& row) {
  if (row.type == "word") return literal(row.values);
  if (row.type == "array of token") return "Sequence[str]";
  if (row.type.starts_with("array") || row.type == "matrix" || row.type == "color") return "_Array";
  if (row.type == "bool" || row.type == "int") return row.type;
  return row.type == "float" || row.type == "double" ? "float" : "str";
}

/// Fields have names of Python, parameters those of their schema. Names with colons are no names of arguments.
std::string stub_class(std::string name, const std::string& base, const std::vector<Row>& fields,
                       const std::vector<Row>& parameters) {
  name[0] = char(std::toupper(name[0]));
  std::string text = "\nclass " + name + "(" + base + ", total=False):\n";
  const auto add = [&](const std::string& argument, const Row& row) {
    if (argument.find(':') == std::string::npos) text += "    " + argument + ": Optional[" + python_type(row) + "]\n";
  };
  for (const Row& row : fields) add(python_name(row.name), row);
  for (const Row& row : parameters) add(row.name, row);
  return text;
}

}  // namespace

std::map<std::string, std::string> ParameterPages() {
  std::map<std::string, std::string> files;
  const std::string folder = "delegate/manual/parameters/";
  std::string stub = "# This file is " + std::string(kWritten) + ".\n";
  stub += "from typing import Literal, Optional, Sequence, TypedDict\n\nfrom . import _Array\n";
  for (const Kind& kind : kinds()) {
    std::vector<Row> rows, all, parameters, of_renderers;
    add_fields(kind.fields, &rows);
    add_parameters(kind.parameters, kind.name == kMaterial ? "NODE." : "", &all);
    // A field comes before a parameter of its name, which is a setting of renderers alone.
    for (const Row& row : all) {
      const auto is_same = [&](const Row& field) { return field.name == row.name; };
      (std::any_of(rows.begin(), rows.end(), is_same) ? of_renderers : parameters).push_back(row);
    }
    if (kind.name == kRenderSettings) {
      stub += stub_class("_SharedSettings", "TypedDict", {}, parameters);
      stub += stub_class(kind.name, "_SharedSettings", rows, {});
      stub += stub_class("settings", "_SharedSettings", {}, of_renderers);
    } else if (!kind.fields.empty() && !kind.open.empty() && kind.name != std::string_view("camera")) {
      stub += stub_class(kind.name, "TypedDict", rows, parameters);
    }
    add_fields(kind.open, &rows);
    rows.insert(rows.end(), parameters.begin(), parameters.end());
    files[folder + python_name(kind.name) + ".md"] = page_text(kind.name, rows);
  }
  for (const auto& [page, schema] :
       {std::pair{"AlabasterTexture", "texture_node"}, std::pair{"AlabasterDisplacement", "displacement_node"}}) {
    std::vector<Row> rows;
    add_parameters(schema, "NODE.", &rows);
    files[folder + schema + ".md"] = page_text(page, rows);
  }
  std::vector<Row> product;
  add_fields(kProductFields, &product);
  files[folder + "product.md"] = page_text("products:N", product);
  files["delegate/python/hdalabaster/_fields.pyi"] = stub;
  return files;
}

}  // namespace alabaster::hd::host
