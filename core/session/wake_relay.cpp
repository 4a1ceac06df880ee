#include "core/session/wake_relay.h"

namespace alabaster {

void WakeRelay::ask() {
  if (!asked_) due_ = Clock::now() + grace_;
  asked_ = true;
  if (carriers_ == 0) wake();
}

// If several see one ask(), one of them wakes.
void WakeRelay::wake() {
  if (asked_.exchange(false)) wake_();
}

void WakeRelay::take_up() {
  ++carriers_;
}

// The count falls before the look: either this sees what ask() did, or ask() sees that nobody carries.
void WakeRelay::lay_down() {
  if (--carriers_ == 0) wake();
}

}  // namespace alabaster
