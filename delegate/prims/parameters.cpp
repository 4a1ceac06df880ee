#include "delegate/prims/parameters.h"

#include <algorithm>
#include <array>

namespace alabaster::hd::sync {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

template <class Enum>
bool set_word(const SettingParameter& parameter, const Value& value, Enum* out) {
  const auto found = std::find(parameter.choices.begin(), parameter.choices.end(), value.text_or(""));
  if (found == parameter.choices.end()) return false;
  *out = static_cast<Enum>(found - parameter.choices.begin());
  return true;
}

}  // namespace

std::span<const Parameter<DisneyParameters>> material_parameters() {
  using P = DisneyParameters;
  static const std::array<Parameter<P>, 15> table{{
      {"baseColor", &P::base_color, 0, 1},
      {"metallic", &P::metallic, 0, 1},
      {"roughness", &P::roughness, 0, 1},
      {"anisotropic", &P::anisotropic, 0, 1},
      {"specularTint", &P::specular_tint, 0, 1},
      {"ior", &P::ior, 1, 4},
      {"specular", &P::specular, 0, 1},
      {"specularColor", &P::specular_color, 0, kInfinity},
      {"sheen", &P::sheen, 0, 1},
      {"sheenTint", &P::sheen_tint, 0, 1},
      {"clearcoat", &P::clearcoat, 0, 1},
      {"clearcoatGloss", &P::clearcoat_gloss, 0, 1},
      {"scatterDistance", &P::scatter_distance, 0, kInfinity},
      {"scatterAnisotropy", &P::scatter_anisotropy, -0.9, 0.9},
      {"emission", &P::emission, 0, kInfinity},
  }};
  return table;
}

std::span<const Parameter<alabaster::LightDescription>> light_parameters() {
  using P = alabaster::LightDescription;
  static const std::array<Parameter<P>, 12> table{{
      {"intensity", &P::intensity, 0, kInfinity},
      {"exposure", &P::exposure, -64, 64},
      {"color", &P::color, 0, kInfinity},
      {"normalize", &P::normalize},
      {"width", &P::width, 0, kInfinity},
      {"height", &P::height, 0, kInfinity},
      {"radius", &P::radius, 0, kInfinity},
      {"treatAsPoint", &P::treat_as_point},
      {"angle", &P::angle, 0, 360},
      {"coneInner", &P::cone_inner, 0, 180},
      {"coneOuter", &P::cone_outer, 0, 180},
      {"visibleToCamera", &P::visible_to_camera},
  }};
  return table;
}

std::span<const Parameter<CameraParameters>> camera_parameters() {
  using P = CameraParameters;
  constexpr double kSmallest = 1e-30;  // of what a projection divides by
  static const std::array<Parameter<P>, 7> table{{
      {"focalLength", &P::focal_length, kSmallest, kInfinity},
      {"horizontalAperture", &P::horizontal_aperture, kSmallest, kInfinity},
      {"verticalAperture", &P::vertical_aperture, kSmallest, kInfinity},
      {"horizontalApertureOffset", &P::horizontal_aperture_offset},
      {"verticalApertureOffset", &P::vertical_aperture_offset},
      {"fStop", &P::f_stop, 0, kInfinity},
      {"focusDistance", &P::focus_distance, 0, kInfinity},
  }};
  return table;
}

const std::vector<SettingParameter>& setting_parameters() {
  using S = RenderSettings;
  static const std::vector<SettingParameter> table{
      {"samples", "Camera samples per pixel, at most.", &S::samples, 1, 1048576},
      {"targetError",
       "Relative RMSE of the noise at which the render ends, within some per cent; 0: samples alone decide.",
       &S::target_error, 0, 1},
      {"adaptive", "Deals the samples out by where the noise is: `samples` is their mean.", &S::adaptive},
      {"timeLimit",
       "Seconds after which the render ends; 0: none. The one setting whose picture depends on the machine.",
       &S::time_limit, 0, 31536000},
      {"seed", "Another seed gives another, equally good noise pattern.", &S::seed, 0, 4294967295.0},
      {"frame", "Frame number: decorrelates the noise of successive frames.", &S::frame, 0, 4294967295.0},
      {"maxDepth", "Bounces between surfaces; a subsurface walk counts as one.", &S::max_depth, 0, 1024},
      {"rouletteDepth", "Bounces after which roulette may end a path. Affects noise only.", &S::roulette_depth, 0,
       1024},
      {"threads", "Threads for rendering and for Sync; 0 uses all cores. The picture does not depend on it.",
       &S::threads, 0, 4096},
      {"subsurface",
       "How scatterDistance is rendered: not at all (lambert), by random walks (walk), by walks without any shortcut "
       "(reference), by normalized diffusion (diffusion), or by walks where a pixel can tell them from Lambert's "
       "diffuse "
       "(auto).",
       &S::subsurface,
       0,
       0,
       {"lambert", "walk", "reference", "diffusion", "auto"}},
      {"inversion",
       "How the single-scattering albedo is found from baseColor.",
       &S::inversion,
       0,
       0,
       {"chiang2016", "exact", "vanDeHulst"}},
      {"walkWeights",
       "Channel probabilities of the walk's distance sampling. Affects noise only.",
       &S::walk_weights,
       0,
       0,
       {"throughput", "throughputTimesAlbedo"}},
      {"walkGuiding", "Walks are guided back to the surface where that pays. Affects noise only.", &S::walk_guiding},
      {"walkSphereSteps", "Walks jump through the interior where that pays. Bias below 3e-4 of the albedo.",
       &S::walk_sphere_steps},
      {"filter", "Pixel filter.", &S::filter, 0, 0, {"box", "triangle", "gaussian", "blackmanHarris"}},
  };
  return table;
}

