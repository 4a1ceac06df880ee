#include "delegate/cli/beside.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "delegate/cli/commands.h"
#include "delegate/cli/console.h"
#include "delegate/cli/exit_codes.h"

namespace alabaster::cli {

std::string program_beside(const char* name) {
  std::error_code error;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::filesystem::path program = self.parent_path() / name;
  return !error && std::filesystem::exists(program, error) ? program.string() : std::string();
}

int run_beside(const std::string& program, char* const* arguments) {
  execv(program.c_str(), arguments);
  Console(false).error(program, std::string("It could not be started: ") + std::strerror(errno) + ".");
  return kRender;
}

std::string view_program() {
  return program_beside("alabaster-view");
}

// The window is a program of its own, so that this one runs where there is no OpenGL.
int run_view(char** arguments) {
  const std::string program = view_program();
  if (program.empty())
    Console(false).usage_error("view",
                               "This build has no window. Install libglfw3-dev and libimgui-dev, and configure and "
                               "build again.");
  return run_beside(program, arguments);
}

}  // namespace alabaster::cli
