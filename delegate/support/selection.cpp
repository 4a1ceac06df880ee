#include "delegate/support/selection.h"

namespace alabaster::hd::support {
namespace {

std::set<std::string_view> without_slashes(const std::vector<Path>& paths) {
  std::set<std::string_view> out;
  for (const Path& path : paths) {
    std::string_view text = path.str();
    if (text.empty()) continue;
    while (text.ends_with('/')) text.remove_suffix(1);
    out.insert(text);
  }
  return out;
}

// True if the path, or one above it, is in the set; the empty one is above all.
bool covers(const std::set<std::string_view>& set, std::string_view path) {
  if (set.empty()) return false;
  for (;;) {
    if (set.contains(path)) return true;
    if (path.empty()) return false;
    const size_t slash = path.rfind('/');
    path = slash == std::string_view::npos ? std::string_view() : path.substr(0, slash);
  }
}

}  // namespace

Selection::Selection() : Selection(RenderPassState().renderTags, {}) {}

Selection::Selection(const std::vector<Token>& render_tags, const Collection& collection)
    : tags_(render_tags.begin(), render_tags.end()),
      roots_(without_slashes(collection.rootPaths)),
      excludes_(without_slashes(collection.excludePaths)) {}

bool Selection::includes(const Path& mesh, bool is_visible, const Token& render_tag) const {
  if (!is_visible) return false;
  static const Token hidden("hidden");
  const bool tagged = tags_.empty() ? !(render_tag == hidden) : tags_.contains(render_tag);
  return tagged && (roots_.empty() || covers(roots_, mesh.str())) && !covers(excludes_, mesh.str());
}

}  // namespace alabaster::hd::support
