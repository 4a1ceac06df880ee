// Decides what a render product's file will hold, once for the check before rendering and for the writing.
#pragma once

#include <array>
#include <span>

#include "core/images/image_file.h"
#include "delegate/api/scene_types.h"

namespace alabaster::hd::host {

/// One channel of the file. The usual names are those of kAovs (core/film/aov.h) and delegate/manual/pipeline.md.
/// A RenderVar whose name is not its AOV's gives a layer: name.R, name.Z, ...; name.X for ids and counts.
/// Z is the distance along the view in world units, 1e10 where nothing was hit (as Cycles writes it). depth.Z is
/// Hydra's clip depth, 0 near to 1 far. Depths and counts of samples are float32 (uint32 with data type "int"). Ids are
/// uint32, and -1 (nothing hit) becomes 4294967295. With data type "float" ids are float32: -1 stays -1, and ids are
/// exact up to 2^24. Half would merge neighbouring ids.
struct PlannedChannel {
  std::string name;
  Token aov;
  int component = 0;
  bool is_color = false;     // goes through the colour transform, with its neighbours
  bool is_distance = false;  // 0 means that nothing was hit
  ChannelStore store = ChannelStore::half;
};

struct ProductPlan {
  FileKind kind = FileKind::exr;
  bool display_referred = false;  // display and view, else a scene-referred space
  std::string compression;        // of an EXR
  int tiles = 0;                  // the same: pixels of a side; 0: scanlines
  std::vector<PlannedChannel> channels;
};

/// Ways to compress an EXR. The last five lose bits of floats or halves.
inline constexpr std::array kCompressions{"none", "rle", "zip", "zips", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab"};
inline constexpr std::span kLossyCompressions = std::span(kCompressions).last(5);

/// The vars that the product's file holds. Color brings its own alpha, so an alpha beside it is left out. With
/// `denoise` set, AOV denoised stands beside color in an EXR and in its place in other files.
std::vector<RenderVar> WantedVars(const RenderProduct& product);

/// Pixels that a picture has a side, at most.
inline constexpr int64_t kMostPixels = 65536;

/// Why a file of the plan's kind cannot hold the pixels of `window`, and what to do about it; empty if it can.
std::string window_fault(const ProductPlan& plan, const Rect2i& window);

/// Returns false if the product contradicts itself; `error` then says what is wrong and what to do about it. Looks
/// neither at the disk nor at the colour configuration.
bool PlanProduct(const RenderProduct& product, ProductPlan& plan, std::string& error);

}  // namespace alabaster::hd::host
