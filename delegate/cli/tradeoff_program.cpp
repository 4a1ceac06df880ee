// Commands tradeoff and compare of the program alabaster: alabaster-tradeoff runs them, so that a first picture needs
// less to be built.
#include "delegate/cli/beside.h"
#include "delegate/cli/commands.h"
#include "delegate/cli/console.h"

namespace alabaster::cli {
namespace {

int pass_on(const Words& given) {
  const std::string program = program_beside("alabaster-tradeoff");
  if (program.empty())
    Console(false).usage_error(given.empty() ? "alabaster" : given[0],
                               "This build lacks the program that runs it. Build it: cmake --build build/release "
                               "--target alabaster-tradeoff, with the folder of your build.");
  Words words{"alabaster"};
  words.insert(words.end(), given.begin(), given.end());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  return run_beside(program, pointers.data());
}

}  // namespace

int run_tradeoff(const TradeoffArguments& arguments) {
  return pass_on(arguments.words);
}
int run_compare(CompareArguments arguments) {
  return pass_on(arguments.render.words);
}

}  // namespace alabaster::cli
