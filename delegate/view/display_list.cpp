#include "delegate/view/display_list.h"

#include <sstream>

namespace alabaster::view {
namespace {

constexpr const char* kDefaultMark = " *";

// Takes the mark of a default off a name.
bool is_default(std::string* name) {
  if (!name->ends_with(kDefaultMark)) return false;
  name->resize(name->size() - 2);
  return true;
}

template <class T>
void add(std::vector<T>* list, T entry, bool first) {
  list->insert(first ? list->begin() : list->end(), std::move(entry));
}

}  // namespace

std::vector<DisplayChoice> read_displays(const std::string& description) {
  std::vector<DisplayChoice> list;
  std::istringstream stream(description);
  std::string heading;
  size_t current = 0;
  for (std::string line; std::getline(stream, line);) {
    const size_t indent = line.find_first_not_of(' ');
    if (indent == std::string::npos) continue;
    std::string name = line.substr(indent);
    if (indent == 0) {
      heading = name.substr(0, name.find_first_of(" :"));
    } else if (heading == "displays" && indent == 2) {
      const bool first = is_default(&name);
      current = first ? 0 : list.size();
      add(&list, DisplayChoice{name, {}}, first);
    } else if (heading == "displays" && !list.empty()) {
      const bool first = is_default(&name);
      add(&list[current].views, name, first);
    }
  }
  return list;
}

}  // namespace alabaster::view
