// The delegate's commands: RenderDelegate::InvokeCommand, whose comment lists them.
#pragma once

#include "delegate/rendering/delegate_state.h"

namespace alabaster::hd::rendering {

/// Runs a command. Its name and the names and types of its arguments are checked here. Throws only what the memory for
/// the answer itself throws.
CommandResult run_command(DelegateState& delegate, const Token& command, const Dictionary& arguments);

inline CommandResult command_done(Value answer = {}) {
  return {CommandStatus::done, {}, std::move(answer)};
}
inline CommandResult command_failed(std::string fault) {
  return {CommandStatus::failed, std::move(fault), {}};
}

}  // namespace alabaster::hd::rendering
