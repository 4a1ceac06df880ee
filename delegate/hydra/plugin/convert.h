// Values of OpenUSD as values of the contract, and back. Arrays share their memory.
#pragma once

#include <pxr/base/gf/matrix4d.h>
#include <pxr/base/vt/array.h>
#include <pxr/base/vt/dictionary.h>
#include <pxr/imaging/hd/types.h>
#include <pxr/usd/sdf/path.h>

#include "delegate/hydra/host_values.h"

namespace alabaster::hydra {

inline hd::Token ToToken(const pxr::TfToken& token) {
  return hd::Token(token.GetString());
}
template <class Tokens>
std::vector<hd::Token> ToTokens(const Tokens& tokens) {
  std::vector<hd::Token> ours;
  for (const pxr::TfToken& token : tokens) ours.push_back(ToToken(token));
  return ours;
}
inline hd::Path ToPath(const pxr::SdfPath& path) {
  return path.IsEmpty() ? hd::Path() : hd::Path(path.GetString());
}
hd::Matrix4d ToMatrix(const pxr::GfMatrix4d& matrix);
/// Empty for types that the contract lacks.
hd::Value ToValue(const pxr::VtValue& value);
hd::Format ToFormat(pxr::HdFormat format);

pxr::VtValue FromValue(const hd::Value& value);
pxr::VtDictionary FromDictionary(const hd::Dictionary& dictionary);
pxr::HdFormat FromFormat(hd::Format format);

/// The array's memory, alive for as long as the result.
template <class Ours, class Theirs>
hd::Array<Ours> ToArray(const pxr::VtArray<Theirs>& array) {
  static_assert(sizeof(Ours) == sizeof(Theirs));
  const auto held = std::make_shared<const pxr::VtArray<Theirs>>(array);
  return hd::Array<Ours>(held, reinterpret_cast<const Ours*>(held->cdata()), held->size());
}

}  // namespace alabaster::hydra
