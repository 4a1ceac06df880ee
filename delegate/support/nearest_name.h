// The nearest known name to a wrong one, for messages that ask "did you mean ...?".
#pragma once

#include <string>
#include <vector>

namespace alabaster::hd::support {

/// Returns the known name that is the end of `name` behind ':', '.' or '/'; else the one with the smallest edit
/// distance; else one that `name` extends, or that extends it, by such a part. Wrong case counts half a wrong letter.
/// Empty if none is near. Near is two letters, or a third of the letters for names longer than six. In very long lists
/// only the first names are compared, for about a tenth of a second.
std::string NearestName(const std::string& name, const std::vector<std::string>& known);

/// "; did you mean 'NEAREST'?", or `otherwise` if none is near: the end of a sentence about a wrong name.
std::string DidYouMean(const std::string& name, const std::vector<std::string>& known,
                       const std::string& otherwise = {});

/// " Did you mean 'NEAREST'?": a sentence of its own. Empty if none is near.
std::string Suggestion(const std::string& name, const std::vector<std::string>& known);

/// The same of paths, which are the keys of `prims`.
template <class Prims>
std::string DidYouMeanPath(const std::string& path, const Prims& prims) {
  std::vector<std::string> known;
  for (const auto& prim : prims) known.push_back(prim.first.str());
  return DidYouMean(path, known);
}

}  // namespace alabaster::hd::support
