// The nodes above a surface, as signals: images and the primvars that surfaces read, with the arithmetic that scale and
// bias of a texture can do; constants are folded. Internal to this room.
#pragma once

#include <map>
#include <string>
#include <utility>

#include "delegate/looks/looks.h"
#include "delegate/looks/signal.h"

namespace alabaster::hd::looks {

/// A signal, or why there is none: "a node of type 'ND_noise3d_float' (/m/noise), which is not read".
struct Pattern {
  std::optional<Signal> signal;
  std::string fault;
};

class Patterns {
 public:
  Patterns(const MaterialNetwork& network, const WarnLook& warn) : network_(network), warn_(warn) {}

  Pattern read(const MaterialConnection& connection) { return read(connection, 0); }
  /// Of a map of normals in tangent space.
  Pattern read_normals(const MaterialConnection& connection);
  /// The constant of a node in linear Rec. 709; empty: there is none. A value that is no number is reported.
  std::optional<Vec4f> constant(const MaterialNode& node, const std::string& name) const;

 private:
  Pattern read(const MaterialConnection& connection, int depth);
  Pattern read_node(const Path& id, const MaterialNode& node, const std::string& output, int depth);
  Pattern input(const MaterialNode& node, const char* name, float otherwise, int depth);
  Pattern read_image(const Path& id, const MaterialNode& node, const std::string& output, int depth);
  Pattern read_primvar(const MaterialNode& node, const std::string& name, const char* fallback) const;
  Pattern combine(const MaterialNode& node, int depth);
  Pattern unpack_normals(const Path& id, const MaterialNode& node, int depth);
  void read_coordinates(const Path& id, const MaterialNode& image, MaterialNode* texture) const;
  const MaterialNode* find(const MaterialConnection* connection) const;

  const MaterialNetwork& network_;
  const WarnLook& warn_;
  std::map<std::pair<Path, Token>, Pattern> known_;
};

}  // namespace alabaster::hd::looks
