// Command tradeoff of the program alabaster: alabaster-tradeoff runs it, so that a first picture needs less to be
// built.
#include "delegate/cli/beside.h"
#include "delegate/cli/commands.h"
#include "delegate/cli/console.h"

namespace alabaster::cli {

int run_tradeoff(const TradeoffArguments& arguments) {
  const std::string program = program_beside("alabaster-tradeoff");
  if (program.empty())
    Console(false).usage_error("tradeoff",
                               "This build has no trade-off. Build it: cmake --build build/release --target "
                               "alabaster-tradeoff, with the folder of your build.");
  Words words{"alabaster"};
  words.insert(words.end(), arguments.words.begin(), arguments.words.end());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  return run_beside(program, pointers.data());
}

}  // namespace alabaster::cli
