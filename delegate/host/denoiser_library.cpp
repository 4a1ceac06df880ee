#include "delegate/host/denoiser_library.h"

#include "core/denoise/denoiser.h"

namespace alabaster::hd::host {

std::string DenoiserFault() {
  std::string fault;
  return Denoiser::load(&fault) ? std::string() : fault;
}

std::string DenoiserVersion() {
  std::string fault;
  const auto denoiser = Denoiser::load(&fault);
  return denoiser ? denoiser->name().substr(denoiser->name().rfind(' ') + 1) : std::string();
}

}  // namespace alabaster::hd::host
