// Rows of a panel, one for each parameter of a table: names, units, ranges and sentences come from the tables alone.
#pragma once

#include <string>
#include <vector>

#include "delegate/api/types.h"

namespace alabaster::view {

enum class RowKind { number, integer, toggle, color, choice, text };

struct ParameterRow {
  std::string name;         // as the schema has it
  std::string label;        // "Scatter distance"
  std::string unit;         // empty: none
  std::string description;  // a sentence or two
  RowKind kind = RowKind::number;
  bool in_millimetres = false;          // the renderer has scene units
  bool is_length = false;               // in the scene: its size is the range of sliders
  hd::Value default_value;              // a number, bool, Vec3f or string
  double minimum = 0, maximum = 0;      // infinite where the schema has no limit
  std::vector<std::string> choices;     // of kind choice
  std::vector<std::string> applies_to;  // types of lights; empty: all
};

/// The rows of a schema of tables (host::ParameterRows), in its order. Parameters that are lists of other things than
/// three numbers are left out.
std::vector<ParameterRow> parameter_rows(const std::string& schema);

/// The range of a slider: a typed number may go beyond, up to the row's own limits.
struct SoftRange {
  double low = 0, high = 1;
  bool logarithmic = false;
};

/// The schema's range where it has both limits and a slider can cover them. Else up to ten times the default, or for
/// lengths up to `scene_size`, in the row's unit; a value beyond that is in the range, too, unless it is
/// beyond what sliders take (2^30 for whole numbers).
SoftRange soft_range(const ParameterRow& row, double value, double scene_size);

/// A unit as it stands behind a number: "mm", "nm"; empty for none.
std::string unit_text(const ParameterRow& row);
/// How printf shows a value: digits enough for a thousandth of the range or of the value, and the unit. Whole numbers
/// are an int, others a float or double.
std::string value_format(const ParameterRow& row, const SoftRange& range, double value);

/// `value` within the row's limits.
double limited(const ParameterRow& row, double value);

}  // namespace alabaster::view
