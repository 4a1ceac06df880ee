#include "delegate/python/fields.h"

#include <algorithm>

namespace alabaster::python {
namespace {

bool ends_with_one_of(const std::string& name, std::initializer_list<const char*> ends) {
  return std::any_of(ends.begin(), ends.end(), [&](const char* end) { return name.ends_with(end); });
}

/// The type of the elements of an array field whose name decides it; NONE: its shape does.
int32_t element_type(const std::string& name) {
  if (name == "primvars:hydra:instanceRotations") return ALABASTER_QUATERNION;
  if (name == "primvars:hydra:instanceTransforms") return ALABASTER_MATRIX;
  if (name == "primvars:points" || name == "primvars:normals" || name == "primvars:hydra:instanceTranslations" ||
      name == "primvars:hydra:instanceScales")
    return ALABASTER_FLOAT3;
  if (name == "creaseWeights" || name == "cornerWeights") return ALABASTER_FLOAT;
  const bool holds_places = name.starts_with("prototypes:") || name.starts_with("categories:") || name == "crop" ||
                            (name.starts_with("subsets:") && name.ends_with(":faces")) ||
                            (name.starts_with("primvars:") && name.ends_with(":indices"));
  const bool is_plain = name.find_first_of(":.") == std::string::npos;
  if (holds_places || (is_plain && ends_with_one_of(name, {"Counts", "Indices", "Lengths", "Faces"})))
    return ALABASTER_INT;
  return ALABASTER_NONE;
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

Value field_value(const std::string& name, const py::object& value, const std::string& argument);

Value samples(const std::string& name, const py::object& value, const std::string& argument) {
  std::vector<std::pair<double, Value>> all;
  for (const py::object& sample : items(value, argument)) {
    const std::vector<py::object> pair = items(sample, "each of " + argument);
    if (pair.size() != 2) throw py::value_error(argument + " is a list of pairs of a time and a value");
    Value at = name == "transform" ? Value(matrix(pair[1], argument)) : field_value(name, pair[1], argument);
    all.emplace_back(number(pair[0], "a time of " + argument), std::move(at));
  }
  return Value::samples(std::move(all));
}

Value field_value(const std::string& name, const py::object& value, const std::string& argument) {
  if (value.is_none()) return {};
  if (name.ends_with(":samples")) return samples(name.substr(0, name.rfind(':')), value, argument);
  if (name == "transform") return matrix(value, argument);
  if (const int32_t type = element_type(name); type != ALABASTER_NONE) return array(type, value, argument);
  if (name == "categories" || name == "includedPurposes") return Value::tokens(texts(value, argument));
  if (is_connection(value)) return Value::path(connection(value, argument));
  if (py::isinstance<py::list>(value) && py::len(value) > 0 && is_connection(py::object(value[py::int_(0)]))) {
    std::vector<std::string> all;
    for (const py::object& one : items(value, argument)) all.push_back(connection(one, argument));
    return Value::paths(std::move(all));
  }
  const bool is_one = PyUnicode_Check(value.ptr()) || PyBool_Check(value.ptr());
  if (name.starts_with("primvars:") && !is_one) return array_by_shape(value, argument);
  return name == "clipPlanes" ? planes(value, argument) : parameter(value, argument);
}

}  // namespace

std::string field_name(const std::string& argument) {
  if (argument.find_first_of(":.") != std::string::npos) return argument;
  std::string name;
  for (size_t i = 0; i < argument.size(); ++i) {
    const bool is_joint = argument[i] == '_' && i > 0 && i + 1 < argument.size();
    name += is_joint ? char(std::toupper(static_cast<unsigned char>(argument[++i]))) : argument[i];
  }
  return name;
}

void add_primvar(const std::string& name, const Primvar& primvar, const std::string& argument, bool of_mesh,
                 c_api::Parameters* fields) {
  const std::string field = "primvars:" + name;
  if (!primvar.motion.is_none() && element_type(field) == ALABASTER_NONE)
    throw py::value_error("points, normals and transforms of instances have motion; " + argument + " has none");
  fields->emplace_back(field, field_value(field, primvar.values, argument));
  if (of_mesh && !primvar.values.is_none()) {
    fields->emplace_back(field + ":interpolation", Value(primvar.interpolation));
    fields->emplace_back(field + ":role", primvar.role.empty() ? Value() : Value(primvar.role));
    fields->emplace_back(field + ":indices", array(ALABASTER_INT, primvar.indices, "indices of " + argument));
  }
  if (!primvar.motion.is_none())
    fields->emplace_back(field + ":samples", samples(field, primvar.motion, "motion of " + argument));
}

void add_field(const std::string& name, const py::object& value, const std::string& argument,
               c_api::Parameters* fields) {
  constexpr const char* kPrimvars = "primvars:";
  if (py::isinstance<Primvar>(value) && name.starts_with(kPrimvars))
    return add_primvar(name.substr(std::char_traits<char>::length(kPrimvars)),
                       object_of<Primvar>(value, argument, "a Primvar"), argument, true, fields);
  fields->emplace_back(name, field_value(name, value, argument));
}

void add_fields(py::handle values, const std::string& argument, c_api::Parameters* fields) {
  for (const auto& [name, value] : entries(values, argument)) add_field(field_name(name), value, name, fields);
}

c_api::Parameters camera_fields(py::handle options) {
  c_api::Parameters fields;
  py::object motion = py::none();
  for (const auto& [name, value] : entries(options, "camera")) {
    if (name == "motion")
      motion = value;
    else
      add_field(field_name(name), value, name, &fields);
  }
  if (!motion.is_none()) add_field("transform:samples", motion, "motion", &fields);
  return fields;
}

}  // namespace alabaster::python
