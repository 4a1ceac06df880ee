#include "core/session/render_settings.h"

namespace alabaster {

std::span<const SettingParameter> setting_parameters() {
  using S = RenderSettings;
  static constexpr SettingParameter kTable[] = {
      {"samples", &S::samples, 1, 1048576},
      {"firstSample", &S::first_sample, 0, 1048575},
      {"targetError", &S::target_error, 0, 1},
      {"adaptive", &S::adaptive},
      {"timeLimit", &S::time_limit, 0, 31536000},
      {"seed", &S::seed, 0, 4294967295.0},
      {"frame", &S::frame, 0, 4294967295.0},
      {"maxDepth", &S::max_depth, 0, 1024},
      {"threads", &S::threads, 0, 4096},
      {"subsurface", &S::subsurface, 0, 0, {"lambert", "walk", "reference", "diffusion"}},
      {"inversion", &S::inversion, 0, 0, {"chiang2016", "exact"}},
      {"walkGuiding", &S::walk_guiding},
      {"walkSphereSteps", &S::walk_sphere_steps},
      {"energy", &S::energy, 0, 0, {"burley2015", "bounded", "conserving"}},
      {"textureMemory", &S::texture_memory, 1, 16777216},
      {"memoryLimit", &S::memory_limit, 0, 16777216},
      {"textureFilter", &S::texture_filter, 0, 8},
      {"glossyFilter", &S::glossy_filter, 0, 1},
      {"refineEdgeLength", &S::refine_edge_length, 0, 1024},
      {"filter", &S::filter, 0, 0, {"box", "triangle", "gaussian", "blackmanHarris"}},
      {"denoise", &S::denoise},
  };
  return kTable;
}

IntegratorSettings integrator_settings(const RenderSettings& s) {
  const bool shortcuts = s.subsurface != SubsurfaceMode::reference;
  IntegratorSettings out{s.max_depth, s.subsurface, s.inversion, {}, s.energy, s.texture_filter, s.glossy_filter};
  if (!shortcuts) out.glossy_filter = 0;
  out.walk.guiding = shortcuts && s.walk_guiding;
  out.walk.twins = shortcuts;
  out.light_paths = shortcuts && out.glossy_filter == 0;  // filtered gloss has no fireflies
  out.walk.sphere_steps = shortcuts && s.walk_sphere_steps;
  return out;
}

}  // namespace alabaster
