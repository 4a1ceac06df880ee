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
    : context_(context),
      v_(v),
      incoming_(path.ray.dir),
      seeks_specular_(path.seeks_layer() || context.scene.features.lobe_scales) {
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

Side VertexBsdf::side_of(const DisneyTransmissiveBsdf& bsdf, const Vec3f& wi_local, const Vec3f& wi) const {
  if (bsdf.reflects_to(wi_local) && v_.is_above_surface(wi)) return Side::near;
  return wi_local.z < 0 && dot(wi, v_.smooth_normal()) < 0 && dot(wi, v_.hit.ng) < 0 ? Side::far : Side::neither;
}

ScatterValue VertexBsdf::evaluate(const Interface& at, const Vec3f& wi, Side side) const {
  const Vec3f local = v_.frame.to_local(wi);
  if (side_of(at.bsdf, local, wi) != side) return {};
  Rgb specular;
  const BsdfValue value = at.bsdf.evaluate(local, seeks_specular_ ? &specular : nullptr);
  return {side == Side::far ? value.f_cos * at.factor : value.f_cos, value.pdf,
          seeks_specular_ ? share_of(specular, value.f_cos) : Rgb(0.0f)};
}

void VertexBsdf::record_lobe(const BsdfSample& sample) const {
  if (context_.record) context_.record->sample_lobe(lobe_name(sample.lobe), sample.f_cos, sample.pdf);
}

bool VertexBsdf::sample(const DisneyBsdf& bsdf, const std::array<float, 4>& u, ScatterSample* out) const {
  Rgb specular;
  const auto sample = bsdf.sample(u[0], {u[1], u[2]}, seeks_specular_ ? &specular : nullptr);
  if (!sample) return false;
  DCHECK_GE(sample->pdf, 0.0f);
  record_lobe(*sample);
  out->lobe = sample->lobe;
  out->weight = sample->weight();
  if (sample->lobe == Lobe::subsurface) return true;
  out->wi = v_.frame.to_world(sample->wi);
  out->side = Side::near;
  out->pdf = sample->pdf;
  if (seeks_specular_) out->specular = share_of(specular, sample->f_cos);
  return v_.is_above_surface(out->wi);
}

bool VertexBsdf::sample(const Interface& at, const std::array<float, 4>& u, ScatterSample* out) const {
  Rgb specular;
  const auto sample = at.bsdf.sample(u[0], {u[1], u[2]}, seeks_specular_ ? &specular : nullptr);
  if (!sample) return false;
  record_lobe(*sample);
  out->lobe = sample->lobe;
  out->weight = sample->weight();
  const bool is_discrete = sample->lobe == Lobe::subsurface || sample->lobe == Lobe::straight;
  out->pdf = is_discrete ? std::numeric_limits<float>::infinity() : sample->pdf;
  if (sample->lobe == Lobe::subsurface) return true;
  const Vec3f wi = v_.frame.to_world(sample->wi);
  out->side = side_of(at.bsdf, sample->wi, wi);
  out->wi = sample->lobe == Lobe::straight ? incoming_ : wi;
  if (seeks_specular_) out->specular = sample->lobe == Lobe::straight ? Rgb(1.0f) : share_of(specular, sample->f_cos);
  return out->side != Side::neither;
}

bool VertexBsdf::sample_exit(const std::array<float, 4>& u, ScatterSample* out) const {
  out->lobe = Lobe::diffuse;
  out->wi = v_.frame.to_world(sample_cosine_hemisphere({u[0], u[1]}));
  out->side = Side::near;
  const ScatterValue value = evaluate_exit(out->wi);
  out->weight = value.f_cos * (1 / value.pdf);
  out->pdf = value.pdf;
  return value.pdf > 0;
}

bool VertexBsdf::sample(const std::array<float, 4>& u, ScatterSample* out) const {
  switch (v_.kind) {
    case Vertex::Kind::surface:
      return sample(std::get<DisneyBsdf>(bsdf_), u, out);
    case Vertex::Kind::interface:
      return sample(std::get<Interface>(bsdf_), u, out);
    case Vertex::Kind::exit:
      return sample_exit(u, out);
    case Vertex::Kind::within:
      break;
  }
  out->lobe = Lobe::subsurface;
  out->weight = Rgb(1.0f);
  return true;
}

bool VertexBsdf::has_twins() const {
  constexpr float kOverflows = 1e30f;  // beyond, a drawn distance may be infinite
  const DisneyParameters& p = v_.material;
  return v_.kind == Vertex::Kind::surface && p.scatters() && context_.mode() == SubsurfaceMode::walk &&
         context_.settings.walk.twins && p.scatter_anisotropy == 0 && max_component(p.scatter_distance) < kOverflows &&
         !is_black(subsurface_entry());
}

}  // namespace alabaster
