// Photometric files of luminaires: ANSI/IES LM-63 (1986, 1991, 1995, 2002, 2019), type C.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/diagnostics/report.h"
#include "core/digest/digest.h"

namespace alabaster {

/// The luminous intensity of a luminaire by direction, in candela: bilinear in the angles of its file, dark beyond
/// them. Immutable.
class IesProfile {
 public:
  /// Reads a file of at most 16 MiB. Null and a report (file and line, fault, remedy) if it is not read whole: it is
  /// missing or malformed, its photometry is of type A or B, or its TILT is not NONE.
  /// `within`: as of core/files/input_file.h.
  static std::shared_ptr<const IesProfile> load(const std::string& path, const DiagnosticSink& sink,
                                                const std::string& within = {});
  /// `name`: of the file, for reports.
  static std::shared_ptr<const IesProfile> parse(std::string_view text, const std::string& name,
                                                 const DiagnosticSink& sink);

  /// Degrees: `vertical` from straight down (0) to straight up (180), `horizontal` about the vertical, any.
  double intensity(double vertical, double horizontal) const;
  /// The largest intensity between two vertical angles.
  double largest(double from_vertical, double to_vertical) const;
  /// Over the sphere of directions: exact for the bilinear profile.
  double mean() const { return mean_; }
  /// Adds all that lookups depend on.
  void add_to(Digest* digest) const {
    digest->add(verticals_);
    digest->add(horizontals_);
    digest->add(candela_);
  }

 private:
  friend class IesReader;
  IesProfile() = default;
  void finish();

  std::vector<double> verticals_, horizontals_;
  std::vector<double> candela_;  // a row of verticals for each horizontal
  std::vector<double> largest_;  // by vertical
  double mean_ = 0;
};

}  // namespace alabaster
