#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "delegate/cli/commands.h"
#include "delegate/cli/console.h"
#include "delegate/cli/exit_codes.h"

namespace alabaster::cli {

std::string view_program() {
  std::error_code error;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::filesystem::path program = self.parent_path() / "alabaster-view";
  return !error && std::filesystem::exists(program, error) ? program.string() : std::string();
}

// The window is a program of its own, so that this one runs where there is no OpenGL.
int run_view(char** arguments) {
  Console console(false);
  const std::string program = view_program();
  if (program.empty())
    console.usage_error("view",
                        "This build has no window. Install libglfw3-dev and libimgui-dev, and configure and "
                        "build again.");
  execv(program.c_str(), arguments);
  console.error(program, std::string("It could not be started: ") + std::strerror(errno) + ".");
  return kRender;
}

}  // namespace alabaster::cli
