#include "delegate/hydra/plugin/convert.h"

#include <pxr/base/gf/half.h>
#include <pxr/base/gf/quatf.h>
#include <pxr/base/gf/quath.h>
#include <pxr/base/gf/vec2d.h>
#include <pxr/base/gf/vec2f.h>
#include <pxr/base/gf/vec2h.h>
#include <pxr/base/gf/vec2i.h>
#include <pxr/base/gf/vec3d.h>
#include <pxr/base/gf/vec3f.h>
#include <pxr/base/gf/vec3h.h>
#include <pxr/base/gf/vec3i.h>
#include <pxr/base/gf/vec4d.h>
#include <pxr/base/gf/vec4f.h>
#include <pxr/base/gf/vec4h.h>
#include <pxr/usd/sdf/assetPath.h>

#include <cstring>

namespace alabaster::hydra {
namespace {

/// A type of OpenUSD's and one of the contract's that have the same bytes, in values and in arrays.
template <class Theirs, class Ours>
struct Same {
  static bool take(const pxr::VtValue& value, hd::Value* out) {
    static_assert(sizeof(Ours) == sizeof(Theirs));
    if (value.IsHolding<Theirs>()) {
      Ours held;
      std::memcpy(static_cast<void*>(&held), &value.UncheckedGet<Theirs>(), sizeof held);
      *out = held;
      return true;
    }
    if (!value.IsHolding<pxr::VtArray<Theirs>>()) return false;
    *out = ToArray<Ours>(value.UncheckedGet<pxr::VtArray<Theirs>>());
    return true;
  }
};

template <class... Pairs>
bool take_first(const pxr::VtValue& value, hd::Value* out) {
  return (Pairs::take(value, out) || ...);
}

// OpenUSD's quaternions hold the real part last, Imath's first.
template <class Quaternion>
hd::Quatf quaternion(const Quaternion& q) {
  const auto& v = q.GetImaginary();
  return {static_cast<float>(q.GetReal()), static_cast<float>(v[0]), static_cast<float>(v[1]),
          static_cast<float>(v[2])};
}

template <class Quaternion>
bool take_quaternions(const pxr::VtValue& value, hd::Value* out) {
  if (value.IsHolding<Quaternion>()) return *out = quaternion(value.UncheckedGet<Quaternion>()), true;
  if (!value.IsHolding<pxr::VtArray<Quaternion>>()) return false;
  std::vector<hd::Quatf> all;
  for (const Quaternion& q : value.UncheckedGet<pxr::VtArray<Quaternion>>()) all.push_back(quaternion(q));
  *out = hd::Array<hd::Quatf>(std::move(all));
  return true;
}

// An asset that the resolver did not find keeps its name: the report then tells it.
hd::AssetPath asset(const pxr::SdfAssetPath& path) {
  const std::string& found = path.GetResolvedPath();
  return {path.GetAssetPath(), found.empty() ? path.GetAssetPath() : found, nullptr};
}

bool take_words(const pxr::VtValue& value, hd::Value* out) {
  if (value.IsHolding<pxr::TfToken>()) return *out = ToToken(value.UncheckedGet<pxr::TfToken>()), true;
  if (value.IsHolding<std::string>()) return *out = value.UncheckedGet<std::string>(), true;
  if (value.IsHolding<pxr::SdfPath>()) return *out = ToPath(value.UncheckedGet<pxr::SdfPath>()), true;
  if (value.IsHolding<pxr::SdfAssetPath>()) return *out = asset(value.UncheckedGet<pxr::SdfAssetPath>()), true;
  return false;
}

}  // namespace

hd::Matrix4d ToMatrix(const pxr::GfMatrix4d& matrix) {
  hd::Matrix4d ours;
  std::memcpy(&ours.x[0][0], matrix.GetArray(), sizeof ours.x);
  return ours;
}

hd::Value ToValue(const pxr::VtValue& value) {
  using namespace pxr;
  hd::Value out;
  if (value.IsEmpty()) return out;
  if (take_first<Same<float, float>, Same<GfVec3f, hd::Vec3f>, Same<GfVec2f, hd::Vec2f>, Same<bool, bool>,
                 Same<int, int32_t>, Same<double, double>, Same<long, int64_t>, Same<unsigned, uint32_t>,
                 Same<GfVec4f, hd::Vec4f>, Same<GfMatrix4d, hd::Matrix4d>, Same<GfHalf, hd::Half>,
                 Same<GfVec2i, hd::Vec2i>, Same<GfVec3i, hd::Vec3i>, Same<GfVec2d, hd::Vec2d>, Same<GfVec3d, hd::Vec3d>,
                 Same<GfVec4d, hd::Vec4d>, Same<GfVec2h, hd::Vec2h>, Same<GfVec3h, hd::Vec3h>,
                 Same<GfVec4h, hd::Vec4h>>(value, &out))
    return out;
  if (take_words(value, &out) || take_quaternions<GfQuatf>(value, &out) || take_quaternions<GfQuath>(value, &out))
    return out;
  return {};
}

namespace {

// Formats that the contract lacks are invalid: the host's Allocate then fails, and it drops the AOV.
constexpr std::pair<pxr::HdFormat, hd::Format> kFormats[] = {{pxr::HdFormatUNorm8, hd::Format::unorm8},
                                                             {pxr::HdFormatUNorm8Vec3, hd::Format::unorm8vec3},
                                                             {pxr::HdFormatUNorm8Vec4, hd::Format::unorm8vec4},
                                                             {pxr::HdFormatFloat16, hd::Format::float16},
                                                             {pxr::HdFormatFloat16Vec3, hd::Format::float16vec3},
                                                             {pxr::HdFormatFloat16Vec4, hd::Format::float16vec4},
                                                             {pxr::HdFormatFloat32, hd::Format::float32},
                                                             {pxr::HdFormatFloat32Vec2, hd::Format::float32vec2},
                                                             {pxr::HdFormatFloat32Vec3, hd::Format::float32vec3},
                                                             {pxr::HdFormatFloat32Vec4, hd::Format::float32vec4},
                                                             {pxr::HdFormatInt32, hd::Format::int32}};

}  // namespace

hd::Format ToFormat(pxr::HdFormat format) {
  for (const auto& [theirs, ours] : kFormats)
    if (theirs == format) return ours;
  return hd::Format::invalid;
}

pxr::HdFormat FromFormat(hd::Format format) {
  for (const auto& [theirs, ours] : kFormats)
    if (ours == format) return theirs;
  return pxr::HdFormatInvalid;
}

pxr::VtValue FromValue(const hd::Value& value) {
  if (const auto* held = value.get<bool>()) return pxr::VtValue(*held);
  if (const auto* held = value.get<int32_t>()) return pxr::VtValue(*held);
  if (const auto* held = value.get<uint32_t>()) return pxr::VtValue(*held);
  // Hosts make controls for int, but not for long.
  if (const auto* held = value.get<int64_t>())
    return *held == static_cast<int>(*held) ? pxr::VtValue(static_cast<int>(*held)) : pxr::VtValue(*held);
  if (const auto* held = value.get<float>()) return pxr::VtValue(*held);
  if (const auto* held = value.get<double>()) return pxr::VtValue(*held);
  if (const auto* held = value.get<hd::Vec4f>()) return pxr::VtValue(pxr::GfVec4f(held->x, held->y, held->z, held->w));
  if (const auto* held = value.get<hd::Vec3f>()) return pxr::VtValue(pxr::GfVec3f(held->x, held->y, held->z));
  const std::string text = value.text_or("");
  return value.empty() ? pxr::VtValue() : pxr::VtValue(text.empty() ? value.to_string() : text);
}

pxr::VtDictionary FromDictionary(const hd::Dictionary& dictionary) {
  pxr::VtDictionary theirs;
  for (const auto& [key, value] : dictionary) theirs[key] = FromValue(value);
  return theirs;
}

}  // namespace alabaster::hydra
