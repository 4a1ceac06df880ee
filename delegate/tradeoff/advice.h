// Advice: for a budget of time, the configuration whose measurements promise the smallest error.
#pragma once

#include <string>
#include <vector>

#include "delegate/tradeoff/analysis.h"

namespace alabaster::tradeoff {

/// The frame that users want, and the machine that renders it.
struct WantedFrame {
  double pixels = 0;           // over those of the study's pictures
  unsigned threads = 1;        // of the machine
  std::string command_of_all;  // "alabaster render SCENE -o frame.exr", which flags follow
};

struct Advice {
  double seconds = 0;  // wall time
  Estimate error;      // that is expected: relative RMSE
  std::string command;
};

/// One for each of a minute, ten minutes and an hour. Noise is taken to fall with the root of the samples, and CPU time
/// to grow with samples and pixels. A configuration is preferred to one that the list has before it only if it is
/// better beyond both intervals. A denoised picture counts with the error that was measured, at the samples that it
/// was measured at.
std::vector<Advice> advise(const StudyResult& result, const ConfigurationList& list, const WantedFrame& frame);

}  // namespace alabaster::tradeoff
