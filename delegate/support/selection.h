// The meshes that a pass draws: by render tag and by collection.
#pragma once

#include <set>
#include <string_view>

#include "delegate/api/prims.h"

namespace alabaster::hd::support {

/// Immutable. Selections that list the same in another order are equal.
class Selection {
 public:
  /// The default of RenderPassState.
  Selection();
  Selection(const std::vector<Token>& render_tags, const Collection& collection);
  bool includes(const Path& mesh, bool is_visible, const Token& render_tag) const;
  bool operator==(const Selection&) const = default;

 private:
  std::set<Token> tags_;                         // empty: all but `hidden`
  std::set<std::string_view> roots_, excludes_;  // of interned paths, without a slash at their end; no root: all
};

}  // namespace alabaster::hd::support
