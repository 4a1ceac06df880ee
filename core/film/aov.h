// The AOVs: one table for the film, the delegate's descriptors, the layers of products and the list in delegate/manual.
#pragma once

#include <cstdint>
#include <iterator>
#include <limits>
#include <string_view>

namespace alabaster {

enum class Aov {
  color,
  alpha,
  depth,
  camera_depth,
  camera_distance,
  normal,
  albedo,
  ambient_occlusion,
  shadow,  // on shadow catchers, by colour
  prim_id,
  instance_id,
  element_id,
  material_id,
  sample_count,
  diffuse,
  subsurface,
  subsurface_single,
  subsurface_multiple,
  subsurface_unscattered,
  specular,
  emission,
  direct_diffuse,  // light by kind: these and emission add up to color
  indirect_diffuse,
  direct_subsurface,
  indirect_subsurface,
  direct_specular,
  indirect_specular,
  transmission,
  light_group,    // light by the group of the light where it began: "lightGroup:NAME"
  error,          // of color: PixelNoise::deviation()
  nonfinite,      // samples whose colour was not finite: black in color
  denoised,       // color without its noise (core/denoise)
  crypto_object,  // Cryptomatte's layers (core/film/id_counts.h)
  crypto_material,
  crypto_asset,
  eye_point,     // Hydra's Peye
  eye_normal,    // Hydra's Neye
  position,      // in world space
  uv,            // of the mesh's texture coordinates
  motion,        // over the picture, in pixels, in the time of MotionShutter
  first_primvar  // the named primvars that a render is asked for: primvar_aov()
};
/// A set of AOVs, by aov_bit(). Checkpoints hold it.
using AovSet = uint64_t;
constexpr AovSet aov_bit(Aov a) {
  return AovSet{1} << static_cast<uint32_t>(a);
}

/// Where a pixel's value comes from.
enum class AovSource {
  samples,  // all of them: their mean, number or error
  layer,    // the mean of one of LightLayers
  group,    // the mean of the light of one group
  closest,  // the one that hit the closest surface
  ids,      // how many of the pixel's samples hit each of the things that they hit
  frame,    // all pixels' samples, once the frame has its last
};

/// The kind of a value, by which files keep it.
enum class AovValue {
  color,     // premultiplied; files convert it to their colour space
  number,    // 16 bits of float are enough
  exact,     // of a float that 16 bits would merge with its neighbours
  distance,  // such a float, of which 0 says that nothing was hit
  integer,   // int32
};

struct AovInfo {
  Aov aov;
  const char* name;
  AovSource source;
  AovValue value;
  float background;  // of each component, where nothing was hit
  // The names of channels in an EXR, as compositors know them: "layer.R". Blender leaves out a layer of one channel
  // without such a letter.
  const char* layer;     // empty: none
  const char* channels;  // one letter per component

