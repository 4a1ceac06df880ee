// The image nodes of MaterialX as AlabasterTexture nodes. Internal to this room.
#pragma once

#include <optional>

#include "delegate/hydra/materials.h"

namespace alabaster::hydra {

/// The constant of a node's input; empty: it has none.
hd::Value input_value(const hd::MaterialNode& node, const char* name);
/// The first connection of a node's input. Null: it is a constant.
const hd::MaterialConnection* upstream(const hd::MaterialNode& node, const char* input);

/// Follows connections up to images. Each image becomes one node of `to`, under its own path and use.
class MaterialImages {
 public:
  /// `from`, `to` and `warn` must outlive it.
  MaterialImages(const hd::MaterialNetwork& from, hd::MaterialNetwork* to, const WarnMaterial& warn)
      : from_(from), to_(to), warn_(warn) {}

  /// The connection of an input of colours or numbers; none (reported): it ends at no image.
  std::optional<hd::MaterialConnection> read(const char* input, const hd::MaterialConnection& connection);
  /// The same for an input of normals, which come through ND_normalmap.
  std::optional<hd::MaterialConnection> read_normals(const char* input, const hd::MaterialConnection& connection);

 private:
  struct Found {
    hd::Path id;
    const hd::MaterialNode* image;
    std::string channel;
  };
  const hd::MaterialNode* find(const hd::Path& id) const;
  std::optional<Found> find_image(const char* input, const hd::MaterialConnection& connection);
  hd::MaterialNode* add(const Found& found, const std::string& use, hd::Path* id);
  void read_coordinates(const hd::MaterialNode& image, hd::MaterialNode* texture);

  const hd::MaterialNetwork& from_;
  hd::MaterialNetwork* to_;
  const WarnMaterial& warn_;
};

}  // namespace alabaster::hydra
