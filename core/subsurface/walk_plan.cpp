#include "core/subsurface/walk_plan.h"

namespace alabaster {
namespace {

// The direction to light that a walk is guided to, if that lies below the surface; else zero.
Vec3f direction_to_light(const LitSurface& lit, const SubsurfaceEntry& entry) {
  const DiffusionModes& modes = entry.medium->modes;
  double kappa = 0, mfp = 0;
  int guided = 0;
  for (size_t c = 0; c < 3; ++c) {
    if (!modes.guided[c]) continue;
    kappa += modes.kappa[c], mfp += 1 / entry.medium->sigma_t[c];
    ++guided;
  }
  if (guided == 0) return {0, 0, 0};
  const Vec3f inside = entry.hit.p - entry.hit.ng * static_cast<float>(mfp / guided);
  const Vec3f direction = lit.direction_from(inside, static_cast<float>(kappa / guided));
  return dot(direction, entry.hit.ng) < 0 ? direction : Vec3f(0, 0, 0);
}

}  // namespace

WalkPlan plan_walk(const WalkSettings& settings, const SubsurfaceBody& body, const SubsurfaceEntry& entry) {
  const WalkMedium& medium = *entry.medium;
  WalkPlan plan;
  plan.sphere_steps = settings.sphere_steps && medium.worthwhile.sphere_steps;
  if (!settings.guiding || !medium.worthwhile.guiding) return plan;

  // To the light, where the surface is turned away from it.
  const LitSurface* const lit = body.lit && !entry.within ? body.lit->get() : nullptr;
  if (lit && !lit->faces_light(entry.hit.ng)) plan.to_light = direction_to_light(*lit, entry);

  // Else back to the surface. Behind an open mesh the medium has no end, and it pays for every medium.
  const SubsurfaceBody::Member& member = body.members[entry.member];
  const bool pays_back = member.room_to_guide && (member.shells->any_open || medium.pays_to_guide_back);
  plan.guided = pays_back || plan.to_light != Vec3f(0, 0, 0);
  return plan;
}

WalkShortcuts possible_shortcuts(const WalkSettings& settings, const SubsurfaceBody& body, uint32_t member) {
  return {settings.guiding && (body.members[member].room_to_guide || body.lit),
          settings.sphere_steps && body.members[member].distances};
}

}  // namespace alabaster