  constexpr int components() const { return static_cast<int>(std::string_view(channels).size()); }
  constexpr bool is_integer() const { return value == AovValue::integer; }
  constexpr bool is_color() const { return value == AovValue::color; }
};

/// In the order of enum Aov, without primvars.
inline constexpr AovInfo kAovs[] = {
    {Aov::color, "color", AovSource::samples, AovValue::color, 0, "", "RGBA"},
    {Aov::alpha, "alpha", AovSource::samples, AovValue::number, 0, "", "A"},
    {Aov::depth, "depth", AovSource::closest, AovValue::exact, 1, "depth", "Z"},  // Hydra's: 0 near, 1 far
    {Aov::camera_depth, "cameraDepth", AovSource::closest, AovValue::distance, 0, "", "Z"},
    {Aov::camera_distance, "cameraDistance", AovSource::closest, AovValue::distance, 0, "cameraDistance", "Z"},
    {Aov::normal, "normal", AovSource::samples, AovValue::number, 0, "N", "XYZ"},
    {Aov::albedo, "albedo", AovSource::samples, AovValue::color, 0, "albedo", "RGB"},
    {Aov::ambient_occlusion, "ambientOcclusion", AovSource::samples, AovValue::number, 0, "ambientOcclusion", "X"},
    {Aov::shadow, "shadow", AovSource::samples, AovValue::number, 0, "shadow", "RGB"},
    {Aov::prim_id, "primId", AovSource::closest, AovValue::integer, -1, "primId", "X"},
    {Aov::instance_id, "instanceId", AovSource::closest, AovValue::integer, -1, "instanceId", "X"},
    {Aov::element_id, "elementId", AovSource::closest, AovValue::integer, -1, "elementId", "X"},
    {Aov::material_id, "materialId", AovSource::closest, AovValue::integer, -1, "materialId", "X"},
    {Aov::sample_count, "sampleCount", AovSource::samples, AovValue::integer, 0, "sampleCount", "X"},
    {Aov::diffuse, "diffuse", AovSource::layer, AovValue::color, 0, "diffuse", "RGB"},
    {Aov::subsurface, "subsurface", AovSource::layer, AovValue::color, 0, "subsurface", "RGB"},
    {Aov::subsurface_single, "subsurfaceSingle", AovSource::layer, AovValue::color, 0, "subsurfaceSingle", "RGB"},
    {Aov::subsurface_multiple, "subsurfaceMultiple", AovSource::layer, AovValue::color, 0, "subsurfaceMultiple", "RGB"},
    {Aov::subsurface_unscattered, "subsurfaceUnscattered", AovSource::layer, AovValue::color, 0,
     "subsurfaceUnscattered", "RGB"},
    {Aov::specular, "specular", AovSource::layer, AovValue::color, 0, "specular", "RGB"},
    {Aov::emission, "emission", AovSource::layer, AovValue::color, 0, "emission", "RGB"},
    {Aov::direct_diffuse, "directDiffuse", AovSource::layer, AovValue::color, 0, "directDiffuse", "RGB"},
    {Aov::indirect_diffuse, "indirectDiffuse", AovSource::layer, AovValue::color, 0, "indirectDiffuse", "RGB"},
    {Aov::direct_subsurface, "directSubsurface", AovSource::layer, AovValue::color, 0, "directSubsurface", "RGB"},
    {Aov::indirect_subsurface, "indirectSubsurface", AovSource::layer, AovValue::color, 0, "indirectSubsurface", "RGB"},
    {Aov::direct_specular, "directSpecular", AovSource::layer, AovValue::color, 0, "directSpecular", "RGB"},
    {Aov::indirect_specular, "indirectSpecular", AovSource::layer, AovValue::color, 0, "indirectSpecular", "RGB"},
    {Aov::transmission, "transmission", AovSource::layer, AovValue::color, 0, "transmission", "RGB"},
    {Aov::light_group, "lightGroup:", AovSource::group, AovValue::color, 0, "lightGroup", "RGB"},
    {Aov::error, "error", AovSource::samples, AovValue::exact, 0, "error", "X"},
    {Aov::nonfinite, "nonfiniteSamples", AovSource::samples, AovValue::integer, 0, "nonfiniteSamples", "X"},
    {Aov::denoised, "denoised", AovSource::frame, AovValue::color, 0, "denoised", "RGBA"},
    {Aov::crypto_object, "cryptoObject", AovSource::ids, AovValue::exact, 0, "CryptoObject00", "RGBA"},
    {Aov::crypto_material, "cryptoMaterial", AovSource::ids, AovValue::exact, 0, "CryptoMaterial00", "RGBA"},
    {Aov::crypto_asset, "cryptoAsset", AovSource::ids, AovValue::exact, 0, "CryptoAsset00", "RGBA"},
    {Aov::eye_point, "Peye", AovSource::closest, AovValue::exact, 0, "Peye", "XYZ"},
    {Aov::eye_normal, "Neye", AovSource::closest, AovValue::number, 0, "Neye", "XYZ"},
    {Aov::position, "position", AovSource::closest, AovValue::exact, 0, "P", "XYZ"},
    {Aov::uv, "uv", AovSource::closest, AovValue::exact, 0, "uv", "UV"},
    {Aov::motion, "motion", AovSource::closest, AovValue::exact, 0, "motion", "XY"},
};
inline constexpr AovInfo kPrimvarAov = {Aov::first_primvar, "primvars:", AovSource::closest, AovValue::exact, 0,
                                        "primvars",         "XYZ"};

/// A render shows this many primvars at most. Each takes the place of one of its names.
inline constexpr size_t kMostPrimvarAovs = 8;
constexpr Aov primvar_aov(size_t name) {
  return static_cast<Aov>(static_cast<size_t>(Aov::first_primvar) + name);
}
constexpr bool is_primvar(Aov a) {
  return a >= Aov::first_primvar;
}

/// Primvars included. Each number of enum Aov is below it.
inline constexpr size_t kAovCount = std::size(kAovs) + kMostPrimvarAovs;

static_assert(std::size(kAovs) == static_cast<size_t>(Aov::first_primvar));
static_assert(kAovCount <= std::numeric_limits<AovSet>::digits, "AovSet has no bit for another AOV: see its comment");
static_assert([] {
  for (size_t i = 0; i < std::size(kAovs); ++i)
    if (kAovs[i].aov != static_cast<Aov>(i)) return false;
  return true;
}());

constexpr const AovInfo& aov_info(Aov a) {
  return is_primvar(a) ? kPrimvarAov : kAovs[static_cast<size_t>(a)];
}
/// NAME of an AOV "primvars:NAME"; empty for others.
constexpr std::string_view primvar_of_aov(std::string_view name) {
  const std::string_view prefix = kPrimvarAov.name;
  return name.starts_with(prefix) ? name.substr(prefix.size()) : std::string_view();
}
/// A frame shows this many light groups at most, light without a group included.
inline constexpr size_t kMostLightGroups = 64;
/// True for an AOV "lightGroup:NAME". All have one row.
constexpr bool is_light_group(std::string_view name) {
  return name.starts_with(aov_info(Aov::light_group).name);
}
/// NAME of such an AOV; empty: it shows light without a group.
constexpr std::string_view light_group_of_aov(std::string_view name) {
  return name.substr(std::string_view(aov_info(Aov::light_group).name).size());
}
/// An AOV of ids shows two ranks of a pixel's ids: its name ends with the number of the pair, of two digits, or shows
/// the first pair.
struct RankPair {
  std::string_view aov;  // without the digits
  int number = 0;
};
inline constexpr int kMostRankPairs = 8;
constexpr RankPair rank_pair(std::string_view name) {
  const size_t base = name.size() < 2 ? 0 : name.size() - 2;
  const std::string_view digits = name.substr(base);
  if (!name.starts_with("crypto") || digits.size() < 2 || digits[0] != '0' || digits[1] < '0' ||
      digits[1] >= '0' + kMostRankPairs)
    return {name};
  return {name.substr(0, base), digits[1] - '0'};
}
/// Null if no AOV has this name. All primvars have one row, and so have all light groups and all pairs of ranks.
constexpr const AovInfo* find_aov(std::string_view name) {
  if (!primvar_of_aov(name).empty()) return &kPrimvarAov;
  if (is_light_group(name)) return &aov_info(Aov::light_group);
  for (const AovInfo& info : kAovs)
    if (rank_pair(name).aov == info.name) return &info;
  return nullptr;
}

/// Bits of all AOVs from one source.
constexpr AovSet aovs_from(AovSource source) {
  AovSet bits = 0;
  for (const AovInfo& info : kAovs)
    if (info.source == source) bits |= aov_bit(info.aov);
  return bits;
}
/// The AOVs that need LightLayers.
inline constexpr AovSet kLayerAovs = aovs_from(AovSource::layer);
/// The AOVs of ids: Cryptomatte.
inline constexpr AovSet kIdsAovs = aovs_from(AovSource::ids);
/// Those of them that count prims, or their instances.
inline constexpr AovSet kPrimCountAovs = aov_bit(Aov::crypto_object) | aov_bit(Aov::crypto_asset);
/// Those that need the number of a sample's material.
inline constexpr AovSet kMaterialIdAovs = aov_bit(Aov::material_id) | aov_bit(Aov::crypto_material);
/// Those whose numbers stand for names.
inline constexpr AovSet kNamedAovs = kIdsAovs | aov_bit(Aov::prim_id) | aov_bit(Aov::material_id);
inline constexpr AovSet kPrimvarAovs = ((AovSet{1} << kMostPrimvarAovs) - 1)
                                       << static_cast<uint32_t>(Aov::first_primvar);
/// The AOVs that show the closest sample's first hit.
inline constexpr AovSet kClosestAovs = aovs_from(AovSource::closest) | kPrimvarAovs;
/// Those of them that need HitVectors.
inline constexpr AovSet kVectorAovs = aov_bit(Aov::eye_point) | aov_bit(Aov::eye_normal) | aov_bit(Aov::position) |
                                      aov_bit(Aov::uv) | aov_bit(Aov::motion) | kPrimvarAovs;
/// The AOVs that guide the denoiser.
inline constexpr AovSet kGuideAovs = aov_bit(Aov::normal) | aov_bit(Aov::albedo);
/// `aovs` and those that they are made from.
constexpr AovSet with_guides(AovSet aovs) {
  return aovs & aov_bit(Aov::denoised) ? aovs | kGuideAovs : aovs;
}

}  // namespace alabaster
