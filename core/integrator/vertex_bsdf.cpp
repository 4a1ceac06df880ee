#include "core/integrator/vertex_bsdf.h"

#include <limits>

#include "core/diagnostics/check.h"
#include "core/integrator/interface.h"
#include "core/integrator/path_record.h"
#include "core/sampling/warp.h"

namespace alabaster {

VertexBsdf::Interface::Interface(const PathContext& context, const Vertex& v, const Path& path)
    : bsdf(v.material, v.frame.to_local(-path.ray.dir), v.side, context.settings.energy),
      beyond(media_past(v, path.media)),
      factor(passing_factor(v, path.media, beyond)) {}

VertexBsdf::VertexBsdf(const PathContext& context, const Vertex& v, const Path& path)
    : context_(context), v_(v), incoming_(path.ray.dir), seeks_specular_(path.seeks_layer()) {
  switch (v.kind) {
    case Vertex::Kind::surface:
      bsdf_.emplace<DisneyBsdf>(v.material, v.frame.to_local(-path.ray.dir), context.settings.energy);
      break;
    case Vertex::Kind::interface:
      bsdf_.emplace<Interface>(context, v, path);
      break;
    case Vertex::Kind::exit:
      bsdf_.emplace<ExitLobe>();
      break;
    case Vertex::Kind::within:
      break;
  }
}

LightSampleContext VertexBsdf::light_context() const {
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

bool VertexBsdf::leaves_from(Vertex::Origin origin) const {
  if (origin != Vertex::kFarSide) return true;
  const auto* const interface = std::get_if<Interface>(&bsdf_);
  return interface && interface->bsdf.scatters_beyond();
}

Side VertexBsdf::side_of(const DisneyTransmissiveBsdf& bsdf, const Vec3f& wi_local, const Vec3f& wi) const {
  if (bsdf.reflects_to(wi_local) && v_.is_above_surface(wi)) return Side::near;
  return wi_local.z < 0 && dot(wi, v_.smooth_normal) < 0 && dot(wi, v_.hit.ng) < 0 ? Side::far : Side::neither;
}

ScatterValue VertexBsdf::evaluate(const DisneyBsdf& bsdf, const Vec3f& wi) const {
  const Vec3f local = v_.frame.to_local(wi);
  if (!bsdf.reaches(local) || !v_.is_above_surface(wi)) return {};
  Rgb specular;
  const BsdfValue value = bsdf.evaluate(local, seeks_specular_ ? &specular : nullptr);
  ScatterValue scattered{value.f * std::abs(local.z), value.pdf};
  if (seeks_specular_) scattered.specular = share_of(specular, value.f);
  if (seeks_exit_lobe_)
    scattered.exit_cos = bsdf.subsurface_exit(local) * local.z, scattered.exit_pdf = local.z * kInvPi;
  return scattered;
}

ScatterValue VertexBsdf::evaluate(const Interface& at, const Vec3f& wi, Side side) const {
  const Vec3f local = v_.frame.to_local(wi);
  if (side_of(at.bsdf, local, wi) != side) return {};
  Rgb specular;
  const BsdfValue value = at.bsdf.evaluate(local, seeks_specular_ ? &specular : nullptr);
  const Rgb f_cos = (side == Side::far ? value.f * at.factor : value.f) * std::abs(local.z);
  return {f_cos, value.pdf, seeks_specular_ ? share_of(specular, value.f) : Rgb(0.0f)};
}

// The albedo of the lobe is kMeanDiffuseTransmittance. The lobes at the entry compensate for that.
ScatterValue VertexBsdf::evaluate_exit(const Vec3f& wi) const {
  const float cosine = dot(wi, v_.frame.n);
  if (!(cosine > 0) || !v_.is_above_surface(wi)) return {};
  ScatterValue value{Rgb(eval_subsurface_exit({0, 0, cosine}) * cosine), cosine * kInvPi};
  if (v_.exit_layers) [[unlikely]]
    value.f_cos *= v_.exit_layers->leaving(v_.frame.to_local(wi));
  return value;
}

ScatterValue VertexBsdf::evaluate(const Vec3f& wi, Vertex::Origin origin) const {
  if (origin != Vertex::kFarSide && v_.is_above_facet(wi) != (origin == Vertex::kFacet)) return {};
  switch (v_.kind) {
    case Vertex::Kind::surface:
      return evaluate(std::get<DisneyBsdf>(bsdf_), wi);
    case Vertex::Kind::interface:
      return evaluate(std::get<Interface>(bsdf_), wi, origin == Vertex::kFarSide ? Side::far : Side::near);
    case Vertex::Kind::exit:
      return evaluate_exit(wi);
    case Vertex::Kind::within:
      break;
  }
  return {};
}

void VertexBsdf::record_lobe(Lobe lobe, const Rgb& f, float pdf) const {
  if (context_.record) context_.record->sample_lobe(lobe_name(lobe), f, pdf);
}

std::optional<ScatterSample> VertexBsdf::sample(const DisneyBsdf& bsdf, const std::array<float, 4>& u) const {
  Rgb specular;
  const auto sample = bsdf.sample(u[0], {u[1], u[2]}, seeks_specular_ ? &specular : nullptr);
  if (!sample) return std::nullopt;
  DCHECK_GE(sample->pdf, 0.0f);
  record_lobe(sample->lobe, sample->f, sample->pdf);
  ScatterSample scattered{sample->lobe};
  if (sample->lobe == Lobe::subsurface) {
    scattered.weight = sample->f * (1 / sample->pdf);
    return scattered;
  }
  scattered.wi = v_.frame.to_world(sample->wi);
  if (!v_.is_above_surface(scattered.wi)) return std::nullopt;
  scattered.weight = sample->f * (std::abs(sample->wi.z) / sample->pdf);
  scattered.pdf = sample->pdf;
  if (seeks_specular_) scattered.specular = share_of(specular, sample->f);
  return scattered;
}

std::optional<ScatterSample> VertexBsdf::sample(const Interface& at, const std::array<float, 4>& u) const {
  Rgb specular;
  const auto sample = at.bsdf.sample(u[0], {u[1], u[2]}, seeks_specular_ ? &specular : nullptr);
  if (!sample) return std::nullopt;
  record_lobe(sample->lobe, sample->f, sample->pdf);
  ScatterSample scattered{sample->lobe};
  scattered.pdf = std::numeric_limits<float>::infinity();
  if (sample->lobe == Lobe::subsurface) {
    scattered.weight = sample->f * (1 / sample->pdf);
    return scattered;
  }
  const Vec3f wi = v_.frame.to_world(sample->wi);
  scattered.side = side_of(at.bsdf, sample->wi, wi);
  if (scattered.side == Side::neither) return std::nullopt;
  if (sample->lobe == Lobe::straight) {
    scattered.wi = incoming_;
    scattered.weight = sample->f * (1 / sample->pdf);
    scattered.specular = Rgb(1.0f);
    return scattered;
  }
  scattered.wi = wi;
  scattered.weight = sample->f * (std::abs(sample->wi.z) / sample->pdf);
  scattered.pdf = sample->pdf;
  if (seeks_specular_) scattered.specular = share_of(specular, sample->f);
  return scattered;
}

std::optional<ScatterSample> VertexBsdf::sample_exit(const std::array<float, 4>& u) const {
  ScatterSample scattered{Lobe::diffuse};
  scattered.wi = v_.frame.to_world(sample_cosine_hemisphere({u[0], u[1]}));
  const ScatterValue value = evaluate_exit(scattered.wi);
  if (!(value.pdf > 0)) return std::nullopt;
  scattered.weight = value.f_cos * (1 / value.pdf);
  scattered.pdf = value.pdf;
  return scattered;
}

std::optional<ScatterSample> VertexBsdf::sample(const std::array<float, 4>& u) const {
  switch (v_.kind) {
    case Vertex::Kind::surface:
      return sample(std::get<DisneyBsdf>(bsdf_), u);
    case Vertex::Kind::interface:
      return sample(std::get<Interface>(bsdf_), u);
    case Vertex::Kind::exit:
      return sample_exit(u);
    case Vertex::Kind::within:
      break;
  }
  return ScatterSample{Lobe::subsurface};
}

ControlVariate VertexBsdf::control_variate(const std::array<float, 4>& u) const {
  constexpr float kOverflows = 1e30f;  // beyond, a drawn distance may be infinite
  const DisneyParameters& p = v_.material;
  if (v_.kind != Vertex::Kind::surface || !p.scatters() || context_.mode() != SubsurfaceMode::walk ||
      !context_.settings.walk.twins || p.scatter_anisotropy != 0 || !(max_component(p.scatter_distance) < kOverflows) ||
      is_black(subsurface_entry()))
    return {};
  ControlVariate control;
  control.active = true;
  control.albedo = obtained_albedo(p.base_color, context_.settings.inversion);
  control.light_numbers = u;
  return control;
}

}  // namespace alabaster
