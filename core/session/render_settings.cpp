#include "core/session/render_settings.h"

namespace alabaster {

std::span<const SettingParameter> setting_parameters() {
  using S = RenderSettings;
  using setting_use::kContinues, setting_use::kLive, setting_use::kNoPixels, setting_use::kResyncs;
  // The second line of a row is its unit and its description. clang-format would give each element a line.
  // clang-format off
  static constexpr SettingParameter kTable[] = {
      {"samples", &S::samples, 1, 1048576, {},
       "per pixel", "Camera samples per pixel, at most.", kContinues},
      {"firstSample", &S::first_sample, 0, 1048575, {},
       "per pixel", "The first of the samples to take, below 'samples': those before it are left to other renders, "
       "whose checkpoints can be merged with this one's. Not with 'targetError', 'adaptive' or 'timeLimit'.",
       kNoPixels},
      {"targetError", &S::target_error, 0, 1, {},
       "relative RMSE", "The render ends when its own estimate of the noise of the picture as rendered, before any "
       "denoising, is near this: the root mean square over the frame of error / sqrt(level^2 + (0.05 of the mean "
       "level)^2). Each quarter of the pixels ends when the estimate of another quarter is below it. 0: only samples "
       "end the render."},
      {"adaptive", &S::adaptive, -kUnbounded, kUnbounded, {},
       "none", "Allocates samples by noise, after 16 for every pixel. 'samples' is then the mean over pixels, and "
       "the number of samples of a pixel never depends on its own samples. Takes effect from 32 samples on."},
      {"timeLimit", &S::time_limit, 0, 31536000, {},
       "seconds", "The render ends after this time, pauses not counted. A pixel that has no sample by then may take "
       "its first one up to half a second later. If pixels are left without a sample, a warning, the statistics and "
       "the EXR (pixelsWithoutSample) tell how many; AOV sampleCount is 0 there, and blocks of pixels without any "
       "sample have alpha 0. Denoising comes after the limit. 0: no limit. With this setting alone the picture "
       "depends on the machine.", kContinues | kNoPixels},
      {"seed", &S::seed, 0, 4294967295.0, {},
       "none", "Selects the noise pattern; all seeds are equally good."},
      {"frame", &S::frame, 0, 4294967295.0, {},
       "frames", "Frame number; decorrelates the noise of successive frames."},
      {"maxDepth", &S::max_depth, 0, 1024, {},
       "bounces", "Bounces between surfaces, at most; a subsurface walk of any length counts as one."},
      {"threads", &S::threads, 0, 4096, {},
       "threads", "Render threads; 0 uses all cores. The picture does not depend on it.", kContinues | kNoPixels},
      {"subsurface", &S::subsurface, 0, 0, {"lambert", "walk", "reference", "diffusion"},
       "none", "Rendering of scatterDistance: not at all (lambert), path-traced random walks (walk), walks without "
       "any shortcut for comparison (reference), or normalized diffusion as in the paper's comparison (diffusion)."},
      {"inversion", &S::inversion, 0, 0, {"chiang2016", "exact"},
       "none", "Inversion that gives the single-scattering albedo for baseColor: the paper's fit (chiang2016), which "
       "obtains 0.926 for 1, or the exact solution (exact)."},
      {"walkGuiding", &S::walk_guiding, -kUnbounded, kUnbounded, {},
       "none", "Guides walks back to the surface (Dwivedi) where that pays. Affects only noise; mode 'reference' "
       "never does it."},
      {"walkSphereSteps", &S::walk_sphere_steps, -kUnbounded, kUnbounded, {},
       "none", "Lets walks jump through the interior where that pays. The bias is below 3e-4 of the albedo; mode "
       "'reference' never does it."},
      {"energy", &S::energy, 0, 0, {"burley2015", "bounded", "conserving"},
       "none", "Energy of the surface's lobes: as published, where their sum may reflect more than it receives "
       "(burley2015); as published wherever that keeps energy and dimmed where it would not (bounded); or that with "
       "what rough specular facets lose between them given back (conserving)."},
      {"textureMemory", &S::texture_memory, 1, 16777216, {},
       "MiB", "Memory for the texels of images. Half of it holds images for the whole render. Those that come when "
       "it is spent are read tile by tile from a temporary file, and the other half caches their tiles. Pictures do "
       "not depend on it. Counts for images that are read after it is set.", kLive | kNoPixels},
      {"memoryLimit", &S::memory_limit, 0, 16777216, {},
       "MiB", "Memory of the renderer: meshes as given and as refined, their ray tracing hierarchies, distance "
       "grids, texels, lights and frames. Memory beyond it is refused, with an error that names each use and the "
       "bytes that it holds. The object can be built once the limit is raised or other things are gone. 0: three "
       "quarters of what the process may use, which is the machine's memory or a lower limit of its cgroup or of its "
       "address space; the rest is left to the libraries, to what malloc keeps and to the system. Pictures do not "
       "depend on it.", kLive | kNoPixels},
      {"textureFilter", &S::texture_filter, 0, 8, {},
       "none", "Colours of images are read as means over what a path covers of the surface, a pixel or the spread of "
       "a bounce, times this. 0 reads points, without bias. 0.5 to 1 blurs images by as much of a pixel, and has "
       "less noise where texels are smaller than pixels; it needs memory for the means. Roughness, normals, opacity "
       "and other numbers are always read at points."},
      {"glossyFilter", &S::glossy_filter, 0, 1, {},
       "none", "Light that comes by way of other surfaces sees narrow glossy lobes as wide as the bundle of "
       "directions that a path stands for, times this. 0 is without bias. Above 0 caustics and reflections of "
       "reflections are softer and have much less noise, and surfaces that the camera sees, directly or in mirrors, "
       "stay sharp. Mode 'reference' never does it."},
      {"refineEdgeLength", &S::refine_edge_length, 0, 1024, {},
       "pixels", "Refines meshes whose refineLevel is above 0 adaptively: edges of their triangles are at most about "
       "as long as this in the picture of the RenderSettings prim's camera, wherever the surface faces. 0: by their "
       "refineLevel.", kResyncs},
      {"filter", &S::filter, 0, 0, {"box", "triangle", "gaussian", "blackmanHarris"},
       "none", "Pixel filter."},
      {"ambientOcclusionDistance", &S::ambient_occlusion_distance, 0, kUnbounded, {},
       "scene unit", "AOV ambientOcclusion: surfaces that are farther away than this do not occlude. 0: all do."},
      {"motionShutter", &S::motion_shutter, 0, 0, {"frame", "camera"},
       "none", "The time whose motion AOV motion shows: from the frame that is drawn to the next one (frame), also "
       "with a closed shutter, or while the camera's shutter is open (camera).", kNoPixels},
      {"cryptoRanks", &S::crypto_ranks, 2, 16, {},
       "none", "Objects, materials or assets that a pixel of a file's Cryptomatte layers names, those with the largest "
       "coverage; an odd number is raised by one. The renderer counts all of them.", kLive | kNoPixels},
      {"denoise", &S::denoise, -kUnbounded, kUnbounded, {},
       "none", "Denoises the picture after its last sample with Open Image Denoise 2, which must be installed. AOV "
       "'denoised' holds the result and 'color' stays as rendered; where a host draws 'color' alone, it shows the "
       "denoised picture.", kContinues | kNoPixels},
  };
  // clang-format on
  return kTable;
}

IntegratorSettings integrator_settings(const RenderSettings& s) {
  const bool shortcuts = s.subsurface != SubsurfaceMode::reference;
  IntegratorSettings out{s.max_depth, s.subsurface, s.inversion, {}, s.energy, s.texture_filter, s.glossy_filter};
  if (!shortcuts) out.glossy_filter = 0;
  out.ambient_occlusion_distance = s.ambient_occlusion_distance;
  out.walk.guiding = shortcuts && s.walk_guiding;
  out.walk.twins = shortcuts;
  out.walk.sphere_steps = shortcuts && s.walk_sphere_steps;
  return out;
}

}  // namespace alabaster
