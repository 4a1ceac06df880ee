// One table per kind of parameter: name -> member, range. Reading, dumping and describing all go through it.
#pragma once

#include <cmath>
#include <limits>
#include <span>
#include <variant>

#include "core/camera/camera.h"
#include "core/light/light.h"
#include "core/material/disney_parameters.h"
#include "core/session/render_settings.h"
#include "delegate/api/render_delegate.h"
#include "delegate/prims/diagnostics.h"

namespace alabaster::hd::sync {

template <class T>
struct Parameter {
  const char* name;
  std::variant<float T::*, bool T::*, Rgb T::*> member;
  double minimum = -std::numeric_limits<double>::infinity();
  double maximum = std::numeric_limits<double>::infinity();
};

std::span<const Parameter<DisneyParameters>> material_parameters();          // schemas/disney_material.json
std::span<const Parameter<alabaster::LightDescription>> light_parameters();  // schemas/lights.json, but texture:file
std::span<const Parameter<CameraParameters>> camera_parameters();  // schemas/camera.json, but projection, clippingRange

/// A render setting: a number, a switch, or one of a few words.
struct SettingParameter {
  const char* name;
  const char* documentation;
  std::variant<uint32_t RenderSettings::*, float RenderSettings::*, bool RenderSettings::*,
               SubsurfaceMode RenderSettings::*, AlbedoInversion RenderSettings::*, WalkWeights RenderSettings::*,
               PixelFilter RenderSettings::*>
      member;
  double minimum = 0, maximum = 0;        // of numbers
  std::vector<std::string> choices = {};  // of words, in the order of the enumeration
};
const std::vector<SettingParameter>& setting_parameters();  // schemas/render_settings.json

enum class ParameterFault { none, type, range };

/// A number that fits `minimum`..`maximum`, or the nearest that does.
ParameterFault read_number(const Value& value, double minimum, double maximum, double* out);
ParameterFault read_color(const Value& value, double minimum, double maximum, Rgb* out);
ParameterFault set_setting(const SettingParameter& parameter, const Value& value, RenderSettings* settings);
Value get_setting(const SettingParameter& parameter, const RenderSettings& settings);
/// Says what is wrong with parameter `name` of `where` and what is used instead.
void report_fault(const alabaster::DiagnosticSink& sink, const std::string& where, const std::string& name,
                  ParameterFault fault, const Value& value);

template <class T>
ParameterFault set_parameter(const Parameter<T>& parameter, const Value& value, T* object) {
  if (const auto* number = std::get_if<float T::*>(&parameter.member)) {
    double read = 0;
    const ParameterFault fault = read_number(value, parameter.minimum, parameter.maximum, &read);
    if (fault != ParameterFault::type) object->*(*number) = static_cast<float>(read);
    return fault;
  }
  if (const auto* color = std::get_if<Rgb T::*>(&parameter.member))
    return read_color(value, parameter.minimum, parameter.maximum, &(object->*(*color)));
  const auto* flag = std::get_if<bool T::*>(&parameter.member);
  const double read = value.number_or(std::numeric_limits<double>::quiet_NaN());
  if (std::isnan(read)) return ParameterFault::type;
  object->*(*flag) = read != 0;
  return ParameterFault::none;
}

template <class T>
Value get_parameter(const Parameter<T>& parameter, const T& object) {
  if (const auto* number = std::get_if<float T::*>(&parameter.member)) return object.*(*number);
  if (const auto* flag = std::get_if<bool T::*>(&parameter.member)) return object.*(*flag);
  const Rgb& color = object.*std::get<Rgb T::*>(parameter.member);
  return Vec3f(color.r, color.g, color.b);
}

}  // namespace alabaster::hd::sync
