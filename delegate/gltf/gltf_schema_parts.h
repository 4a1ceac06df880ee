// Shorthands for the tables of schemas. Private to them.
#pragma once

#include "delegate/gltf/gltf_schema.h"

namespace alabaster::hd::gltf {

inline constexpr double kMostInteger = 9007199254740992.0;  // 2^53: every integer below is exact in JSON's numbers

inline Property reference(const char* name, const char* target, bool required = false) {
  return {.name = name, .kind = Kind::reference, .required = required, .target = target};
}
inline Property object(const char* name, const Schema& schema, bool required = false) {
  return {.name = name, .kind = Kind::object, .required = required, .schema = &schema};
}
inline Property objects(const char* name, const Schema& schema, bool required = false) {
  return {.name = name, .kind = Kind::objects, .required = required, .schema = &schema};
}
inline Property integer(const char* name, double minimum, double maximum, bool required = false) {
  return {.name = name, .kind = Kind::integer, .required = required, .minimum = minimum, .maximum = maximum};
}
inline Property text(const char* name, const char* choices = nullptr, bool required = false) {
  return {.name = name, .kind = Kind::text, .required = required, .target = choices};
}
// A factor of a material or light; values out of range are clamped.
inline Property factor(const char* name, double minimum, double maximum) {
  return {.name = name, .kind = Kind::number, .minimum = minimum, .maximum = maximum, .harmless = true};
}
inline Property color(const char* name, double maximum, size_t items = 3) {
  return {.name = name,
          .kind = Kind::numbers,
          .minimum = 0,
          .maximum = maximum,
          .min_items = items,
          .max_items = items,
          .harmless = true};
}
inline Property numbers(const char* name, size_t items) {
  return {.name = name, .kind = Kind::numbers, .min_items = items, .max_items = items};
}

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline const Schema kMarker{};  // an extension whose content is not checked

const Schema& material_schema();  // gltf_schema_materials.cpp

}  // namespace alabaster::hd::gltf
