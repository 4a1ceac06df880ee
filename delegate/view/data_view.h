// Shows AOVs that are no light: numbers as gray from the least to the greatest, directions and places as colours, ids
// as colours of their own.
#pragma once

#include <array>
#include <memory>
#include <string>

#include "delegate/api/prims.h"

namespace alabaster::view {

enum class DataKind { light, direction, vector, number, id };

/// The kind of an AOV. Light, and colours of surfaces, are shown by a display transform instead.
DataKind data_kind(const std::string& aov);

/// The least and the greatest finite number of a buffer's pixels, which are of format float32 or int32 and `components`
/// each; only places where `ids` (null: everywhere) is not negative count. 0 and 1 if there is none.
std::array<float, 2> finite_range(const float* pixels, const int32_t* ids, size_t count, size_t components);

class DataView final : public hd::PixelTransform {
 public:
  DataView(DataKind kind, std::array<float, 2> range) : kind_(kind), range_(range) {}
  void Apply(std::span<float> rgba) const override;

 private:
  const DataKind kind_;
  const std::array<float, 2> range_;
};

/// Light of one component, such as AOV `error`: gray, as a display shows it. Null: as it is.
class GrayLight final : public hd::PixelTransform {
 public:
  explicit GrayLight(std::shared_ptr<const hd::PixelTransform> display) : display_(std::move(display)) {}
  void Apply(std::span<float> rgba) const override;

 private:
  const std::shared_ptr<const hd::PixelTransform> display_;
};

}  // namespace alabaster::view
