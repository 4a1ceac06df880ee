// The scattering function of a vertex, in render space: of the lobes of a surface or an interface, or of the exit lobe
// of a walk. Values have the cosine, and are black in directions that do not leave from the origin that is asked for.
#pragma once

#include <variant>

#include "core/integrator/vertex.h"
#include "core/material/disney_bsdf.h"

namespace alabaster {

/// Branches that a path becomes at the surface that the camera sees, unless that lets light through. The camera's ray
/// and the lights sampled there give little of the noise, and what comes by way of bodies and other surfaces gives
/// much. More than two gain beyond doubt on skin alone (testenv/benchmark/results/sampling.md).
inline constexpr uint32_t kPathsPerSample = 2;

struct ScatterValue {
  Rgb f_cos{0.0f};
  float pdf = 0;                     // of sampling the direction
  Rgb specular{0.0f};                // the specular lobes' share of f, per channel; only where it is asked for
  float exit_cos = 0, exit_pdf = 0;  // f cos and pdf of an exit lobe; only where the vertex has a control variate
};

/// The side of the surface that a direction leaves to. Light that passes must do so by the lobe, by the smooth normal,
/// which a normal map tilts, and by the facet.
enum class Side { near, far, neither };

struct ScatterSample {
  Lobe lobe;   // subsurface: the path goes below, and there is no direction
  Rgb weight;  // f cos / pdf
  Vec3f wi;
  Side side;
  float pdf;     // infinite: a discrete choice
  Rgb specular;  // the specular lobes' share of f, where it is asked for
};

class VertexBsdf {
 public:
  /// `path`: that came to the vertex. Keeps references to all but it.
  VertexBsdf(const PathContext& context, const Vertex& v, const Path& path);

  /// False within a medium: there is no light to sample.
  bool has_lobes() const { return v_.kind != Vertex::Kind::within; }
  uint32_t branches() const {
    return v_.kind == Vertex::Kind::surface || v_.kind == Vertex::Kind::within ? kPathsPerSample : 1;
  }
  LightSampleContext light_context() const;
  /// Of an interface: false if all light that passes goes straight on.
  bool scatters_beyond() const { return std::get<Interface>(bsdf_).bsdf.scatters_beyond(); }

  /// For a direction that leaves from `origin`.
  ScatterValue evaluate(const Vec3f& wi, Vertex::Origin origin) const {
    if (origin != Vertex::kFarSide && v_.is_above_facet(wi) != (origin == Vertex::kFacet)) return {};
    if (const auto* const surface = std::get_if<DisneyBsdf>(&bsdf_)) [[likely]]
      return evaluate(*surface, wi);
    if (const auto* const at = std::get_if<Interface>(&bsdf_))
      return evaluate(*at, wi, origin == Vertex::kFarSide ? Side::far : Side::near);
    return evaluate_exit(wi);
  }
  /// False: no direction was sampled.
  bool sample(const std::array<float, 4>& u, ScatterSample* out) const;

  /// True if walks that enter here have twins.
  bool has_twins() const;
  /// The entry weight of walks.
  Rgb subsurface_entry() const { return std::get<DisneyBsdf>(bsdf_).subsurface_entry(); }
  /// The colour that light takes where walks leave here.
  Rgb exit_color() const { return std::get<DisneyBsdf>(bsdf_).coat_passage(); }

  /// Of an interface: the media on the far side, and a factor of what passes, beside the lobes.
  const MediumStack& media_beyond() const { return std::get<Interface>(bsdf_).beyond; }
  const Rgb& factor_beyond() const { return std::get<Interface>(bsdf_).factor; }

 private:
  struct Interface {
    Interface(const PathContext& context, const Vertex& v, const Path& path);
    DisneyTransmissiveBsdf bsdf;
    MediumStack beyond;
    Rgb factor;
  };
  struct ExitLobe {};

  Side side_of(const DisneyTransmissiveBsdf& bsdf, const Vec3f& wi_local, const Vec3f& wi) const;
  ScatterValue evaluate(const DisneyBsdf& bsdf, const Vec3f& wi) const;
  ScatterValue evaluate(const Interface& at, const Vec3f& wi, Side side) const;
  ScatterValue evaluate_exit(const Vec3f& wi) const;
  bool sample(const DisneyBsdf& bsdf, const std::array<float, 4>& u, ScatterSample* out) const;
  bool sample(const Interface& at, const std::array<float, 4>& u, ScatterSample* out) const;
  bool sample_exit(const std::array<float, 4>& u, ScatterSample* out) const;
  void record_lobe(const BsdfSample& sample) const;

  const PathContext& context_;
  const Vertex& v_;
  Vec3f incoming_;  // along the path's ray
  bool seeks_specular_;
  std::variant<std::monostate, DisneyBsdf, Interface, ExitLobe> bsdf_;
};

inline LightSampleContext VertexBsdf::light_context() const {
  switch (v_.kind) {
    case Vertex::Kind::surface:
      return {v_.material.scatters() ? ConstantDomes::sampled : ConstantDomes::bsdf_sampling_only, v_.frame.n};
    case Vertex::Kind::interface:  // its lobes are on both sides: no one normal weighs the light
      return {v_.material.scatters() ? ConstantDomes::sampled : ConstantDomes::bsdf_sampling_only};
    case Vertex::Kind::exit:
    case Vertex::Kind::within:
      break;
  }
  return {ConstantDomes::bsdf_sampling_only, v_.frame.n};
}

inline ScatterValue VertexBsdf::evaluate(const DisneyBsdf& bsdf, const Vec3f& wi) const {
  const Vec3f local = v_.frame.to_local(wi);
  if (!bsdf.reaches(local) || !v_.is_above_surface(wi)) return {};
  Rgb specular;
  const BsdfValue value = bsdf.evaluate(local, seeks_specular_ ? &specular : nullptr);
  ScatterValue scattered{value.f_cos, value.pdf};
  if (seeks_specular_) scattered.specular = share_of(specular, value.f_cos);
  if (v_.control) scattered.exit_cos = bsdf.exit_f_cos(local), scattered.exit_pdf = local.z * kInvPi;
  return scattered;
}

// The albedo of the lobe is kMeanDiffuseTransmittance. The lobes at the entry compensate for that.
inline ScatterValue VertexBsdf::evaluate_exit(const Vec3f& wi) const {
  const float cosine = dot(wi, v_.frame.n);
  if (!(cosine > 0) || !v_.is_above_surface(wi)) return {};
  ScatterValue value{Rgb(subsurface_exit_f_cos(cosine)), cosine * kInvPi};
  if (v_.exit_layers) [[unlikely]]
    value.f_cos *= v_.exit_layers->leaving(v_.frame.to_local(wi));
  return value;
}

}  // namespace alabaster