ParameterFault read_number(const Value& value, double minimum, double maximum, double* out) {
  const double number = value.number_or(std::numeric_limits<double>::quiet_NaN());
  if (std::isnan(number)) return ParameterFault::type;
  constexpr double kLargest = std::numeric_limits<float>::max();
  *out = std::clamp(number, std::max(minimum, -kLargest), std::min(maximum, kLargest));
  return *out == number ? ParameterFault::none : ParameterFault::range;
}

ParameterFault read_color(const Value& value, double minimum, double maximum, Rgb* out) {
  std::array<double, 3> c{};
  if (const auto* v = value.get<Vec3f>())
    c = {v->x, v->y, v->z};
  else if (const auto* w = value.get<Vec3d>())
    c = {w->x, w->y, w->z};
  else if (const auto* a = value.get<Vec4f>())
    c = {a->x, a->y, a->z};
  else
    c.fill(value.number_or(std::numeric_limits<double>::quiet_NaN()));
  ParameterFault fault = ParameterFault::none;
  std::array<double, 3> read{};
  for (size_t i = 0; i < 3; ++i) {
    const ParameterFault f = read_number(c[i], minimum, maximum, &read[i]);
    if (f == ParameterFault::type) return f;
    if (f == ParameterFault::range) fault = f;
  }
  *out = Rgb(static_cast<float>(read[0]), static_cast<float>(read[1]), static_cast<float>(read[2]));
  return fault;
}

ParameterFault set_setting(const SettingParameter& parameter, const Value& value, RenderSettings* settings) {
  return std::visit(
      [&](auto member) {
        using Member = std::decay_t<decltype(settings->*member)>;
        if constexpr (std::is_same_v<Member, uint32_t>) {
          double read = 0;
          const ParameterFault fault = read_number(value, parameter.minimum, parameter.maximum, &read);
          if (fault != ParameterFault::type) settings->*member = static_cast<uint32_t>(read);
          return fault;
        } else if constexpr (std::is_same_v<Member, float>) {
          double read = 0;
          const ParameterFault fault = read_number(value, parameter.minimum, parameter.maximum, &read);
          if (fault != ParameterFault::type) settings->*member = static_cast<float>(read);
          return fault;
        } else if constexpr (std::is_same_v<Member, bool>) {
          const double read = value.number_or(std::numeric_limits<double>::quiet_NaN());
          if (std::isnan(read)) return ParameterFault::type;
          settings->*member = read != 0;
          return ParameterFault::none;
        } else {
          return set_word(parameter, value, &(settings->*member)) ? ParameterFault::none : ParameterFault::type;
        }
      },
      parameter.member);
}

Value get_setting(const SettingParameter& parameter, const RenderSettings& settings) {
  return std::visit(
      [&](auto member) -> Value {
        using Member = std::decay_t<decltype(settings.*member)>;
        if constexpr (std::is_same_v<Member, uint32_t>)
          return static_cast<int64_t>(settings.*member);
        else if constexpr (std::is_same_v<Member, bool> || std::is_same_v<Member, float>)
          return settings.*member;
        else
          return parameter.choices[static_cast<size_t>(settings.*member)];
      },
      parameter.member);
}

void report_fault(const alabaster::DiagnosticSink& sink, const std::string& where, const std::string& name,
                  ParameterFault fault, const Value& value) {
  if (fault == ParameterFault::type)
    alabaster::report(sink, alabaster::Severity::warning, "parameter.type", where,
                      name + " = " + value.to_string() + " is not a value it can have; the default is used");
  if (fault == ParameterFault::range)
    alabaster::report(sink, alabaster::Severity::warning, "parameter.range", where,
                      name + " = " + value.to_string() + " is out of range; the nearest allowed value is used");
}

}  // namespace alabaster::hd::sync
