// The program's exit codes.
#pragma once

#include "delegate/description/render_description.h"
#include "delegate/host/frame_recorder.h"

namespace alabaster::cli {

/// kDegraded: with --keep-going, rendered and written without what the scene's faults left out. kToDo: of farm status,
/// tasks run or have not begun.
enum ExitCode {
  kDone = 0,
  kToDo = 1,
  kUsage = 2,
  kInput = 3,
  kRender = 4,
  kOutput = 5,
  kDegraded = 6,
  kInterrupted = 130
};

/// Thrown to end a command, after a report of why.
struct Exit {
  int code = kDone;
};
/// Ends the command, unless the code is kDone.
inline void require(int code) {
  if (code != kDone) throw Exit{code};
}

// Where memory was refused, neither the scene nor the command is at fault, whether or not the run went on without it:
// the code is kRender.

inline int exit_code(const hd::host::RecordResult& result) {
  using hd::host::RecordStatus;
  switch (result.status) {
    case RecordStatus::done:
      return kDone;
    case RecordStatus::input_failed:
      return kInput;
    case RecordStatus::render_failed:
      return kRender;
    case RecordStatus::output_failed:
      return kOutput;
    case RecordStatus::interrupted:
      return kInterrupted;
    case RecordStatus::degraded:
      return result.out_of_memory ? kRender : kDegraded;
  }
  return kRender;
}

/// `named`: the command names what the product is and how it is shown, and not a file.
inline int exit_code(hd::host::ProductStatus status, bool named) {
  using hd::host::ProductStatus;
  switch (status) {
    case ProductStatus::done:
      return kDone;
    case ProductStatus::invalid:
    case ProductStatus::colors:
      return named ? kUsage : kInput;
    case ProductStatus::outside:
      return kInput;
    case ProductStatus::output:
      return kOutput;
    case ProductStatus::out_of_memory:
      return kRender;
  }
  return kRender;
}

/// Of a plan that is refused or made.
inline int exit_code(const hd::host::FramePlan& plan, bool named) {
  if (plan.product != hd::host::ProductStatus::done) return exit_code(plan.product, named);
  return plan.status == hd::host::RecordStatus::done ? kDone : kInput;
}

/// The code of a command about files that the user names.
inline int exit_code(hd::CommandStatus status) {
  return status == hd::CommandStatus::done ? kDone : status == hd::CommandStatus::out_of_memory ? kRender : kInput;
}

inline int exit_code(hd::description::LoadCause cause) {
  using hd::description::LoadCause;
  switch (cause) {
    case LoadCause::none:
      return kDone;
    case LoadCause::input:
      return kInput;
    case LoadCause::option:
      return kUsage;
    case LoadCause::out_of_memory:
      return kRender;
  }
  return kRender;
}

}  // namespace alabaster::cli
