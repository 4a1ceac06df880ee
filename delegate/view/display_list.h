// Displays and views of a colour configuration, for menus.
#pragma once

#include <string>
#include <vector>

namespace alabaster::view {

struct DisplayChoice {
  std::string name;
  std::vector<std::string> views;  // the default view first
};

/// Reads the text of alabaster::hd::host::DescribeColors. The default display comes first.
std::vector<DisplayChoice> read_displays(const std::string& description);

}  // namespace alabaster::view
