#include "delegate/python/objects.h"

namespace alabaster::python {
namespace {

/// Arguments whose fields have other names.
constexpr std::pair<const char*, const char*> kShortForms[] = {{"points", "primvars:points"},
                                                               {"widths", "primvars:widths"},
                                                               {"counts", "faceVertexCounts"},
                                                               {"indices", "faceVertexIndices"},
                                                               {"holes", "holeIndices"},
                                                               {"motion", "transform:samples"},
                                                               {"pixel_aspect", "pixelAspectRatio"},
                                                               {"transforms", "primvars:hydra:instanceTransforms"},
                                                               {"translations", "primvars:hydra:instanceTranslations"},
                                                               {"rotations", "primvars:hydra:instanceRotations"},
                                                               {"scales", "primvars:hydra:instanceScales"}};
constexpr const char *kPrimvars = "primvars:", *kOfInstances = "primvars:hydra:";

struct Type {
  int32_t type = ALABASTER_NONE, is_array = 0;
};
Type type_of(const std::string& kind, const std::string& name) {
  Type found;
  c_api::check(c_api::api().field_type(kind.c_str(), name.c_str(), &found.type, &found.is_array));
  return found;
}

bool is_connection(py::handle value) {
  if (!py::isinstance<py::tuple>(value) || py::len(value) != 2) return false;
  const auto pair = py::reinterpret_borrow<py::tuple>(value);
  return py::isinstance<py::str>(pair[0]) && py::isinstance<py::str>(pair[1]);
}
std::string connection(const py::object& value, const std::string& name) {
  if (!is_connection(value)) throw wrong_type("each of " + name, "a pair of texts", value);
  const auto pair = py::reinterpret_borrow<py::tuple>(value);
  return text(pair[0], name) + "." + text(pair[1], name);
}

/// A value of one of several types.
Value any_value(const std::string& field, const py::object& value, const std::string& argument) {
  if (is_connection(value)) return Value::path(connection(value, argument));
  if (py::isinstance<py::list>(value) && py::len(value) > 0 && is_connection(py::object(value[py::int_(0)]))) {
    std::vector<std::string> all;
    for (const py::object& one : items(value, argument)) all.push_back(connection(one, argument));
    return Value::paths(std::move(all));
  }
  const bool is_one = PyUnicode_Check(value.ptr()) || PyBool_Check(value.ptr());
  return field.starts_with(kPrimvars) && !is_one ? array_by_shape(value, argument) : parameter(value, argument);
}

Value scalar_value(int32_t type, const std::string& field, const py::object& value, const std::string& argument) {
  switch (type) {
    case ALABASTER_BOOL:
      return flag(value, argument);
    case ALABASTER_INT:
      return whole(value, argument);
    case ALABASTER_FLOAT:
    case ALABASTER_DOUBLE:
      return number(value, argument);
    case ALABASTER_MATRIX:
      return matrix(value, argument);
    case ALABASTER_TOKEN:
    case ALABASTER_PATH:
      return text(value, argument);
    default:
      return any_value(field, value, argument);
  }
}

Value field_value(const std::string& kind, const std::string& field, const py::object& value,
                  const std::string& argument);

Value samples(const std::string& kind, const std::string& field, const py::object& value, const std::string& argument) {
  std::vector<std::pair<double, Value>> all;
  for (const py::object& sample : items(value, argument)) {
    const std::vector<py::object> pair = items(sample, "each of " + argument);
    if (pair.size() != 2) throw py::value_error(argument + " is a list of pairs of a time and a value");
    Value at = field == "transform" ? Value(matrix(pair[1], argument)) : field_value(kind, field, pair[1], argument);
    all.emplace_back(number(pair[0], "a time of " + argument), std::move(at));
  }
  return Value::samples(std::move(all));
}

Value field_value(const std::string& kind, const std::string& field, const py::object& value,
                  const std::string& argument) {
  if (value.is_none()) return {};
  if (field.ends_with(":samples")) return samples(kind, field.substr(0, field.rfind(':')), value, argument);
  const auto [type, is_array] = type_of(kind, field);
  if (!is_array) return scalar_value(type, field, value, argument);
  if (type == ALABASTER_TOKEN) return Value::tokens(texts(value, argument));
  return type == ALABASTER_FLOAT4 ? planes(value, argument) : array(type, value, argument);
}

void add_primvar(const std::string& kind, const std::string& field, const Primvar& primvar, const std::string& argument,
                 c_api::Parameters* fields) {
  if (!primvar.motion.is_none() && type_of(kind, field).type == ALABASTER_NONE)
    throw py::value_error("points, normals and transforms of instances have motion; " + argument + " has none");
  if (field.starts_with(kOfInstances) && !(primvar.indices.is_none() && primvar.role.empty()))
    throw py::value_error("primvars of instances have no indices and no role; " + argument + " has");
  fields->emplace_back(field, field_value(kind, field, primvar.values, argument));
  if (!primvar.values.is_none() && !field.starts_with(kOfInstances)) {
    fields->emplace_back(field + ":interpolation", Value(primvar.interpolation));
    fields->emplace_back(field + ":role", primvar.role.empty() ? Value() : Value(primvar.role));
    fields->emplace_back(field + ":indices", array(ALABASTER_INT, primvar.indices, "indices of " + argument));
  }
  if (!primvar.motion.is_none())
    fields->emplace_back(field + ":samples", samples(kind, field, primvar.motion, "motion of " + argument));
}

}  // namespace

std::string field_name(const std::string& argument) {
  if (argument.find_first_of(":.") != std::string::npos) return argument;
  for (const auto& [name, field] : kShortForms)
    if (argument == name) return field;
  std::string name;
  for (size_t i = 0; i < argument.size(); ++i) {
    const bool is_joint = argument[i] == '_' && i > 0 && i + 1 < argument.size();
    name += is_joint ? char(std::toupper(static_cast<unsigned char>(argument[++i]))) : argument[i];
  }
  return name;
}

void add_fields(const std::string& kind, py::handle values, const std::string& name, c_api::Parameters* fields) {
  for (const auto& [argument, value] : entries(values, name)) {
    const std::string field = field_name(argument);
    if (py::isinstance<Primvar>(value) && field.starts_with(kPrimvars))
      add_primvar(kind, field, object_of<Primvar>(value, argument, "a Primvar"), argument, fields);
    else
      fields->emplace_back(field, field_value(kind, field, value, argument));
  }
}

}  // namespace alabaster::python
