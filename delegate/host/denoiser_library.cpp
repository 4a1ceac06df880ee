#include "delegate/host/denoiser_library.h"

#include "core/denoise/denoiser.h"

namespace alabaster::hd::host {

std::string DenoiserFault() {
  std::string fault;
  return Denoiser::load(&fault) ? std::string() : fault;
}

}  // namespace alabaster::hd::host
